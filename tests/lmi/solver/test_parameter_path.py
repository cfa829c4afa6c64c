"""The primal-dual path: exact ends, feasible all the way, and where it does not begin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import common_lyapunov_condition, max_decay_rate, pdc_condition
from takagi.lmi.analysis.common_quadratic import rate_of
from takagi.lmi.analysis.decay_rate import fast_decay
from takagi.lmi.parameter_search import ParameterPencil, follow_path
from takagi.models import TSModel

Floats = NDArray[np.float64]


def pencil_of(A: Floats, sample_time: float | None = None) -> ParameterPencil:
    """Return the pencil of the largest decay rate, or of the least contraction."""
    condition = common_lyapunov_condition(A, sample_time=sample_time)
    largest = sample_time is None
    return ParameterPencil.of(condition, "alpha" if largest else "contraction", largest=largest)


def small(value: float) -> float:
    """Return a difference that does not matter."""
    return 1e-8 * max(abs(value), 1e-2)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(2, 6))
def test_one_matrix_against_its_eigenvalues(seed: int, n: int) -> None:
    """The path alone, without a solver, ends at -max Re(eigenvalue), never above."""
    A = np.random.default_rng(seed).standard_normal((n, n))
    pencil = pencil_of(A)
    start = {"P": np.eye(n)[None]}
    value, best, _ = follow_path(pencil, start, pencil.allowed(start, 0.0), small)
    exact = -float(np.linalg.eigvals(A).real.max())

    # Near a defective eigenvalue P degenerates, and the path stops in time.
    assert exact - 2e-2 < value <= exact + 1e-9
    assert value == pytest.approx(pencil.allowed(best, 0.0), abs=1e-9)


@settings(max_examples=10)
@given(st.integers(0, 10**6))
def test_one_matrix_in_discrete_time(seed: int) -> None:
    """The least contraction of x+ = A x is the square of the spectral radius."""
    A = np.random.default_rng(seed).standard_normal((3, 3))
    pencil = pencil_of(A, 1.0)
    start = {"P": np.eye(3)[None]}
    value, best, _ = follow_path(pencil, start, pencil.allowed(start, 1.0), small)
    exact = float(np.abs(np.linalg.eigvals(A)).max()) ** 2

    assert exact - 1e-9 <= value < exact * (1 + 2e-2)
    grown = A.T @ best["P"][0] @ A - value * (1 + 1e-9) * best["P"][0]
    assert np.linalg.eigvalsh(grown)[-1] <= 1e-12


def test_many_vertices_end_where_the_solver_agrees() -> None:
    """From the identity to the largest common rate: the solver, just beyond, finds nothing."""
    rng = np.random.default_rng(0)
    A = rng.standard_normal((6, 6)) - 3 * np.eye(6) + 0.3 * rng.standard_normal((8, 6, 6))
    pencil = pencil_of(A)
    start = {"P": np.eye(6)[None]}
    first = pencil.allowed(start, 0.0)
    value, _, ended = follow_path(pencil, start, first, small)
    answer = max_decay_rate(A, tolerance=1e-5)

    assert ended and value > first
    assert answer.decay_rate is not None
    assert answer.decay_rate == pytest.approx(value, rel=3e-5)
    assert answer.bound >= value * (1 - 1e-9)
    # One look just beyond, and one for the best conditioned P.
    assert len(answer.tries) <= 4


def test_stiff_vertices() -> None:
    """Time constants from 1 ms to 1 s: the rate of the slowest mode, P far from the identity."""
    rng = np.random.default_rng(7)
    T = rng.standard_normal((6, 6))
    A = T @ np.diag([-1.0, -3.0, -10.0, -100.0, -300.0, -1000.0]) @ np.linalg.inv(T)
    answer = max_decay_rate(A * np.array([1.0, 1.3])[:, None, None])

    assert answer.decay_rate == pytest.approx(1.0, rel=1e-4)
    assert answer.bound >= 1.0 - 1e-6


def test_a_defective_eigenvalue_is_approached_while_p_is_usable() -> None:
    """A Jordan block of four at -1: every rate below 1, but P of condition 1/(1 - alpha)^6."""
    A = -np.eye(4) + np.diag(np.ones(3), 1)
    answer = fast_decay(A)

    assert answer.decay_rate is not None and answer.P is not None
    assert 0.95 < answer.decay_rate < 1.0 <= answer.bound < 1.001
    assert np.linalg.cond(answer.P) < 1e9

    asked = max_decay_rate(A)
    assert asked.status == "unknown" and asked.P is None and asked.decay_rate is None
    assert f"shows {answer.decay_rate:.6g} 1/s, no P shows more than 1.0" in asked.diagnosis
    assert rate_of(A[None], asked.feasible["P"][0]) == pytest.approx(answer.decay_rate, rel=1e-6)


def test_where_the_path_does_not_begin() -> None:
    """Several unknowns, or no end to begin with: what was given is handed back."""
    condition = pdc_condition(TSModel([[[1.0]]], [[1.0]]))
    pencil = ParameterPencil.of(condition, "alpha", largest=True)
    start = {"Q": np.ones((1, 1, 1)), "M": np.full((1, 1, 1), 3.0), "nu": np.full((1, 1, 1), 9.0)}
    assert follow_path(pencil, start, 1.0, small) == (1.0, start, False)

    alone = pencil_of(-np.eye(2))
    P = {"P": np.eye(2)[None]}
    assert follow_path(alone, P, np.inf, small) == (np.inf, P, False)
