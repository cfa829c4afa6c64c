"""Points of a sweep against the same design, certificate and check made one by one."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from operator import mul
from typing import Any

import pytest

from takagi.certificates import Checked, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_claim
from takagi.certificates.claims.turbine.published import (
    published_candidate,
    published_claim,
    with_overlaps,
)
from takagi.certificates.document.certificate_file import (
    certificate_document,
    published_law_data,
    turbine_data,
)
from takagi.certificates.sweep import sweep as points
from takagi.certificates.sweep.sweep import Axis, AxisKind, parse_axes
from takagi.models import ModelError, nrel5mw
from takagi.models.laws.published.law import equilibrium
from tests.certificates.test_paper_certificate import make_law

TURBINE = nrel5mw()
WINDS = (6.0, 12.0, 20.0)
SPANS = [(v, round(v + 0.004, 9)) for v in WINDS]


@pytest.mark.slow
def test_an_effort_sharing_point_is_what_the_direct_design_gives(built: Any) -> None:
    """The default point against gains, candidate, document and checker called one by one."""
    row = points.effort_sharing_point(built.turbine, {})
    claim, direct = effort_sharing_claim(built.candidate), check_document(built.document).claims[0]

    assert row["verdict"] == direct.verdict.name == "PROVED"
    assert row["reason"] is None
    assert row["common_decay [1/s]"] == claim["settling"]["decay_rate"]
    # The checker prints three digits, rounded up, and computes the bound by itself.
    printed = float(direct.text.split("overspeed at most ")[1].split(" %")[0])
    assert row["overspeed [%]"] <= printed <= row["overspeed [%]"] + 0.01
    widths = [b - a for a, b in pairwise(built.law.schedule.wind)]
    for key, unit in (("wind_error", "m/s"), ("wind_rate", "m/s^2")):
        values = [cell[key] for cell in claim["cells"]]
        mean = sum(map(mul, widths, values)) / sum(widths)
        assert row[f"least_{key} [{unit}]"] == min(values)
        assert row[f"mean_{key} [{unit}]"] == pytest.approx(mean, rel=1e-5)


def test_axes_change_what_they_say() -> None:
    """Plant, law, uncertainty and wind class; nothing uncertain is a value."""
    at = {"pitch-lag": 0.4, "frozen-wake": 0.0, "wind-rate": 1.0}
    plant, law, covered = points.loop_at(TURBINE, {**at, "inertia": 0.2})

    assert plant.pitch_time_constant == 0.4
    assert not law.schedule.effectiveness_limit.any()
    assert not covered["uncertainty"].frozen_wake
    assert [float(end) for end in (covered["uncertainty"].inertia.lower,)] == [0.8]
    assert max(covered["wind_class"].rate) == 1.0
    assert parse_axes(["inertia=0,0.1"], points.EFFORT_SHARING)[0].values == (0.0, 0.1)
    with pytest.raises(ModelError, match="above 0 rad/s"):
        parse_axes(["overlap=0,0.1"], points.EFFORT_SHARING)


@pytest.mark.slow
def test_a_published_window_is_the_direct_certification() -> None:
    """Each window's decay rate and set are those of a certificate made and checked by hand."""
    law = with_overlaps(make_law(), speed_overlap=0.08, torque_overlap=1500.0)
    for window, span in zip(points.certified_windows(law, SPANS), SPANS, strict=True):
        candidate = published_candidate(law, winds=[span], narrowest=0.004, ladder=points.LADDER)
        document = certificate_document(
            model=turbine_data(TURBINE, ()),
            gains=published_law_data(law),
            claims=[published_claim(candidate)],
            provenance={"solver": {}},
        )
        assert check_document(document).claims[0].verdict is Verdict.PROVED
        assert (window["from [m/s]"], window["to [m/s]"], window["verdict"]) == (*span, "PROVED")
        assert window["decay_rate [1/s]"] == min(cell.decay_rate for cell in candidate.cells)
        assert window["half_width [rad/s]"] in points.LADDER
        rest = equilibrium(law, span[0])
        assert window["rest"] == rest.kind
        assert window["power_ratio [-]"] == pytest.approx(rest.power_ratio, abs=1e-6)


@pytest.mark.slow
def test_a_published_point_counts_its_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """With f_1 = 0 at rated speed nothing rests above rated wind; below it the point holds.

    Source: docs/laws.md, "How Schulte's law was read", placement 1.
    """
    monkeypatch.setattr(points, "_law", lambda *_: make_law(placement=1.0))
    row = points.published_point("paper", TURBINE, {"speed-overlap": 0.08}, WINDS)

    assert (row["verdict"], row["proved_windows"], row["proved_at_trim"]) == ("PARTLY", 1, 1)
    assert row["first_failing_wind [m/s]"] == 12.0
    assert "no equilibrium at 12 m/s" in row["reason"]
    assert [window["rest"] for window in row["windows"]] == ["intended", "none", "none"]
    assert row["least_decay_rate [1/s]"] == row["windows"][0]["decay_rate [1/s]"]
    with pytest.raises(ModelError, match="narrow the overlap"):
        points.published_point("paper", TURBINE, {"torque-overlap": 9e4}, WINDS)


def test_a_steeper_ramp_is_proved_on_smaller_sets() -> None:
    """Until none of those tried contracts: what ends is the size of the set, not stability."""
    sizes = []
    for overlap in (0.2, 0.06, 0.01):
        law = with_overlaps(make_law(), speed_overlap=overlap, torque_overlap=2000.0)
        (window,) = points.certified_windows(law, SPANS[1:2])
        sizes.append(window["half_width [rad/s]"])
    assert sizes[0] > sizes[1] > 0
    assert sizes[2] is None
    assert window["reason"].startswith("stable where it rests (slowest at ")


def test_only_the_checker_proves(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the checker does not confirm is not proved, and takes no other window with it."""

    def doubting(document: Any) -> Checked:
        checked = check_document(document)
        spans = [claim["winds"] for claim in document["claims"]]
        claims = [
            replace(claim, verdict=Verdict.UNDECIDED) if [12.0, 12.004] in winds else claim
            for claim, winds in zip(checked.claims, spans, strict=True)
        ]
        return replace(checked, claims=claims)

    monkeypatch.setattr(points, "check_document", doubting)
    law = with_overlaps(make_law(), speed_overlap=0.08, torque_overlap=1500.0)
    windows = points.certified_windows(law, SPANS)
    assert [window["verdict"] for window in windows] == ["PROVED", "UNDECIDED", "PROVED"]
    assert windows[1]["reason"] == "the checker did not confirm what was found"


def test_winds_of_a_published_law() -> None:
    """One a metre per second from 3.5 on, and the full ones within 1.5 m/s of rated, 11.3 m/s."""
    winds = points.default_winds(TURBINE)
    assert winds[:3] == (3.5, 4.5, 5.5)
    assert (winds[-1], len(winds)) == (24.5, 25)
    assert {v for v in winds if v == int(v)} == {10.0, 11.0, 12.0}
    with pytest.raises(ModelError, match="2 m/s was given.*from 3 to 24.996 m/s"):
        points.require_winds(TURBINE, (2.0, 8.0))


KINDS = (
    AxisKind("speed-overlap", "rad/s"),
    AxisKind("torque-overlap", "N m"),
    AxisKind("share", "-", highest=0.5),
)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("speed-overlap=0.02:0.2:3", (0.02, 0.11, 0.2)),
        ("speed-overlap=1:2:4", (1.0, 1.33333333, 1.66666667, 2.0)),
        ("speed-overlap=0.05", (0.05,)),
        ("speed-overlap= .05 , 1e-1 ", (0.05, 0.1)),
        ("torque-overlap=0.5kNm:5kN m:2", (500.0, 5000.0)),
        ("torque-overlap=500 N m,5kNm", (500.0, 5000.0)),
        ("speed-overlap=3deg/s", (0.0523598775598,)),
        ("share=0.5", (0.5,)),
    ],
)
def test_values(text: str, values: tuple[float, ...]) -> None:
    """Ranges, lists and units give short decimals in SI."""
    (axis,) = parse_axes([text], KINDS)
    assert axis.values == values
    assert axis == Axis(text.partition("=")[0], axis.unit, values)


@pytest.mark.parametrize(
    ("texts", "parts"),
    [
        (["sped-overlap=1"], ["'sped-overlap'", "did you mean 'speed-overlap'", "share [-]"]),
        (["wind=1:2:3"], ["'wind' cannot be swept", "speed-overlap [rad/s], torque-overlap [N m]"]),
        (["share=0.1", "share=0.2"], ["share was given before"]),
        (["share"], ["--over share: write share=LOW:HIGH:COUNT"]),
        (["share=0.1:0.2"], ["write share=LOW:HIGH:COUNT"]),
        (["share=0.1:0.2:1"], ["whole number from 2 to 100000"]),
        (["share=0.1:0.2:2.5"], ["'2.5'", "whole number"]),
        (["share=0.2:0.1:3"], ["0.2 is followed by", "must increase"]),
        (["share=0.1:0.1:3"], ["must increase"]),
        (["share=0.2,0.1"], ["0.2 is followed by 0.1", "must increase"]),
        (["share=0.1,x"], ["'x' is not a number"]),
        (["share=nan"], ["'nan' is not a number"]),
        (["share=1e999"], ["is not a number"]),
        (["share=0.1:0.6:3"], ["0.6", "above 0 and at most 0.5"]),
        (["share=0"], ["above 0"]),
        (["torque-overlap=0.1rad/s"], ["'rad/s' does not fit", "'kN m'"]),
        (["torque-overlap=5lbf"], ["'lbf' is not known"]),
        (["share=0.1:0.2:100001"], ["100001"]),
        (["share=0.1:0.2:400", "speed-overlap=1:2:400"], ["160000 points", "100000"]),
    ],
)
def test_mistakes(texts: list[str], parts: list[str]) -> None:
    """Each mistake names what was given, and what is needed."""
    with pytest.raises(ModelError) as raised:
        parse_axes(texts, KINDS)
    for part in parts:
        assert part in str(raised.value)
