"""Gains that hold for every norm-bounded uncertainty: vertices, small gain, random Delta."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.lmi import DoubleSum, EigenvalueRegion, NormBounded, Unknown, robust_lyapunov
from takagi.lmi.condition.region import Uncertainty
from takagi.lmi.gains.requirements.closed_loop import closed_loop, region_sums, with_uncertainty
from takagi.models import ModelError, TSModel
from tests.lmi.synthesis.placed import Added, More, blends, nothing, pendulum, placed


def robust_loop(model: TSModel, uncertainty: Uncertainty, alpha: float) -> More:
    """Return V' <= -2 alpha V for the uncertain loop, as Re z < -alpha with a carrier."""
    region = EigenvalueRegion.half_plane(alpha)

    def more(Q: Unknown, M: Unknown) -> Added:
        (loop,) = region_sums(model.A, model.B, Q, M, region)
        loop, sigma = with_uncertainty(loop, Q, M, uncertainty)
        return (loop,), sigma, ()

    return more


def corners_of(model: TSModel, block: NormBounded) -> TSModel:
    """Return the vertices of a scalar block: Delta = +1 and -1 at every rule."""
    D, E = np.asarray(block.D), np.asarray(block.E)
    F = np.zeros((1, 1)) if block.F is None else np.asarray(block.F)
    return TSModel(
        np.concatenate([model.A + D @ E, model.A - D @ E]),
        np.concatenate([model.B + D @ F, model.B - D @ F]),
    )


@pytest.mark.parametrize("alpha", [1.0, 3.0])
def test_a_scalar_block_and_one_gain_are_as_good_as_the_vertices(alpha: float) -> None:
    """p = delta (E x + F u), |delta| <= 1 in one dimension: one gain for the 2 r vertices."""
    block_found: list[bool] = []
    vertices_found: list[bool] = []
    for size in np.geomspace(0.2, 20, 12):
        block = NormBounded([[0.0], [1.0]], size * np.array([[1.0, 0.3]]), [[0.05 * size]])
        for found, model, more in (
            (block_found, pendulum(), robust_loop(pendulum(), block, alpha)),
            (vertices_found, corners_of(pendulum(), block), None),
        ):
            K, _, _, _ = placed(
                model,
                more or nothing,
                relaxation="common-gain",
                decay_rate=-20.0 if more else alpha,
            )
            found.append(K is not None)

    assert block_found == vertices_found
    assert any(block_found) and not all(block_found)


@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "tanaka-wang", "polya-1"])
def test_the_loop_decays_for_every_delta(relaxation: str) -> None:
    """Two blocks, random Delta of norm 1: V' <= -2 alpha V at every blend, with the design's P."""
    model, alpha, rng = pendulum(), 0.5, np.random.default_rng(1)
    blocks = (
        NormBounded([[0.0], [1.0]], [[1.5, 0.2]], [[0.15]]),
        NormBounded(np.eye(2), np.array([[[0.2, 0.1]], [[0.1, 0.3]]])),
    )
    K, P, _, _ = placed(model, robust_loop(model, blocks, alpha), relaxation=relaxation)
    assert K is not None and P is not None
    E1 = np.asarray(blocks[1].E)
    h = rng.dirichlet([0.6, 0.6], 300)
    for weight in h:
        A, B, gain, second = (np.tensordot(weight, part, 1) for part in (model.A, model.B, K, E1))
        delta = rng.standard_normal((2, 1))
        loop = A - B @ gain + alpha * np.eye(2) + delta / np.linalg.norm(delta) @ second
        loop += (
            rng.uniform(-1, 1) * np.array([[0.0], [1.0]]) @ (np.array([[1.5, 0.2]]) - 0.15 * gain)
        )
        assert np.linalg.eigvalsh(P @ loop + loop.T @ P).max() < 0


def test_uncertainty_that_cannot_be_overcome_is_a_no() -> None:
    """The input's own effect uncertain by more than 100 %: no gain stabilises."""
    model = TSModel([[[1.0]]], [[[1.0]]])
    for size, found in ((0.95, True), (1.05, False)):
        block = NormBounded([[1.0]], [[0.0]], [[size]])
        K, _, _, _ = placed(model, robust_loop(model, block, 0.0), effort=1e6)
        assert (K is not None) == found


def test_a_sector_keeps_its_uncertain_poles() -> None:
    """A carrier of rank two: frozen blends with any Delta lie in the sector and the disc."""
    model, rng = pendulum(), np.random.default_rng(3)
    region = (
        EigenvalueRegion.half_plane(0.8) & EigenvalueRegion.sector(0.9) & EigenvalueRegion.disc(15)
    )
    block = NormBounded([[0.0], [1.0]], [[1.0, 0.2]], [[0.1]])

    def more(Q: Unknown, M: Unknown) -> Added:
        sums: list[DoubleSum] = []
        sigmas: tuple[Unknown, ...] = ()
        for loop, part in zip(
            region_sums(model.A, model.B, Q, M, region), region.parts, strict=True
        ):
            robust, sigma = with_uncertainty(loop, Q, M, block, carrier=part.matrices[1])
            sums.append(robust)
            sigmas += sigma
        return sums, sigmas, ()

    K, _, _, _ = placed(model, more)
    assert K is not None
    A, B, gain = blends(model, K, 1000)
    delta = rng.choice([-1.0, 1.0], len(A))[:, None, None] * rng.uniform(0.5, 1, (len(A), 1, 1))
    moved = delta * (np.array([[0.0], [1.0]]) @ (np.array([[1.0, 0.2]]) - 0.1 * gain))

    assert region.excess(np.linalg.eigvals(A - B @ gain + moved)).max() < 0
    # Ten times the uncertainty takes some pole out, so the test above can fail.
    assert region.excess(np.linalg.eigvals(A - B @ gain + 10 * moved)).max() > 0


def test_discrete_time_from_both_sides() -> None:
    """x+ = 1.5 x + (1 + delta) u, |delta| <= d, u = -k x, can be stable exactly for d < 2/3.

    |1.5 - k (1 + delta)| < 1 at both ends asks 0.5 / (1 - d) < k < 2.5 / (1 + d).
    """
    model = TSModel([[[1.5]]], [[[1.0]]], sample_time=1.0)
    for size, found in ((0.66, True), (0.675, False)):

        def more(Q: Unknown, M: Unknown, size: float = size) -> Added:
            loop = closed_loop(model.A, model.B, Q, M, weight=1.0, discrete=True)
            block = NormBounded([[1.0]], [[0.0]], [[size]])
            robust, sigma = with_uncertainty(loop, Q, M, block, discrete=True)
            return (replace(robust, name="uncertain rule"),), sigma, ()

        K, _, _, _ = placed(model, more, decay_rate=0.0)
        assert (K is not None) == found


def test_the_product_of_blends_is_covered_where_both_sides_change() -> None:
    """D = 1, 3 and E = 3, 1: D_i E_i = 3, but D(h) E(h) = 4 half way, out of the input's reach.

    A state that decays by 3.5 is unstable there; with one multiplier for both rules 5 is needed.
    """
    D = np.array([[[1.0], [0.0]], [[3.0], [0.0]]])
    E = np.array([[[3.0, 0.0]], [[1.0, 0.0]]])
    for decay, found in ((3.5, False), (5.05, True)):
        model = TSModel(
            np.broadcast_to(np.diag([-decay, 1.0]), (2, 2, 2)), np.full((2, 2, 1), [[0.0], [1.0]])
        )
        K, _, _, _ = placed(model, robust_loop(model, NormBounded(D, E), 0.0))
        assert (K is not None) == found
        assert robust_lyapunov(model.A[:, :1, :1], NormBounded(D[:, :1], E[:, :, :1])).found == (
            found
        )


def test_a_carrier_that_does_not_fit_is_refused() -> None:
    model = pendulum()
    with pytest.raises(ModelError, match="the carrier has shape"):
        placed(
            model,
            lambda Q, M: (
                [
                    with_uncertainty(
                        closed_loop(model.A, model.B, Q, M, weight=1.0),
                        Q,
                        M,
                        NormBounded(np.eye(2), np.eye(2)),
                        carrier=np.eye(2),
                    )[0]
                ],
                (),
                (),
            ),
        )
