"""The checker's numbers about a turbine's loops are the recorded ones, to the last digit.

What the modules of ``checker/turbine`` enclose, round and count in a few recorded cells is compared
as exact integers and fractions: ranges of the loop's coefficients, corner matrices, how far tables
leave the trim, balances whose zeros are rests, rates of wind and actuators, and the words of the
answers.  Of ``checker/files`` and ``checker/controller`` it is what is said of recorded files with
one part changed.  That all this is *right* is what the other tests here show.  This one shows that
it is the same: a change of one number is a change of what every certificate is worth.  After a
change that is meant, ``numbers`` tells how they are written anew, and the difference is read.
"""

from __future__ import annotations

import pytest

from tests.certificates.pinned.turbine.numbers import GROUPS, found, recorded

RECORDED = recorded()


# Those that are dear, and of which others hold most.
SLOW = (
    *("cart,", "cart replaced", "certificate of cart", "turbine, cp.csv", "turbine, turbine.toml"),
    *("failures", "cell, pitch", "balance, pitch", "balance, torque", "balance, paper-two"),
    *("one rests", "one trim", "two rests", "one curve", "carried pitch", "trims", "frozen wake"),
    *("paper, claim", "paper-two-integrators, claim", "paper claim", "whole, pitch"),
    *("whole, rated", "members", "gain file of torque", "rests, torque", "sizes"),
    *("variants, pitch", "thresholds, rated, 1", "thresholds, rated, 3", "thresholds, rated, 4"),
    *("room, room.toml", "step, step.toml", "one integrator", "whole, torque, 4"),
)


@pytest.mark.parametrize(
    "group",
    [pytest.param(g, marks=pytest.mark.slow) if g.startswith(SLOW) else g for g in GROUPS],
)
def test_they_are_the_recorded_ones(group: str) -> None:
    assert found(group) == RECORDED[group]


def test_none_is_recorded_that_nobody_looks_at() -> None:
    assert RECORDED.keys() == GROUPS.keys()
