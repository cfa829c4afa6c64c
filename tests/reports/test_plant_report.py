"""The report of a plant: well-formed, self-contained, honest about what is not proved."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant
from takagi.models.plant.design_settings import PlantSettings
from takagi.reports.loops.plant_claims import proved_jumps
from takagi.reports.loops.plant_loop import plant_loop, proved_kinds
from takagi.reports.page import text
from takagi.reports.page.assembly import ReportFiles
from takagi.reports.page.text import at_least, at_most, at_most_to, decimal
from takagi.reports.sections.plant.claims import claim_rows
from takagi.reports.sections.plant.page import plant_report_files
from takagi.reports.sections.plant.summary import answer_sentence, summary_rows
from takagi.reports.simulation.plant import jump_motions
from tests.reports.html_page import HtmlPage, self_contained, unsettled
from tests.reports.plant_designs import design_of
from tests.reports.test_table_gain_file import servo

PENDULUM, DISCRETE, ANALYSIS, MASS = "cart_pole", "truck_trailer", "dayawansa_martin", "tora"
SMALL = "duffing"
HOSTILE = '<script>alert("x")</script> & {{ 7*7 }}'
SECTIONS = [
    "verdict", "gains", "certificate", "set", "loops", "responses", "plant",
    "derivation", "check", "provenance",
]  # fmt: skip
FIGURES = {"memberships", "bode", "responses", "phase"}


@cache
def report_of(name: str) -> ReportFiles:
    with unsettled():
        return plant_report_files(design_of(name))


def doubted(design: PlantDesign) -> PlantDesign:
    claims = [Claim(c.name, Verdict.UNDECIDED, "a reason") for c in design.checked.claims]
    certificate = replace(design.certificate, checked=concluded(claims, ["a message"]))
    return replace(design, certificate=certificate)


@pytest.mark.parametrize(
    "name", [SMALL, ANALYSIS, *(pytest.param(n, marks=pytest.mark.slow) for n in (DISCRETE, MASS))]
)
def test_the_page_is_well_formed_and_self_contained(name: str) -> None:
    html = report_of(name).html

    self_contained(html)
    assert not re.search(r"\bon\w+=", html)


def test_sections_stand_in_their_order_with_the_verdict_first() -> None:
    for name, left_out in ((SMALL, set()), (ANALYSIS, {"gains", "loops", "set"})):
        found = [str(a["id"]) for tag, a in HtmlPage(report_of(name).html).tags if tag == "section"]
        assert found == [name for name in SECTIONS if name not in left_out]


def test_the_first_screen_has_sentence_picture_and_six_tiles() -> None:
    html = report_of(SMALL).html
    first = html[html.index('<section id="verdict"') : html.index("</section>")]
    (row,) = (row for row in summary_rows(design_of(SMALL)) if row.name == "disturbance")

    assert 'class="sentence"' in first and 'id="figure-phase"' in first
    assert first.count("<dt>") == 6
    assert ('<div class="partial">' in first) == row.partial


def test_every_claim_has_its_number_and_assumptions_of_its_own() -> None:
    """That the model equals the plant needs no continuous time; the safe set does."""
    design = design_of(SMALL)
    rows = claim_rows(design, plant_loop(design))

    assert [row["text"].partition(": ")[0] for row in rows] == [
        c.name for c in design.checked.claims
    ]
    assert all(row["number"] and row["assumes"] and row["why"] for row in rows)
    assert "no sampling" not in rows[0]["assumes"]
    assert any(
        "start in the set" in row["assumes"] and "no sampling" in row["assumes"] for row in rows
    )


@pytest.mark.slow
def test_a_law_in_samples_has_the_safe_starts_of_its_own_set() -> None:
    """The set of continuous time would promise more."""
    found = design_plant(design_of(PENDULUM).plant, PlantSettings(sample_time=0.005))
    assert isinstance(found, PlantDesign)
    rows = {row.name: row for row in summary_rows(found)}
    sampled, continuous = (
        [number.value for number in rows[name].numbers] for name in ("in samples", "safe start")
    )

    assert np.prod(sampled) < np.prod(continuous)
    assert sampled[0] < continuous[0]
    assert "run in samples" in answer_sentence(found)


def test_formulas_of_the_derivation_are_on_the_page() -> None:
    design = design_of(SMALL)
    assert design.model.derivation is not None
    count = sum(tag == "math" for tag, _ in HtmlPage(report_of(SMALL).html).tags)
    plant = design.plant

    assert count == len(design.model.derivation.steps) + len(plant.states) + len(plant.outputs) + 1


def test_gains_and_premises_are_printed_as_emitted() -> None:
    design = design_of(SMALL)
    assert design.gains is not None
    cells = HtmlPage(report_of(SMALL).html).cells

    for K in design.gains:
        row = [decimal(float(x)) for x in K.ravel()]
        assert any(cells[k : k + 2] == row for k in range(len(cells)))
    for premise in design.model.premises:
        ends = [premise.name, decimal(float(premise.lower)), decimal(float(premise.upper))]
        assert any(cells[k : k + 3] == ends for k in range(len(cells)))
        assert premise.evidence in cells


@pytest.mark.parametrize(
    "name",
    [ANALYSIS, *(pytest.param(n, marks=pytest.mark.slow) for n in (SMALL, DISCRETE, PENDULUM))],
)
def test_only_what_is_proved_is_called_so(name: str) -> None:
    proved, open_ = design_of(name), doubted(design_of(name))
    with unsettled():
        before, after = report_of(name).html, plant_report_files(open_).html

    assert proved.verdict is Verdict.PROVED and 'class="badge PROVED"' in before
    assert "badge PROVED" not in after and 'class="badge UNDECIDED"' in after
    assert "are proved to come to rest" in before and "are proved to" not in after
    assert "a message" in after and "a reason" in after
    assert proved_kinds(open_) == set()


@pytest.mark.slow
def test_the_words_about_the_plant_itself_need_the_embedding() -> None:
    design = design_of(SMALL)
    claims = list(design.checked.claims)
    assert "sector-embedding" in proved_kinds(design)
    claims[0] = replace(claims[0], verdict=Verdict.UNDECIDED)
    less = replace(design, certificate=replace(design.certificate, checked=concluded(claims, [])))

    assert "From plant to model." not in report_of(SMALL).html
    assert "From plant to model." in plant_report_files(less).html


@pytest.mark.slow
def test_a_scheduling_signal_is_no_disturbance() -> None:
    page = report_of(ANALYSIS).html
    cells = HtmlPage(page).cells

    assert cells[cells.index("w") + 1] == "scheduling"
    assert "<b>Scheduling signals</b> (w)" in page and "<b>Disturbances</b>" not in page
    assert "<b>Disturbances</b> (road)" in plant_report_files(design_of("quarter_car")).html


def test_a_plant_that_is_disproved_gets_its_report() -> None:
    """Dayawansa and Martin (1999): no common function from 3 + sqrt(8) on, here a = 6."""
    old = design_of(ANALYSIS).plant
    above = tuple(replace(p, value=Fraction(6)) for p in old.parameters)
    found = design_plant(replace(old, parameters=above))
    assert isinstance(found, PlantDesign)
    with unsettled():
        page = plant_report_files(found).html

    assert found.verdict is Verdict.DISPROVED
    assert 'class="badge DISPROVED"' in page and "are proved to" not in page


@pytest.mark.slow
def test_words_from_a_file_cannot_become_markup() -> None:
    design = design_of(ANALYSIS)
    old = design.plant
    parameters = tuple(replace(p, source=HOSTILE) for p in old.parameters)
    states = tuple(replace(v, description=HOSTILE) for v in old.states)
    plant: Plant = replace(
        old, name=HOSTILE, description=HOSTILE, source=HOSTILE, parameters=parameters, states=states
    )
    page = HtmlPage(plant_report_files(replace(design, plant=plant, notes=(HOSTILE,))).html)

    assert "script" not in {tag for tag, _ in page.tags} and not page.wrong
    assert HOSTILE in page.cells


@pytest.mark.parametrize("name", [SMALL, ANALYSIS, pytest.param(DISCRETE, marks=pytest.mark.slow)])
def test_figures_are_drawings_with_words_for_who_cannot_see_them(name: str) -> None:
    files = report_of(name)
    found = {file for file in files.figures if file.endswith(".svg")}
    expected = FIGURES - ({"bode"} if name == ANALYSIS else set())
    # Of two states the first screen has the only plane.
    expected |= {"set"} if name == DISCRETE else set()

    assert found == {f"{figure}.svg" for figure in expected}
    for file in found:
        root = ElementTree.fromstring(files.figures[file])
        assert len(root.get("aria-label") or "") > 20
        assert f'id="figure-{file.removesuffix(".svg")}"' in files.html


def test_the_data_beside_the_figures_are_what_they_show() -> None:
    files = report_of(SMALL).figures
    heads, *rows = csv.reader(io.StringIO(files["memberships-z1.csv"].decode()))
    x, value, w0, w1 = np.array(rows, dtype=float).T

    # The premise is x^2 on |x| <= 5.
    assert heads == ["x [-]", "z1 [-]", "w0 [-]", "w1 [-]"]
    assert w0 + w1 == pytest.approx(1)
    assert 25 * w1 == pytest.approx(value, rel=1e-6)
    assert value == pytest.approx(x**2, rel=1e-6)
    for file, runs in (("responses.csv", 2), ("phase.csv", 12)):
        heads, *rows = csv.reader(io.StringIO(files[file].decode()))
        table = np.array(rows, dtype=float)
        first = table[:, heads.index("time [s]")] == 0
        assert np.sum(first) == runs == table[:, 0].max()
        assert np.all(table[first, heads.index("V/level [-]")] < 1)


@pytest.mark.slow
def test_the_same_design_gives_the_same_bytes() -> None:
    with unsettled():
        again = plant_report_files(design_of(DISCRETE))

    assert again.html == report_of(DISCRETE).html
    assert again.figures == report_of(DISCRETE).figures


def test_motions_after_the_proved_jumps_arrive_within_all_ranges() -> None:
    runs = jump_motions(servo(), plant_loop(servo()))
    targets = [jump["target"] for jump in proved_jumps(servo())]

    assert len(runs) == len(targets) == 2 and targets[0] < 0 < targets[1]
    variables = (*servo().plant.states, *servo().plant.inputs)
    for run, target in zip(runs, targets, strict=True):
        assert run.state[-1][0] == pytest.approx(target, rel=1e-2)
        largest = np.abs(np.hstack([run.state, run.input])).max(axis=0)
        for variable, most in zip(variables, largest, strict=True):
            assert variable.range is None or most <= float(variable.range.upper)


def test_the_summary_says_what_follows_what() -> None:
    rows = {row.name: row for row in summary_rows(servo())}
    steps = max(abs(jump["target"]) for jump in proved_jumps(servo()))

    (number,) = rows["follows"].numbers
    assert (number.quantity, number.unit) == ("target", "deg")
    assert number.value == pytest.approx(np.degrees(steps))
    assert number.share == pytest.approx(steps / np.radians(90)) and rows["follows"].partial
    assert "target" not in {number.quantity for number in rows["disturbance"].numbers}


@pytest.mark.slow
def test_the_report_has_the_jumps_as_a_figure_and_as_numbers() -> None:
    files = plant_report_files(servo())

    assert "After jumps of the reference" in files.html
    assert "jumps.csv" in files.figures and "jumps.svg" in files.figures
    lines = files.figures["jumps.csv"].decode("utf-8").splitlines()
    first, last = lines[0], lines[-1]
    assert "theta" in first and len(last.split(",")) == len(first.split(","))


DECIMALS = st.decimals("-1000", "1000", places=7, allow_nan=False).map(float)


@given(DECIMALS, st.integers(1, 6))
def test_the_text_stays_on_the_safe_side(value: float, digits: int) -> None:
    exact = Fraction(repr(value))

    assert Fraction(at_least(value, digits)) <= exact <= Fraction(at_most(value, digits))
    assert 0 <= Fraction(at_most_to(value, digits)) - exact < Fraction(1, 10**digits)


@given(st.floats(1e-3, 1e3), st.integers(1, 4))
def test_the_page_rounds_by_the_same(value: float, digits: int) -> None:
    exact = Fraction(repr(value))

    assert Fraction(text.lower_bound(value, digits)) <= exact
    assert exact <= Fraction(text.upper_bound(value, digits))


@pytest.mark.parametrize(
    ("shown", "wanted"),
    [
        (at_least(0.145, 3), "0.145"),  # The float is less; what is meant is the decimal.
        (at_least(0.08865, 3), "0.0886"),
        (at_most(0.0399999 * 9.5493, 3), "0.382"),
        (at_most_to(3.15777, 2), "3.16"),
        (at_most_to(3.1600000001, 2), "3.17"),
        (at_most_to(2, 2), "2.00"),
        (at_most_to(-0.2532, 2), "-0.25"),
        (text.upper_bound(3.1600000001, 2), "3.17"),
        (text.lower_bound(0.3, 3), "0.300"),
        (text.with_decimals(-0.0001, 2), "0.00"),
        (text.with_decimals(float("inf"), 1), "∞"),
        (text.significant(-2.2154e-6, 3), "−2.22·10⁻⁶"),
        (text.significant(43093.55, 3), "43094"),
        (text.powers("m/s^2 and kg^-1"), "m/s² and kg⁻¹"),
    ],
)
def test_known_numbers(shown: str, wanted: str) -> None:
    assert shown == wanted
