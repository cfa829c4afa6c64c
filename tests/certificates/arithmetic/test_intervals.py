"""The checker's intervals: exact results inside, the smallest ones, and words on the safe side."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Callable
from fractions import Fraction
from math import ceil, floor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import takagi.certificates.checker
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
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
from takagi.certificates.checker.arithmetic.powers import power, whole_power
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
