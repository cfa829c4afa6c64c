"""Rigorous range of a symbolic expression, and its value at a point.

Quotients of polynomials with rational coefficients are enclosed exactly in Bernstein form
(``bernstein_form``).  All other expressions are enclosed in ball arithmetic with derivative forms
(``ball_form``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import flint
import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Range
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.ball_form import PRECISION, BallForm, side_of
from takagi.models.ranges.cell_search import (
    MOST_BOXES,
    TOLERANCE,
    Cell,
    checked_symbols,
    parts_by_sign,
    searched,
)
from takagi.models.ranges.domain import DomainLike, as_domain
from takagi.models.ranges.symbolic_steps import combined


def expression_range(
    expression: sp.Expr,
    domain: DomainLike,
    *,
    tolerance: Fraction = TOLERANCE,
    most_boxes: int = MOST_BOXES,
) -> Range:
    """Return an enclosure of the range of the expression over the domain.

    A removable singularity counts with its limit.  Tables are taken inside their ranges only.

    Parameters
    ----------
    domain : an interval for each free symbol, or a ``Domain`` (bands, unions of cells).
    tolerance : excess at each end as a share of the range's width.
    most_boxes : when it is reached the bounds are valid and less tight; ``inner`` gives by how
        much they may be.

    Raises
    ------
    ModelError : a free symbol without interval, a function without enclosure, a pole inside the
        domain, or an argument that may leave its table.
    """
    cells = as_domain(domain).cells
    return searched(expression, cells, tolerance=tolerance, most_boxes=most_boxes)


@dataclass(frozen=True, slots=True, eq=False)
class RangeProof:
    """What proves bounds: the expression is enclosed over the domain, to the tolerance."""

    expression: sp.Expr
    domain: DomainLike
    tolerance: Fraction

    def replay(self, bounds: Interval) -> Interval:
        """Return the enclosure, made again; it lies inside the bounds.

        Raises
        ------
        ModelError : it leaves the bounds, or there is none.
        """
        outer = expression_range(self.expression, self.domain, tolerance=self.tolerance).outer
        if not bounds.contains(outer):
            raise ModelError(
                f"the bounds {bounds} of {self.expression} are not proved: its enclosure is "
                f"{outer}; bound the expression again"
            )
        return outer


def expression_value(
    expression: sp.Expr, point: Mapping[sp.Symbol, float] | Mapping[sp.Symbol, Fraction]
) -> float:
    """Return the expression at a point, also at a removable singularity.

    Where x/|x| jumps it is the value beside the point, on the side where x > 0.

    Raises
    ------
    ModelError : a free symbol without value, or no finite value there.
    """
    sides = {s: Interval(Fraction(v), Fraction(v)) for s, v in point.items()}
    ball = _at(expression, sides)
    if not ball.is_finite():
        # One cell for each sign that what stands in |x| may have there: below and above.
        for written, cell in parts_by_sign(expression, [Cell(sides)]):
            ball = _at(written, cell.box)
    if not ball.is_finite():
        raise ModelError(f"{expression} has no finite value at {dict(point)}")
    return float(ball.mid())


def _at(expression: sp.Expr, sides: Mapping[sp.Symbol, Interval]) -> Any:
    written, exactly, _ = combined(expression, sides)
    symbols = checked_symbols(written, exactly)
    with flint.ctx.workprec(PRECISION):
        return _cached_form(written, symbols).plain(tuple(side_of(exactly[s]) for s in symbols))


_cached_form = lru_cache(maxsize=256)(BallForm)
