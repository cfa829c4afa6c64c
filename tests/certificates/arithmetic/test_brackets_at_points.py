"""Brackets on the grid of 10^48 contain the true values, which arb encloses with 500 bits.

On the coarser grid of intervals a bracket that is off by a million units would go unnoticed.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial

import pytest
from flint import arb, ctx

from takagi.certificates.checker.arithmetic import elementary, exponential, logarithm
from takagi.certificates.checker.arithmetic.exponential import FINE

Point = Callable[[int], tuple[int, int]]
SMALL = "0 1e-47 1e-40 1e-24 1e-12 0.001 0.03 0.0625 0.1 1/3 0.5 0.7071 0.9 0.999 0.9999999999"
LARGE = "1 1.0001 1.25 1.5707963 2 3 4.5 7 9.9 10 33 123.456"
EVERY: list[tuple[str, Point, Callable[[arb], arb], str]] = [
    ("sin", partial(elementary._sine_at, quarter=0), arb.sin, f"{SMALL} {LARGE} 999999"),
    ("cos", partial(elementary._sine_at, quarter=1), arb.cos, f"{SMALL} {LARGE} 999999"),
    ("atan", elementary._atan_at, arb.atan, f"{SMALL} {LARGE} 1e10 1e40"),
    ("asin", elementary._asin_at, arb.asin, f"{SMALL} 1"),
    ("exp", exponential.exp_at, arb.exp, f"{SMALL} {LARGE} 699.9"),
    ("sinh", logarithm.sinh_at, arb.sinh, f"{SMALL} {LARGE}"),
    ("tanh", logarithm._tanh_at, arb.tanh, f"{SMALL} {LARGE} 349.9 350.1"),
    ("asinh", logarithm.asinh_at, arb.asinh, f"{SMALL} {LARGE} 1e20"),
    ("atanh", logarithm.atanh_at, arb.atanh, SMALL),
    ("erf", logarithm._erf_at, arb.erf, f"{SMALL} {LARGE}"),
]
POSITIVE: list[tuple[str, Point, Callable[[arb], arb], str]] = [
    ("log", logarithm.log_at, arb.log, f"{SMALL[2:]} {LARGE} 1e30"),
    ("acosh", logarithm.acosh_at, arb.acosh, f"{LARGE} 1e30"),
    ("cosh", logarithm._cosh_at, arb.cosh, f"{SMALL} {LARGE}"),
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
