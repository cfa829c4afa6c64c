"""Ranges of the coefficient surface by the second checker, against scipy's and the first one's."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from takagi.certificates.checker.arithmetic.interval import ONE, enclose
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.cross_check.kernel.reading import loads
from takagi.certificates.cross_check.opinion import judge_document
from takagi.certificates.cross_check.turbine import surface as surfaces
from takagi.certificates.cross_check.turbine.surface import CoefficientSurface, NumberRange, Outside
from takagi.certificates.document.certificate_file import dumps
from tests.certificates.kinds.test_damage import resealed

Data = dict[str, Any]
ORDERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
DIGITS = st.integers(-40, 40)


def number(value: fmpq) -> float:
    return int(value.p) / int(value.q)


def rational(value: float) -> fmpq:
    return fmpq(*Fraction(str(value)).as_integer_ratio())


@pytest.fixture
def surface(short: Data) -> CoefficientSurface:
    return CoefficientSurface(loads(dumps(short["model"]["torque_surface"])))


def knots_of(short: Data) -> tuple[list[float], list[float], list[list[float]]]:
    table = short["model"]["torque_surface"]
    return table["tip_speed_ratio_knots"], table["pitch_knots"], table["coefficients"]


def rectangles(short: Data, seed: int) -> list[tuple[float, float, float, float]]:
    """Return rectangles in the table: some in one patch, some over several, some on its edge."""
    rng = random.Random(seed)
    x, y, _ = knots_of(short)
    found = [(x[0], x[0], y[-1], y[-1]), (x[6], x[6], y[5], y[8]), (x[5], x[7], y[7], y[7])]
    for _ in range(12):
        a, b = sorted(round(rng.uniform(x[0], x[-1]), 3) for _ in range(2))
        c, d = sorted(round(rng.uniform(y[0], y[-1]), 4) for _ in range(2))
        found.append((a, min(b, a + rng.choice((0.1, 1))), c, min(d, c + rng.choice((0.01, 0.1)))))
    return [(a, round(b, 12), c, round(d, 12)) for a, b, c, d in found]


def test_surface_is_the_spline_of_scipy(short: Data, surface: CoefficientSurface) -> None:
    """Values of scipy's spline lie in the span, and a span of one point is the value."""
    x_knots, y_knots, rows = knots_of(short)
    for a, b, c, d in rectangles(short, seed=3):
        over = NumberRange(rational(a), rational(b)), NumberRange(rational(c), rational(d))
        for dx, dy in ORDERS:
            span = surface.over(*over, dx, dy)
            first = BSpline(np.array(x_knots), np.array(rows), 3).derivative(dx)
            along = first(np.linspace(a, b, 7))
            second = BSpline(np.array(y_knots), along.T, 3).derivative(dy)
            values = second(np.linspace(c, d, 7))
            slack = 1e-9 * (1 + np.abs(values).max())
            assert number(span.low) - slack <= values.min(), (dx, dy)
            assert values.max() <= number(span.high) + slack, (dx, dy)
            if a == b and c == d:
                assert number(span.high - span.low) < 1e-9


def test_a_band_forgets_what_it_was_asked_before(surface: CoefficientSurface) -> None:
    """Parts of a patch, then the whole of it, then parts: each as the surface itself has it."""
    a, b, c = surface.x.breaks[4:7]
    middle, y = (a + b) / 2, NumberRange(*surface.y.breaks[5:7])
    bands = {dy: surfaces.Band(surface, y, dy) for dy in (0, 1, 2)}
    for low, high in [(middle, b), (a, middle), (a, b), (a, c), (middle, c), (a, b), (middle, b)]:
        for dx, dy in ORDERS:
            x = NumberRange(low, high)
            assert bands[dy].over(x, dx) == surface.over(x, y, dx, dy), (low, high, dx, dy)


def test_surface_has_the_first_checker_s_ranges(short: Data, surface: CoefficientSurface) -> None:
    """Powers and the recursion of Cox and de Boor, against blossoms and de Casteljau."""
    exact = [[Fraction(str(c)) for c in row] for row in knots_of(short)[2]]
    knots = [[Fraction(str(t)) for t in side] for side in knots_of(short)[:2]]
    theirs = Spline(knots[0], knots[1], exact)
    for a, b, c, d in rectangles(short, seed=4)[3:]:
        over = NumberRange(rational(a), rational(b)), NumberRange(rational(c), rational(d))
        sides = [enclose(Fraction(str(p)), Fraction(str(q))) for p, q in ((a, b), (c, d))]
        for order in ORDERS:
            ours = surface.over(*over, *order)
            low, high = (end / ONE for end in theirs.bounds(sides[0], sides[1], *order))
            assert number(ours.low) == pytest.approx(low, abs=1e-9), order
            assert number(ours.high) == pytest.approx(high, abs=1e-9), order


def test_rectangle_beyond_the_table_is_none(surface: CoefficientSurface) -> None:
    inside, beyond = NumberRange(fmpq(5), fmpq(6)), NumberRange(fmpq(14), fmpq(15))
    with pytest.raises(Outside):
        surface.over(beyond, NumberRange(fmpq(0), fmpq(0)))
    with pytest.raises(Outside):
        surface.over(inside, NumberRange(fmpq(-1), fmpq(0)))


@given(*[DIGITS] * 4, st.fractions(0, 1, max_denominator=9), st.fractions(0, 1, max_denominator=9))
def test_arithmetic_holds_every_pair(
    a: int, b: int, c: int, d: int, s: Fraction, t: Fraction
) -> None:
    """x o y lies in X o Y for x in X, y in Y."""
    X, Y = NumberRange.of(fmpq(a), fmpq(b)), NumberRange.of(fmpq(c), fmpq(d))
    x = a + fmpq(s.numerator, s.denominator) * (b - a)
    y = c + fmpq(t.numerator, t.denominator) * (d - c)
    pairs = [(X + Y, x + y), (X - Y, x - y), (X * Y, x * y), (X.squared(), x * x)]
    if Y.low > 0 or Y.high < 0:
        pairs.append((X / Y, x / y))
    else:
        with pytest.raises(Outside):
            X / Y
    for span, value in [*pairs, *((span.rounded(), value) for span, value in pairs)]:
        assert span.low <= value <= span.high
    assert X.low >= -X.size and X.high <= X.size


def test_larger_surface_is_left_to_the_first_checker(short: Data) -> None:
    table = short["model"]["torque_surface"]
    knots = table["pitch_knots"]
    inner = [round(-0.08 + 0.005 * k, 4) for k in range(140)]
    table["pitch_knots"] = [*knots[:4], *inner, *[0.7] * 4]
    (one,) = judge_document(resealed(short))

    assert one.verdict == "NOT REPLAYED"


def test_surface_reads_the_certificate_alone(short: Data) -> None:
    """One coefficient of the table moves the value on its patch and leaves others alone."""
    table = short["model"]["torque_surface"]
    before = CoefficientSurface(loads(dumps(table)))
    table["coefficients"][10][10] += 0.001
    after = CoefficientSurface(loads(dumps(table)))
    x, y = table["tip_speed_ratio_knots"], table["pitch_knots"]

    def value(surface: CoefficientSurface, k: int) -> NumberRange:
        at_x, at_y = (NumberRange(rational(knots[k]), rational(knots[k])) for knots in (x, y))
        return surface.over(at_x, at_y)

    assert value(before, 12) != value(after, 12)
    assert value(before, 20) == value(after, 20)
