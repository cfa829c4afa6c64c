"""One-step against two-step in words: the numbers that the search left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.certificates.design.turbine.effort_sharing_gains import EffortSharingGainDesign
from takagi.lmi.turbine.one_step.design import OneStepDesign
from takagi.lmi.turbine.one_step.design_point import ReachedValues
from takagi.lmi.turbine.one_step.loop_of_gains import LoopFunctions
from takagi.reports.loops.plant_claims import synthesis_words


@pytest.fixture
def joint(turbine_design: TurbineDesign) -> TurbineDesign:
    """The shared design as if its gains had been found in two joint steps."""
    law, candidate = turbine_design.effort_sharing_law, turbine_design.candidate
    assert law is not None and candidate is not None
    before = ReachedValues(0.1894, 0.04, 0.01695)
    middle, after = replace(before, wind_error=0.2), replace(before, wind_error=0.2075)
    none = np.zeros(3)
    found = OneStepDesign(
        law,
        LoopFunctions(np.eye(3), none, none, np.eye(3), 0.026),
        before,
        replace(after, decay_rate=0.0261),
        (before, middle, after),
        0,
    )
    return replace(turbine_design, synthesis=EffortSharingGainDesign(law, candidate, found, ""))


def test_the_summary_tells_both(joint: TurbineDesign) -> None:
    """The words carry the numbers, the objective's name and the steps that were taken."""
    words = synthesis_words(joint)
    assert "0.1894 to 0.2075 m/s" in words and "0.0169 to 0.0261 1/s" in words
    assert "balanced, 2 joint steps" in words


def test_two_step_gains_are_not_compared_but_the_reason_is_told(
    turbine_design: TurbineDesign,
) -> None:
    """The words say why where one step was asked for."""
    assert turbine_design.synthesis is not None
    failed = replace(turbine_design.synthesis, kept="none of 3 joint steps was better")
    words = synthesis_words(replace(turbine_design, synthesis=failed))
    assert words.endswith("for none of 3 joint steps was better")
    assert synthesis_words(replace(turbine_design, synthesis=None)) == ""
