"""A certificate against an older one: from both sides of the tolerance, and what is lost."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Checked, Claim, Verdict
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.document.certificate_file import certificate_document, dumps
from takagi.cli.main import main
from takagi.models import ModelError
from takagi.reports.baseline.comparison import (
    CertificateComparison,
    compare_certificates,
    gain_sizes,
    listed_changes,
    summary_changes,
)
from takagi.reports.baseline.page import as_data, as_markdown, as_text, gain_words
from tests.reports.html_page import HtmlPage

Data = dict[str, Any]
HALVES = {"name": "line", "kind": "decay", "P": [[1, 0], [0, 1]]}


def document(
    *claims: Data, A: Any = ((-1.0, 0.0), (0.0, -2.0)), configuration: Any = None, **model: Any
) -> Data:
    names = ["angle [rad]", "rate [rad/s]"]
    kind = {"kind": "takagi-sugeno", "sample_time": None, "state_names": names}
    return certificate_document(
        model={**kind, "A": [A], **model},
        gains=None,
        claims=claims,
        provenance={"configuration": configuration or {}},
    )


def test_two_plants_are_not_compared() -> None:
    """Another name with other signals is another plant; a plant that was renamed is none."""
    claim = {**HALVES, "decay_rate": 0.5}
    one, renamed = document(claim, name="motor"), document(claim, name="motor 2")
    other = document(claim, name="pump", state_names=["level [m]", "flow [m^3/s]"])

    assert against(one, renamed).passes
    with pytest.raises(ModelError, match="motor and pump"):
        against(one, other)


def ellipsoid(level: float, **more: Any) -> Data:
    own = {"name": "set", "kind": "invariant-ellipsoid", "P": [[1, 0], [0, 1]]}
    return {**own, "level": level, "multiplier": 0.5, **more}


def against(old: Data, new: Data, tolerance: str = "0.05") -> CertificateComparison:
    first, second = (read_text(json.dumps(one), "test") for one in (old, new))
    return compare_certificates(
        first,
        second,
        checked_old=check_document(old),
        checked_new=check_document(new),
        tolerance=Fraction(tolerance),
    )


def decay(rate: float) -> Data:
    return document(HALVES | {"decay_rate": rate})


def test_a_figure_may_fall_to_the_tolerance_and_not_below() -> None:
    """5 % of 0.8 is 0.04: 0.76 passes exactly, 0.7599999 does not; more is never worse."""
    assert against(decay(0.8), decay(0.76)).passes
    assert not against(decay(0.8), decay(0.7599999)).passes
    assert against(decay(0.8), decay(0.9)).passes
    assert not against(decay(0.8), decay(0.7999999), "0").passes
    assert against(decay(0.8), decay(0.8), "0").passes


@given(st.integers(1, 900), st.integers(1, 900), st.integers(0, 100))
def test_passing_is_the_inequality(old: int, new: int, percent: int) -> None:
    """new >= old (1 - tolerance), decided here in whole numbers."""
    found = against(decay(old / 1000), decay(new / 1000), str(Fraction(percent, 100)))

    assert found.passes == (100 * new >= old * (100 - percent))


def test_figures_that_are_better_smaller() -> None:
    """A gain of 1.05 in the place of 1 is 5 % worse; the reach of a set grows like its root."""
    gain = {"kind": "l2-gain", "name": "g", "disturbance": "disturbances", "P": [[1, 0], [0, 1]]}

    def file(value: float) -> Data:
        return document(gain | {"gain": value}, C=[[[1, 0]]], E=[[[1], [0]]])

    assert check_document(file(1.1)).verdict is Verdict.PROVED
    assert against(file(1.1), file(1.155)).passes
    assert not against(file(1.1), file(1.1551)).passes


def test_a_smaller_set_is_worse_by_volume_before_it_is_by_reach() -> None:
    """Volume pi c, reach sqrt(c): of c = 0.94, -6 % and -3.05 %."""
    found = against(document(ellipsoid(1)), document(ellipsoid(0.94)))
    change = {moved.figure: moved.change for moved in found.moved}

    assert float(change["volume of the set"]) == pytest.approx(-0.06)
    start = "safe start of angle, others at rest"
    assert float(change[start]) == pytest.approx(0.94**0.5 - 1)
    assert [moved.figure for moved in found.moved if moved.worse] == ["volume of the set"]


def test_a_narrower_box_is_worse_though_no_claim_says_so() -> None:
    """The box of a model is what every claim is about: ends are compared by its width."""
    wide, narrow = ({"box": {"angle [rad]": [-1, end]}} for end in (1, 0.89))
    old, new = (document(HALVES | {"decay_rate": 0.5}, **box) for box in (wide, narrow))

    found = against(old, new)

    assert [moved.figure for moved in found.moved if moved.worse] == ["angle [rad], upper end"]
    assert float(found.moved[1].change) == pytest.approx(-0.055)
    assert against(new, old).passes
    assert not against(decay(0.5), old).passes


@pytest.mark.parametrize(
    ("new", "why"),
    [(document(ellipsoid(1)), "no such claim"), (decay(1.1), "was PROVED, is UNDECIDED")],
)
def test_a_lost_claim_is_worse_than_any_figure(new: Data, why: str) -> None:
    found = against(decay(0.8), new, "1")

    assert not found.passes
    assert why in found.lost["line"]
    assert "lost    line" in as_text(found, source="old.json")


def test_what_asks_something_else_is_not_compared() -> None:
    """Poles left of -0.1 say nothing about poles left of -0.5, whatever the claim is called."""
    region = {"name": "poles", "kind": "region", "P": [[1, 0], [0, 1]]}

    def file(rate: float) -> Data:
        return document(region | {"parts": [{"L": [[2 * rate]], "M": [[1]]}]})

    assert check_document(file(0.5)).verdict is Verdict.PROVED
    assert against(file(0.5), file(0.5)).passes
    assert "asks something else" in against(file(0.5), file(0.1)).lost["poles"]


def test_an_unproved_baseline_asks_for_nothing() -> None:
    """What was never proved cannot be lost."""
    assert against(decay(1.1), document(ellipsoid(1))).passes


def test_equal_names_are_matched_in_order_and_new_ones_by_kind() -> None:
    sets = document(ellipsoid(1), ellipsoid(4))
    renamed = document(ellipsoid(4, name="other"), ellipsoid(1))

    assert against(sets, sets).passes
    assert against(sets, document(ellipsoid(1))).lost.keys() == {"set (2)"}
    assert against(sets, renamed, "0").passes
    assert against(document(ellipsoid(1)), sets).added == ("set (2)",)


def test_changes_name_parameter_gain_and_option() -> None:
    old = document(HALVES | {"decay_rate": 0.5}, configuration={"decay_rate": None})
    faster = ((-1.0, 0.0), (0.0, -3.0))
    new = document(HALVES | {"decay_rate": 0.5}, A=faster, configuration={"decay_rate": 2})

    assert listed_changes(against(old, new).changed) == [
        "model: A.1.2.2: -2.0 -> -3.0",
        "configuration: decay_rate: nothing -> 2",
    ]


def turbine(*cells: tuple[float, float, float], peak: float = 0.05) -> tuple[Data, Checked]:
    """Return a turbine's document, and the checked claim with one number for each wind cell."""
    claim = {"kind": "coherent-loop", "name": "loop"}
    data = {"model": {"kind": "turbine"}, "gains": {}, "claims": [claim]}
    spans = tuple((Fraction(low), Fraction(high), Fraction(value)) for low, high, value in cells)
    overspeed = Figure("overspeed", "-", Fraction(peak) / Fraction("1.25"), larger=False)
    figures = (WindProfile("wind error", "m/s", spans), overspeed)
    proved = Claim("loop", Verdict.PROVED, "", figures=figures)
    return read_text(json.dumps(data), "test"), concluded([proved], [])


@pytest.mark.parametrize(
    ("cells", "where"),
    [
        ([(3, 4, 0.2), (4, 5, 0.1)], ""),
        ([(3, 3.5, 0.3), (3.5, 4, 0.2), (4, 5, 0.096)], ""),
        ([(3, 3.5, 0.3), (3.5, 4, 0.18), (4, 5, 0.1)], "3 to 4 m/s"),
        ([(3, 5, 0.15)], "3 to 4 m/s"),
        ([(3, 4, 0.2), (4, 4.9, 0.1)], "4 to 5 m/s"),
        ([(3, 4, 0.2), (4.1, 5, 0.1)], "4 to 5 m/s"),
    ],
)
def test_wind_classes_are_compared_over_the_wind(cells: Any, where: str) -> None:
    old, checked = turbine((3, 4, 0.2), (4, 5, 0.1))
    new, checked_new = turbine(*cells)

    found = compare_certificates(old, new, checked_old=checked, checked_new=checked_new)

    places = {moved.place for moved in found.moved if moved.worse}
    assert places == ({where} if where else set())


def test_overspeed_is_worse_when_it_rises() -> None:
    """Peak 0.05 above 1.25 is 4 % overspeed; 0.053 is 6 % more of it."""
    (old, checked), (new, checked_new) = turbine((3, 4, 1)), turbine((3, 4, 1), peak=0.053)

    found = compare_certificates(old, new, checked_old=checked, checked_new=checked_new)

    assert [moved.figure for moved in found.moved if moved.worse] == ["overspeed"]


def test_numbers_that_no_float_holds_are_shown() -> None:
    """Volume of {1e-40 |x|^2 <= 1e40} in R^10 is beyond 1e308 and is no reason to fail."""
    n = 10
    names = [f"x{k}" for k in range(n)]
    A = [[-int(i == j) for j in range(n)] for i in range(n)]
    P = [[1e-40 if i == j else 0 for j in range(n)] for i in range(n)]
    model = {"kind": "takagi-sugeno", "sample_time": None, "state_names": names, "A": [A]}
    claim = ellipsoid(1e40) | {"P": P}
    old = certificate_document(model=model, gains=None, claims=[claim], provenance={})
    new = deepcopy(old)

    found = against(old, new)

    assert found.passes
    assert json.loads(json.dumps(as_data(found), allow_nan=False))["figures"][0]["old"] is None


BOTH = document(HALVES | {"decay_rate": 0.8}, ellipsoid(0.5))


@pytest.mark.parametrize(
    ("old", "new", "phrase"),
    [
        (decay(0.5), decay(0.6), "nothing got worse by more than 5 %; better (faster)"),
        (decay(0.6), decay(0.5), "1 figure got worse by more than 5 %; worse (slower)"),
        (decay(0.6), decay(0.6), "nothing got worse by more than 5 %; no figure changed"),
        (decay(0.6), decay(0.6001), "no figure changed by more than 0.1 %"),
        (BOTH, decay(0.79), "1 claim lost"),
        (BOTH, decay(0.4), "1 figure got worse by more than 5 %, 1 claim lost"),
        (
            BOTH,
            document(HALVES | {"decay_rate": 0.4}, ellipsoid(0.4)),
            "4 figures got worse by more than 5 %",
        ),
        (
            document(HALVES | {"decay_rate": 0.5}, ellipsoid(1)),
            document(HALVES | {"decay_rate": 0.6}, ellipsoid(0.5)),
            "partly better (faster), partly worse (smaller set)",
        ),
    ],
)
def test_the_first_line_is_a_verdict_in_words(old: Data, new: Data, phrase: str) -> None:
    found = against(old, new)

    for told in (as_text(found, source="old.json"), as_markdown(found, source="old.json")):
        assert phrase in told.splitlines()[0]
    assert as_data(found)["verdict"] in as_text(found, source="old.json")


def test_sizes_of_gains_are_compared_by_input_and_state() -> None:
    law = {"input_names": ["u [N]"], "state_names": ["x [m]", "v [m/s]"]}
    old = law | {"K": [[[2.0, -4.0]], [[1.0, 3.0]]]}
    new = law | {"K": [[[3.0, -2.0]], [[1.0, 1.0]]]}

    sizes = gain_sizes(old, new)

    assert [(one.name, one.old, one.new) for one in sizes] == [
        ("u [N] by x [m]", 2.0, 3.0),
        ("u [N] by v [m/s]", 4.0, 2.0),
    ]
    assert gain_words(sizes) == "gains from 0.5 to 1.5 times the old ones"
    assert gain_words(gain_sizes(old, old)) == ""
    assert gain_sizes(old, new | {"state_names": ["x [m]", "w [m/s]"]}) == ()
    assert gain_words(gain_sizes(old, law | {"K": [[[4.0, 4.0]]]})) == "larger gains, up to 2 times"


def test_rows_of_two_summaries_that_differ_are_shown() -> None:
    old = [SimpleNamespace(name=n, text=t) for n, t in (("settles", "2 s"), ("input", "1 V"))]
    new = [SimpleNamespace(name=n, text=t) for n, t in (("settles", "1 s"), ("margins", "60 deg"))]
    same = SimpleNamespace(name="gains", text="K")
    changes = summary_changes(cast(Any, [*old, same]), cast(Any, [*new, same]))
    compared = replace(against(decay(0.5), decay(0.5)), summary=changes)

    assert [(c.name, c.old, c.new) for c in changes] == [
        ("settles", "2 s", "1 s"),
        ("margins", "", "60 deg"),
        ("input", "1 V", ""),
    ]
    law = [SimpleNamespace(name="gains", text=t) for t in ("u = -x", "v = -2 x", "v = -3 x")]
    (gains,) = summary_changes(cast(Any, law[:2]), cast(Any, law[::2]))
    assert (gains.old, gains.new) == ("u = -x; v = -2 x", "u = -x; v = -3 x")
    assert "settles: 2 s -> 1 s" in as_text(compared, source="old")
    assert "settles: 2 s -> 1 s" in as_markdown(compared, source="old")
    assert as_data(compared)["summary"][2] == {"name": "input", "old": "1 V", "new": ""}


P = [[1, 0], [0, 1]]


def design(folder: Path, rate: float, *, level: float = 0, name: str = "motor") -> Path:
    """Write a design of x1' = -x1, x2' = -2 x2: its claims, and a report if it has a set."""
    claims: list[Data] = [{"name": "line", "kind": "decay", "P": P, "decay_rate": rate}]
    if level:
        of_set = {"name": "set", "kind": "invariant-ellipsoid", "P": P, "multiplier": 0.5}
        claims.append({**of_set, "level": level})
    document = certificate_document(
        model={
            "kind": "takagi-sugeno",
            "name": name,
            "sample_time": None,
            "state_names": [f"{name} angle [rad]", "rate [rad/s]"],
            "A": [[[-1.0, 0.0], [0.0, -2.0]]],
        },
        gains=None,
        claims=claims,
        provenance={"configuration": {}},
    )
    folder.mkdir()
    (folder / "certificate.json").write_text(dumps(document), encoding="utf-8")
    if level:
        (folder / "report.html").write_text("<html></html>", encoding="utf-8")
    return folder


def page_of(*folders: Path, out: Path, status: int) -> HtmlPage:
    """Compare the designs; return the page, which loads nothing and is well-formed."""
    places = [str(folder) for folder in folders]
    assert main(["compare", *places, "--html", str(out)]) == status
    page = HtmlPage(out.read_text(encoding="utf-8"))
    assert page.wrong == [] and page.open == []
    assert not {"script", "link", "img", "iframe", "object"} & {tag for tag, _ in page.tags}
    return page


def test_each_design_has_a_column_and_each_change_a_word(tmp_path: Path) -> None:
    """5 % of 0.8 is 0.04: 0.77 is worse and allowed, 0.7 is more than allowed, 0.9 is better."""
    folders = [
        design(tmp_path / name, rate)
        for name, rate in (("base", 0.8), ("b", 0.77), ("c", 0.7), ("d", 0.9), ("e", 0.8))
    ]

    page = page_of(*folders, out=tmp_path / "page.html", status=1)

    start = next(k for k, cell in enumerate(page.cells) if cell.startswith("decay rate"))
    row = [page.cells[start + k] for k in range(6)]
    assert row[1:] == ["0.8", "0.77", "0.7", "0.9", "0.8"]
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    for words in (
        '<td class="open">0.77<span>slower, 3.75 % worse<',
        '<td class="bad">0.7<span>slower, 12.5 % worse (over 5 %)<',
        '<td class="good">0.9<span>faster, 12.5 % better<',
        "<td>0.8<span>the same<",
    ):
        assert words in text
    assert text.count('<span class="badge PROVED">') == 5
    assert text.count("<strong>worse") == 1 and text.count("<strong>not worse") == 3


def test_a_claim_is_lost_in_one_design_and_the_reports_are_linked(tmp_path: Path) -> None:
    folders = [design(tmp_path / "with a space", 0.8, level=1), design(tmp_path / "b", 0.8)]
    third = design(tmp_path / "c", 0.8, level=0.5)

    page = page_of(*folders, third, out=tmp_path / "pages" / "all.html", status=1)

    links = [a["href"] for a in page.all("a") if not str(a["href"]).startswith("#")]
    assert links == ["../with%20a%20space/report.html", "../c/report.html"]
    text = (tmp_path / "pages" / "all.html").read_text(encoding="utf-8")
    assert "1 claim lost" in text and "lost<span>not proved here" in text
    # Three figures of the set are lost in one design, and decay rate is the same in all.
    assert text.count("lost<span>not proved here") == 3 and "the others, 1, are the same" in text
    assert "smaller set, 50 % worse (over 5 %)" in text


def damaged(folder: Path, **members: object) -> Path:
    file = folder / "certificate.json"
    document = json.loads(file.read_text(encoding="utf-8")) | members
    file.write_text(json.dumps(document), encoding="utf-8")
    return folder


@pytest.mark.parametrize("which", ["plant", "version", "empty", "missing"])
def test_what_cannot_be_compared_is_refused_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], which: str
) -> None:
    base, other = design(tmp_path / "base", 0.8), tmp_path / "other"
    cure = "takagi design MODEL --out DIR"
    if which == "plant":
        design(other, 0.8, name="pump")
        cure = "give two certificates of one"
    elif which == "version":
        damaged(design(other, 0.8), version=2)
        cure = "version"
    elif which == "empty":
        other.mkdir()
    page = tmp_path / "page.html"

    assert main(["compare", str(base), str(other), "--html", str(page)]) == 2

    lines = capsys.readouterr().err.strip().splitlines()
    assert lines[-1].startswith("Error: ") and cure in lines[-1]
    assert [line for line in lines if line.startswith("Error: ")] == lines[-1:]
    assert not page.exists()
