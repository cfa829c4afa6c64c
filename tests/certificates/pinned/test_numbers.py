"""The checker's numbers about a turbine's loops are the recorded ones, to the last digit.

What the modules of ``checker/turbine`` enclose, round and count in a few recorded cells is compared
as exact integers and fractions: ranges of the loop's coefficients, corner matrices, how far tables
leave the trim, balances whose zeros are rests, rates of wind and actuators, and the words of the
answers.  That these numbers are *right* is what the other tests here show.  This one shows that
they are the same: a change of one is a change of what every certificate is worth.  After a change
that is meant, ``numbers`` tells how they are written anew, and the difference is read.
"""

from __future__ import annotations

import pytest

from tests.certificates.pinned.numbers import GROUPS, found, recorded

RECORDED = recorded()


@pytest.mark.parametrize("group", GROUPS)
def test_they_are_the_recorded_ones(group: str) -> None:
    assert found(group) == RECORDED[group]


def test_none_is_recorded_that_nobody_looks_at() -> None:
    assert RECORDED.keys() == GROUPS.keys()
