"""Gains that place the eigenvalues of all frozen blends in a region, by every relaxation."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import Condition, EigenvalueRegion, d_stability, latex, pdc_condition
from takagi.lmi.gains.requirements.region_sums import region_sums
from takagi.models import TSModel
from tests.lmi.synthesis.placed import More, blends, nothing, pendulum, placed

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


def test_one_gain_is_judged_by_the_analysis_condition() -> None:
    """The P of the design shows the closed loop's vertices in the region, by ``d_stability``."""
    model, region = (
        pendulum(),
        EigenvalueRegion.half_plane(1) & EigenvalueRegion.ellipse(4, 2, centre=-5),
    )
    K, _, _, _ = placed(model, in_region(model, region), relaxation="common-gain")
    assert K is not None

    assert d_stability(model.A - model.B @ K, region).found
    assert d_stability(model, region, gains=K).found
    assert not d_stability(model, region & EigenvalueRegion.half_plane(20), gains=K).found


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


def test_the_smaller_region_is_the_harder() -> None:
    """A sector in a sector: gains for the narrow one never need more than the wide one allows."""
    model = pendulum()
    margins = [
        placed(model, in_region(model, EigenvalueRegion.sector(angle)))[2].bound
        for angle in (1.2, 0.8, 0.4)
    ]

    assert margins[0] >= margins[1] >= margins[2]


def test_a_half_plane_is_the_decay_rate_of_pdc() -> None:
    """The part Re z < -alpha poses what pdc poses with that decay rate: equal margins."""
    model = pendulum()
    own = placed(model, nothing, decay_rate=2.0)[2]
    part = placed(model, in_region(model, EigenvalueRegion.half_plane(2.0)), decay_rate=0.0)[2]

    assert part.margin == pytest.approx(own.margin, rel=0.2)
    assert part.status == own.status == "candidate"


def test_it_is_typeset_part_by_part() -> None:
    condition: Condition = placed(pendulum(), in_region(pendulum(), EigenvalueRegion.disc(4)))[3]

    assert r"\text{disc, rule:}" in latex(condition)
    assert "disc, rule 1 of 2" in [
        lmi.label(0) for lmi in condition.lmis if lmi.name == "disc, rule"
    ]
    assert pdc_condition(pendulum()).lmis != condition.lmis
