"""The range of an expression over cells, searched for by branch and bound.

An argument of a table has to stay inside the table, so a cell whose expression has tables is
searched for the ranges of their arguments first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import search
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.cell import Cell
from takagi.models.ranges.cell_enclosures import (
    CellEnclosures,
    attained_at_points,
    checked_symbols,
    enclose,
    halve,
    refined,
)
from takagi.models.ranges.linear_combination import combined

if TYPE_CHECKING:
    import sympy as sp

MOST_BOXES = 8000
TOLERANCE = Fraction(1, 10**6)
LOOSE = Fraction(5, 4)  # the width of bounds over what is attained, above which they are retried
MOST_SIDES = 36  # letters of a tree that number the sides


class Bounds(NamedTuple):
    """Bounds of the values, with the trees of boxes that prove ``outer``; see ``Range``.

    ``names`` are those of the sides of each cell, in the order in which the trees number them.
    """

    outer: Interval
    inner: Interval
    boxes: int
    names: tuple[tuple[str, ...], ...]
    trees: tuple[str, ...]


def bounds_on(expression: sp.Expr, cell: Cell) -> Bounds:
    """Return the bounds on one cell, as ``searched`` with what it takes by itself."""
    return searched(expression, [cell])


def searched(
    expression: sp.Expr,
    cells: Sequence[Cell],
    *,
    tolerance: Fraction = TOLERANCE,
    most_boxes: int = MOST_BOXES,
) -> Bounds:
    """Return bounds of the expression over a union of cells; see ``expression_range``."""
    import flint

    from takagi.models.ranges.ball_form import PRECISION

    with flint.ctx.workprec(PRECISION):
        roots = [cell_root(expression, cell) for cell in cells]
        exact = all(root.polynomial is not None for root in roots)

        def bounds_of(roots: Sequence[CellEnclosures], most_boxes: int) -> Bounds:
            points = [] if exact else [point for root in roots for point in root.points()]
            found = search(
                enclose,
                halve,
                [(root, root.start(exact)) for root in roots],
                tolerance=tolerance,
                most_boxes=most_boxes,
                tell=lambda place: place[0].told(place[1]),
                refine=None if exact else refined,
                attained=None if exact else attained_at_points(points),
            )
            outer, inner = (
                Interval(*map(fraction, ends)) for ends in (found.outer, found.attained)
            )
            names = tuple(root.names for root in roots)
            return Bounds(outer, inner, found.boxes, names, found.trees)

        try:
            found = bounds_of(roots, most_boxes)
            wide = found.outer.width > LOOSE * found.inner.width
            if wide and not exact and any(any(root.form.poles()) for root in roots):
                # These forms are several times longer.
                further = bounds_of([root.further() for root in roots], most_boxes // 4)
                found = min(found, further, key=lambda bounds: bounds.outer.width)
        except ModelError as error:
            raise _without_combinations(error, roots) from error
    return found


def cell_root(expression: sp.Expr, cell: Cell) -> CellEnclosures:
    """Return the expression on the cell.

    Raises
    ------
    ModelError : a symbol without range, too many of them, a function without ball arithmetic, or
        an argument that leaves its table.
    """
    from takagi.models.ranges.ball_form import BallForm
    from takagi.models.ranges.bernstein_form import polynomial_box

    written, box, meanings = combined(cell.written(expression), cell.box)
    symbols = checked_symbols(written, box)
    if len(symbols) > MOST_SIDES:
        raise ModelError(
            f"the expression depends on {len(symbols)} symbols; at most {MOST_SIDES} can be bounded"
        )
    sides = tuple(box[symbol] for symbol in symbols)
    polynomial = polynomial_box(written, symbols, sides)
    form = BallForm(written, symbols, _covered(written, box))
    return CellEnclosures(written, symbols, sides, form, polynomial, meanings)


def fraction(end: Any) -> Fraction:
    """Return an exact ball, or a fraction, as a fraction."""
    from takagi.models.ranges.table_balls import fraction_of

    return end if isinstance(end, Fraction) else fraction_of(end)


def _covered(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> bool:
    """Return whether there are tables and every argument provably stays strictly inside its own.

    Raises
    ------
    ModelError : an argument that takes values outside its table.
    """
    from takagi.models.ranges.table_balls import EDGE, tables_class

    tables = tables_class()
    calls = set() if tables is None else expression.atoms(tables)
    inside = bool(calls)
    for call in sorted(calls, key=str):
        from takagi.models.splines.table_function import table_ranges

        for argument, covers in zip(call.args, table_ranges(call.table), strict=True):
            found = bounds_on(argument, Cell(box))
            slack = EDGE * covers.width
            held = Interval(covers.lower - slack, covers.upper + slack)
            if not held.contains(found.inner):
                raise ModelError(
                    f"an argument of {call}, {argument}, takes values in {found.inner}, but the "
                    f"table covers {covers}; shrink the ranges or extend the table"
                )
            inside = inside and covers.contains(found.outer)
    return inside


def _without_combinations(error: ModelError, roots: Sequence[CellEnclosures]) -> ModelError:
    """Return the error with sums written out where one variable stands for them."""
    text = str(error)
    for root in roots:
        for symbol, base in root.meanings.items():
            text = text.replace(str(symbol), f"({base})")
    return type(error)(text)
