"""Ramps by which two actuators or regions share: convex sums, slopes, placement, identities."""

from __future__ import annotations

from fractions import Fraction
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Interval, ModelError
from takagi.models.ramps import (
    Ramp,
    Shape,
    effort_ramp,
    ramp,
    ramp_slope,
    rated_speed_ramp,
    share_range,
    share_value,
)

RATED = 1.267109  # rad/s, 12.1 rpm of the NREL 5-MW reference turbine
shapes = st.sampled_from(get_args(Shape))
ramps = st.builds(Ramp, st.floats(-5, 5), st.floats(1e-3, 3), shapes)


@given(ramps, st.floats(-20, 20))
def test_weights_are_a_convex_sum(ramp: Ramp, x: float) -> None:
    """w_1, w_2 lie in [0, 1] and sum to 1 everywhere, on the ramp and off it."""
    weights = ramp.weights(x)

    assert np.all(weights >= 0)
    assert float(weights.sum()) == pytest.approx(1.0, abs=1e-15)


@given(ramps, st.floats(-20, 20))
def test_one_number_and_an_array_agree(ramp: Ramp, x: float) -> None:
    assert ramp.at(x) == pytest.approx(float(ramp(x)), abs=1e-15)


@pytest.mark.parametrize(("placement", "at_rated"), [(0.0, 1.0), (0.5, 0.5), (1.0, 0.0)])
def test_placement_says_what_happens_at_rated_speed(placement: float, at_rated: float) -> None:
    """Below, around, above rated speed: w_2 there is 1, 1/2, 0."""
    ramp = rated_speed_ramp(RATED, overlap=0.1, placement=placement)

    assert ramp.at(RATED) == pytest.approx(at_rated, abs=1e-12)
    assert ramp.width == 0.1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.0, -0.1, "linear"), "width above 0, or 0 for a switch"),
        ((float("nan"), 1.0, "linear"), "finite"),
        ((0.0, 1.0, "smoth"), "did you mean 'smooth'"),
    ],
)
def test_a_bad_ramp_is_refused(arguments: tuple[float, float, Shape], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        Ramp(*arguments)


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
    low, rest, s, high = sorted(four)[0], four[1], four[2], sorted(four)[3]
    found = share_range(Interval(low, high), rest, e)

    assert found.lower <= share_value(s, rest, e) <= found.upper
    assert found.lower == share_value(low, rest, e)
    assert found.upper == share_value(high, rest, e)


@given(st.lists(efforts, min_size=1, max_size=5), overlaps)
def test_floating_point_is_the_exact_ramp(s: list[Fraction], e: Fraction) -> None:
    exact = [float(ramp(one, e)) for one in s]

    np.testing.assert_allclose(effort_ramp([float(x) for x in s], float(e)), exact, atol=1e-12)
