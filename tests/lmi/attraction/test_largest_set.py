"""Measures of an ellipsoid as objectives, against cvxpy's log det and closed forms."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import LMI, Condition, Constant, Term, Unknown, optimise
from takagi.lmi.gains.attraction.set_size import (
    Measure,
    points_measure,
    trace_measure,
    volume_measure,
)

Floats = NDArray[np.float64]


def within(rows: Floats) -> tuple[Unknown, Condition]:
    """Return Q > 0 with the ellipsoid in |c_k x| <= 1."""
    size = rows.shape[1]
    Q = Unknown("Q", size, size, symmetric=True)
    one = np.eye(size)[None]
    inside = LMI(
        name="inside",
        blocks=(1,),
        terms=(Term(unknown=Q, left=rows[:, None, :], right=rows[:, :, None]),),
        constants=(Constant(value=-np.ones((1, 1, 1))),),
        sign=-1,
        count=len(rows),
        weight=1e-3,
    )
    positive = LMI(name="Q", blocks=(size,), terms=(Term(unknown=Q, left=one, right=one),))
    return Q, Condition(name="inside", unknowns=(Q,), lmis=(positive, inside))


def largest(condition: Condition, measure: Measure) -> Floats:
    outcome = optimise(measure.put_on(condition))
    assert outcome.status == "candidate"
    return np.asarray(outcome.values["Q"][0])


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5])
def test_the_largest_volume_is_that_of_log_det(size: int) -> None:
    """cvxpy's exponential cones and the tree of geometric means have the same determinant."""
    rows = np.random.default_rng(size).standard_normal((3 * size, size))
    Q, condition = within(rows)
    found = largest(condition, volume_measure(Q))
    cp: Any = import_module("cvxpy")
    X = cp.Variable((size, size), symmetric=True)
    problem = cp.Problem(cp.Maximize(cp.log_det(X)), [row @ X @ row <= 1 for row in rows])
    problem.solve(solver="CLARABEL")

    assert np.linalg.slogdet(found)[1] == pytest.approx(problem.value, abs=1e-4)
    np.testing.assert_allclose(found, X.value, atol=1e-3 * np.abs(found).max())


def test_the_largest_trace_in_given_units() -> None:
    """In the unit square any ellipse through the middles of its sides; weights choose."""
    Q, condition = within(np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]]))
    for units, direction in (([1.0, 9.0], 0), ([9.0, 1.0], 1)):
        found = largest(condition, trace_measure(Q, np.array(units)))
        assert found[direction, direction] == pytest.approx(1, rel=1e-4)


def test_the_largest_multiple_of_points() -> None:
    """In the unit disc the largest multiple of (3, 4) is 1/5."""
    angles = np.linspace(0, np.pi, 181)
    Q, condition = within(np.stack([np.cos(angles), np.sin(angles)], axis=1))
    point = np.array([[3.0, 4.0]])
    found = largest(condition, points_measure(Q, point))

    assert (point @ np.linalg.inv(found) @ point.T)[0, 0] == pytest.approx(25, rel=1e-3)
