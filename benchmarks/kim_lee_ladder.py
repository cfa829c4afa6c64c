"""How far each relaxation reaches on the three rules of Kim and Lee, and what it costs.

Run it by ``python benchmarks/kim_lee_ladder.py``: some seconds.  It writes
docs/figures/kim-lee-ladder.csv and .svg.  The model is that of Kim and Lee (2000), IEEE Trans.
Fuzzy Systems 8(5), with a = 2: gains are sought for larger and larger b.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from takagi.lmi import relaxation_size
from takagi.lmi.gains.decay.condition import decay_request
from takagi.lmi.gains.decay.design import decided
from takagi.lmi.gains.requirements.limits import GivenLimits
from takagi.lmi.sums.membership_shape import at_points, number_of_points
from takagi.models import TSModel
from takagi.reports.figures.style import COLOURS, GREY, figure_to_svg, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = Path(__file__).resolve().parents[1] / "docs" / "figures"
RELAXATIONS = (
    "common-gain",
    "wang-tanaka-griffin",
    "tanaka-wang",
    "tuan",
    "polya-1",
    "kim-lee",
    "polya-2",
    "liu-zhang",
    "polya-4",
    "polya-8",
    "polya-16",
    "polya-24",
)
# Shares of the rules in the condition that no relaxation can do without: multiples of 1/12.
PARTS = 12
LEAST, MOST, TOLERANCE = -20.0, 12.0, 1e-4
REPEATS = 5
# The part of the axis of b that is drawn, and where the columns beside it end, in axis widths.
SHOWN = (-4.0, 8.0)
COLUMNS = (1.12, 1.31, 1.52)
# Axes in the figure: left, bottom, width, height; the columns stand outside of them.
PLACE = (0.19, 0.12, 0.51, 0.80)
# Any: the properties of a patch have as many types as there are of them.
RULED_OUT: dict[str, Any] = {
    "facecolor": "white",
    "edgecolor": COLOURS[1],
    "hatch": "//////",
    "linewidth": 0.8,
    "zorder": 0,
}
HEADS = ("relaxation", "largest_b", "lmis", "variables", "width", "seconds")


class Row(NamedTuple):
    """One relaxation: the largest b with gains, its size, and the time of one decision [s]."""

    relaxation: str
    largest: float
    lmis: int
    variables: int
    width: int
    seconds: float


def main() -> None:
    """Measure, write the table and the figure; print the table too."""
    rows = [row_of(name) for name in RELAXATIONS]
    # Ruled out from the upper end of the bracket on.
    outer = largest_b("any relaxation") + TOLERANCE
    count = number_of_points(3, None, PARTS)
    bound = Row("any relaxation", outer, count, 6, 2, seconds_at(outer - 0.1, "any relaxation"))
    with (FIGURES / "kim-lee-ladder.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADS)
        for row in (*rows, bound):
            print(row)
            writer.writerow((*row[:1], f"{row.largest:.4f}", *row[2:5], f"{row.seconds:.2g}"))
    text = figure_to_svg(
        drawn(rows, bound),
        name="kim-lee-ladder",
        description="Largest b with gains, number of LMIs and time, for each relaxation",
    )
    head = '<?xml version="1.0" encoding="utf-8"?>\n'
    (FIGURES / "kim-lee-ladder.svg").write_text(head + text, encoding="utf-8")


def model(b: float) -> TSModel:
    """Return the three rules, a = 2."""
    return TSModel(
        [[[1.59, -7.29], [0.01, 0]], [[0.02, -4.64], [0.35, 0.21]], [[-2.0, -4.33], [0, 0.05]]],
        [[[1.0], [0.0]], [[8.0], [0.0]], [[6.0 - b], [-1.0]]],
    )


def feasible(b: float, name: str) -> bool:
    """Return whether the relaxation, or the condition that each implies, has gains."""
    pose = at_points(PARTS) if name == "any relaxation" else name
    return (
        decided(decay_request(model(b), GivenLimits(), decay_rate=0.0), 0.0, pose).outcome.status
        == "candidate"
    )


def largest_b(name: str) -> float:
    """Return the largest b with gains, from below, to 1e-4."""
    low, high = LEAST, MOST
    while high - low > TOLERANCE:
        middle = (low + high) / 2
        low, high = (middle, high) if feasible(middle, name) else (low, middle)
    return low


def row_of(name: str) -> Row:
    largest = largest_b(name)
    size = relaxation_size(name, 3, size=2)
    variables = size.slack_variables + (2 if name == "common-gain" else 6)
    seconds = seconds_at(largest - 0.1, name)
    return Row(name, largest, size.lmis, variables, size.width, seconds)


def seconds_at(b: float, name: str) -> float:
    """Return the best time of posing and deciding, where there are gains [s]."""
    spent = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        feasible(b, name)
        spent.append(time.perf_counter() - began)
    return min(spent)


def drawn(rows: Sequence[Row], bound: Row) -> Figure:
    """Return bars up to the largest b, the range that is ruled out, and the price beside them."""
    with house_style():
        figure, (axes,) = new_figure(height=0.9 + 0.3 * len(rows))
        figure.set_layout_engine("none")
        axes.set_position(PLACE)
        axes.set_xlim(*SHOWN)
        axes.set_ylim(len(rows) - 0.4, -0.6)
        for place, row in enumerate(rows):
            _bar(axes, place, row.largest)
            _price(axes, place, f"{row.lmis}", f"{row.variables}", f"{1e3 * row.seconds:.2g}")
        _price(axes, -1.0, "LMIs", "variables", "time [ms]")
        axes.axvspan(bound.largest, SHOWN[1], **RULED_OUT)
        axes.annotate(
            f"none for b > {bound.largest:.2f}",
            (SHOWN[1], -1.0),
            annotation_clip=False,
            ha="right",
            va="center",
            color=COLOURS[1],
        )
        axes.set_yticks(range(len(rows)), [row.relaxation for row in rows])
        axes.set_xlabel("b [-]: gains are found up to the end of a bar")
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
    return figure


def _bar(axes: Axes, place: int, largest: float) -> None:
    """Draw one bar with its value; one that ends left of the axis is an arrow."""
    text = f"{largest:.2f}".replace("-", "\u2212")
    if largest < SHOWN[0]:
        axes.annotate(f" \u25c0 {text}", (SHOWN[0], place), va="center", color=COLOURS[0])
        return
    axes.barh(place, largest - SHOWN[0], left=SHOWN[0], height=0.62, color=COLOURS[0])
    axes.annotate(
        text,
        (largest, place),
        xytext=(-4, 0),
        textcoords="offset points",
        ha="right",
        va="center",
        color="white",
    )


def _price(axes: Axes, place: float, *cells: str) -> None:
    """Write the columns to the right of the axis."""
    for x, cell in zip(COLUMNS, cells, strict=True):
        axes.annotate(
            cell,
            (x, place),
            xycoords=axes.get_yaxis_transform(),
            annotation_clip=False,
            ha="right",
            va="center",
            color=GREY,
        )


if __name__ == "__main__":
    main()
