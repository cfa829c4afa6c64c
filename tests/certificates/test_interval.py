"""Intervals bracket the exact result; numbers in words round to the safe side."""

from __future__ import annotations

import ast
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import takagi.certificates.checker
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    Interval,
    enclose,
    hull,
    point,
    product,
)
from takagi.certificates.checker.arithmetic.powers import power, whole_power
from takagi.certificates.checker.words.rounded import at_least, at_most

RATIONALS = st.fractions(min_value=-1000, max_value=1000, max_denominator=10**30)
SHARES = st.fractions(min_value=0, max_value=1, max_denominator=1000)


@st.composite
def points(draw: st.DrawFn) -> tuple[Interval, Fraction]:
    """Return a bracket and a number inside it."""
    a, b = sorted((draw(RATIONALS), draw(RATIONALS)))
    return enclose(a, b), a + (b - a) * draw(SHARES)


def holds(bracket: Interval, value: Fraction) -> bool:
    return bracket[0] <= value * ONE <= bracket[1]


@given(points(), points())
def test_operations_bracket_the_exact_result(
    p: tuple[Interval, Fraction], q: tuple[Interval, Fraction]
) -> None:
    """Moore (1966): x in A and y in B imply x op y in A op B, here after outward rounding."""
    (a, x), (b, y) = p, q

    assert holds(a, x) and holds(point(x), x)
    assert holds(a + b, x + y)
    assert holds(a - b, x - y)
    assert holds(a * b, x * y)
    assert holds(-a, -x)
    assert holds(a.square(), x * x)
    assert holds(hull(a, b), x) and holds(hull(a, b), y)
    assert a.magnitude() >= abs(x) * ONE
    if b[0] > 0 or b[1] < 0:
        assert holds(a / b, x / y)
    else:
        with pytest.raises(CertificateError, match="zero"):
            a / b


@given(points(), SHARES)
def test_within_is_decided_exactly(p: tuple[Interval, Fraction], tiny: Fraction) -> None:
    """A bracket is within its own ends and not within anything smaller."""
    bracket, _ = p
    low, high = Fraction(bracket[0], ONE), Fraction(bracket[1], ONE)
    step = Fraction(1, 10**40)

    assert bracket.within(low - tiny, high + tiny)
    assert not bracket.within(low + step, high)
    assert not bracket.within(low, high - step)


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
