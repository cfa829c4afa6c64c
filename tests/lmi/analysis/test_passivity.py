"""Passivity: a textbook's threshold from both sides, a frequency sweep, exact P B = C'."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.lmi import exact_solution, passivity, passivity_condition
from takagi.models import ModelError, TSModel


def lag(zero: float, first: float = 1.0, second: float = 2.0) -> tuple[Any, Any, Any]:
    """(s + zero) / ((s + first)(s + second)) in controllable form."""
    A = np.array([[0.0, 1.0], [-first * second, -(first + second)]])
    return A, np.array([[0.0], [1.0]]), np.array([[zero, 1.0]])


def least_real_part(zero: float, first: float = 1.0, second: float = 2.0) -> float:
    """The least of w^2 Re G(i w) over frequencies up to 1e4: its limit is first + second - zero."""
    w = np.logspace(-3, 4, 2000)
    s = 1j * w
    return float(
        ((s + zero) / ((s + first) * (s + second))).real.min(where=w > 0, initial=1.0) * 1e8
    )


@pytest.mark.parametrize(("zero", "passive"), [(2.99, True), (3.01, False), (0.5, True)])
def test_a_lag_is_strictly_positive_real_up_to_the_sum_of_its_poles(
    zero: float, passive: bool
) -> None:
    """Narendra and Annaswamy (1989), Stable Adaptive Systems, chapter 2: (s + c)/((s + a)(s + b))
    with a, b, c > 0 is strictly positive real if and only if a + b > c.
    """
    answer = passivity(*lag(zero))

    assert answer.status == ("candidate" if passive else "infeasible")
    assert (least_real_part(zero) > 0) is passive


def test_the_storage_function_holds_in_exact_arithmetic_with_P_B_equal_to_C() -> None:
    """Rounded onto P B = C' in rationals, P > 0 and He(P A) < 0 are decided without rounding."""
    condition = passivity_condition(*lag(2.5))
    P = passivity(*lag(2.5)).P
    assert P is not None

    exact = exact_solution(condition, {"P": P[None]})
    broken = exact_solution(condition, {"P": P[None] - 10 * np.eye(2)})

    assert exact is not None and exact.holds
    assert exact.values["P"][0, 0, 1] == Fraction(5, 2) and exact.values["P"][0, 1, 1] == 1
    assert broken is not None and not broken.holds


def test_a_mass_spring_damper_is_passive_from_force_to_velocity_only_strictly_with_damping() -> (
    None
):
    """Khalil (2002), section 6.1, RLC circuits: passive from force to velocity, with P the energy.

    The LMI asks for decay in every state, which velocity alone does not show: a little of the
    position in the output makes it strict, the position alone is not passive.
    """
    A, B = [[0.0, 1.0], [-4.0, -0.5]], [[0.0], [1.0]]

    assert passivity(A, B, [[0.2, 1.0]]).status == "candidate"
    assert passivity(A, B, [[0.2, 0.0]]).status == "infeasible"
    assert passivity(A, B, [[0.6, 1.0]]).status == "infeasible"  # past a + b = 0.5 of the sum


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_a_direct_term_decides_by_the_real_part_of_the_frequency_response(
    sample_time: float | None,
) -> None:
    """D just above and below the most negative real part of G, from a dense grid of frequencies."""
    A = np.array([[0.2, 0.5], [-0.4, 0.6]]) - (0.0 if sample_time else 1.0) * np.eye(2)
    B, C = np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    grid = np.linspace(0, np.pi, 4001) if sample_time else np.logspace(-4, 3, 4001)
    points = np.exp(1j * grid) if sample_time else 1j * grid
    least = min(float((C @ np.linalg.solve(z * np.eye(2) - A, B))[0, 0].real) for z in points)

    above = passivity(A, B, C, [[-least + 0.01]], sample_time=sample_time)
    below = passivity(A, B, C, [[-least - 0.01]], sample_time=sample_time)

    assert (above.status, below.status) == ("candidate", "infeasible")


def test_vertices_share_one_storage_function_or_have_none() -> None:
    """Two loops that are passive each, with one B and one C: together up to a distance."""
    A = np.array([lag(1.0)[0], lag(1.0, 1.0, 3.0)[0]])
    model = TSModel(A, np.array([lag(1.0)[1]] * 2), C=np.array([lag(1.0)[2]] * 2))
    other = TSModel(A, np.array([lag(1.0)[1]] * 2), C=np.array([lag(1.0)[2], lag(1.5)[2]]))

    together, apart = passivity(model), passivity(other)

    assert together.status == "candidate"
    assert apart.status == "infeasible" and "contradict" in apart.diagnosis


def test_units_of_the_states_do_not_matter() -> None:
    """The same loop in mm and hours: the same answer, on both sides of the threshold."""
    T = np.diag([1e3, 3600.0])
    for zero, status in ((2.9, "candidate"), (3.1, "infeasible")):
        A, B, C = lag(zero)
        assert passivity(T @ A @ np.linalg.inv(T), T @ B, C @ np.linalg.inv(T)).status == status


def test_as_many_outputs_as_inputs_are_needed() -> None:
    """The supply w' y is a product of vectors of one length."""
    with pytest.raises(ModelError, match="as many outputs as inputs"):
        passivity(-np.eye(2), np.eye(2), [[1.0, 0.0]])
