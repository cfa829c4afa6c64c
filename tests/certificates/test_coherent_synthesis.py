"""Gains and function together, as a certificate: more than two steps prove, and never less."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from takagi.certificates import DesignSettings, Verdict, design_turbine
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine.effort_sharing import (
    DEFAULT_BOX,
    DEFAULT_UNCERTAINTY,
    effort_sharing_candidate,
    effort_sharing_claim,
)
from takagi.certificates.design.turbine.effort_sharing_gains import (
    EffortSharingGainDesign,
    effort_sharing_gain_design,
    wind_by_wind_law,
)
from takagi.certificates.design.turbine.settings import Synthesis
from takagi.certificates.document.certificate_file import (
    effort_sharing_law_data,
    turbine_data,
)
from takagi.lmi.turbine.one_step import design as one_step_climb
from takagi.models import Interval, ModelError, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw, LoopUncertainty
from takagi.models.turbine.data import FrozenWake
from takagi.models.turbine.loader import model_files
from tests.certificates.conftest import Built
from tests.certificates.kinds.claims import sealed

NODES = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")


def part_of(law: EffortSharingLaw, low: float, high: float) -> EffortSharingLaw:
    kept = (law.schedule.wind >= low) & (law.schedule.wind <= high)
    cells = kept[:-1] & kept[1:]
    columns = {name: getattr(law.schedule, name)[kept] for name in NODES}
    return replace(
        law,
        schedule=replace(law.schedule, **columns),
        gains=EffortGains(law.gains.proportional[kept], law.gains.integral_rate[cells]),
    )


@pytest.fixture(scope="module")
def near_rated(built: Built) -> EffortSharingLaw:
    """Return the law of a few cells whose integral is too slow, so that there is much to gain."""
    law = part_of(built.law, 11.4, 11.7)
    slow = EffortGains(law.gains.proportional, np.round(0.7 * law.gains.integral_rate, 6))
    return replace(law, gains=slow)


def synthesised(
    built: Built, law: EffortSharingLaw, synthesis: Synthesis, steps: int = 3
) -> EffortSharingGainDesign:
    return effort_sharing_gain_design(
        built.turbine,
        law,
        box=DEFAULT_BOX,
        uncertainty=DEFAULT_UNCERTAINTY,
        synthesis=synthesis,
        steps=steps,
    )


def verdict(built: Built, found: EffortSharingGainDesign, **change: object) -> Verdict:
    document = sealed(
        turbine_data(built.turbine, []),
        effort_sharing_law_data(found.law),
        effort_sharing_claim(found.candidate) | change,
    )
    return check_document(document).verdict


def mean_error(found: EffortSharingGainDesign) -> float:
    return float(np.exp(np.log(found.candidate.wind_error).mean()))


@pytest.mark.slow
def test_one_step_proves_more_wind_and_no_cell_bears_less(
    built: Built, near_rated: EffortSharingLaw
) -> None:
    """Both are PROVED; the joint gains allow more wind error, on average and at least."""
    two = synthesised(built, near_rated, "two-step")
    one = synthesised(built, near_rated, "one-step")
    assert verdict(built, two) is Verdict.PROVED is verdict(built, one)
    assert two.joint is None and two.kept == ""
    assert one.joint is not None and one.kept == "" and len(one.joint.history) > 1
    assert mean_error(one) > 1.03 * mean_error(two)
    weakest = effort_sharing_candidate(built.turbine, near_rated).wind_error.min()
    assert one.candidate.wind_error.min() >= 0.98 * weakest
    claim = effort_sharing_claim(one.candidate)
    cells = [dict(cell) for cell in claim["cells"]]
    cells[0]["wind_error"] *= 1.05
    assert verdict(built, one, cells=cells) is not Verdict.PROVED


@pytest.mark.slow
def test_a_given_function_is_taken_where_it_holds_and_replaced_where_not(
    built: Built, near_rated: EffortSharingLaw
) -> None:
    """P of the two-step analysis stays P; one that fails everywhere or leaves the box does not."""
    first = effort_sharing_candidate(built.turbine, near_rated)
    assert first.P is not None
    rates = [Fraction(cell.wind_rate) for cell in first.cells]
    again = effort_sharing_candidate(built.turbine, near_rated, P=first.P, rates=rates)
    assert again.P == pytest.approx(first.P, rel=1e-4)
    assert again.wind_error == pytest.approx(first.wind_error, rel=2e-3)
    wide = effort_sharing_candidate(built.turbine, near_rated, P=0.5 * first.P)
    turned = effort_sharing_candidate(built.turbine, near_rated, P=np.diag([3e3, 2e4, 9e9]))
    for other in (wide, turned):
        assert other.P == pytest.approx(first.P, rel=1e-6)


@pytest.mark.slow
def test_where_no_step_gains_the_two_step_gains_are_kept_and_it_is_said(
    built: Built, near_rated: EffortSharingLaw, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search without a single step, or whose every step is refused."""
    monkeypatch.setattr(one_step_climb, "joint_step", lambda *_: None)
    found = synthesised(built, near_rated, "one-step", steps=1)
    assert found.law is near_rated and found.joint is None
    assert found.kept == "none of 1 joint steps made the objective better"
    assert verdict(built, found) is Verdict.PROVED


@pytest.mark.slow
def test_no_function_at_the_start_is_told_with_its_wind(built: Built) -> None:
    """A third to five times the inertia is beyond any function: the message names the wind."""
    with pytest.raises(ModelError, match=r"no common quadratic function.*wind 11\."):
        effort_sharing_gain_design(
            built.turbine,
            part_of(built.law, 11.3, 11.6),
            box=DEFAULT_BOX,
            uncertainty=LoopUncertainty(Interval.of("0.2", "3"), frozen_wake=True),
        )


@pytest.mark.slow
def test_a_cell_without_a_wind_error_is_told_with_what_would_do(
    built: Built, reduced: bool
) -> None:
    """A frozen wake that is too strong near rated wind: the cell, the reason, the pitch tried."""
    if reduced:
        pytest.skip("reduced: a minute and a half; words of one cell")
    wake, asked = built.turbine.frozen_wake, DesignSettings()
    columns = (wake.wind[2:], wake.pitch[2:], wake.power_sensitivity[2:])
    strong = replace(built.turbine, frozen_wake=FrozenWake(*columns, "from 13 m/s on"))

    def law(turbine: Turbine) -> EffortSharingLaw:
        return part_of(wind_by_wind_law(turbine, asked)[1], 10.9, 12.1)

    def designed(turbine: Turbine) -> EffortSharingGainDesign:
        return effort_sharing_gain_design(
            turbine,
            law(turbine),
            box=asked.box,
            uncertainty=asked.uncertainty,
            synthesis="two-step",
            remade=law,
        )

    with pytest.raises(ModelError, match=r"no wind error in 1 of .* cells: 11\.4509 to") as caught:
        designed(strong)
    found = re.search(r"smallest pitch of (\S+) deg would do", str(caught.value))
    assert found is not None
    made = designed(replace(strong, pitch_min=np.radians(float(found[1]))))
    assert made.candidate.wind_error.min() > 0


def test_a_synthesis_that_does_not_exist_is_refused() -> None:
    """The message says which there are."""
    with pytest.raises(
        ModelError, match="'three-step' was given; choose one of one-step, two-step"
    ):
        DesignSettings(synthesis="three-step")  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.numeric
def test_the_default_design_in_one_step_is_proved(reduced: bool) -> None:
    """All winds of the 5-MW turbine: more wind and quicker decay than in two steps."""
    if reduced:
        pytest.skip("reduced: four minutes; a turbine of few cells is made in one step above")
    asked = DesignSettings(synthesis="one-step")
    design = design_turbine(nrel5mw(), asked, files=model_files("nrel5mw"))
    assert design.checked.verdict is Verdict.PROVED
    assert design.synthesis is not None and design.synthesis.joint is not None
    joint = design.synthesis.joint
    assert joint.after.wind_error > 1.05 * joint.before.wind_error
    assert joint.after.decay_rate > 1.3 * joint.before.decay_rate
