"""The checker's own sin, exp, erf, ... against Arb's balls, and as functions of intervals."""

from __future__ import annotations

from fractions import Fraction

import flint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker.arithmetic import interval as d
from takagi.certificates.checker.arithmetic.elementary import function_of
from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.arithmetic.monotone import PI_FINE
from takagi.certificates.checker.arithmetic.powers import power, root
from takagi.certificates.checker.kernel.refusal import Refused

# Name, Arb's name, domain in which it is tried, and how wide a point's bracket may be.
CASES = [
    ("sin", "sin", -(10**5), 10**5),
    ("cos", "cos", -(10**5), 10**5),
    ("tan", "tan", -1, 1),
    ("atan", "atan", -1000, 1000),
    ("asin", "asin", -1, 1),
    ("acos", "acos", -1, 1),
    ("exp", "exp", -60, 60),
    ("log", "log", Fraction(1, 10**6), 10**6),
    ("sinh", "sinh", -40, 40),
    ("cosh", "cosh", -40, 40),
    ("tanh", "tanh", -60, 60),
    ("asinh", "asinh", -1000, 1000),
    ("acosh", "acosh", 1, 1000),
    ("atanh", "atanh", Fraction(-999, 1000), Fraction(999, 1000)),
    ("erf", "erf", -12, 12),
]


def arb_value(name: str, value: Fraction) -> tuple[Fraction, Fraction]:
    """Return ends of Arb's ball at 400 bits."""
    with flint.ctx.workprec(400):
        ball = getattr(flint.arb(flint.fmpq(value.numerator, value.denominator)), name)()
        return exact(ball.lower()), exact(ball.upper())


def exact(ball: flint.arb) -> Fraction:
    mantissa, exponent = ball.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def ends(pair: Interval) -> tuple[Fraction, Fraction]:
    return Fraction(pair[0], ONE), Fraction(pair[1], ONE)


@pytest.mark.parametrize(("name", "arb", "low", "high"), CASES)
@given(share=st.fractions(0, 1, max_denominator=10**12))
def test_points_lie_in_brackets(
    name: str, arb: str, low: Fraction, high: Fraction, share: Fraction
) -> None:
    """Arb and the checker agree to thirty digits, and the checker's bracket holds Arb's ball."""
    # On the grid of 10^-36, so that the argument is the same for both.
    value = Fraction(int((low + (high - low) * share) * 10**30), 10**30)
    value = min(max(value, Fraction(low)), Fraction(high))

    below, above = ends(function_of(name)(d.point(value)))
    first, last = arb_value(arb, value)

    assert below <= first and last <= above
    assert above - below <= Fraction(1, 10**30) * max(Fraction(1), above * above)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "arb", "low", "high"), CASES)
@given(shares=st.tuples(*[st.fractions(0, 1, max_denominator=10**6)] * 3))
def test_intervals_contain_their_points(
    name: str, arb: str, low: Fraction, high: Fraction, shares: tuple[Fraction, ...]
) -> None:
    """f([a, c]) contains f(b) for a <= b <= c, also between extremes of sin, cos and cosh."""
    size = min(Fraction(20), high - low)
    a, b, c = sorted(low + size * share for share in shares)

    try:
        below, above = ends(function_of(name)(d.enclose(a, c)))
    except Refused:
        # Refused only where rounding an end outward leaves the domain.
        assert name in ("asin", "acos", "acosh", "tan")
        return
    first, last = arb_value(arb, b)

    assert below <= first and last <= above


def test_sine_and_cosine_reach_one_exactly_between_their_ends() -> None:
    """The extremes themselves are exact, so that bounds such as 1 can be proved."""
    assert function_of("sin")(d.enclose(Fraction(1), Fraction(2)))[1] == ONE
    assert function_of("cos")(d.enclose(Fraction(-1), Fraction(1)))[1] == ONE
    assert function_of("cos")(d.enclose(Fraction(3), Fraction(4)))[0] == -ONE
    assert function_of("sin")(d.enclose(Fraction(0), Fraction(157, 100)))[1] < ONE


def test_pi_is_that_of_machin() -> None:
    """Machin (1706): pi/4 = 4 atan(1/5) - atan(1/239), here with rational partial sums."""

    def atan_of(n: int) -> Fraction:
        terms = (Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(40))
        return sum(terms, Fraction(0))

    pi = 16 * atan_of(5) - 4 * atan_of(239)

    assert PI_FINE <= pi * 10**48 < PI_FINE + 1


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("log", 0, 1),
        ("asin", 0, 2),
        ("acosh", 0, 2),
        ("atanh", 0, 1),
        ("tan", 1, 2),
        ("tan", -10, 10),
        ("exp", 0, 701),
        ("sin", 0, 10**7),
    ],
)
def test_arguments_outside_the_domain_are_refused(name: str, low: int, high: int) -> None:
    """No bracket is made up where there is no value, or too large a one."""
    with pytest.raises(Refused):
        function_of(name)(d.enclose(Fraction(low), Fraction(high)))


@given(
    base=st.fractions(0, 1000, max_denominator=10**6),
    q=st.integers(2, 9),
    n=st.integers(1, 9),
)
def test_roots_and_powers_enclose(base: Fraction, q: int, n: int) -> None:
    """root(a)^q contains a, and a^n is rounded once at each end."""
    bracket = d.point(base)

    low, high = ends(root(bracket, q))
    assert low**q <= base <= high**q
    low, high = ends(power(bracket, n))
    assert low <= base**n <= high
