"""A ball of initial states: closed forms from both sides, an independent optimum, units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import He, Unknown, block, hinf_pdc, optimise, pdc, pose
from takagi.models import ModelError, TSModel


def balance(a: float = 2.0) -> TSModel:
    """x' = a x + u."""
    return TSModel([[[a]]], [[[1.0]]])


def two_rules() -> TSModel:
    """Two rules of a pole on a cart, as the guide has them, in units of order one."""
    A = np.array([[[0, 1], [17.29, 0]], [[0, 1], [9.35, 0]]])
    return TSModel(A, np.array([[[0], [1.0]], [[0], [0.8]]]))


def largest_radius(model: TSModel, limit: float) -> float:
    """The largest ball by LMIs written anew: Q >= t I, u_max^2 and M_i, all pairs; t = radius^2."""
    n, m = model.B.shape[1:]
    Q, M = Unknown("Q", n, n, symmetric=True), Unknown("M", m, n, count=2)
    t = Unknown("t", 1, 1)
    A, B = model.A, model.B
    loop = [[A[i] @ Q - B[i] @ M.member(j) for j in range(2)] for i in range(2)]
    condition = pose(
        *(He(loop[i][i]) << 0 for i in range(2)),
        He(loop[0][1] + loop[1][0]) << 0,
        *(block([[limit**2 * np.eye(m), M.member(i)], [None, Q]]) >= 0 for i in range(2)),
        Q >= t * np.eye(n),
        minimise=-t,
    )
    return float(np.sqrt(-optimise(condition).objective))


@pytest.mark.parametrize(("radius", "status"), [(0.49, "candidate"), (0.51, "infeasible")])
def test_a_scalar_plant_holds_a_ball_up_to_limit_over_pole(radius: float, status: str) -> None:
    """x' = 2 x + u with |u| <= 1: k > 2 and k radius <= 1, so radius < 1/2 exactly."""
    design = pdc(balance(), input_limit=[1.0], initial_ball=radius)

    assert design.status == status
    if design.found:
        gains, P = design.require()
        assert P[0, 0] * radius**2 <= 1 and abs(gains[0, 0, 0]) / np.sqrt(P[0, 0]) <= 1


@pytest.mark.parametrize("factor", [0.98, 1.02])
def test_both_sides_of_the_largest_ball_of_an_independent_optimum(factor: float) -> None:
    """Tanaka and Wang (2001), section 3.4.1: phi^2 I <= X; the largest phi by other LMIs."""
    model = two_rules()
    radius = factor * largest_radius(model, 5.0)

    design = pdc(model, input_limit=[5.0], initial_ball=radius)

    assert design.found is (factor < 1)


def test_the_ball_lies_inside_the_ellipsoid_and_the_input_keeps_its_limit_there() -> None:
    """The largest eigenvalue of P is 1 / radius^2 at most; a much larger ball is not inside."""
    design = pdc(two_rules(), decay_rate=0.5, input_limit=[60.0], initial_ball=0.4)
    K, P = design.require()

    assert np.linalg.eigvalsh(P)[-1] <= 1 / 0.4**2
    assert max(np.sqrt(k @ np.linalg.inv(P) @ k) for k in K[:, 0]) <= 60.0
    # Of all sets with these limits the one of least effort is not much larger than the ball.
    assert np.linalg.eigvalsh(P)[-1] > 1 / 4.0**2


def test_a_ball_asks_less_than_the_box_around_it() -> None:
    """Corners of the box are sqrt(2) radii away: a limit between the two has gains for the ball."""
    model = two_rules()
    radius = 0.9 * largest_radius(model, 5.0)

    ball = pdc(model, input_limit=[5.0], initial_ball=radius)
    box = pdc(model, input_limit=[5.0], initial_box=[radius, radius])

    assert (ball.status, box.status) == ("candidate", "infeasible")


def test_semi_axes_are_a_ball_in_other_units() -> None:
    """The same plant with its rate in mrad/s: the ball becomes an ellipsoid, the answer stays."""
    model, T = two_rules(), np.diag([1.0, 1000.0])
    other = TSModel(T @ model.A @ np.linalg.inv(T), T @ model.B)
    limit = largest_radius(model, 5.0)

    for factor in (0.98, 1.02):
        axes = [factor * limit, 1000.0 * factor * limit]
        assert pdc(other, input_limit=[5.0], initial_ball=axes).found is (factor < 1)


def test_the_largest_decay_rate_is_bounded_by_a_ball_too() -> None:
    """x' = 2 x + u, |u| <= 1 from |x| <= 0.25: k <= 4, so the largest rate is 2 1/s."""
    design = pdc(balance(), decay_rate="max", input_limit=[1.0], initial_ball=0.25)

    assert design.decay_rate == pytest.approx(2.0, rel=1e-3)


def test_disturbances_take_a_ball_too() -> None:
    """The set of ``hinf_pdc`` holds the ball, and its limit on the input."""
    model = TSModel([[[2.0]]], [[[1.0]]], C=[[1.0]], E=[[1.0]])

    design = hinf_pdc(model, input_limit=[1.0], initial_ball=0.3, disturbance_energy=1e-3)

    K, P = design.require()
    assert P[0, 0] * 0.3**2 <= 1 and abs(K[0, 0, 0]) / np.sqrt(P[0, 0]) <= 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"initial_ball": -1.0}, "initial_ball"),
        ({"initial_ball": [1.0, 2.0, 3.0]}, r"initial_ball has shape \(3,\)"),
        ({"initial_ball": 2.0, "state_box": [1.0, np.inf]}, "the initial ball reaches to 2"),
        ({"initial_ball": 0.0}, "initial_ball"),
    ],
)
def test_balls_that_are_none_are_refused(arguments: dict[str, Any], message: str) -> None:
    """Radius and semi-axes are positive, and fit into the box of the states."""
    with pytest.raises(ModelError, match=message):
        pdc(two_rules(), **arguments)


Floats = NDArray[np.float64]
