"""The checker's spline against the models floor: two implementations, one surface."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.arithmetic.interval import ONE, enclose, hull, point
from takagi.certificates.checker.arithmetic.spline import PAD, Spline
from takagi.models import Interval, Surface, nrel5mw
from takagi.models.intervals.interval import exact

ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def decimals(values: Any) -> list[Fraction]:
    return [exact(float(value)) for value in values]


def spline_of(surface: Surface) -> Spline:
    rows = [decimals(row) for row in surface.coefficients]
    return Spline(decimals(surface.x_knots), decimals(surface.y_knots), rows)


@pytest.fixture(scope="module")
def surface() -> Surface:
    return nrel5mw().torque


@pytest.fixture(scope="module")
def spline(surface: Surface) -> Spline:
    return spline_of(surface)


def rectangles(surface: Surface, count: int) -> list[tuple[Interval, Interval]]:
    """Return rectangles of all sizes: points, slivers, several cells, with ends on knots."""
    rng = random.Random(5)

    def side(low: float, high: float, knots: list[Fraction]) -> Interval:
        a, b = (exact(round(rng.uniform(low, high), 6)) for _ in "ab")
        if rng.random() < 0.3:
            a = rng.choice(knots)
        wide = rng.choice([Fraction(0), Fraction(1, 10**9), Fraction(1, 50), Fraction(1)])
        b = min(max(a + (b - a) * wide, knots[0]), knots[-1])
        return Interval(min(a, b), max(a, b))

    x, y = (sorted(set(decimals(k))) for k in (surface.x_knots, surface.y_knots))
    return [(side(*surface.x_range, x), side(*surface.y_range, y)) for _ in range(count)]


def test_bounds_agree_with_the_exact_ones(surface: Surface, spline: Spline) -> None:
    """Exact Bernstein hulls lie inside the fixed-point ones, which are at most 2^-38 wider."""
    slack = Fraction(4 * PAD, ONE)
    for x, y in rectangles(surface, 60):
        for dx, dy in ORDERS:
            theirs = surface.bounds(x, y, dx, dy)
            low, high = (
                Fraction(end, ONE)
                for end in spline.bounds(
                    enclose(x.lower, x.upper), enclose(y.lower, y.upper), dx, dy
                )
            )
            assert low <= theirs.lower and theirs.upper <= high
            if x.width and y.width:
                # A point on a knot also meets the neighbouring cell, whose value is the same.
                assert theirs.lower - low <= slack + abs(theirs.width)
                assert high - theirs.upper <= slack + abs(theirs.width)


def test_what_was_asked_before_changes_nothing(surface: Surface) -> None:
    """Parts of a cell, then the whole of it, then parts: each as a new spline bounds it."""
    asked = spline_of(surface)
    a, b, c = sorted(set(decimals(surface.x_knots)))[4:7]
    low, high = sorted(set(decimals(surface.y_knots)))[5:7]
    third, middle = (high - low) / 3, (a + b) / 2
    across = [(low, high), (low, low + third), (low + third, high), (low + third, high - third)]
    for x in [(middle, b), (a, middle), (a, b), (a, c), (middle, c), (a, b), (middle, b)]:
        for y in across:
            for order in ORDERS:
                found = asked.bounds(enclose(*x), enclose(*y), *order)
                assert found == spline_of(surface).bounds(enclose(*x), enclose(*y), *order)


def test_points_agree_with_exact_values(surface: Surface, spline: Spline) -> None:
    """At a rational point the bracket holds the exact derivative and is 2^-38 wide."""
    rng = random.Random(6)
    for _ in range(60):
        x = exact(round(rng.uniform(*surface.x_range), 9))
        y = exact(round(rng.uniform(*surface.y_range), 9))
        for dx, dy in ORDERS:
            low, high = spline.bounds(point(x), point(y), dx, dy)
            assert low <= surface.exact(x, y, dx, dy) * ONE <= high
            assert high - low <= 4 * PAD


def test_without_an_order_it_is_the_value(surface: Surface, spline: Spline) -> None:
    for x, y in rectangles(surface, 5):
        box = enclose(x.lower, x.upper), enclose(y.lower, y.upper)
        assert spline.bounds(*box) == spline.bounds(*box, 0, 0) != spline.bounds(*box, 1, 0)


def test_leaving_the_table_is_refused(surface: Surface, spline: Spline) -> None:
    """A range beyond the last knot has no value: refused, not extrapolated."""
    x, y = (point(exact((r[0] + r[1]) / 2)) for r in (surface.x_range, surface.y_range))
    beyond = point(exact(surface.x_range[1]) + Fraction(1, 10**9))
    below = point(exact(surface.y_range[0]) - Fraction(1, 10**9))

    with pytest.raises(CertificateError, match="leaves"):
        spline.bounds(hull(x, beyond), y)
    with pytest.raises(CertificateError, match="leaves"):
        spline.bounds(x, hull(below, y))


CLAMPED = [Fraction(k) for k in (0, 0, 0, 0, 1, 2, 2, 2, 2)]
UNIFORM = [Fraction(k) for k in range(9)]


@pytest.mark.parametrize(
    ("knots", "rows", "words"),
    [
        (UNIFORM, 5, "clamped"),
        (CLAMPED[:6], 5, "clamped"),
        ([*CLAMPED[:4], Fraction(2), Fraction(1), *CLAMPED[5:]], 6, "increase"),
        ([*CLAMPED[:4], Fraction(1), *CLAMPED[4:]], 6, "increase"),
        ([*CLAMPED[:4], Fraction(1, 10**6), *CLAMPED[4:]], 6, "narrower"),
        (CLAMPED, 4, "rows"),
    ],
)
def test_knots_that_are_no_clamped_cubic_are_refused(
    knots: list[Fraction], rows: int, words: str
) -> None:
    """Knots decide what the coefficients mean; anything but a clamped cubic is refused."""
    with pytest.raises(CertificateError, match=words):
        Spline(knots, CLAMPED, [[Fraction(1)] * 5 for _ in range(rows)])


def test_huge_or_too_steep_surfaces_are_refused() -> None:
    """The rounding budget is stated for coefficients below 1000 and nets below 2^20."""
    with pytest.raises(CertificateError, match="beyond 1000"):
        Spline(CLAMPED, CLAMPED, [[Fraction(10**6)] * 5 for _ in range(5)])
    narrow = [Fraction(k, 500) for k in (0, 0, 0, 0, 1, 2, 2, 2, 2)]
    rows = [[Fraction(1000 * (-1) ** i)] * 5 for i in range(5)]
    steep = Spline(narrow, CLAMPED, rows)
    with pytest.raises(CertificateError, match="steep"):
        steep.bounds(point(Fraction(1, 1000)), point(Fraction(1)), 1, 0)
