"""The common style of all figures, and figures as SVG, PDF and PNG.

It uses no pyplot and no display, and changes no global state: the settings are active only inside
``house_style()``.

Colours: Okabe & Ito (2008), Color Universal Design, in an order that keeps neighbours apart in
lightness too.

The same numbers give the same bytes, so that reports can be compared.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.output import read_words
from takagi.reports.page.text import CaptionedFigure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
# Dashes distinguish lines in black-and-white print, where colours cannot.
STYLES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 3)))
GREY = "#666666"
# Surfaces use the map that is safe for colour-blind readers, lines the one with more hues.
SEQUENTIAL = "cividis"
ORDERED = "viridis"

WIDTH, HEIGHT = 7.0, 4.5
POINTS = 2000

# Any: the names of matplotlib's settings are a closed type that changes from release to release.
_SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "svg.fonttype": "path",
    "svg.hashsalt": "takagi",
    "pdf.fonttype": 42,
    "axes.unicode_minus": True,
    "figure.max_open_warning": 0,
}


@contextmanager
def house_style() -> Iterator[None]:
    """Activate the settings of all figures while one is drawn or written."""
    import matplotlib

    active: Any = matplotlib.rcParams
    with matplotlib.rc_context():
        # They are valid: matplotlib would look at all three hundred at each figure.
        dict.update(active, _valid_settings())
        yield


@cache
def _valid_settings() -> dict[str, Any]:
    """Return matplotlib's own defaults with the settings of all figures, as it keeps them."""
    import matplotlib

    active: Any = matplotlib.rcParams
    with matplotlib.rc_context():
        defaults = {k: v for k, v in matplotlib.rcParamsDefault.items() if k not in _NOT_STYLE}
        matplotlib.rcParams.update(defaults)
        matplotlib.rcParams.update(_SETTINGS)
        return {k: v for k, v in dict.items(active) if k not in _NOT_STYLE}


_NOT_STYLE = frozenset({"backend", "backend_fallback", "toolbar", "interactive", "timezone"})


def new_figure(
    rows: int = 1,
    across: int = 1,
    *,
    width: float = WIDTH,
    height: float = HEIGHT,
    share_x: bool = False,
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes row by row; call inside ``house_style()``.

    Parameters
    ----------
    width, height : inches; 7 in at 9 pt stays legible on a phone turned sideways.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="tight")
    FigureCanvasAgg(figure)
    place_roughly(figure, rows, across, share_x=share_x)
    grid = figure.subplots(rows, across, sharex=share_x, squeeze=False)
    return figure, list(grid.ravel())


def decimate(x: ArrayLike, y: ArrayLike, *, points: int = POINTS) -> tuple[Floats, Floats]:
    """Return at most ``points`` samples of y(x) that keep every extreme.

    The series is cut into bins; of each, the first occurrence of its least and of its greatest
    value stay, in their order, besides the first and the last sample.  A gap (nan) stays a gap
    where a whole bin is one.

    Parameters
    ----------
    x, y : (n,), x increasing.

    Raises
    ------
    ModelError : different lengths, or fewer than 8 points asked for.
    """
    xs, ys = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if xs.shape != ys.shape or xs.ndim != 1:
        raise ModelError(f"x has shape {xs.shape}, y {ys.shape}; both must be (n,)")
    if points < 8:
        raise ModelError(f"{points} points were asked for; at least 8 are needed")
    if len(xs) <= points:
        return xs, ys
    edges = np.linspace(0, len(xs), points // 2).astype(int)
    keep = {0, len(xs) - 1}
    gap = np.isnan(ys)
    least, greatest = np.where(gap, np.inf, ys), np.where(gap, -np.inf, ys)
    for start, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if gap[start:stop].all():
            keep.add(start)
            continue
        keep.add(start + int(least[start:stop].argmin()))
        keep.add(start + int(greatest[start:stop].argmax()))
    chosen = np.array(sorted(keep))
    return xs[chosen], ys[chosen]


def shades(count: int) -> list[str]:
    """Return colours from dark to light for an ordered set (winds): viridis up to green."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    where = np.linspace(0.0, 0.7, max(count, 1)) if count > 1 else np.array([0.0])
    return [to_hex(colormaps[ORDERED](value)) for value in where]


def marks_above(axes: Axes, marks: Mapping[str, float], *, width: float = WIDTH) -> None:
    """Draw vertical lines labelled above the axes, on two levels where labels would meet.

    Parameters
    ----------
    marks : label -> place on the x axis, whose limits and scale are already set.
    width : of the axes, about [inches].
    """
    low, high = axes.transAxes.inverted().transform(
        axes.transData.transform([(x, 0.0) for x in axes.get_xlim()])
    )[:, 0]
    taken = [-np.inf, -np.inf]
    for text, x in sorted(marks.items(), key=lambda item: item[1]):
        inside = axes.transAxes.inverted().transform(axes.transData.transform((x, 0.0)))[0]
        place = width * 72 * (inside - low) / (high - low)
        half = 0.3 * 9 * len(text) + 2
        level = 0 if place - half >= taken[0] else 1
        taken[level] = place + half
        axes.axvline(x, color=GREY, linestyle=":", linewidth=1.0)
        axes.annotate(
            text,
            (x, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0, 2 + 11 * level),
            textcoords="offset points",
            ha="center",
            fontsize=9,
            color=GREY,
        )


def wind_axis(axes: Axes, *, ticks: int = 12) -> None:
    """Label the x axis as wind [m/s], with ticks at whole numbers."""
    from matplotlib.ticker import MaxNLocator

    axes.set_xlabel("wind [m/s]")
    axes.xaxis.set_major_locator(MaxNLocator(nbins=ticks, integer=True, steps=[1, 2, 5, 10]))


def region_axes(panels: Sequence[Axes], wind: Floats, regions: Mapping[str, float]) -> None:
    """Let two rows of two panels lie over wind, with a mark where each region begins."""
    for k, axes in enumerate(panels):
        axes.set_xlim(wind[0], wind[-1])
        if k < 2:
            marks_above(axes, regions, width=3.0)
        else:
            wind_axis(axes, ticks=6)
            for begin in regions.values():
                axes.axvline(begin, color=GREY, linestyle=":", linewidth=1.0)


def columns(name: str, values: Sequence[ArrayLike], length: int) -> list[Floats]:
    """Return each value as a float (length,) array; ModelError names the one that is not."""
    arrays = [np.asarray(value, dtype=np.float64) for value in values]
    for k, array in enumerate(arrays):
        if array.shape != (length,):
            raise ModelError(
                f"{name}: item {k + 1} of {len(arrays)} has shape {array.shape}; ({length},) is "
                "needed, one value per point of the first axis"
            )
    return arrays


# Paths of more characters than this are data lines, not markers: a tenth of a point is enough.
LONG_PATH = 400
LINES = re.compile(r"([ML] \S+ \S+)((?: L \S+ \S+)+)")


def figure_to_svg(figure: Figure, *, name: str, description: str = "") -> str:
    """Return the figure as one ``<svg>`` element, ready to stand inside HTML.

    Parameters
    ----------
    name : prefix of every id in the element, so that several figures fit in one page; letters,
        digits, hyphens.
    description : text for readers who do not see the figure.

    The same figure gives the same text: ids are salted with a constant, no date is written.
    Letters are outlines, so that labels have the same position on every computer.

    Raises
    ------
    ModelError : a name that cannot be an id.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9-]*", name):
        raise ModelError(
            f"figure name {name!r} was given; it must begin with a letter and hold only letters, "
            "digits and hyphens"
        )
    buffer = BytesIO()
    with house_style():
        _settle(figure)
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue().decode("utf-8")
    body = text[text.index("<svg ") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, count=1, flags=re.DOTALL)
    body = re.sub(r"\n\s*", "\n", body)
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = body.replace('href="#', f'href="#{name}-').replace("url(#", f"url(#{name}-")
    body = _shorter(body)
    label = escape(description or name, quote=True)
    # Keeps the figure narrower than its page, also on a phone.
    fit = 'style="max-width:100%;height:auto"'
    return body.replace("<svg ", f'<svg role="img" aria-label="{label}" {fit} ', 1)


def figure_to_pdf(figure: Figure) -> bytes:
    """Return the figure as a PDF page for LaTeX, without dates."""
    buffer = BytesIO()
    metadata = {"CreationDate": None, "Creator": None, "Producer": None}
    with house_style():
        _settle(figure)
        figure.savefig(buffer, format="pdf", metadata=metadata)
    return buffer.getvalue()


def figure_to_png(figure: Figure, *, dpi: int = 100) -> bytes:
    """Return the figure as a PNG image, for looking at it; reports use SVG and PDF."""
    buffer = BytesIO()
    with house_style():
        _settle(figure)
        figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def _settle(figure: Figure) -> None:
    """Lay the figure out once for all; laying out again at each writing would move it a little."""
    if figure.get_layout_engine() is not None:
        # For any engine savefig draws twice.
        figure.set_layout_engine(None)
        for axes in figure.axes:
            _write_powers_in_letters(axes)
        make_room(figure)


def _write_powers_in_letters(axes: Axes) -> None:
    """Let logarithmic axes write powers of ten as text.

    matplotlib sets them as formulas, which takes as long as to draw the figure.
    """
    from matplotlib.ticker import Formatter, LogFormatterMathtext

    class InLetters(Formatter):
        def __init__(self, formulas: Formatter) -> None:
            self.formulas = formulas

        def set_locs(self, locs: Any) -> None:
            self.formulas.set_locs(locs)

        def __call__(self, x: float, pos: int | None = None) -> str:
            return _in_letters(self.formulas(x, pos))

    for axis in (axes.xaxis, axes.yaxis):
        major, minor = axis.get_major_formatter(), axis.get_minor_formatter()
        if isinstance(major, LogFormatterMathtext):
            axis.set_major_formatter(InLetters(major))
        if isinstance(minor, LogFormatterMathtext):
            axis.set_minor_formatter(InLetters(minor))


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_POWER = re.compile(r"\$\\mathdefault\{(-?)(?:([\d.]+)\\times)?10\^\{(-?\d+)\}\}\$")


def _in_letters(formula: str) -> str:
    power = _POWER.fullmatch(formula)
    if power is None:
        return formula
    sign, factor, exponent = power.groups()
    times = "" if factor is None else f"{factor} × "
    return f"{sign and '−'}{times}10{exponent.translate(_RAISED)}"


def _shorter(svg: str) -> str:
    """Round coordinates, to a tenth of a point in long lines, and leave out what SVG implies."""
    named = set(re.findall(r'(?:href="#|url\(#)([^")]+)', svg))
    svg = re.sub(r"<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    svg = re.sub(r' id="([^"]*)"', lambda m: m.group() if m.group(1) in named else "", svg)
    svg = re.sub(r"<g>\s*(<(?:use|path) [^>]*/>)\s*</g>", r"\1", svg)
    svg = re.sub(r'style="[^"]*"', lambda m: re.sub(r"([:;]) ", r"\1", m.group()), svg)

    def coordinates(match: re.Match[str]) -> str:
        digits = 1 if len(match.group(2)) > LONG_PATH else 2
        text = re.sub(
            r"-?\d+\.\d+",
            lambda number: f"{float(number[0]):.{digits}f}".rstrip("0").rstrip("."),
            match.group(2),
        )
        text = re.sub(r"\s+", " ", text).strip()
        # After a move or a line, further pairs are lines: their letter is implied.  After a curve
        # they would be curves.
        return match.group(1) + LINES.sub(lambda m: m[1] + m[2].replace("L ", ""), text) + '"'

    return re.sub(r'( d="|\bx="|\by=")([^"]*)"', coordinates, svg)


def captioned_figure(figure: Figure, name: str, key: str = "", **filled: str) -> CaptionedFigure:
    """Return a drawn figure with its caption; its SVG is in the page and in a file of its own.

    key : in ``words.toml``, the name unless given;  filled : what the words there leave open.
    """
    words = read_words("page/words.toml")["figures"][key or name]
    caption, alternative = (words[part].format(**filled) for part in ("caption", "alternative"))
    svg = figure_to_svg(figure, name=name, description=alternative)
    return CaptionedFigure(name, svg, caption, alternative)


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
