"""Figures: the same bytes each time, small, legible, and honest about extremes."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scipy.linalg import expm
from sympy import Symbol

from takagi.certificates.claims.certification import USEFUL
from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, Plant, Variable
from takagi.reports.figures.loops import BodeLine, bode_figure
from takagi.reports.figures.operation import OverlapRow, cells_figure, overlaps_figure
from takagi.reports.figures.plant.proved_set import pairs, section, set_figure
from takagi.reports.figures.response import ResponseLine, response_figure
from takagi.reports.figures.style import (
    decimate,
    figure_to_png,
    figure_to_svg,
    house_style,
    new_figure,
)
from takagi.reports.loops.plant_claims import half_widths, overshoots, settling_time
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.sections.plant.claims import set_section
from tests.reports.plant_designs import U, V, X, two_integrators

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAKERS: dict[str, Callable[[], Figure]] = {}


def maker(make: Callable[[], Figure]) -> Callable[[], Figure]:
    MAKERS[make.__name__.replace("_", "-")] = make
    return make


@maker
def bode() -> Figure:
    """Three winds, one of them without a loop."""
    omega = np.geomspace(0.01, 30, 300)
    lines = [BodeLine("6 m/s", np.zeros(300, dtype=complex))]
    for wind, gain in ((12, 0.5), (20, 0.7)):
        response = gain / (1j * omega) * np.exp(-0.3j * omega)
        lines.append(BodeLine(f"{wind} m/s", response, gain, np.pi / 0.6))
    return bode_figure(omega, lines, marks={"tower 0.32 Hz": 2.04, "3P": 3.8})


def response_line(label: str, time: NDArray[np.float64]) -> ResponseLine:
    answer = 1 - np.exp(-np.clip(time - 20, 0, None) / 3)
    wind = np.where(time < 20, 10.0, 13.0)
    return ResponseLine(label, wind, 0.1 * answer, 4e4 * answer, 1.2 + 0 * time, 5e6 * answer)


@maker
def response() -> Figure:
    """Two laws, 10 000 samples."""
    time = np.linspace(0, 200, 10_000)
    lines = [response_line("coherent", time), response_line("paper", time)]
    return response_figure(time, lines, rated={"rotor_speed": 1.267}, title="step")


@maker
def cells() -> Figure:
    """Twenty cells, two of them not proved."""
    proved = np.ones(20, dtype=bool)
    proved[[0, 8]] = False
    values = np.linspace(0.05, 0.1, 20)
    shown = dict.fromkeys(("decay_rate", "wind_error", "wind_rate", "overspeed"), values)
    return cells_figure(np.linspace(5, 25, 21), proved, **shown)


@maker
def overlaps() -> Figure:
    """One row with a gap, eight of narrow windows, all of the last one not proved."""
    windows = tuple((v, v + 0.03) for v in np.arange(3.5, 25))
    rows = [OverlapRow("0.1 rad/s, 2000 N m (chosen)", ((3, 10), (10.4, 25)), ((10, 10.4),))]
    rows += [OverlapRow("0.05 rad/s, 1000 N m", windows[:k], windows[k:]) for k in range(7, -1, -1)]
    return overlaps_figure(rows, wind=(3, 25))


class Pictured(NamedTuple):
    """A figure of which a picture was made, its page, and where its texts stood in the picture."""

    figure: Figure
    svg: str
    page: tuple[float, float]
    texts: list[tuple[str, float, float]]


# A few of them at every run; all of them with the slow tests.
SHOWN = [
    n if n in ("bode", "trim", "overlaps") else pytest.param(n, marks=pytest.mark.slow)
    for n in MAKERS
]


@cache
def pictured(name: str) -> Pictured:
    from matplotlib.text import Text

    figure = MAKERS[name]()
    svg = figure_to_svg(figure, name=name)
    figure_to_png(figure, dpi=100)
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    page = figure.bbox.padded(2.0)
    texts = []
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        # Tick labels beyond the limits of their axis are kept by matplotlib but not drawn.
        number = re.fullmatch(r"[−\d.]+|10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", text.get_text())
        if text.get_visible() and text.get_text().strip() and not number:
            box = text.get_window_extent(renderer)
            texts.append((text.get_text(), box.x0 - page.x0, box.x1 - page.x0))
    return Pictured(figure, svg, (0.0, page.x1 - page.x0), texts)


@pytest.mark.parametrize("name", SHOWN)
def test_svg_is_repeatable_small_and_fit_to_stand_in_html(name: str) -> None:
    """Drawn twice the text is the same: one element, own ids, no date, no raster, below 150 kB."""
    first = pictured(name).svg

    # A second writing moves nothing.
    assert first == figure_to_svg(pictured(name).figure, name=name)
    assert len(first.encode()) < 150_000
    assert first.startswith("<svg ")
    assert "<image" not in first
    assert "<metadata" not in first
    root = ElementTree.fromstring(first)
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(ids) == len(set(ids))
    assert all(str(identity).startswith(f"{name}-") for identity in ids)
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', first))
    assert used <= set(map(str, ids))


@pytest.mark.parametrize("name", SHOWN)
def test_a_figure_can_be_read(name: str) -> None:
    """No text is below 9 pt or leaves the page; every labelled axis says its unit in brackets."""
    from matplotlib.text import Text

    figure, _, (left, right), shown = pictured(name)
    texts = [t for t in figure.findobj(Text) if isinstance(t, Text) and t.get_text().strip()]
    assert min(float(text.get_fontsize()) for text in texts) >= 9
    assert figure.get_size_inches()[0] == 7.0
    labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel())]
    assert any(labels)
    assert all(re.search(r"\[.+\]", label) for label in labels if label)
    assert shown
    for text, start, end in shown:
        assert left <= start and end <= right, text


@pytest.mark.parametrize("name", SHOWN)
def test_no_text_lies_on_another(name: str) -> None:
    from matplotlib.text import Text

    figure = pictured(name).figure
    figure_to_png(figure, dpi=100)  # A legend's texts stand where they were drawn last.
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    not_drawn = set()
    for axes in figure.axes:
        for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not min(limits) <= tick.get_loc() <= max(limits):
                    not_drawn |= {tick.label1, tick.label2}
    boxes = [
        (text.get_text(), text.get_window_extent(renderer))
        for text in figure.findobj(Text)
        if isinstance(text, Text) and text.get_visible() and text.get_text().strip()
        if text not in not_drawn
    ]
    for (first, box), (second, other) in combinations(boxes, 2):
        over = np.minimum(box.max, other.max) - np.maximum(box.min, other.min)
        # Two dots of the page: the extent of a letter has some room of its own.
        assert not np.all(over > 2), (first, second)


def test_labels_of_a_column_stand_in_one_line() -> None:
    with house_style():
        figure, panels = new_figure(3, 1, share_x=True)
        for axes, size in zip(panels, (1.0, 1e5, 1e-3), strict=True):
            axes.plot([0.0, 1.0], [-size, size])
            axes.set_ylabel("speed\n[m/s]")
    figure_to_png(figure)
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    labels = [axes.yaxis.label.get_window_extent(renderer) for axes in panels]
    assert np.ptp([label.x1 for label in labels]) < 0.5
    for axes, label in zip(panels, labels, strict=True):
        numbers = [text.get_window_extent(renderer) for text in axes.get_yticklabels()]
        assert 0 <= label.x0 and label.x1 < min(number.x0 for number in numbers)


def test_what_is_not_proved_is_hatched_and_lies_on_top() -> None:
    from matplotlib.patches import Rectangle

    row = OverlapRow("0.1 rad/s, 2000 N m", ((3, 10), (10.4, 25)), ((10, 10.4),))
    bars = [bar for bar in overlaps_figure([row], wind=(3, 25)).axes[0].patches]
    looks = [bool(bar.get_hatch()) for bar in bars]
    ends = [(b.get_x(), b.get_x() + b.get_width()) for b in bars if isinstance(b, Rectangle)]

    assert looks == [False, False, True]
    np.testing.assert_allclose(ends, [(3, 10), (10.4, 25), (10, 10.4)])


@given(
    values=arrays(np.float64, st.integers(0, 5000), elements=st.floats(-1e6, 1e6)),
    points=st.integers(8, 300),
)
def test_decimation_keeps_extremes_and_ends(values: NDArray[np.float64], points: int) -> None:
    time = np.arange(len(values), dtype=np.float64)
    x, y = decimate(time, values, points=points)

    assert len(x) <= max(points, 0)
    assert np.array_equal(values[x.astype(int)], y)
    assert np.all(np.diff(x) > 0)
    if len(values):
        assert (y.min(), y.max(), y[0], y[-1]) == (
            values.min(),
            values.max(),
            values[0],
            values[-1],
        )


def test_powers_of_ten_beside_an_axis_are_letters() -> None:
    """A formula for each of them would take as long as the figure."""
    with house_style():
        figure, (axes,) = new_figure()
        axes.loglog([1e-3, 1e4], [2.0, 7.0])
        figure_to_svg(figure, name="powers")

    beside = [label.get_text() for label in axes.get_xticklabels()]
    between = [label.get_text() for label in axes.get_yticklabels(minor=True)]
    assert "10⁻²" in beside
    assert "3 × 10⁰" in between


A, B, C, JERK = sp.symbols("a b c u", real=True)
SIDE = Interval.of(-1, 1)


def three_states() -> Plant:
    """A chain of three integrators, the first state in deg in its file."""
    return Plant(
        equations=(B, C, JERK),
        states=(
            Variable(A, "rad", SIDE, written="deg"),
            Variable(B, "rad/s", SIDE, written="rad/s"),
            Variable(C, "rad/s^2", Interval.of(-8, 8), written="rad/s^2"),
        ),
        inputs=(Variable(JERK, "rad/s^3"),),
    )


@cache
def design() -> PlantDesign:
    return certify_plant(three_states(), np.array([[[6.0, 11.0, 6.0]]]))


def test_every_pair_has_a_panel_with_units_on_its_outer_axes() -> None:
    loop = plant_loop(design())
    figure = set_figure(loop)
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert len(shown) == len(pairs(loop)) == 3
    assert {axes.get_xlabel() for axes in shown} == {"a [deg]", "b [rad/s]", ""}
    assert {axes.get_ylabel() for axes in shown} == {"b [rad/s]", "c [rad/s^2]", ""}
    P, level = loop.ellipsoid
    widest = np.degrees(np.sqrt(level * np.linalg.inv(P)[0, 0]))
    border = next(line for line in shown[0].lines if "projection" in str(line.get_label()))
    assert np.isclose(np.abs(np.asarray(border.get_xdata())).max(), widest, rtol=1e-3)


def test_the_section_is_the_set_with_all_other_states_at_rest() -> None:
    P = np.array([[2.0, 0.5, 0.3], [0.5, 1.0, 0.2], [0.3, 0.2, 3.0]])
    border = section(P, 4.0, (0, 2))
    points = np.stack((border[0], np.zeros_like(border[0]), border[1]))
    assert np.allclose(np.einsum("ik,ij,jk->k", points, P, points), 4.0)


def test_the_table_is_in_the_file_s_units_and_absent_without_a_set() -> None:
    loop = plant_loop(design())
    found = set_section(design(), loop)
    assert found is not None
    rows = found.content["table"].rows
    P, level = loop.ellipsoid
    assert rows[0][:2] == ("a", "deg")
    alone = float(rows[0][2].removeprefix("±"))
    assert np.isclose(alone, np.degrees(np.sqrt(level / P[0, 0])), rtol=1e-2)
    assert set_section(design(), replace(loop, level_proved=False)) is None


@pytest.mark.parametrize("disturbed", [False, True])
def test_one_state_settles_as_its_pole_says(*, disturbed: bool) -> None:
    """x' = -2 x: all of |x| <= 1, 2 % after ln(50) / 2, also beside a disturbance at rest."""
    W = Symbol("W", real=True)
    plant = Plant(
        equations=(U + W if disturbed else U,),
        states=(Variable(X, "-", Interval.of(-1, 1)),),
        inputs=(Variable(U, "-", Interval.of(-3, 3)),),
        disturbances=(Variable(W, "-", Interval.of(-0.1, 0.1)),) if disturbed else (),
    )
    loop = plant_loop(certify_plant(plant, np.array([[[2.0]]])))
    reach, time = half_widths(loop), settling_time(loop)

    assert reach is not None and np.isclose(reach[0], 1.0, rtol=1e-3)
    # The proved rate is a little below the pole.
    assert time is not None and np.log(50) / 2 <= time <= 1.05 * np.log(50) / 2


def test_motions_from_the_set_s_edge_keep_both_bounds() -> None:
    """Two poles at -1; exp(A t) moves sixty starts on the edge of {x' P x <= c}."""
    loop = plant_loop(two_integrators(1, 2, room=3))
    reach, time = half_widths(loop), settling_time(loop)
    assert reach is not None and time is not None
    P, level = loop.ellipsoid
    angle = np.linspace(0, np.pi, 60)
    edge = np.linalg.solve(
        np.linalg.cholesky(P).T, np.sqrt(level) * np.array([np.cos(angle), np.sin(angle)])
    )
    A = np.array([[0.0, 1.0], [-1.0, -2.0]])

    for t in np.linspace(0, 2 * time, 41):
        part = np.abs(expm(A * t) @ edge).max(axis=1) / reach
        assert np.all(part <= (0.02 if t >= time else 1.0) * (1 + 1e-9))
    assert np.isclose((np.abs(edge).max(axis=1) / reach).max(), 1.0, rtol=1e-2)


W = sp.Symbol("w", real=True)


@pytest.mark.parametrize("damping", [0.6, 2.0])
def test_motions_keep_the_bound_and_come_near_it(damping: float) -> None:
    design = two_integrators(1.0, damping)
    found = overshoots(design, plant_loop(design))
    A = np.array([[0.0, 1.0], [-1.0, -damping]])
    peaks = np.abs([expm(A * t) for t in np.linspace(0, 20, 801)]).max(axis=0)

    for k, name in enumerate(("x", "v")):
        assert peaks[k, k] <= found[name] < 1.6 * peaks[k, k]


def test_units_do_not_matter_and_a_useless_claim_is_made_again() -> None:
    """x'' = -1e4 x - 200 v, v up to 100: over the half-widths of the set as of poles at -1."""
    design = two_integrators(1e4, 200.0, side=100.0)
    slow = two_integrators(1.0, 2.0)
    claims = [c for c in design.document["claims"] if c["kind"] == "transient"]

    assert all(float(claim["overshoot"]) <= USEFUL for claim in claims)
    fast = overshoots(design, plant_loop(design))
    for name, most in overshoots(slow, plant_loop(slow)).items():
        assert np.isclose(fast[name], most, rtol=0.2)


def test_no_range_for_one_state_takes_the_set_s_own_width() -> None:
    """Scales of 1 would say 100 times: v gets 100 times as large as x."""
    plant = Plant(
        equations=(V, U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V, "-")),
        inputs=(Variable(U, "-"),),
    )
    design = certify_plant(plant, np.array([[[1e4, 100.0]]]))
    (claim,) = (c for c in design.document["claims"] if c["kind"] == "transient")

    assert "half-widths" in claim["name"] and float(claim["overshoot"]) <= USEFUL
    assert float(claim["scales"][1]) > 10 * float(claim["scales"][0])


def test_nothing_is_said_without_a_proved_set_or_with_a_disturbance() -> None:
    design = two_integrators(1.0, 2.0)
    loop = plant_loop(design)
    pushed = replace(loop.plant, equations=(V, U + W), disturbances=(Variable(W, "-"),))

    assert overshoots(design, replace(loop, level_proved=False)) == {}
    assert overshoots(design, replace(loop, plant=pushed)) == {}
