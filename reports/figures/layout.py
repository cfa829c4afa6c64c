"""Room for the labels around the panels of a figure, measured once.

matplotlib's constrained layout measures all labels four times, which takes longer than to draw a
small figure.  Here panels begin near their final places, so that they keep their ticks when they
are moved; one measurement then gives the margins and the gaps between rows and columns.  Labels of
a column, or of a row, stand in one line.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

# All in inches: around the figure, between a panel's labels and the next panel, and about what
# labels take on the left, below and above.
EDGE, GAP = 0.05, 0.09
LEFT, BELOW, ABOVE = 0.75, 0.5, 0.25
SMALLEST = 0.2


def place_roughly(figure: Figure, rows: int, across: int, *, share_x: bool) -> None:
    """Put the panels of a grid about where they will be."""
    width, height = figure.get_size_inches()
    within = EDGE + GAP if share_x else BELOW + ABOVE
    panel = _panel(width, LEFT, EDGE, LEFT, across), _panel(height, BELOW, ABOVE, within, rows)
    figure.subplots_adjust(
        left=LEFT / width,
        right=1 - EDGE / width,
        bottom=BELOW / height,
        top=1 - ABOVE / height,
        wspace=LEFT / panel[0],
        hspace=within / panel[1],
    )


def make_room(figure: Figure) -> None:
    """Move the panels of one grid so that all labels, titles and outer legends have room."""
    room = _Room.of(figure)
    if room is None:
        return
    width, height = figure.get_size_inches()
    across, rows = len(room.left), len(room.above)
    beside = room.right[:-1] + room.left[1:]
    between = room.below[:-1] + room.above[1:]
    left, right = EDGE + room.left[0], EDGE + room.right[-1] + room.at_right
    below, above = EDGE + room.below[-1] + room.at_bottom, EDGE + room.above[0] + room.at_top
    column_gap, row_gap = (GAP + max(gaps, default=0.0) for gaps in (beside, between))
    figure.subplots_adjust(
        left=left / width,
        right=1 - right / width,
        bottom=below / height,
        top=1 - above / height,
        wspace=column_gap / _panel(width, left, right, column_gap, across),
        hspace=row_gap / _panel(height, below, above, row_gap, rows),
    )
    for bar in room.bars:
        grid = figure.subplotpars
        size = bar.get_position().width
        start = 1 - (EDGE + room.at_right) / width + GAP / width
        bar.set_position((start, grid.bottom, size, grid.top - grid.bottom))


def _panel(size: float, first: float, last: float, gap: float, count: int) -> float:
    """Return the size of a panel, of so many with gaps between margins [in]."""
    return max((size - first - last - gap * (count - 1)) / count, SMALLEST)


@dataclass
class _Room:
    """What labels take around the panels of each column and row [in], and around the whole grid.

    ``bars`` : colour bars of the whole figure, which stand at its right.
    """

    left: np.ndarray
    right: np.ndarray
    above: np.ndarray
    below: np.ndarray
    at_right: float = 0.0
    at_top: float = 0.0
    at_bottom: float = 0.0
    bars: list[Axes] = field(default_factory=list)

    @classmethod
    def of(cls, figure: Figure) -> _Room | None:
        """Return the room of all visible panels; None if there are none."""
        axes = [one for one in figure.axes if one.get_visible()]
        panels = [one for one in axes if one.get_subplotspec() is not None]
        if not panels:
            return None
        rows, across = _cell(panels[0]).get_gridspec().get_geometry()
        room = cls(np.zeros(across), np.zeros(across), np.zeros(rows), np.zeros(rows))
        renderer: Any = figure.canvas.get_renderer()  # type: ignore[attr-defined]
        for one in panels:
            room._measure(one, renderer)
        room._align(panels, renderer)
        room._surround(figure, renderer)
        for bar in (one for one in axes if one.get_subplotspec() is None):
            box = bar.get_tightbbox(renderer)
            if box is not None:
                room.bars.append(bar)
                room.at_right = max(room.at_right, GAP + box.width / figure.dpi)
        return room

    def _measure(self, axes: Axes, renderer: Any) -> None:
        figure, cell = axes.get_figure(root=True), _cell(axes)
        assert figure is not None
        inner = cell.get_position(figure).transformed(figure.transFigure)
        outer = axes.get_tightbbox(renderer, for_layout_only=True)
        if outer is None:
            return
        columns, rows, dots = cell.colspan, cell.rowspan, figure.dpi
        _grow(self.left, columns.start, (inner.x0 - outer.x0) / dots)
        _grow(self.right, columns.stop - 1, (outer.x1 - inner.x1) / dots)
        _grow(self.above, rows.start, (outer.y1 - inner.y1) / dots)
        _grow(self.below, rows.stop - 1, (inner.y0 - outer.y0) / dots)

    def _align(self, panels: Sequence[Axes], renderer: Any) -> None:
        """Put the labels of each column, and of each row, in one line."""
        for k in range(len(self.left)):
            column = (one.yaxis for one in panels if _cell(one).colspan.start == k)
            _grow(self.left, k, _aligned(column, renderer, 0))
        for k in range(len(self.below)):
            row = (one.xaxis for one in panels if _cell(one).rowspan.stop - 1 == k)
            _grow(self.below, k, _aligned(row, renderer, 1))

    def _surround(self, figure: Figure, renderer: Any) -> None:
        for legend in figure.legends:
            size = legend.get_window_extent(renderer).height / figure.dpi
            side = getattr(legend, "_outside_loc", None)
            if side == "lower":
                self.at_bottom = max(self.at_bottom, size + EDGE)
            elif side == "upper":
                self.at_top = max(self.at_top, size + EDGE)
        for text in figure.texts:
            if text.get_text() and text.get_text() == figure.get_suptitle():
                self.at_top += GAP + text.get_window_extent(renderer).height / figure.dpi


def _cell(axes: Axes) -> Any:
    spec = axes.get_subplotspec()
    assert spec is not None
    return spec.get_topmost_subplotspec()


def _grow(rooms: np.ndarray, k: int, size: float) -> None:
    rooms[k] = max(rooms[k], size)


def _aligned(axes_lines: Iterable[Axis], renderer: Any, way: int) -> float:
    """Put labels on the left (``way`` 0) or below (1) in one line; return the room it takes [in].

    A label is anchored at its side that is nearer to the panel, whose distance was measured.
    """
    from matplotlib.transforms import ScaledTranslation

    side = ("left", "bottom")[way]
    labelled = [
        axis for axis in axes_lines
        if axis.get_label_position() == side and axis.label.get_visible() and axis.label.get_text()
    ]  # fmt: skip
    distances, sizes = [], []
    for axis in labelled:
        start, box = axis.axes.bbox.min[way], axis.label.get_window_extent(renderer)
        distances.append(start - box.max[way])
        sizes.append(box.size[way])
    if not labelled:
        return 0.0
    farthest, figure = max(distances), labelled[0].get_figure(root=True)
    assert figure is not None
    dots = figure.dpi
    for axis in labelled:
        shift = (-farthest / dots, 0.0) if way == 0 else (0.0, -farthest / dots)
        moved = axis.axes.transAxes + ScaledTranslation(*shift, figure.dpi_scale_trans)
        axis.set_label_coords(*((0.0, 0.5) if way == 0 else (0.5, 0.0)), transform=moved)
    return float(farthest + max(sizes)) / dots
