"""What pdc is asked besides decay: regions of eigenvalues."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import Design, EigenvalueRegion, ZeroGainsWarning, pdc
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import pendulum


def frozen_eigenvalues(model: TSModel, design: Design) -> NDArray[np.complex128]:
    """Return the eigenvalues of A(h) - B(h) K(h) at 201 blends of two rules."""
    K, _ = design.require()
    h = np.linspace(0, 1, 201)
    h = np.stack([h, 1 - h], axis=1)
    A, B, gain = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    return np.asarray(np.linalg.eigvals(A - B @ gain), dtype=np.complex128).ravel()


@pytest.mark.parametrize(
    ("region", "relaxation"),
    [
        (EigenvalueRegion.half_plane(3.0), "common-gain"),
        (EigenvalueRegion.disc(2.0, centre=-5.0), "wang-tanaka-griffin"),
        (EigenvalueRegion.vertical_strip(1.0, 5.0), "tanaka-wang"),
        (EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.disc(9.0), "tuan"),
        (EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.sector(0.3), "kim-lee"),
        (EigenvalueRegion.disc(4.0), "liu-zhang"),
        (EigenvalueRegion.half_plane(3.0) & EigenvalueRegion.disc(9.0), "polya-1"),
    ],
    ids=str,
)
def test_eigenvalues_of_all_blends_lie_in_the_region(
    region: EigenvalueRegion, relaxation: str
) -> None:
    """Chilali and Gahinet (1996); without the region some lie outside."""
    model = pendulum()
    free, held = (pdc(model, relaxation=relaxation, region=asked) for asked in (None, region))

    assert all(region.contains(z) for z in frozen_eigenvalues(model, held))
    assert not all(region.contains(z) for z in frozen_eigenvalues(model, free))


def test_a_disc_places_the_poles_of_a_sampled_loop() -> None:
    """Discrete time: |z - 0.6| < 0.3 for the eigenvalues of every blend."""
    design = pdc(pendulum(0.05), region=EigenvalueRegion.disc(0.3, centre=0.6))

    assert np.abs(frozen_eigenvalues(pendulum(0.05), design) - 0.6).max() < 0.3


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

    assert pdc(model, region=region).found == reachable


def test_a_half_plane_is_a_decay_rate() -> None:
    """Re z < -alpha as a region and alpha as the rate are feasible for the same gains."""
    rates = pdc(pendulum(), decay_rate="max", gain_bound=300.0).decay_rate

    for share, exists in ((0.99, True), (1.01, False)):
        region = EigenvalueRegion.half_plane(share * rates)
        assert pdc(pendulum(), gain_bound=300.0, region=region).found is exists


@pytest.mark.parametrize(("options", "said"), [({"region": 3.0}, "an EigenvalueRegion is needed")])
def test_misuse_is_refused(options: dict[str, object], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        pdc(pendulum(), **options)  # type: ignore[arg-type]


def test_a_part_of_a_region_without_the_loop() -> None:
    """L < 0 alone, M = 0: every loop keeps it, and the gains are as without it."""
    assert pdc(pendulum(), region=EigenvalueRegion.lmi([[-1.0]], [[0.0]])).found
    assert not pdc(pendulum(), region=EigenvalueRegion.lmi([[1.0]], [[0.0]])).found


def test_gains_that_do_nothing_are_warned_of() -> None:
    """A plant that is stable by itself has gains of zero where no rate is asked for; K is gains."""
    stable = TSModel([[[-1.0, 0.2], [0.0, -2.0]], [[-1.5, 0.0], [0.3, -1.0]]], [[[0.0], [1.0]]] * 2)
    with pytest.warns(ZeroGainsWarning, match="the plant alone meets"):
        design = pdc(stable)
    assert design.K is design.gains is not None
    # Filters make warnings errors: of gains that do something there is none.
    assert pdc(pendulum()).found
