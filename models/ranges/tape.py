"""Expressions compiled to a flat list of ball operations, each made once.

Walking a sympy tree costs more than the arithmetic; a tape is walked as one loop, and several
expressions (a function and its derivatives) share what they have in common.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    import sympy as sp

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
        from flint import arb

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
    from flint import arb, fmpq

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


class Tape(NamedTuple):
    """Operations that fill slots: inputs first, then constants, then one slot a step.

    Attributes
    ----------
    outputs : slot of each expression; None for one that has no enclosure.
    """

    constants: tuple[Ball, ...]
    steps: tuple[Operation, ...]
    outputs: tuple[int | None, ...]

    def run(self, balls: Sequence[Ball], covered: bool = False) -> list[Ball | None]:
        """Return a ball for each output that contains its value for all values in the balls.

        Parameters
        ----------
        covered : every argument of every table is proved to stay inside it, so that the part of
            a ball that leaves the table holds no argument.
        """
        slots = [*balls, *self.constants]
        add = slots.append
        for kind, apply, first, second in self.steps:
            if kind == ONE:
                add(apply(slots[first]))
            elif kind == TWO:
                add(apply(slots[first], slots[second]))
            else:
                add(apply([slots[i] for i in first], covered))
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
    return maker.tape(outputs)


class _Maker:
    """Slots are numbered apart while the tape grows: ("in", 0), ("const", 3), ("step", 2)."""

    def __init__(self, symbols: Sequence[sp.Symbol], positive: Collection[sp.Expr]) -> None:
        self.positive = positive
        self.inputs = len(symbols)
        self.known: dict[sp.Expr, tuple[str, int]] = {s: ("in", i) for i, s in enumerate(symbols)}
        self.constants: list[Ball] = []
        self.steps: list[tuple[int, Callable[..., Ball], Any, Any]] = []
        self.places: list[tuple[str, int]] = []

    def slot(self, expression: sp.Expr) -> int:
        """Return a number that ``tape`` turns into the slot of the expression."""
        self.places.append(self.place(expression))
        return len(self.places) - 1

    def tape(self, outputs: Sequence[int | None]) -> Tape:
        start = {"in": 0, "const": self.inputs, "step": self.inputs + len(self.constants)}

        def slot(position: tuple[str, int]) -> int:
            return start[position[0]] + position[1]

        steps = tuple(
            Operation(
                kind,
                apply,
                tuple(map(slot, first)) if kind == TABLE else slot(first),
                slot(second) if kind == TWO else 0,
            )
            for kind, apply, first, second in self.steps
        )
        output_slots = tuple(None if o is None else slot(self.places[o]) for o in outputs)
        return Tape(tuple(self.constants), steps, output_slots)

    def place(self, expression: sp.Expr) -> tuple[str, int]:
        if expression not in self.known:
            self.known[expression] = self._made(expression)
        return self.known[expression]

    def constant(self, ball: Ball) -> tuple[str, int]:
        self.constants.append(ball)
        return "const", len(self.constants) - 1

    def step(
        self, apply: Callable[..., Ball], first: Any, second: Any = None, kind: int | None = None
    ) -> tuple[str, int]:
        chosen = (ONE if second is None else TWO) if kind is None else kind
        self.steps.append((chosen, apply, first, second))
        return "step", len(self.steps) - 1

    def chain(
        self, apply: Callable[[Ball, Ball], Ball], operands: Sequence[tuple[str, int]]
    ) -> tuple[str, int]:
        total = operands[0]
        for operand in operands[1:]:
            total = self.step(apply, total, operand)
        return total

    def _made(self, expression: sp.Expr) -> tuple[str, int]:
        import operator

        import sympy as sp
        from flint import arb, fmpq

        if expression.is_Rational:
            return self.constant(arb(fmpq(int(expression.p), int(expression.q))))
        if expression is sp.pi or expression is sp.E:
            return self.constant(arb.pi() if expression is sp.pi else arb.const_e())
        if expression.is_Symbol:
            raise ModelError(f"{expression} has no range; add it to the box")
        if expression.is_Add:
            return self.chain(operator.add, [self.place(a) for a in expression.args])
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        return self._function(expression)

    def _product(self, expression: sp.Expr) -> tuple[str, int]:
        import operator

        above, below = [], []
        for factor in expression.args:
            if factor.is_Pow and factor.exp.is_Rational and factor.exp.is_negative:
                below.append(self.place(factor.base ** (-factor.exp)))
            else:
                above.append(self.place(factor))
        if not below:
            return self.chain(operator.mul, above)
        bottom = self.chain(operator.mul, below)
        if not above:
            return self.step(_inverse, bottom)
        return self.step(operator.truediv, self.chain(operator.mul, above), bottom)

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> tuple[str, int]:
        import operator

        if exponent.is_Rational and exponent.is_negative:
            return self.step(_inverse, self.place(base**-exponent))
        if exponent.is_Integer:
            return self.step(_Power(int(exponent)), self.place(base))
        if exponent.is_Rational and int(exponent.q) == 2:
            root = self.step(_cut_root if base in self.positive else _root, self.place(base))
            return root if exponent.p == 1 else self.step(_Power(int(exponent.p)), root)
        return self.step(operator.pow, self.place(base), self.place(exponent))

    def _function(self, expression: sp.Expr) -> tuple[str, int]:
        from flint import arb

        name = type(expression).__name__
        tables = tables_class()
        if tables is not None and isinstance(expression, tables):
            slots = [self.place(a) for a in expression.args]
            return self.step(TableBalls(type(expression)), slots, kind=TABLE)
        if name in ("Max", "Min"):
            apply = arb.max if name == "Max" else arb.min
            return self.chain(apply, [self.place(a) for a in expression.args])
        special: dict[str, Callable[..., Ball]] = {
            "Abs": _absolute,
            "sign": arb.sgn,
            "Heaviside": _unit_step,
            "sqrt": _root,
        }
        if name not in UNARY and name not in special:
            raise UnknownFunction(
                f"{expression}: no ball arithmetic for {name}; known are {', '.join(UNARY)}, "
                "Abs, sign, Max, Min, tables, powers, and + - * /; give the premise's bounds "
                "yourself, or sample them, which proves nothing (sampled_bounds)"
            )
        unary: Callable[..., Ball] = special[name] if name in special else getattr(arb, name)
        return self.step(unary, self.place(expression.args[0]))


def _inverse(ball: Ball) -> Ball:
    return 1 / ball


def _absolute(ball: Ball) -> Ball:
    return abs(ball).nonnegative_part()


def _unit_step(ball: Ball) -> Ball:
    return (1 + ball.sgn()) / 2


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
