"""Norms together with a region of the poles, one set of LMIs: where they are, and what it costs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.lmi import EigenvalueRegion, h2_pdc, hinf_pdc, peak_pdc
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant, plant_of
from takagi.models import TSModel

pytestmark = pytest.mark.numeric
# Damping of at least 0.98, and no pole faster than 30/s.
REGION = EigenvalueRegion.sector(float(np.arccos(0.98))) & EigenvalueRegion.disc(30.0)


def plant(seconds: float) -> DisturbedPlant:
    """Return two rules of an oscillator with z = (x, u), in another unit of time."""
    A = np.array([[[0.0, 1.0], [-4.0, -0.1]], [[0.0, 1.0], [-9.0, -0.1]]])
    B, E = np.array([[[0.0], [1.0]]] * 2), np.array([[[0.0], [1.0]]] * 2)
    model = TSModel(A * seconds, B * seconds, E=E * seconds)
    return plant_of(model, ([[1.0, 0.0], [0.0, 0.0]], [[0.0], [0.1]]))


@pytest.mark.parametrize("function", [hinf_pdc, h2_pdc, peak_pdc])
def test_poles_lie_in_the_region_and_the_norm_is_larger(function: Any) -> None:
    free = function(plant(1.0))
    held = function(replace(plant(1.0), region=REGION))

    def poles(design: Any) -> Any:
        p = plant(1.0)
        return np.linalg.eigvals(p.A - p.B @ design.gains)

    assert REGION.excess(poles(held)).max() < 0 < REGION.excess(poles(free)).max()
    assert held.gain > free.gain


def test_the_unit_of_time_does_not_matter() -> None:
    """In ms the plant is a thousand times slower, and so is the region: the same energy gain."""
    in_seconds = hinf_pdc(replace(plant(1.0), region=REGION))
    in_milliseconds = hinf_pdc(replace(plant(1e-3), region=REGION.slowed(1e3)))

    assert in_milliseconds.gain == pytest.approx(in_seconds.gain, rel=1e-3)
