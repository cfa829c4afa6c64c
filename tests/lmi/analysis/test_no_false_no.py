"""A no is never said of vertices that have a P, known exactly, in units and states that hide it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    EigenvalueRegion,
    common_lyapunov,
    common_lyapunov_condition,
    d_stability,
    decide,
    fuzzy_lyapunov,
    pdc,
)
from takagi.lmi.argument_checks import decays_exactly, slow_vertex
from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.refutation.exact_algebra import is_definite
from takagi.models import Floats, TSModel
from tests.lmi.known_models import planar_pair, three_rules

pytestmark = pytest.mark.numeric


def falls_exactly(A: Floats, P: NDArray[np.object_]) -> bool:
    """Return whether P > 0 and A_i' P + P A_i < 0 for the very numbers that are stored."""
    decays = [-(P @ one + one.T @ P) for one in fractions(A)]
    return all(is_definite(matrix) for matrix in (P, *decays))


def mixed(states: int, seed: int, gain: int) -> tuple[Floats, NDArray[np.object_]]:
    """A_i = T (S_i - Q_i) T^-1, S_i skew, Q_i > 0 with eigenvalues from 1 to the gain; integers."""
    random = np.random.default_rng(seed)
    up, down = np.eye(states, dtype=object) * 1, np.eye(states, dtype=object) * 1
    for k in range(states - 1):
        up[k, k + 1], down[k + 1, k] = int(random.integers(3, 8)), int(random.integers(3, 8))
    T = up @ down
    back = np.rint(np.linalg.inv(T.astype(np.float64))).astype(np.int64).astype(object)
    assert np.array_equal(T @ back, np.eye(states))
    found = []
    for _ in range(3):
        skew = np.triu(random.integers(-gain, gain, (states, states)), 1)
        w = random.integers(-9, 10, (states, 1))
        Q = np.eye(states, dtype=np.int64) + (gain // 100) * w @ w.T
        found.append(T @ (skew - skew.T - Q).astype(object) @ back)
    whole = np.array(found)
    assert np.abs(whole).max() < 2**53
    return whole.astype(np.float64), fractions(back.T @ back)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("gain", [1_000, 100_000])
def test_a_function_that_gains_and_states_hide_is_found(gain: int, seed: int) -> None:
    """P is conditioned as 1e8 and 1e9; of such vertices "infeasible" was said."""
    A, P = mixed(3, seed, gain)
    answer = common_lyapunov(A)

    assert falls_exactly(A, P)
    assert answer.status == "candidate", answer.diagnosis
    assert answer.P is not None
    assert np.linalg.eigvalsh(answer.P).min() > 0


@pytest.mark.parametrize("seed", range(4))
def test_no_condition_excludes_what_is_known_to_exist(seed: int) -> None:
    """The condition itself, as it stands: a margin that no solver tells from zero is no no."""
    A, P = mixed(3, seed, 100_000)
    outcome = decide(common_lyapunov_condition(A), most=2)

    assert falls_exactly(A, P)
    assert outcome.status != "infeasible"


def test_no_other_analysis_excludes_it() -> None:
    A, P = mixed(3, 1, 100_000)

    assert falls_exactly(A, P)
    assert d_stability(A, EigenvalueRegion.half_plane(0.0)).status != "infeasible"
    assert fuzzy_lyapunov(A[:2], rate_bounds=0).status != "infeasible"


powers = st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=2)


@given(powers, st.integers(-20, 20), st.booleans())
def test_units_and_states_turn_no_answer(exponents: list[float], shear: int, inside: bool) -> None:
    a = (3 + np.sqrt(8)) * (0.99 if inside else 1.01)
    T = np.diag(10.0 ** np.array(exponents)) @ np.array([[1.0, shear], [0.0, 1.0]])
    A = T @ planar_pair(a) @ np.linalg.inv(T)

    assert common_lyapunov(A).status == ("candidate" if inside else "infeasible")


@settings(max_examples=10)
@given(powers, st.booleans())
def test_units_turn_no_answer_in_discrete_time(exponents: list[float], inside: bool) -> None:
    """|x+|^2 <= 0.98 |x|^2 by two rotations of 0.99; and a pair whose product grows."""
    c, s = np.cos(1.0), np.sin(1.0)
    turns = 0.99 * np.array([[[c, -s], [s, c]], [[c, s], [-s, c]]])
    shears = np.array([[[0.5, 2.0], [0.0, 0.5]], [[0.5, 0.0], [2.0, 0.5]]])
    T = np.diag(10.0 ** np.array(exponents))
    A = T @ (turns if inside else shears) @ np.linalg.inv(T)

    answer = common_lyapunov(A, sample_time=0.1)
    assert answer.status == ("candidate" if inside else "infeasible")


@settings(max_examples=6)
@given(powers, st.booleans())
def test_units_turn_no_gains(exponents: list[float], inside: bool) -> None:
    """Kim and Lee (2000), a = 2: by all pairs up to b = -2.1432, from both sides."""
    b = -2.3 if inside else -2.0
    plain = three_rules(b)
    T = np.diag(10.0 ** np.array(exponents))
    model = TSModel(T @ plain.A @ np.linalg.inv(T), T @ plain.B)
    found = pdc(model, relaxation="wang-tanaka-griffin").status

    assert found == ("candidate" if inside else "infeasible")


@pytest.mark.parametrize(("excess", "slow"), [(-1, False), (0, True), (1, True)])
def test_a_mode_at_its_limit_is_decided_exactly(excess: int, slow: bool) -> None:
    """One eigenvalue is excess / 2^30, of integers up to 2^20 over 2^30: nothing is rounded."""
    e = float(Fraction(excess, 2**30))
    T, back = np.array([[1.0, 0.0], [2.0, 1.0]]), np.array([[1.0, 0.0], [-2.0, 1.0]])
    turned = T @ np.array([[[e, 2.0**16], [0.0, -1.0]]]) @ back

    assert decays_exactly(turned[0], 0.0) is not slow
    assert (slow_vertex(turned, 0.0) is not None) is slow


def test_an_eigenvalue_that_rounding_moves_is_no_reason() -> None:
    """Eight modes at -1/4, coupled by 1e5, in integer states: computed, some grow."""
    n = 8
    A = -0.25 * np.eye(n) + np.diag([1e5] * (n - 1), 1)
    S = np.tri(n)
    turned = S @ A @ (np.eye(n) - np.eye(n, k=-1))

    assert np.linalg.eigvals(turned).real.max() > 0
    assert decays_exactly(turned, 0.0)
    assert slow_vertex(turned[None], 0.0) is None


@pytest.mark.parametrize("step", [None, 0.1])
def test_exact_decay_agrees_with_eigenvalues(step: float | None) -> None:
    random = np.random.default_rng(3)
    for _ in range(40):
        A = random.normal(size=(size := int(random.integers(1, 6)), size))
        z = np.linalg.eigvals(A)
        rate = -z.real.max() if step is None else -np.log(np.abs(z).max()) / step

        assert decays_exactly(A, rate - 1e-6, step=step)
        assert not decays_exactly(A, rate + 1e-6, step=step)
