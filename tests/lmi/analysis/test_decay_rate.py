"""The largest common decay rate against exact and published values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import common_lyapunov, max_decay_rate
from takagi.lmi.analysis.decay_rate import rate_of
from tests.lmi.known_models import feasp_triple

pytestmark = pytest.mark.numeric


def test_three_vertices_of_the_gevp_page() -> None:
    """MathWorks, gevp: V' <= -0.122 V, recomputed by bisection 0.1221308; ours is half of it."""
    A = feasp_triple()
    answer = max_decay_rate(A)

    assert answer.decay_rate == pytest.approx(0.12213081 / 2, rel=1e-6)
    assert answer.P is not None and answer.decay_rate is not None
    assert rate_of(A, answer.P) == pytest.approx(answer.decay_rate, rel=1e-9)
    assert len(answer.tries) < 8


def test_an_unstable_system_has_a_negative_rate() -> None:
    """x' = 0.1 x + rotation grows with 0.1: the rate is -0.1, and it is an answer."""
    answer = max_decay_rate(np.array([[0.1, 2.0], [-2.0, 0.1]]))

    assert answer.found
    assert answer.decay_rate == pytest.approx(-0.1, abs=1e-5)


def test_a_supremum_that_is_not_attained_is_approached_from_below() -> None:
    """A Jordan block at -1 shows every rate below 1 and not 1; P stays usable."""
    answer = max_decay_rate(np.array([[-1.0, 1.0], [0.0, -1.0]]))

    assert answer.decay_rate is not None and answer.P is not None
    assert 0.999 < answer.decay_rate < 1.0 <= answer.bound
    assert np.linalg.cond(answer.P) < 1e10


@settings(max_examples=10)
@given(st.integers(0, 1000))
def test_one_matrix_against_its_eigenvalues(seed: int) -> None:
    """For one diagonalisable matrix the rate is -max Re(eigenvalue)."""
    A = np.random.default_rng(seed).standard_normal((4, 4))
    answer = max_decay_rate(A)
    slowest = -float(np.linalg.eigvals(A).real.max())

    assert answer.decay_rate == pytest.approx(slowest, abs=2e-3)
    assert answer.decay_rate is not None and answer.decay_rate <= slowest + 1e-9


def test_rounds_find_what_all_vertices_at_once_find() -> None:
    """The rate of 400 vertices is the rate of the few that bind."""
    rng = np.random.default_rng(3)
    A = rng.standard_normal((3, 3)) - 3 * np.eye(3) + 0.2 * rng.standard_normal((400, 3, 3))
    answer = max_decay_rate(A)
    assert answer.P is not None and answer.decay_rate is not None

    assert rate_of(A, answer.P) == pytest.approx(answer.decay_rate, abs=1e-9)
    # A thousandth, of the rate or of a thousandth of the vertices: what a candidate promises.
    size = float(np.linalg.norm(A, 2, axis=(1, 2)).max())
    near = 1e-3 * max(abs(answer.bound), 2e-3 * size)
    assert answer.decay_rate <= answer.bound <= answer.decay_rate + near
    assert common_lyapunov(A, decay_rate=answer.bound + 10 * near).status == "infeasible"
