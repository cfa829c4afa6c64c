"""The checker's intervals and functions: exact results inside, the smallest brackets, words."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from math import ceil, floor
from pathlib import Path

import pytest
import sympy
from flint import arb, ctx
from hypothesis import given
from hypothesis import strategies as st

import takagi.certificates.checker
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.arithmetic import elementary, exponential, logarithm
from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.elementary import function_of
from takagi.certificates.checker.arithmetic.exponential import FINE
from takagi.certificates.checker.arithmetic.interval import (
    LARGEST,
    ONE,
    UNIT,
    Interval,
    enclose,
    hull,
    point,
    product,
)
from takagi.certificates.checker.arithmetic.monotone import PI_FINE
from takagi.certificates.checker.arithmetic.powers import power, root, whole_power
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.words.rounded import at_least, at_most

ENDS = st.one_of(
    st.integers(-3, 3).map(lambda k: k * ONE),
    st.integers(-3, 3),
    st.integers(-(ONE << 10), ONE << 10),
)
BRACKETS = st.tuples(ENDS, ENDS).map(lambda ends: Interval(min(ends), max(ends)))


def smallest(values: list[Fraction]) -> Interval:
    """Return the smallest bracket of exact values."""
    return Interval(floor(min(values) * ONE), ceil(max(values) * ONE))


def ends(a: Interval) -> tuple[Fraction, Fraction]:
    return Fraction(a[0], ONE), Fraction(a[1], ONE)


@given(BRACKETS, BRACKETS)
def test_every_operation_gives_the_smallest_bracket(a: Interval, b: Interval) -> None:
    """Of the exact range, which is that of the ends (Moore 1966), here in rationals."""
    pairs = list(itertools.product(ends(a), ends(b)))

    assert a + b == smallest([ends(a)[0] + ends(b)[0], ends(a)[1] + ends(b)[1]])
    assert a - b == smallest([x - y for x, y in pairs])
    assert a * b == smallest([x * y for x, y in pairs])
    exact = [int(x * y * ONE**2) for x, y in pairs]
    assert product(a, b) == (min(exact), max(exact))
    assert -a == smallest([-x for x in ends(a)])
    around_zero = [Fraction(0)] if a[0] <= 0 <= a[1] else []
    assert a.square() == smallest([x * x for x in ends(a)] + around_zero)
    assert hull(a, b) == smallest([*ends(a), *ends(b)])
    assert a.magnitude() == max(abs(x) for x in ends(a)) * ONE
    if b[0] <= 0 <= b[1]:
        with pytest.raises(CertificateError, match="zero"):
            a / b
    else:
        assert a / b == smallest([x / y for x, y in pairs])


@given(st.fractions(max_denominator=10**40), st.fractions(max_denominator=10**40))
def test_numbers_get_the_smallest_bracket(x: Fraction, y: Fraction) -> None:
    low, high = min(x, y), max(x, y)

    assert enclose(low, high) == smallest([low, high])
    assert point(x) == smallest([x])


@pytest.mark.parametrize("b", [(0, 0), (0, ONE), (-ONE, 0), (-1, 1)])
def test_a_divisor_that_touches_zero_is_refused(b: tuple[int, int]) -> None:
    with pytest.raises(CertificateError, match="zero"):
        UNIT / Interval(*b)
    assert UNIT / Interval(1, 1) == (ONE * ONE, ONE * ONE)
    assert UNIT / Interval(-1, -1) == (-ONE * ONE, -ONE * ONE)


def test_within_takes_both_ends_exactly() -> None:
    """A third lies between two units: the bracket of it is not within it, but of a bit more."""
    third, unit = Fraction(1, 3), Fraction(1, ONE)
    bracket = point(third)

    assert not bracket.within(third, third)
    assert not bracket.within(third - unit, third)
    assert not bracket.within(third, third + unit)
    assert bracket.within(third - unit, third + unit)
    assert Interval(ONE, 2 * ONE).within(Fraction(1), Fraction(2))
    assert not Interval(ONE - 1, 2 * ONE).within(Fraction(1), Fraction(2))
    assert not Interval(ONE, 2 * ONE + 1).within(Fraction(1), Fraction(2))


def test_numbers_beyond_the_largest_are_refused() -> None:
    """At 10^320 they are held, a unit beyond it not, at either end and by each operation."""
    assert Interval(-LARGEST, LARGEST).held() == (-LARGEST, LARGEST)
    for wrong in ((-LARGEST - 1, 0), (0, LARGEST + 1)):
        with pytest.raises(CertificateError, match="beyond"):
            Interval(*wrong).held()
    assert Interval(LARGEST, LARGEST) * UNIT == (LARGEST, LARGEST)
    beyond: list[Callable[[], Interval]] = [
        lambda: Interval(0, LARGEST) * Interval(ONE, ONE + 1),
        lambda: Interval(0, 10**200 * ONE).square(),
        lambda: Interval(LARGEST, LARGEST) / Interval(ONE - 1, ONE),
    ]
    for operation in beyond:
        with pytest.raises(CertificateError, match="beyond"):
            operation()


@pytest.mark.parametrize(
    ("s", "eps", "value", "slope"),
    [
        ("-3", "2", "0", "0"),
        ("-2", "2", "0", "0"),
        ("-1", "2", "1/8", "1/4"),
        ("0", "2", "1/2", "1/2"),
        ("1", "2", "9/8", "3/4"),
        ("2", "2", "2", "1"),
        ("5/2", "2", "5/2", "1"),
        ("0", "1/3", "1/12", "1/2"),
        ("1/3", "1/3", "1/3", "1"),
        ("-1/3", "1/3", "0", "0"),
    ],
)
def test_values(s: str, eps: str, value: str, slope: str) -> None:
    """(s + eps)^2 / (4 eps) and (s + eps) / (2 eps) inside, 0 below, s and 1 beyond."""
    assert psi(Fraction(s), Fraction(eps)) == Fraction(value)
    assert share(Fraction(s), Fraction(eps)) == Fraction(slope)


RATIONALS = st.fractions(min_value=-1000, max_value=1000, max_denominator=10**30)
SHARES = st.fractions(min_value=0, max_value=1, max_denominator=1000)


@st.composite
def points(draw: st.DrawFn) -> tuple[Interval, Fraction]:
    a, b = sorted((draw(RATIONALS), draw(RATIONALS)))
    return enclose(a, b), a + (b - a) * draw(SHARES)


def holds(bracket: Interval, value: Fraction) -> bool:
    return bracket[0] <= value * ONE <= bracket[1]


@given(RATIONALS, RATIONALS, RATIONALS, RATIONALS, SHARES)
def test_ends_that_are_fractions_are_not_rounded(
    a: Fraction, b: Fraction, c: Fraction, d: Fraction, share: Fraction
) -> None:
    """Both ends of a product and of a power are attained, and all between lies inside."""
    first, last = (min(a, b), max(a, b)), (min(c, d), max(c, d))
    x, y = first[0] + share * (first[1] - first[0]), last[0] + share * (last[1] - last[0])

    low, high = product(first, last)
    assert {low, high} <= {p * q for p in first for q in last}
    assert low <= x * y <= high
    for n in (1, 2, 3, 4):
        low, high = whole_power(first, n)
        assert {low, high} <= {first[0] ** n, first[1] ** n, Fraction(0)}
        assert low <= x**n <= high


def test_a_bound_that_is_attained_is_exact_on_the_grid() -> None:
    tenth = enclose(Fraction(-1, 10), Fraction(1, 10))

    assert power(tenth, 2) == tenth.square() == (0, ONE // 100)
    assert power(tenth, 3) == (-ONE // 1000, ONE // 1000)
    third = point(Fraction(1, 3))
    assert third[1] - third[0] == 1


@given(points(), st.integers(1, 6))
def test_powers_bracket_the_exact_result(p: tuple[Interval, Fraction], n: int) -> None:
    a, x = p

    assert holds(power(a, n), x**n)
    if n == 2:
        assert power(a, n) == a.square()


def test_the_checker_has_one_interval_and_one_exponential() -> None:
    """Two would be two things to trust."""
    folder = Path(str(takagi.certificates.checker.__file__)).parent
    defined = [
        (node.name, file.relative_to(folder).as_posix())
        for file in sorted(folder.rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    ]

    for name, file in (
        *((name, "arithmetic/interval.py") for name in ("enclose", "magnitude", "within")),
        *((name, "arithmetic/exponential.py") for name in ("exp_at", "exp_above", "exp_below")),
    ):
        assert [place for known, place in defined if known == name] == [file]


@given(RATIONALS, st.integers(1, 12))
def test_shown_numbers_are_on_the_safe_side(value: Fraction, digits: int) -> None:
    """A lower bound is printed no higher, an upper bound no lower, and both are close."""
    low, high = Fraction(at_least(value, digits)), Fraction(at_most(value, digits))

    assert low <= value <= high
    assert high - low <= abs(value) * Fraction(11, 10**digits)


SMALL = Fraction(1, 10**20)
# In absolute units of 10^-36, and as a share of the value.
UNITS, SHARE = 4, Fraction(1, 10**34)
POINTS = [-SMALL, SMALL, *(Fraction(p, 10) for p in (-7, -3, 0, 3, 5, 7))]
BEYOND = [Fraction(p, 10) for p in (10, 13, 16, 20, 33, 48, 63, 95)]
EVERYWHERE = [*POINTS, *BEYOND, *(-p for p in BEYOND)]
DOMAINS: dict[str, list[Fraction]] = {
    **dict.fromkeys(("sin", "cos", "tan", "atan", "exp", "sinh", "cosh", "tanh"), EVERYWHERE),
    **dict.fromkeys(("asinh", "erf"), EVERYWHERE),
    **dict.fromkeys(("asin", "acos"), [*POINTS, Fraction(1), Fraction(-1), 1 - SMALL]),
    "atanh": [*POINTS, Fraction(99, 100), Fraction(-99, 100)],
    "log": [SMALL, *(p for p in EVERYWHERE if p > SMALL), Fraction(10**9)],
    "acosh": [Fraction(1), 1 + SMALL, *BEYOND[1:]],
}
# Where the formula changes: far angles, tanh that is 1, erf that is 1, large exponents.
DOMAINS["sin"] = DOMAINS["cos"] = [*EVERYWHERE, Fraction(9999), Fraction(-9999)]
DOMAINS["tanh"] = [*EVERYWHERE, Fraction(400), Fraction(-400)]
DOMAINS["erf"] = [*EVERYWHERE, Fraction(101, 10), Fraction(-101, 10)]
DOMAINS["exp"] = DOMAINS["sinh"] = DOMAINS["cosh"] = [*EVERYWHERE, Fraction(60), Fraction(-60)]


def units(value: sympy.Expr) -> Fraction:
    """Return a number in units of 10^-36, exact to a hundred digits."""
    number = sympy.Rational(sympy.N(value, 100))
    return Fraction(int(number.p), int(number.q)) * ONE


def assert_tight(found: Interval, truth: Fraction, what: str) -> None:
    assert found[0] <= truth <= found[1], what
    assert found[1] - found[0] <= UNITS + SHARE * abs(truth), what


@pytest.mark.parametrize("name", DOMAINS)
def test_a_function_at_points(name: str) -> None:
    for p in DOMAINS[name]:
        truth = units(getattr(sympy, name)(sympy.Rational(p.numerator, p.denominator)))
        assert_tight(function_of(name)(point(p)), truth, f"{name}({p})")


@pytest.mark.parametrize("name", DOMAINS)
def test_a_range_is_that_of_its_ends_and_extremes(name: str) -> None:
    """Of intervals between neighbouring points: 1 or -1 inside counts for sin, cos and cosh."""
    places = sorted(DOMAINS[name])
    for low, high in zip(places, places[1:], strict=False):
        if name == "tan":
            continue
        ends = [
            units(getattr(sympy, name)(sympy.Rational(p.numerator, p.denominator)))
            for p in (low, high)
        ]
        if name in ("sin", "cos"):
            quarter = sympy.pi / 2
            first = 0 if name == "cos" else 1
            for k in range(-10, 10):
                at = units(quarter * (2 * k + first))
                if low * ONE <= at <= high * ONE:
                    ends.append(Fraction(-ONE if k % 2 else ONE))
            if high - low > 100:
                ends += [Fraction(ONE), Fraction(-ONE)]
        if name == "cosh" and low <= 0 <= high:
            ends.append(Fraction(ONE))
        bracket = Interval(point(low)[0], point(high)[1])
        found = function_of(name)(bracket)
        slack = UNITS + SHARE * max(map(abs, ends))
        assert min(ends) - slack <= found[0] <= min(ends), (name, low, high)
        assert max(ends) <= found[1] <= max(ends) + slack, (name, low, high)


@pytest.mark.parametrize("q", [2, 3, 5])
def test_a_root(q: int) -> None:
    """The greatest whole number below it, and the next one unless it is exact."""
    for p in (Fraction(0), SMALL, Fraction(1, ONE), Fraction(2), Fraction(27), Fraction(10**9)):
        low, high = root(point(p), q)
        assert low**q <= p * ONE**q <= high**q
        assert high - low <= 1


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("log", -1, 1),
        ("log", 0, 1),
        ("asin", -2, 0),
        ("acos", 0, 2),
        ("acosh", 0, 2),
        ("atanh", -1, 0),
        ("atanh", 0, 1),
        ("tan", 1, 2),
        ("tan", -1, 2),
        ("tan", 0, 3),
        ("tan", -10, 10),
        # Or too large a one.
        ("exp", 0, 701),
        ("sin", 0, 10**7),
    ],
)
def test_what_has_no_value_is_refused(name: str, low: int, high: int) -> None:
    with pytest.raises(Refused):
        function_of(name)(Interval(low * ONE, high * ONE))


def test_sine_and_cosine_reach_one_exactly_between_their_ends() -> None:
    """The extremes themselves are exact, so that bounds such as 1 can be proved."""
    for name, low, high, extreme in (
        ("sin", "1", "2", ONE), ("cos", "-1", "1", ONE), ("cos", "3", "4", -ONE)
    ):  # fmt: skip
        assert extreme in function_of(name)(enclose(Fraction(low), Fraction(high)))
    assert function_of("sin")(enclose(Fraction(0), Fraction(157, 100)))[1] < ONE


def test_pi_is_that_of_machin() -> None:
    """Machin (1706): pi/4 = 4 atan(1/5) - atan(1/239), here with rational partial sums."""

    def atan_of(n: int) -> Fraction:
        terms = (Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(40))
        return sum(terms, Fraction(0))

    assert PI_FINE <= (16 * atan_of(5) - 4 * atan_of(239)) * 10**48 < PI_FINE + 1


Point = Callable[[int], tuple[int, int]]
NEAR_ZERO = "0 1e-47 1e-40 1e-24 1e-12 0.001 0.03 0.0625 0.1 1/3 0.5 0.7071 0.9 0.999 0.9999999999"
LARGE = "1 1.0001 1.25 1.5707963 2 3 4.5 7 9.9 10 33 123.456"
EVERY: list[tuple[str, Point, Callable[[arb], arb], str]] = [
    ("sin", partial(elementary._sine_at, quarter=0), arb.sin, f"{NEAR_ZERO} {LARGE} 999999"),
    ("cos", partial(elementary._sine_at, quarter=1), arb.cos, f"{NEAR_ZERO} {LARGE} 999999"),
    ("atan", elementary._atan_at, arb.atan, f"{NEAR_ZERO} {LARGE} 1e10 1e40"),
    ("asin", elementary._asin_at, arb.asin, f"{NEAR_ZERO} 1"),
    ("exp", exponential.exp_at, arb.exp, f"{NEAR_ZERO} {LARGE} 699.9"),
    ("sinh", logarithm.sinh_at, arb.sinh, f"{NEAR_ZERO} {LARGE}"),
    ("tanh", logarithm._tanh_at, arb.tanh, f"{NEAR_ZERO} {LARGE} 349.9 350.1"),
    ("asinh", logarithm.asinh_at, arb.asinh, f"{NEAR_ZERO} {LARGE} 1e20"),
    ("atanh", logarithm.atanh_at, arb.atanh, NEAR_ZERO),
    ("erf", logarithm._erf_at, arb.erf, f"{NEAR_ZERO} {LARGE}"),
]
POSITIVE: list[tuple[str, Point, Callable[[arb], arb], str]] = [
    ("log", logarithm.log_at, arb.log, f"{NEAR_ZERO[2:]} {LARGE} 1e30"),
    ("acosh", logarithm.acosh_at, arb.acosh, f"{LARGE} 1e30"),
    ("cosh", logarithm._cosh_at, arb.cosh, f"{NEAR_ZERO} {LARGE}"),
]


def fine(value: str) -> int:
    """Return a number over 10^48, rounded down."""
    return int(Fraction(value) * FINE // 1)


@pytest.mark.parametrize(("name", "at", "true", "points"), EVERY + POSITIVE)
def test_a_bracket_contains_the_value(
    name: str, at: Point, true: Callable[[arb], arb], points: str
) -> None:
    """And at the neighbours of each point on the grid, on both sides of zero."""
    before, ctx.prec = ctx.prec, 500
    try:
        for written in points.split():
            for x in (fine(written) + k for k in (-1, 0, 1)):
                for place in (x, -x) if name in {n for n, *_ in EVERY} else (x,):
                    inside = {"asin": FINE, "atanh": FINE - 1}.get(name, abs(place))
                    least = {"log": 1, "acosh": FINE, "cosh": 0}.get(name, place)
                    if abs(place) > inside or place < least:
                        continue
                    low, high = at(place)
                    value = true(arb(place) / FINE) * FINE
                    assert not (value < low or value > high), (name, place)
    finally:
        ctx.prec = before
