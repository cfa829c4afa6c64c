"""The vertex form: memberships are convex weights, blends are exact, misuse is explained."""

from __future__ import annotations

from fractions import Fraction

import control
import numpy as np
import pytest
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError, Premise, TSModel


def two_premises() -> tuple[Premise, ...]:
    return Premise("z1", -1, 2), Premise("k", 3, 3), Premise("z2", "0.1", 0.3)


def four_rules() -> TSModel:
    return TSModel(
        np.arange(16.0).reshape(4, 2, 2), np.ones((2, 1)), premises=two_premises(), name="four"
    )


def test_rules_are_all_corners_and_a_constant_premise_costs_none() -> None:
    assert four_rules().rules == ((0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 0, 1))


def test_bounds_are_read_as_the_decimals_they_are_written_as() -> None:
    """0.3 as a float and "0.3" as text are both 3/10, not the nearest binary number."""
    assert two_premises()[2].upper == Fraction(3, 10)


@given(st.floats(-1, 2), st.floats(0.1, 0.3))
def test_memberships_are_a_convex_sum(z1: float, z2: float) -> None:
    """h_i >= 0 and sum h_i = 1 anywhere in the box (Tanaka and Wang 2001, section 2.1)."""
    h = four_rules().memberships(z1=z1, k=3, z2=z2)

    assert np.all(h >= 0)
    assert np.sum(h) == pytest.approx(1, abs=1e-15)


@given(st.floats(-1, 2), st.floats(0.1, 0.3))
def test_blend_returns_the_premises_themselves(z1: float, z2: float) -> None:
    first, _, second = two_premises()
    corners = [(a, b) for a in first.corners for b in second.corners]
    model = TSModel(
        [[[float(a), float(b)], [float(a * b), 1.0]] for a, b in corners],
        premises=(first, second),
    )

    expected = [[z1, z2], [z1 * z2, 1.0]]
    np.testing.assert_allclose(model.blend([z1, z2]).A, expected, atol=1e-14)


def test_a_corner_belongs_to_one_rule() -> None:
    h = four_rules().memberships([2, 3, 0.3])

    np.testing.assert_array_equal(h, [0, 0, 0, 1])


def test_arrays_of_premise_values_give_arrays_of_memberships() -> None:
    z = np.array([[0.0, 1.0], [3.0, 3.0], [0.2, 0.1]])
    model = four_rules()

    assert model.memberships(z).shape == (4, 2)
    np.testing.assert_allclose(model.blend(z).A[1], model.blend(z[:, 1]).A)


def test_outside_the_box_is_refused_unless_clipped() -> None:
    """A premise outside its range raises; clip=True takes the nearer end."""
    model = four_rules()

    with pytest.raises(ModelError, match=r"premise z1 = 5 .* outside its range \[-1, 2\]"):
        model.memberships(z1=5, k=3, z2=0.2)
    np.testing.assert_array_equal(
        model.memberships(z1=5, k=3, z2=0.2, clip=True), model.memberships(z1=2, k=3, z2=0.2)
    )


def test_nan_is_refused_even_when_clipped() -> None:
    with pytest.raises(ModelError, match="premise z1 = nan"):
        four_rules().memberships(z1=np.nan, k=3, z2=0.2, clip=True)


def test_arrays_are_read_only_copies() -> None:
    A = np.zeros((1, 2, 2))
    model = TSModel(A)
    A[0, 0, 0] = 1

    assert model.A[0, 0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        model.A[0, 0, 0] = 1


@pytest.mark.parametrize("step", [None, 0.5])
@pytest.mark.parametrize("maker", ["control", "scipy"])
def test_state_spaces_are_vertices(maker: str, step: float | None) -> None:
    A, B, C, D = np.array([[0.0, 1.0], [-2.0, -1.0]]), [[0.0], [1.0]], [[1.0, 0.0]], [[0.0]]
    timed = {} if step is None else {"dt": step}
    make = control.ss if maker == "control" else scipy.signal.StateSpace
    model = TSModel([make(A, B, C, D, **timed), make(2 * A, B, C, D, **timed)])

    np.testing.assert_array_equal(model.A, [A, 2 * A])
    np.testing.assert_array_equal(model.B, [B, B])
    assert model.C.shape == (2, 1, 2) and model.sample_time == step


def test_missing_matrices_are_empty_and_shared_ones_are_repeated() -> None:
    """Without B there is no input; a (n, m) matrix counts for every vertex."""
    model = TSModel(np.zeros((3, 2, 2)), C=[[1, 0]])

    assert model.B.shape == (3, 2, 0)
    assert model.C.shape == (3, 1, 2)
    assert model.D.shape == (3, 1, 0)
    assert (model.states, model.outputs) == (("x1 [-]", "x2 [-]"), ("y1 [-]",))
    assert len(model.vertices) == 3


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: TSModel([np.eye(3), np.zeros((3, 4))], states=["a", "b", "c"]),
            r"vertex 2 of 2: A has shape \(3, 4\), but 3 states are named \(a, b, c\), so A must",
        ),
        (lambda: TSModel(np.eye(2)), r"\(r, n, n\) is needed"),
        (lambda: TSModel([np.eye(2)], np.ones((3, 1))), r"B has shape \(3, 1\)"),
        (lambda: TSModel(np.array([[[1, np.nan], [0, 1]]])), r"A\[0, 0, 1\] is nan"),
        (lambda: TSModel(np.array([[["a", "0"], ["0", "1"]]])), "A cannot be read"),
        (
            lambda: TSModel([np.eye(2)], np.eye(2), inputs=["force [N]"]),
            r"1 inputs are named \(force \[N\]\), but B has 2",
        ),
        (lambda: TSModel([np.eye(2)], states=["a", "a"]), "named more than once"),
        (lambda: TSModel([np.eye(2)], premises=[Premise("z", 0, 1)]), "1 vertices.*2 rules"),
        (lambda: TSModel([np.eye(2)] * 2, rules=[(0,), (1,)]), "rule 1 of 2"),
        (
            lambda: TSModel([np.eye(2)] * 2, premises=[Premise("z", 0, 1)], rules=[(0,), (0,)]),
            "leave out a combination",
        ),
        (lambda: TSModel([np.eye(2)], box={"x": (1, 0)}), "box of x"),
        (lambda: TSModel([np.eye(2)] * 2).memberships(), "no premises"),
        (lambda: TSModel([control.tf([1], [1, 2])]), "transfer functions"),
        (lambda: TSModel([control.ss(-1, 1, 1, 0), [[1.0]]]), "systems alone"),
        (lambda: TSModel([control.ss(-1, 1, 1, 0)], [[1.0]]), "B given"),
        (lambda: TSModel([control.ss(-1, 1, 1, 0, 1), control.ss(-1, 1, 1, 0)]), "sample times"),
        (lambda: TSModel([control.ss(-1, 1, 1, 0, True)]), "sample times"),
        (lambda: TSModel([control.rss(2), control.rss(3)]), "systems' A have shapes"),
        (lambda: four_rules().memberships(z1=0), "each of z1, k, z2 is needed"),
        (lambda: four_rules().memberships([0, 0]), "first axis must be 3"),
        (lambda: four_rules().premise_values(), "no evaluate function"),
        (lambda: Premise("z", 1, 0), "lower bound 1 exceeds upper bound 0"),
        (lambda: Premise("z", "one", 2), "premise z: lower bound"),
        (lambda: Premise(" ", 0, 1), "empty name"),
    ],
)
def test_misuse_names_the_item_and_what_was_needed(build: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        build()  # type: ignore[operator]
