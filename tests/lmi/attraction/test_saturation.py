"""The double sums of saturating inputs: their Theta against the formula, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import LMI, Condition, DoubleSum, Unknown, latex, relaxation_named
from takagi.lmi.condition import lmi_value
from takagi.lmi.gains.attraction.saturation import dead_zone_sum, polytope_sums, secant_sums
from takagi.models import ModelError

Floats = NDArray[np.float64]
n, m, r = 2, 2, 2
RNG = np.random.default_rng(0)
A, B = RNG.standard_normal((r, n, n)), RNG.standard_normal((r, n, m))
Q = Unknown("Q", n, n, symmetric=True)
M, Z = Unknown("M", m, n, count=r), Unknown("Z", m, n, count=r)
ROOT = RNG.standard_normal((n, n))
VALUES = {
    "Q": (ROOT @ ROOT.T)[None],
    "M": RNG.standard_normal((r, m, n)),
    "Z": RNG.standard_normal((r, m, n)),
    "S1": np.array([[[0.7]]]),
    "S2": np.array([[[1.9]]]),
}
PARAMETERS = {"alpha": 0.3, "contraction": 0.8, "slow": 0.1}


def pair(loop: DoubleSum) -> Floats:
    """Return Theta_12 + Theta_21 at the values."""
    _, lmis = relaxation_named("wang-tanaka-griffin")(loop)
    lmi: LMI = lmis[-1]
    (value,) = lmi_value(lmi, VALUES, PARAMETERS)
    return np.asarray(value)


def flow(theta: Floats, other: Floats, alpha: float) -> Floats:
    """Return He(A_i Q - B_i (theta M_j + other Z_j)) + 2 alpha Q, summed over both orders."""
    X, total = VALUES["Q"][0], np.zeros((n, n))
    for i, j in ((0, 1), (1, 0)):
        u = np.diag(theta) @ VALUES["M"][j] + np.diag(other) @ VALUES["Z"][j]
        G = A[i] @ X - B[i] @ u
        total += G + G.T + 2 * alpha * X
    return total


def test_secants_are_at_the_corners_of_their_slopes() -> None:
    """Four corners of {0.25, 1} x {0.5, 1}, the first without saturation at its own rate."""
    sums = secant_sums(A, B, Q, M, np.array([0.25, 0.5]), weight=1.0, saturated="slow")
    corners = [(1, 1), (1, 0.5), (0.25, 1), (0.25, 0.5)]

    assert len(sums) == 4 and len({loop.name for loop in sums}) == 4
    for loop, corner in zip(sums, corners, strict=True):
        alpha = 0.3 if corner == (1, 1) else 0.1
        np.testing.assert_allclose(pair(loop), flow(np.array(corner), np.zeros(2), alpha))


def test_an_input_that_does_not_saturate_has_one_corner() -> None:
    assert len(secant_sums(A, B, Q, M, np.array([1.0, 0.5]), weight=1.0)) == 2


def test_the_polytope_takes_each_input_from_either_law() -> None:
    sums = polytope_sums(A, B, Q, M, Z, weight=1.0, saturated="slow")
    corners = [(1, 1), (1, 0), (0, 1), (0, 0)]

    for loop, corner in zip(sums, corners, strict=True):
        kept = np.array(corner, float)
        alpha = 0.3 if corner == (1, 1) else 0.1
        np.testing.assert_allclose(pair(loop), flow(kept, 1 - kept, alpha))


def test_the_dead_zone_has_its_block_beside_the_loop() -> None:
    """[[He(A Q - B M) + 2 alpha Q, B S + (M - Z)'], [., -2 S]], its rows in a power-of-two unit."""
    loop, unknowns = dead_zone_sum(A, B, Q, M, Z, weight=1.0)
    value = pair(loop)
    S = np.diag([0.7, 1.9])
    side = sum(B[i] @ S + (VALUES["M"][j] - VALUES["Z"][j]).T for i, j in ((0, 1), (1, 0)))
    unit = np.sqrt(-value[n, n] / (4 * S[0, 0]))

    assert [S.name for S in unknowns] == ["S1", "S2"]
    assert np.log2(unit) == round(np.log2(unit))
    np.testing.assert_allclose(value[:n, :n], flow(np.ones(2), np.zeros(2), 0.3))
    np.testing.assert_allclose(value[:n, n:] / unit, side)
    np.testing.assert_allclose(value[n:, n:] / unit**2, -4 * S)


def every_way(gain: Unknown | Floats, discrete: bool) -> tuple[DoubleSum, ...]:
    half = np.array([0.5, 0.5])
    return (
        *secant_sums(A, B, Q, gain, half, weight=1.0, discrete=discrete),
        *polytope_sums(A, B, Q, gain, Z, weight=1.0, discrete=discrete),
        dead_zone_sum(A, B, Q, gain, Z, weight=1.0, discrete=discrete)[0],
    )


def test_known_gains_stand_where_the_unknown_ones_would() -> None:
    """With K_j Q in the place of M_j every way has the same Theta."""
    K = VALUES["M"] @ np.linalg.inv(VALUES["Q"][0])
    for discrete in (False, True):
        sought, known = (every_way(gain, discrete) for gain in (M, K))
        for one, other in zip(sought, known, strict=True):
            np.testing.assert_allclose(pair(other), pair(one), atol=1e-12)


def test_discrete_time_puts_the_loop_below_the_contraction() -> None:
    """[[-rho^2 Q, (M - Z)', (A Q - B M)'], ...] with S, in the order of the blocks of the loop."""
    loop, _ = dead_zone_sum(A, B, Q, M, Z, weight=1.0, discrete=True)
    value, X = pair(loop), VALUES["Q"][0]

    np.testing.assert_allclose(value[:n, :n], -2 * 0.8 * X)
    np.testing.assert_allclose(
        value[n : 2 * n, :n],
        sum(A[i] @ X - B[i] @ VALUES["M"][j] for i, j in ((0, 1), (1, 0))),
    )
    np.testing.assert_allclose(value[n : 2 * n, n : 2 * n], -2 * X)
    unit = np.sqrt(-value[2 * n, 2 * n] / (4 * 0.7))
    np.testing.assert_allclose(
        value[n : 2 * n, 2 * n :] / unit, (B[0] + B[1]) @ np.diag([0.7, 1.9])
    )


def test_many_inputs_have_no_corners_in_the_dead_zone_alone() -> None:
    wide, gain = RNG.standard_normal((1, 8, 7)), Unknown("M", 7, 8)
    eye, big = -np.eye(8)[None], Unknown("Q", 8, 8, symmetric=True)
    with pytest.raises(ModelError, match="take the dead zone"):
        secant_sums(eye, wide, big, gain, np.full(7, 0.5), weight=1.0)
    loop, S = dead_zone_sum(eye, wide, big, gain, Unknown("Z", 7, 8), weight=1.0)

    assert loop.size == 15 and len(S) == 7


@pytest.mark.parametrize("least", [0.0, 1.5, -0.1, np.nan])
def test_slopes_outside_zero_and_one_are_refused(least: float) -> None:
    with pytest.raises(ModelError, match=r"\(0, 1\]"):
        secant_sums(A, B, Q, M, np.array([least, 1.0]), weight=1.0)


def test_it_is_typeset() -> None:
    mixed = polytope_sums(A, B, Q, M, Z, weight=1.0, saturated="slow")[1]
    _, lmis = relaxation_named("wang-tanaka-griffin")(mixed)
    text = latex(Condition(name="c", unknowns=(Q, M, Z), lmis=lmis, parameters={"slow": 0.0}))

    for part in (
        r"B_{i} \mathrm{diag}(1, 0) M_{j}",
        r"B_{i} \mathrm{diag}(0, 1) Z_{j}",
        r"\alpha_{s}",
    ):
        assert part in text
