"""Expressions compiled to a flat list of ball operations, each made once.

Walking a sympy tree costs more than the arithmetic; a tape is walked as one loop, and several
expressions (a function and its derivatives) share what they have in common.
"""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import sympy as sp
from flint import arb, fmpq

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

Ball: TypeAlias = Any  # flint.arb carries no type annotations
# Rounding may move an argument outside its table by this share of the table's width.
EDGE = Fraction(1, 2**90)
WIDE = 30  # bits that a ball's width may be smaller than its number to be called wide


def tables_class() -> type[Any] | None:
    """Return ``TableFunction`` if it is loaded; otherwise no expression can contain one."""
    module = sys.modules.get("takagi.models.splines.table_function")
    return None if module is None else module.TableFunction


class TableBalls:
    """A table as an operation on balls.

    Beyond its edge by ``EDGE`` a table is held at its edge.  An argument that leaves it by more
    gives no bound, unless it was proved that all arguments are inside: then the part of the ball
    that is outside is only overestimation, and is cut off.
    """

    def __init__(self, function: Any) -> None:
        from takagi.models.splines.table_function import table_ranges

        self.bounds = function.bounds
        self.orders = function.orders
        self.ranges = table_ranges(function.table)

    def __call__(self, balls: Sequence[Ball], covered: bool) -> Ball:
        sides, may_leave = [], False
        for ball, covers in zip(balls, self.ranges, strict=True):
            if not ball.is_finite():
                return arb.nan()
            low, high = _ends(ball)
            over = max(covers.lower - low, high - covers.upper)
            if over > 0:
                apart = low > covers.upper or high < covers.lower
                if over > EDGE * covers.width and (apart or not covered):
                    return arb.nan()
                may_leave = may_leave or not covered
                low = min(max(low, covers.lower), covers.upper)
                high = max(min(high, covers.upper), covers.lower)
            sides.append(Interval(low, high))
        table_range = self.bounds(*sides)
        if may_leave and any(self.orders):
            table_range = table_range.hull(0)  # the slope of a function that is held at its edge
        return ball_of(table_range)


def _ends(ball: Ball) -> tuple[Fraction, Fraction]:
    """Return ends around a ball: exact for a narrow one, short numbers for a wide one.

    Exact arithmetic with ends of 128 bits costs several times that with floats.
    """
    low, high = ball.lower(), ball.upper()
    if (high - low) * 2**WIDE > abs(ball):
        first, last = math.nextafter(float(low), -math.inf), math.nextafter(float(high), math.inf)
        return Fraction(first), Fraction(last)
    return fraction_of(low), fraction_of(high)


def ball_of(interval: Interval) -> Ball:
    """Return a ball that contains the interval."""
    lower, upper = (arb(fmpq(e.numerator, e.denominator)) for e in (interval.lower, interval.upper))
    return lower if interval.lower == interval.upper else lower.union(upper)


def fraction_of(point: Ball) -> Fraction:
    """Return an exact ball (of radius 0) as a rational."""
    mantissa, exponent = point.man_exp()
    m, e = int(mantissa), int(exponent)
    return Fraction(m << e) if e >= 0 else Fraction(m, 1 << -e)


UNARY = "sin cos tan exp log sqrt asin acos atan sinh cosh tanh asinh acosh atanh sinc erf".split()
ONE, TWO, TABLE = range(3)  # kinds of operations: one operand, two, any number into a table


class UnknownFunction(ModelError):
    """A function has no ball arithmetic: its range cannot be enclosed, only given or sampled."""


class Operation(NamedTuple):
    """One operation on slots of the tape."""

    kind: int
    apply: Callable[..., Ball]
    first: Any  # a slot; the slots of all arguments for a table
    second: int
    target: int


class Tape(NamedTuple):
    """Operations that fill slots; those of the inputs come first.

    Attributes
    ----------
    slots : constants where they stand, None elsewhere.
    outputs : slot of each expression; None for one that has no enclosure.
    """

    slots: tuple[Ball | None, ...]
    steps: tuple[Operation, ...]
    outputs: tuple[int | None, ...]

    def run(self, balls: Sequence[Ball], covered: bool = False) -> list[Ball | None]:
        """Return a ball for each output that contains its value for all values in the balls.

        ``covered`` : every argument of every table is proved to stay inside it, so that the part of
        a ball that leaves the table holds no argument.
        """
        slots = [*balls, *self.slots[len(balls) :]]
        for kind, apply, first, second, target in self.steps:
            if kind == ONE:
                slots[target] = apply(slots[first])
            elif kind == TWO:
                slots[target] = apply(slots[first], slots[second])
            else:
                slots[target] = apply([slots[i] for i in first], covered)
        return [None if i is None else slots[i] for i in self.outputs]


def tape_of(
    expressions: Sequence[sp.Expr],
    symbols: Sequence[sp.Symbol],
    *,
    optional: int = 0,
    positive: Collection[sp.Expr] = (),
) -> Tape:
    """Return the tape of the expressions.

    Parameters
    ----------
    optional : as many of the last expressions may have no enclosure; their output is None.
    positive : what is proved to be >= 0, so that the part of its ball below 0 holds no value.

    Raises
    ------
    ModelError : a function without ball arithmetic.
    """
    maker = _Maker(symbols, positive)
    outputs: list[int | None] = []
    for index, expression in enumerate(expressions):
        try:
            outputs.append(maker.slot(expression))
        except ModelError:
            if index < len(expressions) - optional:
                raise
            outputs.append(None)
    return Tape(tuple(maker.slots), tuple(maker.steps), tuple(outputs))


class _Maker:
    """A tape that grows: each part of an expression gets the next slot, once."""

    def __init__(self, symbols: Sequence[sp.Symbol], positive: Collection[sp.Expr]) -> None:
        self.positive = positive
        self.known: dict[sp.Expr, int] = {s: i for i, s in enumerate(symbols)}
        self.slots: list[Ball | None] = [None] * len(symbols)
        self.steps: list[Operation] = []

    def slot(self, expression: sp.Expr) -> int:
        if expression not in self.known:
            self.known[expression] = self._made(expression)
        return self.known[expression]

    def constant(self, ball: Ball) -> int:
        self.slots.append(ball)
        return len(self.slots) - 1

    def step(self, apply: Callable[..., Ball], first: Any, second: int = 0, kind: int = ONE) -> int:
        target = self.constant(None)
        self.steps.append(Operation(kind, apply, first, second, target))
        return target

    def chain(self, apply: Callable[[Ball, Ball], Ball], operands: Sequence[sp.Expr]) -> int:
        total, *further = [self.slot(operand) for operand in operands]
        for operand in further:
            total = self.step(apply, total, operand, TWO)
        return total

    def _made(self, expression: sp.Expr) -> int:
        if expression.is_Rational:
            return self.constant(arb(fmpq(int(expression.p), int(expression.q))))
        if expression is sp.pi or expression is sp.E:
            return self.constant(arb.pi() if expression is sp.pi else arb.const_e())
        if expression.is_Symbol:
            raise ModelError(f"{expression} has no range; add it to the box")
        if expression.is_Add:
            return self.chain(operator.add, expression.args)
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        return self._function(expression)

    def _product(self, expression: sp.Expr) -> int:
        above, below = [], []
        for factor in expression.args:
            if factor.is_Pow and factor.exp.is_Rational and factor.exp.is_negative:
                below.append(factor.base ** (-factor.exp))
            else:
                above.append(factor)
        if not below:
            return self.chain(operator.mul, above)
        bottom = self.chain(operator.mul, below)
        if not above:
            return self.step(_inverse, bottom)
        return self.step(operator.truediv, self.chain(operator.mul, above), bottom, TWO)

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if exponent.is_Rational and exponent.is_negative:
            return self.step(_inverse, self.slot(base**-exponent))
        if exponent.is_Integer:
            return self.step(_Power(int(exponent)), self.slot(base))
        if exponent.is_Rational and int(exponent.q) == 2:
            root = self.step(_cut_root if base in self.positive else _root, self.slot(base))
            return root if exponent.p == 1 else self.step(_Power(int(exponent.p)), root)
        return self.step(operator.pow, self.slot(base), self.slot(exponent), TWO)

    def _function(self, expression: sp.Expr) -> int:
        name = type(expression).__name__
        tables = tables_class()
        if tables is not None and isinstance(expression, tables):
            slots = [self.slot(a) for a in expression.args]
            return self.step(TableBalls(type(expression)), slots, kind=TABLE)
        if name in ("Max", "Min"):
            return self.chain(arb.max if name == "Max" else arb.min, expression.args)
        special: dict[str, Callable[..., Ball]] = {
            "Abs": lambda ball: abs(ball).nonnegative_part(),
            "sign": arb.sgn,
            "Heaviside": lambda ball: (1 + ball.sgn()) / 2,
            "sqrt": _root,
        }
        if name not in UNARY and name not in special:
            raise UnknownFunction(
                f"{expression}: no ball arithmetic for {name}; known are {', '.join(UNARY)}, "
                "Abs, sign, Max, Min, tables, powers, and + - * /; give the premise's bounds "
                "yourself, or sample them, which proves nothing (sampled_bounds)"
            )
        unary: Callable[..., Ball] = special[name] if name in special else getattr(arb, name)
        return self.step(unary, self.slot(expression.args[0]))


def _inverse(ball: Ball) -> Ball:
    return 1 / ball


def _root(ball: Ball) -> Ball:
    if ball.is_exact() or not ball.is_finite():
        return ball.sqrt()
    low = ball.lower()
    return ball.sqrt() if low < 0 else low.sqrt().union(ball.upper().sqrt())


def _cut_root(ball: Ball) -> Ball:
    """Return the root of the part that is not below 0, where all values are."""
    return _root(ball.nonnegative_part()).nonnegative_part()


@dataclass(frozen=True, slots=True)
class _Power:
    """x^n from the ends of x; a product of balls ignores that the factors are equal."""

    exponent: int

    def __call__(self, ball: Ball) -> Ball:
        n = self.exponent
        if ball.is_exact() or not ball.is_finite():
            return ball**n
        if n % 2 == 0 and ball.contains(0):
            return (ball**n).nonnegative_part()
        return (ball.lower() ** n).union(ball.upper() ** n)
