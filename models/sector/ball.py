r"""Rigorous range of a symbolic expression over a box: ball arithmetic with branch and bound.

Each operation returns a ball that contains the exact result.  Three things make the bounds tight:

- mean-value form, f(X) in f(m) + sum_i df/dx_i(X) (X_i - m_i), next to the plain evaluation;
- a variable in which f is monotone over the box is put to its ends;
- a removable singularity N(x)/x_j^k at x_j = 0 is taken in Taylor form there:
  N/x_j^k = \int_0^1 k (1 - s)^{k-1} N^{(k)}(s x_j) ds / k!  lies in the range of N^{(k)}/k!.

Source: Johansson (2017), "Arb: efficient arbitrary-precision midpoint-radius interval
arithmetic", IEEE Trans. Computers 66; Moore, Kearfott, Cloud (2009), ch. 6.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

from takagi.models.branch_and_bound import Box, Range, range_over
from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

__all__ = ["expression_range", "expression_value"]

Ball: TypeAlias = Any  # flint.arb carries no type annotations
PRECISION = 128  # bits; Taylor forms near a removable singularity cancel leading digits
UNARY = "sin cos tan exp log sqrt asin acos atan sinh cosh tanh asinh acosh atanh sinc erf".split()


def expression_range(
    expression: sp.Expr,
    box: Mapping[sp.Symbol, Interval],
    *,
    tolerance: Fraction = Fraction(1, 10**6),
) -> Range:
    """Return an enclosure of the range of the expression over the box.

    Parameters
    ----------
    box : an interval for each free symbol.
    tolerance : excess at each end as a share of the range's width.

    Raises
    ------
    ModelError : a free symbol without interval, a function without ball arithmetic, or a pole
        inside the box.
    """
    import flint

    symbols = _checked_symbols(expression, box)
    if not symbols:
        with flint.ctx.workprec(PRECISION):
            value = _interval(_evaluate(expression, {}))
        if value is None:
            raise ModelError(f"{expression} is not a finite number")
        return Range(value, value, 1)
    form = _Form(expression, symbols)
    with flint.ctx.workprec(PRECISION):
        return range_over(
            form.enclose, [tuple(box[symbol] for symbol in symbols)], tolerance=tolerance
        )


def expression_value(expression: sp.Expr, point: Mapping[sp.Symbol, float]) -> float:
    """Return the expression at a point, also where a removable singularity sits.

    Raises
    ------
    ModelError : a free symbol without value, or no finite value there.
    """
    import flint

    exactly = {s: Interval(Fraction(v), Fraction(v)) for s, v in point.items()}
    symbols = _checked_symbols(expression, exactly)
    with flint.ctx.workprec(PRECISION):
        found = _cached_form(expression, symbols).enclose(tuple(exactly[s] for s in symbols))
    if found is None:
        raise ModelError(f"{expression} has no finite value at {dict(point)}")
    return float(found.centre)


def _checked_symbols(
    expression: sp.Expr, box: Mapping[sp.Symbol, Interval]
) -> tuple[sp.Symbol, ...]:
    symbols = tuple(sorted(expression.free_symbols, key=str))
    missing = [str(symbol) for symbol in symbols if symbol not in box]
    if missing:
        raise ModelError(
            f"{expression} depends on {', '.join(missing)}, for which no range was given; add "
            "each to the box, or give its value as a parameter"
        )
    return symbols


@lru_cache(maxsize=256)
def _cached_form(expression: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> _Form:
    return _Form(expression, symbols)


class _Form:
    """An expression with its derivatives and Taylor forms, each made when first needed."""

    def __init__(self, expression: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> None:
        self.expression = expression
        self.symbols = symbols
        self._gradient: tuple[_Form, ...] | None = None
        self._poles: tuple[int, ...] | None = None
        self._taylor: dict[int, _Form] = {}

    def enclose(self, box: Box) -> Interval | None:
        """Return the tightest of plain, monotone and mean-value forms; None when unbounded."""
        plain = self.plain(box)
        if plain is None or all(side.width == 0 for side in box):
            return plain
        slopes = [form.plain(box) for form in self.gradient()]
        ends = self._monotone(box, slopes)
        found = plain if ends is None else plain.intersect(ends)
        mean = self._mean_value(box, slopes)
        return found if mean is None else found.intersect(mean)

    def plain(self, box: Box) -> Interval | None:
        """Return one evaluation in balls, and in Taylor form towards each removable pole."""
        found: Interval | None = None
        for index, order in enumerate(self.poles()):
            side = box[index]
            if order and (side.lower <= 0 <= side.upper or self._is_near(side)):
                towards_pole = (*box[:index], side.hull(0), *box[index + 1 :])
                taylor = self._removed(index, order).plain(towards_pole)
                if side.lower <= 0 <= side.upper:
                    return taylor
                found = taylor if found is None or taylor is None else found.intersect(taylor)
        balls = {s: _ball(side) for s, side in zip(self.symbols, box, strict=True)}
        direct = _interval(_evaluate(self.expression, balls))
        if found is None or direct is None:
            return direct
        return direct.intersect(found)

    @staticmethod
    def _is_near(side: Interval) -> bool:
        """Return whether 0 is within three widths, where N(x)/x^k cancels badly."""
        return 0 < side.width and side.magnitude <= 4 * side.width

    def gradient(self) -> tuple[_Form, ...]:
        if self._gradient is None:
            self._gradient = tuple(
                _Form(self.expression.diff(symbol), self.symbols) for symbol in self.symbols
            )
        return self._gradient

    def poles(self) -> tuple[int, ...]:
        """Return, per symbol, the order of the factor 1/x^k that the expression is written with."""
        if self._poles is None:
            import sympy as sp

            denominator = sp.fraction(sp.together(self.expression))[1]
            powers = denominator.as_powers_dict()
            self._poles = tuple(_order(powers.get(symbol, 0)) for symbol in self.symbols)
        return self._poles

    def _removed(self, index: int, order: int) -> _Form:
        """Return the form of d^k N/dx^k / k! for N = f x^k, after proving N^(i)(0) = 0, i < k."""
        if index not in self._taylor:
            import sympy as sp

            x = self.symbols[index]
            numerator = sp.expand(sp.together(self.expression * x**order).cancel())
            for lower in range(order):
                if sp.simplify(numerator.diff(x, lower).subs(x, 0)) != 0:
                    raise ModelError(
                        f"{self.expression} has a pole at {x} = 0, which the box contains; take "
                        "0 out of the box, or choose another premise"
                    )
            taylor = numerator.diff(x, order) / sp.factorial(order)
            self._taylor[index] = _Form(taylor, self.symbols)
        return self._taylor[index]

    def _monotone(self, box: Box, slopes: list[Interval | None]) -> Interval | None:
        low, high = list(box), list(box)
        for index, (side, slope) in enumerate(zip(box, slopes, strict=True)):
            if slope is None or slope.lower < 0 < slope.upper:
                continue
            first = Interval(side.lower, side.lower)
            last = Interval(side.upper, side.upper)
            rising = slope.lower >= 0
            low[index], high[index] = (first, last) if rising else (last, first)
        if low == list(box):
            return None
        below, above = self.plain(tuple(low)), self.plain(tuple(high))
        if below is None or above is None:
            return None
        return Interval(below.lower, above.upper)

    def _mean_value(self, box: Box, slopes: list[Interval | None]) -> Interval | None:
        total = self.plain(tuple(Interval(side.centre, side.centre) for side in box))
        for side, slope in zip(box, slopes, strict=True):
            if total is None or slope is None:
                return None
            total = total + slope * (side - side.centre)
        return total


def _order(exponent: object) -> int:
    import sympy as sp

    return int(exponent) if isinstance(exponent, (int, sp.Integer)) and exponent > 0 else 0


def _ball(side: Interval) -> Ball:
    from flint import arb, fmpq

    lower, upper = (arb(fmpq(end.numerator, end.denominator)) for end in (side.lower, side.upper))
    return lower if side.width == 0 else lower.union(upper)


def _interval(ball: Ball) -> Interval | None:
    if not ball.is_finite():
        return None
    return Interval(_fraction(ball.lower()), _fraction(ball.upper()))


def _fraction(point: Ball) -> Fraction:
    mantissa, exponent = (int(part) for part in point.man_exp())
    return Fraction(mantissa) * Fraction(2) ** exponent


def _evaluate(expression: sp.Expr, balls: Mapping[sp.Symbol, Ball]) -> Ball:
    """Return a ball that contains the expression's value for all values in the balls."""
    import sympy as sp
    from flint import arb, fmpq

    if expression.is_Symbol:
        return balls[expression]
    if expression.is_Rational:
        return arb(fmpq(int(expression.p), int(expression.q)))
    arguments = [_evaluate(argument, balls) for argument in expression.args]
    if expression.is_Add:
        return sum(arguments[1:], arguments[0])
    if expression.is_Mul:
        product = arguments[0]
        for argument in arguments[1:]:
            product = product * argument
        return product
    if expression.is_Pow:
        return _power(arguments[0], expression.exp, arguments[1])
    if expression is sp.pi or expression is sp.E:
        return arb.pi() if expression is sp.pi else arb.const_e()
    return _function(expression)(*arguments)


def _power(base: Ball, exponent: sp.Expr, ball: Ball) -> Ball:
    from flint import arb

    if exponent.is_Integer:
        power = abs(int(exponent))
        value = _even(base, power) if power % 2 == 0 else base**power
        return value if int(exponent) > 0 else arb(1) / value
    if exponent.is_Rational and int(exponent.q) == 2:
        root = base.sqrt() ** abs(int(exponent.p))
        return root if int(exponent.p) > 0 else arb(1) / root
    return base**ball


def _even(base: Ball, power: int) -> Ball:
    """Return base**power without the negative part that a ball around 0 would get."""
    return (base**power).nonnegative_part()


def _function(expression: sp.Expr) -> Callable[..., Ball]:
    from flint import arb

    name = type(expression).__name__
    if name == "Abs":
        return abs
    if name not in UNARY:
        raise ModelError(
            f"{expression}: no ball arithmetic for {name}; known are {', '.join(UNARY)}, Abs, "
            "powers, and + - * /; give the premise's bounds yourself"
        )
    found: Callable[..., Ball] = getattr(arb, name)
    return found
