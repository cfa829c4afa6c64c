"""Rigorous range of a symbolic expression: Bernstein form or ball arithmetic, branch and bound.

Quotients of polynomials with rational coefficients are enclosed exactly in Bernstein form, all
else in ball arithmetic with derivative forms.  See ``bernstein_form`` and
``ball_form``; what is said here is which of them is taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import search
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.branch_and_bound import Range
from takagi.models.ranges.cell_enclosures import (
    CellRoot,
    attained_at_points,
    cell_root,
    checked_symbols,
    enclosed_by_letter,
    halve,
    look,
    refine,
)
from takagi.models.ranges.domain import as_domain
from takagi.models.ranges.linear_combination import combined

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.ranges.domain import DomainLike
    from takagi.models.ranges.evidence import Evidence

__all__ = ["expression_range", "expression_value"]

MOST_BOXES = 8000


def expression_range(
    expression: sp.Expr,
    domain: DomainLike,
    *,
    tolerance: Fraction = Fraction(1, 10**6),
    most_boxes: int = MOST_BOXES,
) -> Range:
    """Return an enclosure of the range of the expression over the domain.

    A removable singularity counts with its limit.  Tables are taken inside their ranges only.

    Parameters
    ----------
    domain : an interval for each free symbol, or a ``Domain`` (bands, unions of cells).
    tolerance : excess at each end as a share of the range's width.
    most_boxes : when it is reached the bounds are valid and less tight; ``inner`` tells by how
        much they may be.

    Raises
    ------
    ModelError : a free symbol without interval, a function without enclosure, a pole inside the
        domain, or an argument that may leave its table.
    """
    import flint

    from takagi.models.ranges.ball_form import PRECISION

    over = as_domain(domain)
    with flint.ctx.workprec(PRECISION):
        roots = [cell_root(expression, cell) for cell in over.cells]
        exact = all(root.polynomial is not None for root in roots)
        places = [(root, root.start(exact)) for root in roots]
        try:
            points = [] if exact else [point for root in roots for point in root.points()]
            found = search(
                look,
                halve,
                places,
                tolerance=tolerance,
                most_boxes=most_boxes,
                tell=lambda place: place[0].told(place[1]),
                refine=None if exact else refine,
                attained=None if exact else attained_at_points(points),
            )
        except ModelError as error:
            raise _without_combinations(error, roots) from error
    outer, inner = (Interval(*map(_fraction, ends)) for ends in (found.outer, found.attained))
    from takagi.models.ranges.evidence import Evidence

    names = tuple(root.names for root in roots)
    evidence = Evidence(outer, expression, over, names, found.trees, PRECISION)
    return Range(outer, inner, found.boxes, evidence)


def expression_value(expression: sp.Expr, point: Mapping[sp.Symbol, float]) -> float:
    """Return the expression at a point, also where a removable singularity sits.

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


def replayed_ends(evidence: Evidence) -> tuple[Fraction, Fraction]:
    """Return the hull of the enclosures on the evidence's leaves; see ``Evidence.replay``."""
    import flint

    from takagi.models.ranges.evidence import leaves_of

    cells = evidence.domain.cells
    if not len(cells) == len(evidence.trees) == len(evidence.symbols):
        raise ModelError(
            f"evidence for {len(evidence.trees)} cells was given; the domain has {len(cells)}"
        )
    ends: list[tuple[Fraction, Fraction]] = []
    with flint.ctx.workprec(evidence.precision):
        parts = zip(cells, evidence.trees, evidence.symbols, strict=True)
        for number, (cell, tree, names) in enumerate(parts, start=1):
            root = cell_root(evidence.expression, cell)
            if root.names != names:
                raise ModelError(
                    f"the trees of cell {number} halve {', '.join(names) or 'nothing'}; the "
                    f"expression has the sides {', '.join(root.names) or 'none'}"
                )
            start = root.start("b" in tree)
            for low, high in leaves_of(
                tree, (root, start), len(root.symbols), halve, enclosed_by_letter
            ):
                ends.append((_fraction(low), _fraction(high)))
    return min(low for low, _ in ends), max(high for _, high in ends)


def _without_combinations(error: ModelError, roots: Sequence[CellRoot]) -> ModelError:
    """Return the error with sums written out where one variable stands for them."""
    text = str(error)
    for root in roots:
        for symbol, base in root.meanings.items():
            text = text.replace(str(symbol), f"({base})")
    return type(error)(text)


@lru_cache(maxsize=256)
def _cached_form(expression: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> Any:
    from takagi.models.ranges.ball_form import BallForm

    return BallForm(expression, symbols)


def _fraction(end: Any) -> Fraction:
    """Return an exact ball, or a fraction, as a fraction."""
    from takagi.models.ranges.table_balls import fraction_of

    return end if isinstance(end, Fraction) else fraction_of(end)
