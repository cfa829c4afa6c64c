r"""Enclosures of a differentiable expression over a box, in ball arithmetic.

Three things make them tight:

- a variable in which f is monotone over the box is put to its ends;
- for the others the mean-value form, f(X) in f(m) + sum_i df/dx_i(X) (X_i - m_i), next to the
  plain evaluation;
- a removable singularity N(x)/x_j^k at x_j = 0 is taken in Taylor form there:
  N/x_j^k = \int_0^1 k (1 - s)^{k-1} N^{(k)}(s x_j) ds / k!  lies in the range of N^{(k)}/k!.

Source: Johansson (2017), "Arb: efficient arbitrary-precision midpoint-radius interval
arithmetic", IEEE Trans. Computers 66; Moore, Kearfott, Cloud (2009), ch. 6.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from takagi.models.branch_and_bound import Ends, Look
from takagi.models.enclosure.side import Side, halves_of
from takagi.models.enclosure.tape import Tape, tape_of
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

__all__ = ["PRECISION", "BallForm", "Sides", "halved", "told"]

Ball: TypeAlias = Any
Sides: TypeAlias = tuple[Side, ...]
PRECISION = 128  # bits; Taylor forms near a removable singularity cancel leading digits
FINEST = 2**60  # a side that much narrower than its number is not halved any more


class BallForm:
    """An expression with its derivatives and Taylor forms, each made when first needed.

    Attributes
    ----------
    covered : every argument of every table is proved to stay inside it.
    """

    def __init__(
        self, expression: sp.Expr, symbols: tuple[sp.Symbol, ...], covered: bool = False
    ) -> None:
        self.expression = expression
        self.symbols = symbols
        self.covered = covered
        self.tape = tape_of([expression], symbols)
        self._joint: Tape | None = None
        self._gradient: tuple[BallForm | None, ...] | None = None
        self._poles: tuple[int, ...] | None = None
        self._taylor: dict[int, BallForm | None] = {}

    # ------------------------------------------------------------------ looks

    def look(self, box: Sides) -> Look:
        """Return the plain enclosure over the box; see ``search``."""
        value = self.plain(box)
        attained = _attained(value) if all(side.is_point for side in box) else None
        return Look(_ends(value), attained, _worst_axis(box, [None] * len(box)), "p")

    def refined(self, box: Sides) -> Look:
        """Return the common part of all forms over the box, and values attained there."""
        value, slopes = self.with_slopes(box)
        rough, axis = _ends(value), _worst_axis(box, slopes)
        if rough is None or axis is None:
            return self.look(box)
        found, points = self._tightened(box, rough, slopes)
        attained = None
        for point in points:
            attained = _wider(attained, _attained(point))
        return Look(found, attained, axis, "s", (rough, "p"))

    def by_letter(self, letter: str, box: Sides) -> Ends | None:
        """Return the enclosure that a leaf's letter stands for: p(lain), or with s(lopes)."""
        if letter == "p":
            return _ends(self.plain(box))
        return self.refined(box).outer

    def _tightened(
        self, box: Sides, rough: Ends, slopes: list[Ball | None]
    ) -> tuple[Ends, list[Ball]]:
        """Return the common part of all forms, and balls of values at points."""
        low, high = list(box), list(box)
        free: list[int] = []
        for index, (side, slope) in enumerate(zip(box, slopes, strict=True)):
            if side.is_point:
                continue
            if slope is None or (slope.lower() < 0 < slope.upper()):
                free.append(index)
                continue
            first, last = side.ends()
            rising = slope.lower() >= 0
            low[index], high[index] = (first, last) if rising else (last, first)
        lower, upper = rough
        points: list[Ball] = []
        if len(free) < len(box):
            for place, is_low in ((low, True), (high, False)):
                value = self.plain(tuple(place))
                if not free:
                    points.append(value)
                ends = _ends(value)
                if ends is not None and is_low:
                    lower = max(lower, ends[0])
                elif ends is not None:
                    upper = min(upper, ends[1])
        if free and all(slopes[i] is not None for i in free):
            known = None
            for place, is_low in ((low, True), (high, False)):
                mean, value = self._mean_value(tuple(place), slopes, free, known)
                known = value if len(free) == len(box) else None
                points.append(value)
                ends = _ends(mean)
                if ends is not None and is_low:
                    lower = max(lower, ends[0])
                elif ends is not None:
                    upper = min(upper, ends[1])
        elif free:
            points.append(self.plain(tuple(side.centre() for side in box)))
        return (lower, upper), points

    def _mean_value(
        self, box: Sides, slopes: list[Ball | None], free: list[int], value: Ball | None
    ) -> tuple[Ball, Ball]:
        """Return f(m) + sum_i f_i (X_i - m_i) and f(m), the sides that are not free being points.

        ``value`` is f(m) if it is known already.
        """
        middle = tuple(side.centre() for side in box)
        if value is None:
            value = self.plain(middle)
        total = value
        for index in free:
            total = total + slopes[index] * (box[index].ball - middle[index].ball)
        return total, value

    # ------------------------------------------------------------------ evaluations

    def plain(self, box: Sides) -> Ball:
        """Return one evaluation in balls, in Taylor form towards each removable pole."""
        found = None
        for index, order in enumerate(self.poles()):
            side = box[index]
            if order and self._is_towards_pole(side):
                form = self._removed(index, order, side.has_zero())
                if form is None:
                    continue
                taylor = form.mean_towards_zero(box, index, order)
                if side.has_zero():
                    return taylor
                found = taylor if found is None else _common(found, taylor)
        direct = self.tape.run([side.ball for side in box], self.covered)[0]
        return direct if found is None else _common(found, direct)

    def _is_towards_pole(self, side: Side) -> bool:
        """Return whether the Taylor form is tried; tables are covered on the box only, not to 0."""
        return side.has_zero() or (not self.covered and side.near_zero())

    def mean_towards_zero(self, box: Sides, index: int, order: int) -> Ball:
        r"""Return k \int_0^1 (1 - s)^{k-1} f(s x) ds over the box, k = ``order``, x side ``index``.

        It lies in the range of f over the hull with x = 0, and in f(0) + x f'(hull) / (k + 1).
        """
        side = box[index]
        hull, rest = side.with_zero(), (box[:index], box[index + 1 :])
        wide = (*rest[0], hull, *rest[1])
        if all(part.is_point for part in wide):
            return self.plain(wide)
        value, slopes = self.with_slopes(wide)
        rough = _ends(value)
        if rough is None:
            return value
        ends, _ = self._tightened(wide, rough, slopes)
        found, slope = _between(*ends), slopes[index]
        if slope is None:
            return found
        start = self.plain((*rest[0], side.zero(), *rest[1]))
        return _common(found, start + side.ball * slope / (order + 1))

    def with_slopes(self, box: Sides) -> tuple[Ball, list[Ball | None]]:
        """Return plain value and slopes; None for one that is not bounded."""
        towards_pole = (
            order and self._is_towards_pole(side)
            for order, side in zip(self.poles(), box, strict=True)
        )
        if any(towards_pole):
            slopes = [None if form is None else form.plain(box) for form in self.gradient()]
            return self.plain(box), [_finite(slope) for slope in slopes]
        if self._joint is None:
            slopes_of = [_slope_or_none(self.expression, s) for s in self.symbols]
            self._joint = tape_of(
                [self.expression, *slopes_of], self.symbols, optional=len(self.symbols)
            )
        value, *slopes = self._joint.run([side.ball for side in box], self.covered)
        return value, [_finite(slope) for slope in slopes]

    def gradient(self) -> tuple[BallForm | None, ...]:
        if self._gradient is None:
            self._gradient = tuple(
                self._form(_derivative(self.expression, symbol)) for symbol in self.symbols
            )
        return self._gradient

    def _form(self, expression: sp.Expr | None) -> BallForm | None:
        if expression is None:
            return None
        try:
            return BallForm(expression, self.symbols, self.covered)
        except ModelError:
            return None  # a derivative without ball arithmetic: that slope is not known

    def poles(self) -> tuple[int, ...]:
        """Return, per symbol, the order of the factor 1/x^k that the expression is written with."""
        if self._poles is None:
            import sympy as sp

            powers = sp.fraction(sp.together(self.expression))[1].as_powers_dict()
            self._poles = tuple(_order(powers.get(symbol, 0)) for symbol in self.symbols)
        return self._poles

    def _removed(self, index: int, order: int, needed: bool) -> BallForm | None:
        """Return the form of d^k N/dx^k / k! for N = f x^k, after proving N^(i)(0) = 0, i < k.

        None where 0 is a pole indeed; ModelError if that is ``needed``.
        """
        if index not in self._taylor:
            import sympy as sp

            x = self.symbols[index]
            numerator = sp.expand(sp.together(self.expression * x**order).cancel())
            vanishes = all(_is_zero(numerator.diff(x, lower).subs(x, 0)) for lower in range(order))
            taylor = _derivative(numerator, x, order) if vanishes else None
            if taylor is not None:
                taylor = taylor / sp.factorial(order)
            self._taylor[index] = self._form(taylor)
        found = self._taylor[index]
        if found is None and needed:
            raise ModelError(
                f"{self.expression} has a pole at {self.symbols[index]} = 0, which the box "
                "contains; take 0 out of the box, or choose another premise"
            )
        return found


def halved(box: Sides, axis: int) -> tuple[Sides, Sides]:
    """Return both halves of a box along one side."""
    first, second = ((*box[:axis], half, *box[axis + 1 :]) for half in halves_of(box[axis]))
    return first, second


def told(symbols: tuple[sp.Symbol, ...], box: Sides) -> str:
    """Return e.g. ``"x in [0, 1], y in [2, 3]"``."""
    return ", ".join(f"{s} in {side.interval()}" for s, side in zip(symbols, box, strict=True))


def _derivative(expression: sp.Expr, symbol: sp.Symbol, order: int = 1) -> sp.Expr | None:
    """Return the derivative; None where a table has no further one."""
    try:
        return expression.diff(symbol, order)
    except ModelError:
        return None


def _is_zero(expression: sp.Expr) -> bool:
    import sympy as sp

    return bool(expression == 0 or sp.expand(expression) == 0 or sp.simplify(expression) == 0)


def _slope_or_none(expression: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
    """Return the derivative, or an expression that no tape knows."""
    import sympy as sp

    found = _derivative(expression, symbol)
    return sp.Function("no_slope")(symbol) if found is None else found


def _finite(ball: Ball | None) -> Ball | None:
    return ball if ball is not None and ball.is_finite() else None


def _ends(ball: Ball) -> Ends | None:
    return (ball.lower(), ball.upper()) if ball.is_finite() else None


def _attained(ball: Ball) -> Ends | None:
    """Return the ends of a value's own enclosure, each on the cautious side."""
    return (ball.upper(), ball.lower()) if ball.is_finite() else None


def _wider(first: Ends | None, second: Ends | None) -> Ends | None:
    if first is None or second is None:
        return second if first is None else first
    return min(first[0], second[0]), max(first[1], second[1])


def _between(lower: Ball, upper: Ball) -> Ball:
    """Return a ball around both ends that keeps their sign: its radius has 30 bits only."""
    ball = lower.union(upper)
    if lower >= 0 and ball.lower() < 0:
        return ball - ball.lower()
    if upper <= 0 and ball.upper() > 0:
        return ball - ball.upper()
    return ball


def _common(first: Ball, second: Ball) -> Ball:
    """Return the intersection of two enclosures of the same set."""
    if not first.is_finite() or not second.is_finite():
        return second if not first.is_finite() else first
    return first.intersection(second)


def _order(exponent: object) -> int:
    import sympy as sp

    return int(exponent) if isinstance(exponent, (int, sp.Integer)) and exponent > 0 else 0


def _worst_axis(box: Sides, slopes: list[Ball | None]) -> int | None:
    """Return the side along which f changes most; None when every side is a point.

    A side along which f is monotone is put to its ends, so the others come first.  Without slopes
    the widest side is halved.
    """
    best, axis = (False, -1.0), None
    known = all(slope is not None for slope in slopes)
    for index, (side, slope) in enumerate(zip(box, slopes, strict=True)):
        width = _width(side)
        if side.is_point or width * FINEST <= _size(side):
            continue
        if not known or slope is None:
            rated = (True, width)
        else:
            is_free = bool(slope.lower() < 0 < slope.upper())
            rated = (is_free, width * float(abs(slope).upper()))
        if rated > best:
            best, axis = rated, index
    return axis


def _width(side: Side) -> float:
    return 2 * float(side.ball.rad())


def _size(side: Side) -> float:
    return float(abs(side.ball).upper())
