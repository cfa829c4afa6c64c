"""The same plant on a smaller box."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from takagi.lmi.explaining.explanation import on_smaller_box, with_narrower_premise
from takagi.models import ModelError, Premise, TSModel


def two_premises(rules: list[tuple[int, int]] | None = None) -> TSModel:
    """Return A = a, B = b of a in [0, 4], b in [-1, 3] /s and with the rules in any order."""
    order = rules or [(0, 0), (0, 1), (1, 0), (1, 1)]
    A = [[[4.0 * c]] for c, _ in order]
    B = [[[-1.0 + 4.0 * c]] for _, c in order]
    premises = [Premise("a", 0, 4), Premise("b", -1, 3, unit="1/s")]
    return TSModel(A, B, premises=premises, rules=rules, states=["x [m]"], sample_time=0.5)


@pytest.mark.parametrize("rules", [None, [(1, 0), (0, 1), (1, 1), (0, 0)]])
def test_the_smaller_model_is_the_same_plant_where_both_hold(
    rules: list[tuple[int, int]] | None,
) -> None:
    """The blends agree at every point of the smaller box; names and sample time are kept."""
    model = two_premises(rules)
    smaller = on_smaller_box(model, Fraction(1, 4))

    assert [(one.lower, one.upper) for one in smaller.premises] == [
        (Fraction(3, 2), Fraction(5, 2)),
        (Fraction(1, 2), Fraction(3, 2)),
    ]
    for point in ([1.5, 0.5], [1.9, 1.4], [2.5, 1.5]):
        for before, after in zip(model.blend(point), smaller.blend(point), strict=True):
            assert np.allclose(before, after, rtol=0, atol=1e-14)
    assert (smaller.states, smaller.sample_time) == (("x [m]",), 0.5)


def test_a_premise_without_a_range_costs_no_rule() -> None:
    """Half of the rules are left, with the other premise as it was."""
    smaller = with_narrower_premise(two_premises(), 1, Fraction(0))

    assert smaller.rules == ((0, 0), (1, 0))
    assert smaller.A.ravel().tolist() == [0.0, 4.0]
    assert smaller.B.ravel().tolist() == [1.0, 1.0]
    assert with_narrower_premise(smaller, 1, Fraction(1, 2)) is smaller


def test_without_premises_the_vertices_move_to_their_mean() -> None:
    """A model, an object with arrays, and an array."""
    A, B = np.array([[[0.0]], [[4.0]]]), np.ones((2, 1, 1))
    half = Fraction(1, 2)

    assert on_smaller_box(TSModel(A, B), half).A.ravel().tolist() == [1.0, 3.0]
    plain = on_smaller_box(SimpleNamespace(A=A, B=B, C=None), half)
    assert plain.A.ravel().tolist() == [1.0, 3.0]
    assert not hasattr(plain, "C")
    assert on_smaller_box(A, half).ravel().tolist() == [1.0, 3.0]
    assert on_smaller_box(A[0], half).ravel().tolist() == [0.0]


def test_shares_and_premises_that_make_no_sense() -> None:
    """Premises count from 0; a box is not enlarged here."""
    with pytest.raises(ModelError, match="premise 2 of 2; count from 0"):
        with_narrower_premise(two_premises(), 2, Fraction(1, 2))
    with pytest.raises(ModelError, match="share is 1.5; it must lie in 0 ... 1"):
        with_narrower_premise(two_premises(), 0, Fraction(3, 2))
