"""One quadratic function under norm-bounded uncertainty: small gain, vertices, several blocks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import (
    NormBounded,
    common_lyapunov,
    robust_lyapunov,
)
from takagi.models import ModelError, TSModel

Floats = NDArray[np.float64]


def oscillator(zeta: float) -> Floats:
    """x'' + 2 zeta x' + x = p."""
    return np.array([[0.0, 1.0], [-1.0, -2.0 * zeta]])


@pytest.mark.parametrize("zeta", [0.05, 0.2, 0.6])
def test_one_block_is_the_small_gain_theorem(zeta: float) -> None:
    """Khargonekar, Petersen and Zhou (1990): a P exists iff |E (sI - A)^-1 D|_inf < 1.

    The resonance of 1 / (s^2 + 2 zeta s + 1) is 1 / (2 zeta (1 - zeta^2)^(1/2)).
    """
    peak = 1 / (2 * zeta * np.sqrt(1 - zeta**2))
    D, E = [[0.0], [1.0]], np.array([[1.0, 0.0]])

    assert robust_lyapunov(oscillator(zeta), NormBounded(D, 0.999 / peak * E)).found
    no = robust_lyapunov(oscillator(zeta), NormBounded(D, 1.001 / peak * E))
    assert no.status == "infeasible"
    assert "shrink the uncertainty" in no.diagnosis


def test_the_first_order_lag_and_its_decay_rate() -> None:
    """x' = -(a + delta) x, |delta| <= d, decays at alpha exactly when alpha < a - d."""
    lag = NormBounded([[0.5]], [[1.4]])

    assert robust_lyapunov([[-2.0]], lag, decay_rate=1.299).found
    assert not robust_lyapunov([[-2.0]], lag, decay_rate=1.301).found


def test_discrete_time_from_both_sides() -> None:
    """x+ = (a + delta) x contracts by rho exactly when |a| + d < rho; T = 0.5 s."""
    block, alpha = NormBounded([[0.3]], [[1.0]]), -np.log(0.9) / 0.5

    assert robust_lyapunov([[0.599]], block, decay_rate=alpha, sample_time=0.5).found
    assert not robust_lyapunov([[0.601]], block, decay_rate=alpha, sample_time=0.5).found


def test_the_discrete_small_gain_theorem() -> None:
    """A P exists iff the norm of E (zI - A)^-1 D on the unit circle is below 1."""
    A = np.array([[0.6, 0.5], [-0.4, 0.5]])
    D, E = np.array([[1.0, 0.2], [0.0, 1.0]]), np.array([[1.0, -1.0]])
    z = np.exp(1j * np.linspace(0, np.pi, 4001))[:, None, None]
    peak = np.linalg.norm(E @ np.linalg.solve(z * np.eye(2) - A, D), 2, axis=(1, 2)).max()

    assert robust_lyapunov(A, NormBounded(0.999 / peak * D, E), sample_time=1.0).found
    assert not robust_lyapunov(A, NormBounded(1.001 / peak * D, E), sample_time=1.0).found


@pytest.mark.parametrize("seed", range(4))
def test_a_scalar_block_is_as_good_as_its_two_vertices(seed: int) -> None:
    """|p| <= |E x| in one dimension is p = delta E x, |delta| <= 1: A + DE and A - DE."""
    rng = np.random.default_rng(seed)
    A, D, E = rng.standard_normal((3, 3)), rng.standard_normal((3, 1)), rng.standard_normal((1, 3))
    A -= (np.linalg.eigvals(A).real.max() + 0.5) * np.eye(3)
    sizes = np.geomspace(0.02, 20, 15)
    block = [robust_lyapunov(A, NormBounded(f * D, E)).found for f in sizes]
    both = [common_lyapunov([A + f * D @ E, A - f * D @ E]).found for f in sizes]

    assert block == both
    assert any(block) and not all(block)


def test_two_blocks_hold_at_every_corner_of_their_deltas() -> None:
    """Two multipliers are sufficient: the four corners share the P that was found."""
    A = np.array([[-1.0, 2.0], [-2.0, -1.0]])
    blocks = (NormBounded([[1.0], [0.0]], [[0.5, 0.2]]), NormBounded([[0.0], [1.0]], [[0.1, 0.4]]))
    P = robust_lyapunov(A, blocks, decay_rate=0.2).P
    assert P is not None
    parts = [np.asarray(block.D) @ np.asarray(block.E) for block in blocks]
    for a in (-1, 1):
        for b in (-1, 1):
            loop = A + a * parts[0] + b * parts[1] + 0.2 * np.eye(2)
            assert np.linalg.eigvalsh(P @ loop + loop.T @ P).max() < 0
    assert not robust_lyapunov(A, blocks, decay_rate=0.9).found


def test_blends_of_rules_with_their_own_channels() -> None:
    """V' <= -2 alpha V for A(h) + D(h) Delta E(h), with D and E of each rule its own."""
    rng = np.random.default_rng(2)
    A = np.array([[-2.0, 1.0], [-1.0, -2.0]]) + 0.3 * rng.standard_normal((3, 2, 2))
    D, E = 0.5 * rng.standard_normal((3, 2, 2)), 0.5 * rng.standard_normal((3, 2, 2))
    answer = robust_lyapunov(A, NormBounded(D, E), decay_rate=0.3)
    P = answer.P
    assert P is not None and answer.decay_rate == 0.3
    for h in rng.dirichlet(0.5 * np.ones(3), 300):
        U = np.linalg.qr(rng.standard_normal((2, 2)))[0]
        a, d, e = (np.tensordot(h, part, 1) for part in (A, D, E))
        loop = a + d @ U @ e + 0.3 * np.eye(2)
        assert np.linalg.eigvalsh(P @ loop + loop.T @ P).max() < 0


def test_a_channel_that_changes_on_both_sides_has_one_multiplier() -> None:
    """D = 1, 3 and E = 3, 1: half way D(h) E(h) = 4, though D_i E_i = 3 at both vertices."""
    D, E = np.array([[[1.0]], [[3.0]]]), np.array([[[3.0]], [[1.0]]])

    assert not robust_lyapunov([[[-3.9]], [[-3.9]]], NormBounded(D, E)).found
    assert robust_lyapunov([[[-5.01]], [[-5.01]]], NormBounded(D, E)).found
    assert robust_lyapunov([[[-3.01]], [[-3.01]]], NormBounded.by_rule(D, E)).found


def test_by_rule_is_the_sum_of_products() -> None:
    """D_1 = E_1 = 1, D_2 = E_2 = -1: sum_i h_i D_i Delta_i E_i is at most 1, so a > 1 is needed.

    The product of the sums, D(h) E(h) = (h_1 - h_2)^2, vanishes half way.
    """
    one = np.ones((1, 1))
    D = E = np.array([one, -one])
    rule = NormBounded.by_rule(D, E)
    blend = np.tensordot([0.3, 0.7], np.asarray(rule[0].E), 1)

    np.testing.assert_allclose(np.asarray(rule[0].D) @ blend, 0.3)
    for a, b in ((1.001, 3.0), (3.0, 1.001), (1.001, 1.001)):
        assert robust_lyapunov([[[-a]], [[-b]]], rule).found
    assert not robust_lyapunov([[[-0.999]], [[-3.0]]], rule).found
    assert not robust_lyapunov([[[-3.0]], [[-0.999]]], rule).found


def test_a_block_that_enters_alike_has_a_multiplier_a_vertex() -> None:
    """D alike: the answer is that of each vertex with its own tau, as good as the vertices +-."""
    rng = np.random.default_rng(7)
    A = np.array([[-1.0, 2.0], [-2.0, -1.0]]) + 0.5 * rng.standard_normal((2, 2, 2))
    D, E = np.array([[0.3], [1.0]]), rng.standard_normal((2, 1, 2)) * np.array([[[0.1]], [[1]]])
    sizes = np.geomspace(0.1, 3, 15)
    block = [robust_lyapunov(A, NormBounded(f * D, E)).found for f in sizes]
    both = [common_lyapunov([*(A + f * D @ E), *(A - f * D @ E)]).found for f in sizes]

    assert block == both
    assert any(block) and not all(block)


def test_with_gains_the_input_channel_counts() -> None:
    """x' = (1 + delta) (x + u)... : u = -K x, loop (1 - K) + delta (1 - K), |delta| <= 0.5."""
    model = TSModel([[[1.0]]], [[[1.0]]])
    block = NormBounded([[0.5]], [[1.0]], [[1.0]])

    for gain, decay in ((3.0, 1.0), (5.0, 2.0)):
        assert robust_lyapunov(model, block, gains=[[gain]], decay_rate=0.999 * decay).found
        assert not robust_lyapunov(model, block, gains=[[gain]], decay_rate=1.001 * decay).found


def test_gains_of_each_rule_are_taken_in_pairs() -> None:
    """The answer of the loop under memberships is that of its (i, j) means as vertices."""
    model = TSModel(
        [[[0.0, 1.0], [2.0, 0.0]], [[0.0, 1.0], [1.0, 0.0]]], [[[0.0], [2.0]], [[0.0], [1.0]]]
    )
    K = np.array([[[3.0, 2.0]], [[4.0, 3.0]]])
    block = NormBounded([[0.0], [1.0]], [[0.3, 0.1]], [[0.1]])
    P = robust_lyapunov(model, block, gains=K, decay_rate=0.1).P
    assert P is not None
    rng = np.random.default_rng(0)
    for h in rng.dirichlet([1, 1], 200):
        A, B, k = (np.tensordot(h, part, 1) for part in (model.A, model.B, K))
        D, E, F = (np.asarray(part) for part in (block.D, block.E, block.F))
        loop = A - B @ k + rng.uniform(-1, 1) * D @ (E - F @ k) + 0.1 * np.eye(2)
        assert np.linalg.eigvalsh(P @ loop + loop.T @ P).max() < 0


@pytest.mark.parametrize(
    ("block", "what"),
    [
        (NormBounded([[1.0], [0.0], [0.0]], [[1.0, 0.0]]), "uncertainty 1 of 1: D is 3 x 1; 2 x 1"),
        (NormBounded([[1.0], [0.0]], [[1.0, 0.0, 0.0]]), "E is 1 x 3; 1 x 2"),
        (NormBounded([[0.0], [0.0]], [[1.0, 0.0]]), "D is zero in every rule"),
        (NormBounded([[1.0], [0.0]], [[0.0, 0.0]]), "E and F are zero"),
        (NormBounded([[np.nan], [0.0]], [[1.0, 0.0]]), "not finite"),
        (NormBounded([["a"], ["b"]], [[1.0, 0.0]]), "cannot be read"),
        (NormBounded(np.ones((3, 2, 1)), [[1.0, 0.0]]), r"\(1, ., .\) or"),
        ([], "a NormBounded is needed"),
        (5, "a NormBounded is needed"),
    ],
)
def test_a_block_that_does_not_fit_is_refused(block: NormBounded, what: str) -> None:
    with pytest.raises(ModelError, match=what):
        robust_lyapunov(oscillator(0.2), block)


def test_what_does_not_fit_the_rules_or_inputs_is_refused() -> None:
    with pytest.raises(ModelError, match="for each of r rules"):
        NormBounded.by_rule([[1.0]], np.ones((2, 1, 1)))
    model = TSModel([[[1.0]]], [[[1.0]]])
    with pytest.raises(ModelError, match="gains have shape"):
        robust_lyapunov(model, NormBounded([[1.0]], [[1.0]]), gains=[[1.0, 2.0]])
