"""The look in floats before the proof: it never rules out what is true."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.requests.decay import cannot_be_definite, cannot_decrease
from takagi.certificates.requests.loop.set_level import (
    best_multiplier,
    fall_rate,
    invariant_level,
)
from takagi.models import TSModel


def exact(M: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> Matrix:
    return Matrix.of([[Fraction(repr(float(entry))) for entry in row] for row in M])


@given(st.integers(1, 12), st.integers(0, 10**6), st.floats(-1e-14, 1e-14))
def test_what_is_ruled_out_is_not_definite(n: int, seed: int, hair: float) -> None:
    """F F' + hair I, singular up to a hair of either sign: a breakdown is never a mistake."""
    F = np.random.default_rng(seed).normal(size=(n, max(1, n - 1)))
    M = F @ F.T + hair * np.eye(n)
    M = (M + M.T) / 2

    if cannot_be_definite(M[None]):
        assert not exact(M).is_positive_definite


def test_what_is_plainly_indefinite_is_ruled_out() -> None:
    """One matrix of many is enough; positive definite ones pass."""
    good = np.array([np.eye(3), 2 * np.eye(3)])

    assert not cannot_be_definite(good)
    assert cannot_be_definite(np.concatenate([good, [np.diag([1.0, 1.0, -1e-6])]]))


@pytest.mark.parametrize("step", [None, 0.1])
def test_rates_beyond_the_eigenvalues_are_ruled_out(step: float | None) -> None:
    """A = -I decays at 1 1/s: with P = I nothing slower is ruled out, and what is faster is."""
    A = -np.eye(2)[None] if step is None else np.exp(-step) * np.eye(2)[None]

    for rate in (0.0, 0.5, 1 - 1e-12, 1.0):
        assert not cannot_decrease(A, np.eye(2), rate, step)
    assert cannot_decrease(A, np.eye(2), 1 + 1e-9, step)


def test_what_was_skipped_is_said() -> None:
    """Too few digits of P for a rate at its limit fail in floats, and the list of tries says so."""
    A = np.array([[0.0, 1.0], [-2.1, -3.3]])
    slowest = -float(np.linalg.eigvals(A).real.max())

    found = certify(TSModel(A[None]), decay_rate=slowest - 1e-7)

    assert found.verdict is Verdict.PROVED
    assert any(words.endswith("fails in floats") for words in found.tried)


@pytest.mark.parametrize("rate", [1.0, 1.1, 3.3])
def test_the_best_multiplier_of_two_vertices_is_found_between_grid_points(rate: float) -> None:
    """x' = -a x + b w at two vertices: b^2 / (s (2 a - s)) each, equal at the best s."""
    a, b = np.array([rate, 2.0 * rate]), np.array([1.0, 3.0])
    A, W, P = -a[:, None, None], b[:, None, None], np.eye(1)
    dense = np.linspace(1e-6, 2 * rate * (1 - 1e-6), 200_001)
    least = (b[:, None] ** 2 / (dense * (2 * a[:, None] - dense))).max(axis=0).min()

    level, multiplier = best_multiplier(A, W, P, discrete=False)

    assert least * (1 - 1e-5) <= level <= least * (1 + 1e-5)
    assert level == pytest.approx(invariant_level(A, W, P, multiplier, discrete=False))


def test_the_best_multiplier_may_lie_next_to_the_rate_of_fall() -> None:
    """x1 alone is disturbed and falls fast, x2 slowly: the level is least at the slow rate's end.

    A grid that ended at 98 per cent of it left one per cent of the level away.
    """
    A, W, P = np.diag([-5.0, -0.5])[None], np.array([[[1.0], [0.0]]]), np.eye(2)
    least = 1.0 / (1.0 * (10.0 - 1.0))

    level, multiplier = best_multiplier(A, W, P, discrete=False)
    known, _ = best_multiplier(A, W, P, discrete=False, start=1.0 - 1e-9)

    assert least < level < least * (1 + 1e-3) and multiplier < 1.0
    assert known == pytest.approx(least, rel=1e-8)


def test_a_p_that_rounding_made_indefinite_shows_nothing() -> None:
    """Ill-conditioned P to too few digits: no level, and no exception."""
    P = np.array([[1.0, 1.0], [1.0, 1.0 - 1e-9]])
    A, W = -np.eye(2)[None], np.ones((1, 2, 1))

    assert fall_rate(A, P, discrete=False) == -np.inf
    assert best_multiplier(A, W, P, discrete=False) == (np.inf, 0.0)
