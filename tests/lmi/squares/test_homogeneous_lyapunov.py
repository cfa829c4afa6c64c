"""Common forms of degree 2, 4, 6: published bounds, exact limits, exact arithmetic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    common_lyapunov,
    exact_no,
    homogeneous_lyapunov,
    homogeneous_lyapunov_condition,
)
from takagi.models import ModelError, TSModel


def spring(k: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    """x'' + x' + (2 + u(t)) x = 0 with 0 <= u(t) <= k: Zelentsovsky (1994), IEEE TAC 39(1)."""
    return np.array([[[0.0, 1.0], [-2.0, -1.0]], [[0.0, 1.0], [-2.0 - k, -1.0]]])


def half_turn(k: float) -> float:
    """By how much |x| grows in a half turn of the worst switching: at 1 stability ends.

    The spring is stiff inward and soft outward: from rest at x = 1 inward with 2 + k, outward with
    2, each a damped oscillation by its closed form.
    """
    damping = 0.5
    size = 1.0
    w = np.sqrt(2.0 + k - damping**2)
    # Inward, stiff, from x = 1 at rest to x = 0.
    t = (np.pi - np.arctan2(w, damping)) / w
    speed = size * (2.0 + k) / w * np.exp(-damping * t) * np.sin(w * t)
    # Outward, soft, from x = 0 with this speed to rest.
    w = np.sqrt(2.0 - damping**2)
    t = np.arctan2(w, damping) / w
    return float(speed / w * np.exp(-damping * t) * np.sin(w * t))


@pytest.mark.parametrize(
    ("degree", "below", "above"),
    [(2, 3.82, 3.83), (4, 5.73, 5.75), (6, 6.20, 6.23)],
)
def test_the_bounds_of_the_spring_are_the_published_ones(
    degree: int, below: float, above: float
) -> None:
    """Chesi, Garulli, Tesi and Vicino (2003): 3.82, 5.73, 6.20 for forms of degree 2, 4, 6."""
    inside = homogeneous_lyapunov(spring(below), degree=degree)
    outside = homogeneous_lyapunov(spring(above), degree=degree)

    assert (inside.status, outside.status) == ("candidate", "infeasible")
    assert inside.exact().holds
    no = exact_no(homogeneous_lyapunov_condition(spring(above), degree=degree))
    assert no is not None and no.holds


def test_quadratic_forms_end_at_the_circle_criterions_exact_value() -> None:
    """k < 1 + 2 sqrt(2), from the Nyquist curve of 1 / (s^2 + s + 2)."""
    limit = 1 + 2 * np.sqrt(2)

    for k, status in ((limit - 1e-3, "candidate"), (limit + 1e-3, "infeasible")):
        assert homogeneous_lyapunov(spring(k), degree=2).status == status
        assert common_lyapunov(spring(k)).status == status


def test_no_degree_goes_beyond_the_worst_switching() -> None:
    """The worst switching is stable up to k = 6.985, and no form of any degree may say more."""
    low, high = 5.0, 9.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if half_turn(middle) < 1 else (low, middle)

    assert low == pytest.approx(6.985, abs=1e-3)
    assert homogeneous_lyapunov(spring(low + 0.02), degree=12).status == "infeasible"
    assert homogeneous_lyapunov(spring(6.6), degree=12).exact().holds


def test_the_form_falls_along_every_blend_on_a_grid() -> None:
    """V and V' by the polynomial with rational coefficients, at 360 directions and 11 blends."""
    A = spring(5.5)
    V = homogeneous_lyapunov(A, degree=4).polynomial
    angle = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    x = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    slopes = np.stack([(V(x + 1e-6 * e) - V(x - 1e-6 * e)) / 2e-6 for e in np.eye(2)], axis=1)

    assert V.degree == 4 and V.least_degree == 4
    assert V(x).min() > 0
    for h in np.linspace(0, 1, 11):
        moved = x @ ((1 - h) * A[0] + h * A[1]).T
        assert (np.sum(slopes * moved, axis=1) < 0).all()


def test_the_decay_rate_is_that_of_a_single_mode() -> None:
    """x1' = -x1, x2' = -2 x2: V^(1/4) decays at 1 1/s at most, from both sides."""
    A = np.diag([-1.0, -2.0])

    assert homogeneous_lyapunov(A, degree=4, decay_rate=0.999).exact().holds
    assert homogeneous_lyapunov(A, degree=4, decay_rate=1.001).status == "infeasible"


def test_a_broken_form_is_refused_in_exact_arithmetic() -> None:
    """One entry of G turned in sign: no longer positive, and said so."""
    answer = homogeneous_lyapunov(spring(5.0), degree=4)
    G = answer.exact().values["G"].copy()
    assert answer.exact().holds

    G[0, 1, 1] = -G[0, 1, 1]
    broken = type(answer.exact())(
        condition=answer.condition, values={**answer.exact().values, "G": G}
    )

    assert "not definite" in broken.fault()


def test_three_states_in_bad_units_are_answered_as_in_good_ones() -> None:
    """A polytope without a common quadratic function, its third state in micrometres."""
    A = np.zeros((2, 3, 3))
    A[:, :2, :2], A[:, 2, 2], A[:, 2, 0] = spring(4.5), -1.0, 0.3
    T = np.diag([1.0, 1.0, 1e6])

    assert common_lyapunov(A).status == "infeasible"
    assert homogeneous_lyapunov(A, degree=4).exact().holds
    assert homogeneous_lyapunov(T @ A @ np.linalg.inv(T), degree=4).exact().holds


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"degree": 3}, "even whole number"),
        ({"degree": 0}, "even whole number"),
        ({"degree": 4.0}, "even whole number"),
        ({"degree": 300}, "monomials in a Gram matrix"),
    ],
)
def test_degrees_that_are_none_are_refused(arguments: dict[str, Any], message: str) -> None:
    """Odd, zero, or too many monomials."""
    with pytest.raises(ModelError, match=message):
        homogeneous_lyapunov(spring(1.0), **arguments)


def test_discrete_time_is_refused_with_its_reason() -> None:
    """V(A x) is not affine in A, so vertices say nothing of blends."""
    with pytest.raises(ModelError, match="not affine in A"):
        homogeneous_lyapunov(TSModel(0.5 * np.eye(2)[None], sample_time=0.1))
