"""Measures how much tighter the enclosures of expressions are than naive interval evaluation.

    python benchmarks/enclosures.py [--seed N]        writes a table into docs/benchmarks.md

``excess`` is what the proved range has more than the true one, as a share of the true width; the
true range is bracketed by a run with a thousandth of the tolerance and by random samples (the
seed).  Naive evaluation halves the widest side of the box that holds the worse end and evaluates
the expression plainly there, nothing else, for as long as ``expression_range`` took from the sympy
expression on:

- intervals: in mpmath's interval arithmetic; a spline by Horner's rule on each of its pieces;
- balls: the expression compiled by takagi itself, with Bernstein hulls for splines; more than a
  naive program has.

``expression_range`` stops at its tolerance, naive bisection goes on until the time is up.  Nothing
is asserted: times depend on the machine.
"""

from __future__ import annotations

import argparse
import heapq
import math
import os
import time
from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import count
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import flint  # noqa: E402  the threads are counted when numpy is loaded
import numpy as np  # noqa: E402
import sympy as sp  # noqa: E402
from measure import PAGE, machine, placed, reduced, table  # noqa: E402
from mpmath import iv  # noqa: E402
from scipy.interpolate import BSpline, PPoly  # noqa: E402

from takagi.models import interpolate_curve, table_function  # noqa: E402
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.ball_form import (
    PRECISION,  # noqa: E402
    halved,  # noqa: E402
    side_of,  # noqa: E402
)
from takagi.models.ranges.expression_range import (
    expression_range,  # noqa: E402
    sampled_bounds,  # noqa: E402
)
from takagi.models.ranges.tape import tape_of  # noqa: E402
from takagi.models.splines.table_function import TableFunction  # noqa: E402

TOLERANCE = Fraction(1, 10**9)
FINE = Fraction(1, 10**12)
RESOLVED = 2e-12  # excess that the bracket of the true range tells from none
REPEATS = 3
# Words of the rows that the page shows.
ON_PAGE = ("gravity", "camel", "torque", "Gauss")

Box = Mapping[sp.Symbol, Interval]
x, y, z = sp.symbols("x y z", real=True)


class Case(NamedTuple):
    """A function and the box it is enclosed on."""

    name: str
    expression: sp.Expr
    box: Box


def cases() -> list[Case]:
    """Return textbook premises, polynomials, rational functions and splines."""
    mass = sp.Rational(4, 3) - sp.cos(x) ** 2 / 11
    ratio = np.linspace(2.0, 12.0, 21)
    power = 0.5 * (116 / ratio - 5) * np.exp(-21 / ratio) + 0.007 * ratio
    c_Q = table_function("c_Q", interpolate_curve(ratio, power / ratio, name="c_Q"))
    symbols = {x: Interval.of(-1, "1.4"), y: Interval.of(-3, 3)}
    camel = (4 - sp.Rational(21, 10) * x**2 + x**4 / 3) * x**2 + x * y + (-4 + 4 * y**2) * y**2
    return [
        Case("sin x / x", sp.sin(x) / x, {x: Interval.of(-1, "1.5")}),
        Case("sin x / x, x >= 1/10", sp.sin(x) / x, {x: Interval.of("0.1", "1.5")}),
        Case("pendulum, gravity", sp.sin(x) / x / mass, {x: Interval.of("0.1", "1.4")}),
        Case("pendulum, speed", y * sp.sin(2 * x) / mass, symbols),
        Case("pendulum, input", sp.cos(x) / mass, {x: Interval.of(-1, "1.4")}),
        Case("tan x / x, x >= 1/10", sp.tan(x) / x, {x: Interval.of("0.1", "1.2")}),
        Case("six-hump camel", camel, {x: Interval.of(-2, 2), y: Interval.of(-1, 1)}),
        Case(
            "cubic in three",
            x * y * z - x**3 + z**2 * y - 2 * x * z,
            {x: Interval.of(-1, 2), y: Interval.of(-2, 1), z: Interval.of(0, 2)},
        ),
        Case("rational", (x - y) / (1 + x**2 + y**2), symbols),
        Case("c_Q spline", c_Q(x), {x: Interval.of(3, 11)}),
        Case(
            "torque v^2 c_Q(63 x / y)",
            y**2 * c_Q(63 * x / y),
            {x: Interval.of("0.9", "1.2"), y: Interval.of(8, 12)},
        ),
        Case(
            "Gauss times wave",
            sp.exp(-(x**2)) * sp.cos(5 * x * y) + sp.sin(z) * y,
            {x: Interval.of(-1, 2), y: Interval.of(0, 3), z: Interval.of(0, 1)},
        ),
    ]


class Naive:
    """Best-first bisection with plain evaluations; ``run`` goes on until ``enough`` says so."""

    def __init__(self, case: Case) -> None:
        symbols = sorted(case.expression.free_symbols, key=str)
        self.tape = tape_of([case.expression], symbols)
        self.start = tuple(side_of(case.box[s]) for s in symbols)

    def run(self, enough: Callable[[int], bool]) -> tuple[float, float]:
        """Return the bounds that are proved when it is enough."""
        number, used = count(), 1
        low, high = self.bounds(self.start)
        lower: list[Any] = [(low, next(number), self.start)]
        upper: list[Any] = [(-high, next(number), self.start)]
        while not enough(used):
            for heap, sign in ((lower, 0), (upper, 1)):
                _, _, box = heapq.heappop(heap)
                axis = max(range(len(box)), key=lambda k: float(box[k].upper - box[k].lower))
                for half in halved(box, axis):
                    ends = self.bounds(half)
                    used += 1
                    heapq.heappush(heap, ((ends[0], -ends[1])[sign], next(number), half))
        return lower[0][0], -upper[0][0]

    def bounds(self, box: Any) -> tuple[float, float]:
        """Return what one plain evaluation gives."""
        ball = self.tape.run([side.ball for side in box])[0]
        if ball is None or not ball.is_finite():
            return -math.inf, math.inf
        return float(ball.lower()), float(ball.upper())


class Textbook(Naive):
    """The same bisection on mpmath's intervals: plain interval arithmetic."""

    def __init__(self, case: Case) -> None:
        super().__init__(case)
        symbols = sorted(case.expression.free_symbols, key=str)
        names: dict[str, Any] = {n: getattr(iv, n) for n in ("sin", "cos", "tan", "exp")}
        written = case.expression
        for call in written.atoms(TableFunction):
            spline = sp.Function(type(call).__name__)(*call.args)
            names[type(call).__name__] = NaiveSpline(type(call).table)
            written = written.subs(call, spline)
        self.value = sp.lambdify(symbols, written, [names])

    def bounds(self, box: Any) -> tuple[float, float]:
        sides = [iv.mpf([float(side.lower), float(side.upper)]) for side in box]
        try:
            found = self.value(*sides)
        except ZeroDivisionError:
            return -math.inf, math.inf
        low, high = float(found.a), float(found.b)
        return (low, high) if math.isfinite(low + high) else (-math.inf, math.inf)


class NaiveSpline:
    """A cubic spline in interval arithmetic: Horner's rule on every piece that is touched."""

    def __init__(self, curve: Any) -> None:
        spline: Any = BSpline(curve.knots, curve.coefficients, 3)
        pieces = PPoly.from_spline(spline)
        wide = np.diff(pieces.x) > 0
        self.starts, self.ends = pieces.x[:-1][wide], pieces.x[1:][wide]
        self.coefficients = pieces.c[:, wide].T

    def __call__(self, argument: Any) -> Any:
        low, high = float(argument.a), float(argument.b)
        found = None
        for start, end, powers in zip(self.starts, self.ends, self.coefficients, strict=True):
            if end < low or high < start:
                continue
            local = iv.mpf([max(low, start), min(high, end)]) - start
            total = iv.mpf(powers[0])
            for power in powers[1:]:
                total = total * local + power
            ends = [total.a, total.b]
            found = ends if found is None else [min(found[0], ends[0]), max(found[1], ends[1])]
        return iv.mpf(found or [-math.inf, math.inf])


def main() -> None:
    """Print the table and write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    seed = parser.parse_args().seed
    heads = (
        "function",
        "time",
        "boxes",
        "excess",
        "naive intervals",
        "wider by",
        "naive balls",
        "wider by",
    )
    rows = [row(case, seed) for case in cases()]
    found = table(heads, rows)
    print(machine(os.getloadavg()[0]), f"Seed {seed}, tolerance {float(TOLERANCE):g}.\n")
    print(found)
    text = PAGE.read_text(encoding="utf-8")
    short = reduced(found, (0, 1, 3, 4), ON_PAGE)
    PAGE.write_text(placed(text, "enclosures", short), encoding="utf-8")


def row(case: Case, seed: int) -> tuple[str, ...]:
    """Return one line of the table."""
    spent = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        found = expression_range(case.expression, case.box, tolerance=TOLERANCE)
        spent.append(time.perf_counter() - began)
    inner = expression_range(case.expression, case.box, tolerance=FINE).inner
    inner = inner.hull(sampled_bounds(case.expression, case.box, seed=seed).bounds)
    true = float(inner.width)
    ours = max(float(found.outer.width - inner.width), 0.0) / true
    with flint.ctx.workprec(PRECISION):
        others = [timed(way, case, min(spent), true) for way in (Textbook, Naive)]
    return (
        case.name,
        f"{1e3 * min(spent):.2g} ms",
        str(found.boxes),
        small(ours),
        *(text for other in others for text in (small(other), ratio(other, ours))),
    )


def timed(way: type[Naive], case: Case, seconds: float, true: float) -> float:
    """Return the excess that a naive way proves in that time."""
    until = time.perf_counter() + seconds
    low, high = way(case).run(lambda used: time.perf_counter() >= until)
    return (high - low) / true - 1


def small(value: float) -> str:
    """Return the excess; below what the bracket of the true range resolves it is told so."""
    if math.isinf(value):
        return "no bound"
    return f"{value:.1e}" if value >= RESOLVED else f"< {RESOLVED:.0e}"


def ratio(other: float, ours: float) -> str:
    if math.isinf(other):
        return "-"
    if max(other, ours) < RESOLVED:
        return "1"
    sign = "> " if ours < RESOLVED else "< " if other < RESOLVED else ""
    return f"{sign}{max(other, RESOLVED) / max(ours, RESOLVED):.2g}"


if __name__ == "__main__":
    main()
