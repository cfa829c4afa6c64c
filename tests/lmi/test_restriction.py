"""An LMI with some of its items is those items: values, labels, contributions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.lmi import LMI, Constant, Term, Unknown, common_lyapunov_condition
from takagi.lmi.condition import lmi_value
from takagi.lmi.condition.selected_items import selected_items
from takagi.models import ModelError

COUNT = 7


def mixed() -> tuple[LMI, dict[str, np.ndarray]]:
    """Return an LMI with every kind of term, and values of its unknowns."""
    random = np.random.default_rng(8)
    P, M = Unknown("P", 2, 2, symmetric=True), Unknown("M", 1, 2, count=3)
    g = Unknown("g", 1, 1)
    one = np.eye(2)[None]
    item = np.array([0, 0, 3, 5, 6, 3, 3])
    lmi = LMI(
        name="mixed",
        blocks=(2, 1),
        terms=(
            Term(unknown=P, left=random.normal(size=(COUNT, 2, 2)), right=one, plus_transpose=True),
            Term(
                unknown=M,
                left=random.normal(size=(7, 1, 1)),
                right=one,
                at=(1, 0),
                items=item,
                members=np.array([0, 1, 2, 0, 1, 2, 1]),
            ),
            Term(unknown=g, left=-np.ones((1, 1, 1)), at=(1, 1)),
            # One contribution, to one item.
            Term(unknown=P, left=one, right=one, items=np.array([2])),
        ),
        constants=(
            Constant(value=random.normal(size=(COUNT, 1, 2)), at=(1, 0)),
            Constant(value=np.eye(3)[None], at=None),
        ),
        count=COUNT,
    )
    symmetric = random.normal(size=(1, 2, 2))
    return lmi, {
        "P": symmetric + symmetric.transpose(0, 2, 1),
        "M": random.normal(size=(3, 1, 2)),
        "g": np.array([[[0.7]]]),
    }


@settings(deadline=None)
@given(st.lists(st.integers(0, COUNT - 1), min_size=1, max_size=COUNT, unique=True))
def test_the_items_have_their_values(items: list[int]) -> None:
    """In the order they were asked for, with the labels of the whole."""
    lmi, values = mixed()
    some = selected_items(lmi, np.array(items))

    assert some.count == len(items)
    expected = lmi_value(lmi, values, {})[items]
    assert np.allclose(lmi_value(some, values, {}), expected, rtol=1e-14, atol=1e-14)
    assert [some.label(k) for k in range(some.count)] == [lmi.label(k) for k in items]


@pytest.mark.parametrize("step", [1, 2, 7])
def test_pieces_are_the_whole(step: int) -> None:
    """Consecutive ranges, side by side, give every item once."""
    lmi, values = mixed()
    pieces = [selected_items(lmi, range(k, min(k + step, COUNT))) for k in range(0, COUNT, step)]
    side_by_side = np.concatenate([lmi_value(piece, values, {}) for piece in pieces])

    assert np.allclose(side_by_side, lmi_value(lmi, values, {}), rtol=1e-14, atol=1e-14)


def test_a_restriction_of_a_restriction_keeps_the_first_names() -> None:
    """Names are those of the whole, however often it is narrowed."""
    lmi, _ = mixed()
    twice = selected_items(selected_items(lmi, np.array([6, 1, 4])), np.array([2]))

    assert twice.label(0) == "mixed 5 of 7"


def test_two_lmis_of_one_name_are_refused() -> None:
    """Multipliers are kept by the LMI's name: two of one name would hide each other's."""
    condition = common_lyapunov_condition(-np.eye(2)[None])
    with pytest.raises(ModelError, match="names must differ, because multipliers"):
        condition.with_lmis(condition.lmis[0])
