"""Claims that are false in one place alone: at a bend, at the end of a range, for two signs.

Each is false by a few lines of arithmetic that are written here, and stands beside one that is
true by a little.  A check that leaves the place out would prove both.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import pytest

from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range, filter_keeps_up
from takagi.certificates.checker.turbine.published.interval_matrices import contraction

F = Fraction
WIND, FILTER, PHI = [F(8), F(9), F(10)], F(1), F(1, 5)


@pytest.mark.parametrize(
    "node",
    [
        pytest.param(0, id="the estimate is at the range's first wind"),
        pytest.param(1, id="the estimate is at a node, the schedule wind between two"),
        pytest.param(2, id="the estimate is at the range's last wind"),
    ],
)
def test_an_estimate_that_outruns_the_schedule_wind_at_one_place(node: int) -> None:
    """Where phi is constant, the schedule wind keeps behind the estimate as long as r <= phi.

    The estimate is fastest at one node, by 1/1000 m/s^2 more than the schedule wind may be; there
    the schedule wind is 1/5 m/s beside that node, which is no node of its own.
    """
    for excess, refused in ((F(1, 1000), True), (F(0), False)):
        estimate = [F(1, 10)] * 3
        estimate[node] = PHI + excess
        one = Range(WIND, estimate, [PHI] * 3, F(0))
        found = first_failure(filter_keeps_up(one, FILTER))
        assert bool(found) == refused
        if found:
            s = F(found.removeprefix("the rates do not fit at ").partition(" ")[0])
            assert abs(s - WIND[node]) == FILTER * PHI
            assert s not in WIND


def test_a_disturbance_is_worst_where_its_parts_have_opposite_signs() -> None:
    """x' = -x + d, |d_i| <= delta: the set x'Px <= 1 keeps the rest x = d for each sign, or none.

    For P = [[2, -1], [-1, 2]] the rests d = delta (1, 1) have V = 2 delta^2, and those of opposite
    signs V = 6 delta^2; the inequality with alpha = 1 allows delta < 1/sqrt(6) = 0.408.
    """
    P = [[F(2), F(-1)], [F(-1), F(2)]]
    A = [[F(-1), F(0)], [F(0), F(-1)]]
    for delta, fails in ((F(1, 2), True), (F(41, 100), True), (F(2, 5), False)):
        said = first_failure(contraction(P, [(A, A)], [delta] * 2, F(1, 2), F(1), "here"))
        rests = [(s * delta, t * delta) for s, t in product((1, -1), repeat=2)]
        V = [2 * x * x - 2 * x * y + 2 * y * y for x, y in rests]
        assert (max(V) > 1) == fails
        assert bool(said) == fails
        assert min(V) < 1


def test_the_worst_signs_are_found_for_each_pair_of_states() -> None:
    """As above with the sign of the coupling changed, and with a third state that is left alone."""
    for sign, delta in product((1, -1), (F(41, 100), F(2, 5))):
        P = [[F(2), F(0), F(sign)], [F(0), F(2), F(0)], [F(sign), F(0), F(2)]]
        A = [[F(-int(i == j)) for j in range(3)] for i in range(3)]
        bounds = [delta, F(0), delta]
        said = first_failure(contraction(P, [(A, A)], bounds, F(1, 2), F(1), "here"))
        assert bool(said) == (6 * delta**2 > 1)
