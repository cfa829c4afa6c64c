"""Zeros of families are counted right, from both sides of where their number changes."""

from __future__ import annotations

from fractions import Fraction

import pytest

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import ONE, UNIT, ZERO, Interval, enclose
from takagi.certificates.checker.turbine.equilibria.zero_count import (
    Count,
    Piece,
    Span,
    count_zeros,
)


def parabola(winds: Span, span: Span) -> Dual:
    """Return s^2 - v with its slopes."""
    v, s = enclose(*winds), enclose(*span)
    return Dual(s.square() - v, (-UNIT, Interval(2 * ONE, 2 * ONE) * s))


def counted(low: str, high: str, start: str = "-1", stop: str = "1") -> Count:
    winds = Fraction(low), Fraction(high)
    return count_zeros(parabola, winds, [Piece((Fraction(start), Fraction(stop)))], most_parts=64)


@pytest.mark.parametrize(
    ("low", "high", "zeros"),
    [("-0.2", "-0.001", 0), ("0.01", "0.2", 2), ("-0.01", "0.01", None)],
)
def test_a_fold_is_counted_on_both_sides_and_not_across(
    low: str, high: str, zeros: int | None
) -> None:
    """s^2 = v has no root for v < 0, two for v > 0, and no constant number over v = 0."""
    assert counted(low, high).exact == zeros


def test_the_blocks_hold_the_roots() -> None:
    """The roots of s^2 = 1/4 are -1/2 and 1/2."""
    blocks = counted("0.24", "0.26").blocks

    assert len(blocks) == 2
    for root, (low, high) in zip((-0.5, 0.5), blocks, strict=True):
        assert low < root < high


def test_a_monotone_piece_without_a_change_of_sign_has_no_zero() -> None:
    """s^2 > 0.2 on [1/2, 1]: rising, and positive at both ends."""
    found = counted("0.1", "0.2", "0.5", "1")

    assert (found.exact, found.start, found.end) == (0, 1, 1)


def test_a_root_at_an_end_that_the_winds_cross_is_not_claimed() -> None:
    """For v in [0.2, 0.3] the root passes s = 1/2: some winds have it in [1/2, 1], some do not."""
    assert counted("0.2", "0.3", "0.5", "1").exact is None


def test_only_allowed_signs_decide() -> None:
    """f > 0 may not decide a piece where only f < 0 is of use, so that nothing is known there."""
    piece = Piece((Fraction(-1), Fraction(1)), frozenset({-1}))
    winds = Fraction(-1, 5), Fraction(-1, 10)

    assert count_zeros(parabola, winds, [piece], most_parts=16).most is None


def test_where_the_family_is_not_defined_there_is_no_zero_and_no_sign() -> None:
    """A family that ends at s = 0 is not continued from one side to the other."""

    def right_alone(winds: Span, span: Span) -> Dual | None:
        return None if span[1] <= 0 else Dual(UNIT, (ZERO, ZERO))

    pieces = [Piece((Fraction(-1), Fraction(0))), Piece((Fraction(0), Fraction(1)))]
    found = count_zeros(right_alone, (Fraction(1), Fraction(2)), pieces, most_parts=8)

    assert (found.exact, found.start, found.end) == (0, 0, 1)
