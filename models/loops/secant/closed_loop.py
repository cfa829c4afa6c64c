"""The symbolic closed loop of plant and law on one cell, with saturations as sectors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.loops.secant.entries import at_point
from takagi.models.loops.secant.feedback import Feedback
from takagi.models.ranges.expression_range import expression_range

if TYPE_CHECKING:
    import sympy as sp

FINE = Fraction(1, 10**6)


@dataclass(frozen=True, slots=True, eq=False)
class ClosedLoop:
    """f(x, u(x, w), w) with one share symbol for each input that saturates on the cell.

    Attributes
    ----------
    rows : closed-loop right-hand sides.
    box : the cell's box and the range of every share.
    at_reference : the rows at (x*, w*), functions of the exogenous variables.
    """

    rows: tuple[sp.Expr, ...]
    box: Mapping[sp.Symbol, Interval]
    at_reference: tuple[sp.Expr, ...]


def close_loop(
    rows: Sequence[sp.Expr],
    law: Feedback,
    reference: Mapping[sp.Symbol, sp.Expr],
    box: Mapping[sp.Symbol, Interval],
) -> ClosedLoop:
    """Return the rows with u = u* + s (v(x, w) - v(x*, w*)) substituted, s in [s_min, 1].

    sat(v) - sat(v*) = s (v - v*) holds with one s in [0, 1] for each x.  If v* is inside the
    limits, s >= min(1, (upper - v*)/(v_max - v*)); the lower limit gives a similar bound.  For each
    x, s is treated as a constant, so that the loop is differentiable.  The share s is one more
    variable of the box.

    Raises
    ------
    ModelError : a command cannot be bounded, or the range of v* contains an end of the limits
        in its interior.
    """
    import sympy as sp

    inputs: dict[sp.Symbol, sp.Expr] = {}
    at_rest: dict[sp.Symbol, sp.Expr] = {}
    sides = dict(box)
    for symbol, command in law.commands.items():
        inputs[symbol] = command
        at_rest[symbol] = at_point(command, reference)
        limit = law.limits.get(symbol)
        if limit is None:
            continue
        reached = _range(command, box)
        if limit.contains(reached):
            continue
        wanted = at_rest[symbol]
        held, least = _at_reference(symbol, wanted, _range(wanted, box), reached, limit)
        share = sp.Symbol(f"share_{symbol.name}", real=True)
        # Rounding outward lowers the least share, which only enlarges the enclosure.  The sector
        # itself gives 0 <= s <= 1, so the intersection loses nothing.
        sides[share] = Interval(least, Fraction(1)).outward(9).intersect(_UNIT)
        at_rest[symbol] = held
        inputs[symbol] = held + share * (command - wanted)
    fixed = tuple(row.subs(at_rest, simultaneous=True) for row in rows)
    return ClosedLoop(
        rows=tuple(row.subs(inputs, simultaneous=True) for row in rows),
        box=sides,
        at_reference=tuple(at_point(row, reference) for row in fixed),
    )


_UNIT = Interval(Fraction(0), Fraction(1))


def _at_reference(
    symbol: sp.Symbol, wanted: sp.Expr, at: Interval, reached: Interval, limit: Interval
) -> tuple[sp.Expr, Fraction]:
    """Return (u* = sat(v*), the least share); all bounds use the worst v* in its range."""
    import sympy as sp

    if limit.contains(at):
        shares = [Fraction(1)]
        if reached.upper > limit.upper:
            shares.append((limit.upper - at.upper) / (reached.upper - at.upper))
        if reached.lower < limit.lower:
            shares.append((at.lower - limit.lower) / (at.lower - reached.lower))
        return wanted, min(shares)
    if at.lower >= limit.upper:
        return sp.Rational(*limit.upper.as_integer_ratio()), Fraction(0)
    if at.upper <= limit.lower:
        return sp.Rational(*limit.lower.as_integer_ratio()), Fraction(0)
    raise ModelError(
        f"the command of {symbol} at the reference lies in {at}, across an end of its limits "
        f"{limit}; move the reference or split the cell"
    )


def _range(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> Interval:
    return expression_range(expression, box, tolerance=FINE).outer
