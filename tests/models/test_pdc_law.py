"""The law by rules as it is run: against its formula by hand, at corners, outside the box."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Interval, ModelError, Plant, TSModel, Variable, sector_model
from takagi.models.laws.pdc import PdcLaw
from tests.symbolic_plants import plant_of

X, V, U, W = sp.symbols("x v u w", real=True)
K = np.array([[[3.0, 1.0]], [[7.0, 2.0]]])
REST = (np.array([0.5, 0.0]), np.array([0.25]))


def model() -> TSModel:
    """x'' = -x^3 + u for |x| <= 2: one premise, -x^2 in [-4, 0]."""
    return sector_model(
        plant_of(
            [V, -(X**3) + U],
            [X, V],
            [U],
            box={X: (-2, 2)},
            premises={sp.Symbol("z1", real=True): -(X**2)},
        )
    )


def law() -> PdcLaw:
    return PdcLaw(model(), K, *REST)


@given(st.floats(-2, 2), st.floats(-3, 3))
def test_the_command_is_the_formula(x: float, v: float) -> None:
    """u = u* - (w0 K_1 + w1 K_2)(x - x*), weights of -x^2 in [-4, 0], by hand."""
    share = (4 - x**2) / 4
    blended = (1 - share) * K[0] + share * K[1]

    found = law().command(np.array([x + 0.5, v]))

    assert found == pytest.approx(0.25 - blended @ np.array([x, v]), abs=1e-9)


def test_memberships_are_convex_and_pick_the_corner() -> None:
    at = law()
    for x in (0.0, 2.0):
        h = at.memberships(np.array([0.5 + x, 0.0]))
        assert h.sum() == pytest.approx(1.0) and h.max() == pytest.approx(1.0, abs=1e-6)


def test_outside_the_box_a_premise_is_held() -> None:
    inside, outside = (law().memberships(np.array([0.5 + x, 0.0])) for x in (2.0, 50.0))

    assert outside == pytest.approx(inside, abs=1e-6)


def test_at_rest_the_command_is_the_trim() -> None:
    """x = x* gives u*, whatever the gains."""
    assert law().command(REST[0]) == pytest.approx(REST[1])


def test_one_gain_for_all_rules_needs_no_premise() -> None:
    """(m, n) stands for all rules, and the state may then lie anywhere."""
    constant = PdcLaw(model(), K[0], *REST)

    assert not constant.is_scheduled and law().is_scheduled
    assert constant.command(np.array([1.5, 2.0])) == pytest.approx([0.25 - 3.0 - 2.0])


def test_a_disturbance_may_schedule() -> None:
    """x' = w x + u, w in [-1, 1] measured: at w = 1 the rule of that corner acts."""
    z = sp.Symbol("z", real=True)
    plant = Plant(
        equations=(W * X + U,),
        states=(Variable(X),),
        inputs=(Variable(U),),
        disturbances=(Variable(W, range=Interval.of(-1, 1), schedules=True),),
        premises={z: W},
    )
    scheduled = sector_model(plant)
    at = PdcLaw(scheduled, np.array([[[2.0]], [[6.0]]]), np.zeros(1), np.zeros(1))

    assert at.command(np.ones(1), w=-1.0) == pytest.approx([-2.0])
    assert at.command(np.ones(1), w=0.5) == pytest.approx([-5.0])
    assert at.command(np.ones(1), w=1.0) == pytest.approx([-6.0])


@pytest.mark.parametrize(
    ("gains", "state_rest", "input_rest", "message"),
    [
        (np.zeros((3, 1, 2)), *REST, "2 rules, 1 inputs and 2 states need"),
        (np.full((2, 1, 2), np.nan), *REST, r"K\[0, 0, 0\] is nan; every entry must be finite"),
        (K, np.zeros(3), REST[1], "state_rest has shape"),
        (K, REST[0], np.array([np.inf]), "input_rest has shape"),
    ],
)
def test_what_does_not_fit_is_refused(
    gains: np.ndarray, state_rest: np.ndarray, input_rest: np.ndarray, message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        PdcLaw(model(), gains, state_rest, input_rest)


def test_a_state_or_signal_that_is_not_the_model_s_is_refused() -> None:
    with pytest.raises(ModelError, match="the state has shape"):
        law().memberships(np.zeros(3))
    with pytest.raises(ModelError, match="signal wind was given; the model has u"):
        law().memberships(np.zeros(2), wind=3.0)
