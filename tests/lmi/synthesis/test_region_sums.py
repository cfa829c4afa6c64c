"""Gains that place the eigenvalues of all frozen blends in a region, by every relaxation."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import EigenvalueRegion
from takagi.lmi.gains.requirements.closed_loop import region_sums
from takagi.models import TSModel
from tests.lmi.synthesis.placed import More, blends, pendulum, placed

RELAXATIONS = (
    "common-gain", "wang-tanaka-griffin", "tanaka-wang", "tuan", "kim-lee", "liu-zhang", "polya-1",
)  # fmt: skip


def in_region(model: TSModel, region: EigenvalueRegion) -> More:
    return lambda Q, M: (region_sums(model.A, model.B, Q, M, region), (), ())


@pytest.mark.parametrize("relaxation", RELAXATIONS)
def test_every_relaxation_places_every_blend(relaxation: str) -> None:
    """Decay, damping and speed at once; a thousand frozen blends and the corners lie inside."""
    model = pendulum()
    region = (
        EigenvalueRegion.half_plane(1) & EigenvalueRegion.sector(0.8) & EigenvalueRegion.disc(15)
    )
    K, _, _, _ = placed(model, in_region(model, region), relaxation=relaxation)
    assert K is not None
    A, B, gain = blends(model, K, 1000)

    assert region.excess(np.linalg.eigvals(A - B @ gain)).max() < 0


@pytest.mark.parametrize(
    ("region", "reachable"),
    [
        (EigenvalueRegion.half_plane(1.9), True),
        (EigenvalueRegion.half_plane(2.1), False),
        (EigenvalueRegion.disc(2.1), True),
        (EigenvalueRegion.disc(1.9), False),
        (EigenvalueRegion.vertical_strip(1, 1.9) & EigenvalueRegion.disc(3), False),
    ],
    ids=str,
)
def test_a_mode_out_of_reach_decides(region: EigenvalueRegion, reachable: bool) -> None:
    """A mode at -2 that no input moves: only regions that hold it can be reached."""
    model = TSModel([[[-2.0, 0.0], [0.0, 1.0]]], [[[0.0], [1.0]]])

    assert (placed(model, in_region(model, region))[0] is not None) == reachable


def test_a_disc_places_the_poles_of_a_sampled_loop() -> None:
    """Discrete time: |z - 0.5| < 0.2 for the eigenvalues of every blend."""
    model, region = pendulum(0.05), EigenvalueRegion.disc(0.3, centre=0.6)
    K, _, _, _ = placed(model, in_region(model, region), decay_rate=0.0)
    assert K is not None
    A, B, gain = blends(model, K, 500)

    assert np.abs(np.linalg.eigvals(A - B @ gain) - 0.6).max() < 0.3
