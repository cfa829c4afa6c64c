"""Rigorous range of a symbolic expression: Bernstein form or ball arithmetic, branch and bound.

Quotients of polynomials with rational coefficients are enclosed exactly in Bernstein form
(``bernstein_form``).  All other expressions are enclosed in ball arithmetic with derivative forms
(``ball_form``).  This module chooses between the two.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.branch_and_bound import Range
from takagi.models.ranges.cell_enclosures import checked_symbols
from takagi.models.ranges.cell_search import MOST_BOXES, TOLERANCE, searched
from takagi.models.ranges.domain import DomainLike, as_domain
from takagi.models.ranges.evidence import Evidence
from takagi.models.ranges.linear_combination import combined

if TYPE_CHECKING:
    import sympy as sp


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
    from takagi.models.ranges.ball_form import PRECISION

    over = as_domain(domain)
    found = searched(expression, over.cells, tolerance=tolerance, most_boxes=most_boxes)
    evidence = Evidence(found.outer, expression, over, found.names, found.trees, PRECISION)
    return Range(found.outer, found.inner, found.boxes, evidence)


def expression_value(
    expression: sp.Expr, point: Mapping[sp.Symbol, float] | Mapping[sp.Symbol, Fraction]
) -> float:
    """Return the expression at a point, also at a removable singularity.

    Raises
    ------
    ModelError : a free symbol without value, or no finite value there.
    """
    import flint

    from takagi.models.ranges.ball_form import PRECISION
    from takagi.models.ranges.box_side import side_of

    given = {s: Interval(Fraction(v), Fraction(v)) for s, v in point.items()}
    written, exactly, _ = combined(expression, given)
    symbols = checked_symbols(written, exactly)
    with flint.ctx.workprec(PRECISION):
        found = _cached_form(written, symbols).plain(tuple(side_of(exactly[s]) for s in symbols))
    if not found.is_finite():
        raise ModelError(f"{expression} has no finite value at {dict(point)}")
    return float(found.mid())


@lru_cache(maxsize=256)
def _cached_form(expression: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> Any:
    from takagi.models.ranges.ball_form import BallForm

    return BallForm(expression, symbols)
