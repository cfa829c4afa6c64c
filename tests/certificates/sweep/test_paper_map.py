"""The paper's map: a point says what the direct certification says; bad axes name the cure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from takagi.certificates import Checked, TurbineDesign, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine import (
    published_candidate,
    published_claim,
    published_law_data,
    with_overlaps,
)
from takagi.certificates.document import certificate_document, turbine_data
from takagi.certificates.sweep import Axis, Task, certified_windows, parse_axes
from takagi.certificates.sweep import published_point as paper_point
from takagi.certificates.sweep.effort_sharing_row import effort_sharing_row
from takagi.certificates.sweep.published_map import AXES, build, default_winds, point, windows
from takagi.certificates.sweep.published_point import LADDER, overlap_point
from takagi.models import ModelError, nrel5mw
from takagi.models.laws.published import PublishedLawName
from takagi.models.laws.published.equilibrium import equilibrium
from tests.certificates.test_paper_certificate import LAWS, make_law

TURBINE = nrel5mw()
WINDS = ((6.0, 6.004), (12.0, 12.004), (20.0, 20.004))
OVERLAPS = {"speed_overlap": 0.08, "torque_overlap": 1500.0}


def never(*_: Any) -> None:
    """Nothing is to be told."""


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_a_point_is_the_direct_certification(name: PublishedLawName) -> None:
    """Each window's decay rate and set are those of a certificate made and checked by hand."""
    found = overlap_point(make_law(name), winds=WINDS, **OVERLAPS)
    law = with_overlaps(make_law(name), **OVERLAPS)
    for window, span in zip(found["windows"], WINDS, strict=True):
        candidate = published_candidate(law, winds=[span], narrowest=0.004, ladder=LADDER)
        document = certificate_document(
            model=turbine_data(TURBINE, ()),
            gains=published_law_data(law),
            claims=[published_claim(candidate)],
            provenance={"solver": {}},
        )
        assert check_document(document).claims[0].verdict is Verdict.PROVED
        assert window["verdict"] == "PROVED" and window["wind [m/s]"] == list(span)
        rates = [cell.decay_rate for cell in candidate.cells]
        assert window["decay_rate [1/s]"] == min(rates)
        assert window["half_width [rad/s]"] in LADDER
        rest = equilibrium(law, span[0])
        assert window["rest"] == rest.kind
        assert window["power_ratio [-]"] == pytest.approx(rest.power_ratio, abs=1e-6)
    assert found["verdict"] == "PROVED" and found["reason"] is None
    assert found["proved_windows"] == 3
    assert found["least_decay_rate [1/s]"] == min(w["decay_rate [1/s]"] for w in found["windows"])


@pytest.mark.slow
def test_sides_of_a_threshold() -> None:
    """A steeper ramp is proved on smaller sets, until none of those tried contracts.

    The loop is stable where it rests on both sides (docs/laws.md, "One integrator"): what ends
    is the size of the set, and the reason says so.
    """
    law, winds = make_law("paper"), [(12.0, 12.004)]
    sizes = []
    for overlap in (0.2, 0.1, 0.06):
        (window,) = certified_windows(
            with_overlaps(law, speed_overlap=overlap, torque_overlap=2000.0), winds
        )
        assert window.proved and window.half_width is not None
        sizes.append(window.half_width)
    assert sizes == sorted(sizes, reverse=True) and sizes[0] > sizes[-1]
    found = overlap_point(law, speed_overlap=0.01, torque_overlap=2000.0, winds=winds)
    assert found["verdict"] == "UNDECIDED" and found["first_failing_wind [m/s]"] == 12.0
    assert found["reason"].startswith("12 to 12.004 m/s: stable where it rests (slowest at ")
    assert found["windows"][0]["decay_rate [1/s]"] is None


def test_no_equilibrium_is_a_reason() -> None:
    """With f_1 = 0 at rated speed nothing rests above rated wind; below it the point holds.

    Source: docs/laws.md, "One integrator", placement 1.
    """
    found = overlap_point(make_law("paper", placement=1.0), winds=WINDS, **OVERLAPS)
    assert found["verdict"] == "PARTLY" and found["proved_windows"] == 1
    assert "no equilibrium at 12 m/s" in found["reason"]
    assert [window["rest"] for window in found["windows"]] == ["intended", "none", "none"]
    assert found["windows"][1]["power_ratio [-]"] is None


def test_only_the_checker_proves(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the checker does not confirm is not proved, and takes no other window with it."""
    asked = []

    def doubting(document: Any) -> Checked:
        """Confirm nothing that covers 12 m/s."""
        checked = check_document(document)
        spans = [claim["winds"] for claim in document["claims"]]
        asked.append(len(spans))
        claims = [
            replace(claim, verdict=Verdict.UNDECIDED) if [12.0, 12.004] in winds else claim
            for claim, winds in zip(checked.claims, spans, strict=True)
        ]
        return replace(checked, claims=claims)

    monkeypatch.setattr(paper_point, "check_document", doubting)
    found = overlap_point(make_law("paper"), winds=WINDS, **OVERLAPS)
    assert [w["verdict"] for w in found["windows"]] == ["PROVED", "UNDECIDED", "PROVED"]
    assert found["reason"] == "12 to 12.004 m/s: the checker did not confirm what was found"
    assert asked == [1, 3]


def test_tasks_name_the_overlaps() -> None:
    """The map's point function hands its task's values on, in their units."""
    from takagi.certificates.sweep.published_map import Prepared

    at = {"speed-overlap": 0.08, "torque-overlap": 1500.0}
    task = Task(at, {}, Prepared(make_law("paper"), WINDS[:1]))
    assert point(task) == overlap_point(make_law("paper"), winds=WINDS[:1], **OVERLAPS)


@pytest.mark.parametrize(
    ("over", "parts"),
    [
        ("wind=2,8", ["2 m/s", "between cut-in and cut-out", "from 3 to 24.996 m/s"]),
        ("wind=8,25", ["25 m/s", "24.996"]),
        ("wind=8,8.003", ["8 and 8.003", "0.004 m/s", "fewer winds"]),
        ("speed-overlap=0.5,1.5", ["1.5 rad/s", "cut-in (3 m/s)", "give values below 1.09 rad/s"]),
        ("torque-overlap=2kNm,9kNm", ["axis torque-overlap", "47593.6", "narrow the overlap"]),
    ],
)
def test_values_beyond_the_turbine(over: str, parts: list[str]) -> None:
    """Values that the tables do not allow are refused before anything is designed."""
    with pytest.raises(ModelError) as raised:
        build("paper", TURBINE, (), parse_axes([over], AXES), never)
    for part in parts:
        assert part in str(raised.value)


def test_default_winds() -> None:
    """One a metre per second from 3.5 on, and the full ones within 1.5 m/s of rated, 11.3 m/s."""
    winds = default_winds(TURBINE)
    assert winds[:3] == (3.5, 4.5, 5.5) and winds[-1] == 24.5
    assert {v for v in winds if v == int(v)} == {10.0, 11.0, 12.0}
    assert len(windows(TURBINE, winds)) == 25


def test_the_coherent_law_beside(
    turbine_design: TurbineDesign, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its windows have the decay rates of its certificate's cells; damaged, they are not proved."""
    from takagi.certificates.sweep import effort_sharing_row as module

    monkeypatch.setattr(module, "design_turbine", lambda *_: turbine_design)
    swept = effort_sharing_row(TURBINE, WINDS)
    found = swept.point(Task({}, swept.settings, TURBINE))
    cells = turbine_design.document["claims"][0]["cells"]
    assert found["verdict"] == "PROVED"
    for window, (low, high) in zip(found["windows"], WINDS, strict=True):
        inside = [c for c in cells if c["wind"][0] < high and c["wind"][1] > low]
        assert window["decay_rate [1/s]"] == min(c["decay_rate"] for c in inside)
    claim = turbine_design.document["claims"][0] | {"cells": cells[1:]}
    damaged = replace(turbine_design, document={**turbine_design.document, "claims": [claim]})
    monkeypatch.setattr(module, "design_turbine", lambda *_: damaged)
    gap = effort_sharing_row(TURBINE, [(3.0, 3.004), *WINDS])
    partly = gap.point(Task({}, gap.settings, TURBINE))
    assert partly["verdict"] == "PARTLY" and partly["proved_windows"] == 3
    assert partly["reason"].endswith("the certificate's cells do not cover it")


def test_one_axis_keeps_the_other_overlap(monkeypatch: pytest.MonkeyPatch) -> None:
    """An axis that is not given has the design's value; winds are settings, not points."""
    from takagi.certificates.sweep import published_map as paper_map

    monkeypatch.setattr(paper_map, "_law", lambda name, _: make_law(name))
    swept = build("paper", TURBINE, (), parse_axes(["wind=6,12"], AXES), never)
    assert swept.axes == (
        Axis("speed-overlap", "rad/s", (0.1,)),
        Axis("torque-overlap", "N m", (2000.0,)),
    )
    assert swept.settings["windows"] == [[6.0, 6.004], [12.0, 12.004]]
    assert [other.name for other in swept.beside] == ["coherent"]
    other = build("paper", TURBINE, (), parse_axes(["wind=6,13"], AXES), never)
    assert other.digest != swept.digest
