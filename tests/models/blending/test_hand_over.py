"""The ramp by which two actuators share an effort: identities, in exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Interval
from takagi.models.ramps import effort_ramp, ramp, ramp_slope, share_range, share_value

efforts = st.fractions(-10, 10, max_denominator=1000)
overlaps = st.fractions("1/100", 5, max_denominator=1000)


@given(efforts, overlaps)
def test_what_one_delivers_less_what_the_other_takes_is_the_effort(
    s: Fraction, e: Fraction
) -> None:
    """psi(s) - psi(-s) = s, and the slopes add up to 1."""
    assert ramp(s, e) - ramp(-s, e) == s
    assert ramp_slope(s, e) + ramp_slope(-s, e) == 1
    assert ramp(s, e) >= 0


def test_pieces_meet_where_the_overlap_ends() -> None:
    """Values and slopes at -e, 0 and e: 0, e/4, e and 0, 1/2, 1."""
    e = Fraction(3, 2)

    assert [ramp(s, e) for s in (-e, Fraction(0), e)] == [0, e / 4, e]
    assert [ramp_slope(s, e) for s in (-e, Fraction(0), e)] == [0, Fraction(1, 2), 1]
    assert ramp(-e - 1, e) == 0
    assert ramp(e + 1, e) == e + 1


@given(efforts, efforts, overlaps)
def test_shares_are_convex_and_give_back_the_ramp(s: Fraction, rest: Fraction, e: Fraction) -> None:
    """psi(s) = psi(r) + F (s - r), psi(-s) = psi(-r) - (1 - F)(s - r), F in [0, 1]."""
    share = share_value(s, rest, e)

    assert 0 <= share <= 1
    assert ramp(s, e) == ramp(rest, e) + share * (s - rest)
    assert ramp(-s, e) == ramp(-rest, e) - (1 - share) * (s - rest)


@given(st.tuples(efforts, efforts, efforts, efforts), overlaps)
def test_the_range_of_the_share_holds_every_share(
    four: tuple[Fraction, Fraction, Fraction, Fraction], e: Fraction
) -> None:
    """Rest and effort anywhere in the interval; the ends are attained."""
    low, rest, s, high = sorted(four)[0], four[1], four[2], sorted(four)[3]
    found = share_range(Interval(low, high), rest, e)

    assert found.lower <= share_value(s, rest, e) <= found.upper
    assert found.lower == share_value(low, rest, e)
    assert found.upper == share_value(high, rest, e)


@given(st.lists(efforts, min_size=1, max_size=5), overlaps)
def test_floating_point_is_the_exact_ramp(s: list[Fraction], e: Fraction) -> None:
    exact = [float(ramp(one, e)) for one in s]

    np.testing.assert_allclose(effort_ramp([float(x) for x in s], float(e)), exact, atol=1e-12)
