"""The range of an expression over cells, searched for by branch and bound.

An argument of a table has to stay inside the table, so a cell whose expression has tables is
searched for the ranges of their arguments first.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple, TypeVar

import flint
import sympy as sp

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Bounded, Ends, Range, SearchResult, search
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.ball_form import PRECISION, BallForm, Sides, halved, side_of, wider
from takagi.models.ranges.bernstein_form import (
    PolynomialBox,
    halved_polynomial,
    has_pole,
    look_at_polynomial,
    polynomial_box,
)
from takagi.models.ranges.symbolic_steps import combined, linear_terms
from takagi.models.ranges.tape import EDGE, fraction_of, tables_class


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """The points {x : x_i in box_i, or x_i = places_i(coordinates), coordinates in box}.

    Attributes
    ----------
    box : a range for each variable or coordinate that varies by itself.
    places : variable -> expression in the symbols of ``box``.

    Raises
    ------
    ModelError : a variable that has both a range and a place, or a place in other symbols.
    """

    box: Mapping[sp.Symbol, Interval]
    places: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        twice = sorted(str(s) for s in self.places if s in self.box)
        if twice:
            raise ModelError(f"{', '.join(twice)} has a range and a place; give one of them")
        for symbol, expression in self.places.items():
            strange = sorted(str(s) for s in expression.free_symbols if s not in self.box)
            if strange:
                raise ModelError(
                    f"the place of {symbol}, {expression}, depends on {', '.join(strange)}, which "
                    "the box gives no range; add it to the box"
                )

    def written(self, expression: sp.Expr) -> sp.Expr:
        """Return the expression in the symbols of the box."""
        return expression.subs(dict(self.places), simultaneous=True) if self.places else expression


MOST_CORNERS = 4  # sides whose ends are all tried as first samples


class CellEnclosures(NamedTuple):
    """One cell with the expression in its coordinates, and both ways to enclose it."""

    expression: sp.Expr
    symbols: tuple[sp.Symbol, ...]
    sides: tuple[Interval, ...]
    form: BallForm
    polynomial: PolynomialBox | None  # None where the expression is no quotient of polynomials
    meanings: Mapping[sp.Symbol, sp.Expr]  # sums that a symbol stands for

    def further(self) -> CellEnclosures:
        """Return the same cell with Taylor forms towards removable poles on every box."""
        return self._replace(form=self.form.further())

    def attained(self) -> Ends | None:
        """Return the ends of the values at corners, and nearest to 0, where an extreme often is."""
        nearest = [min(max(Fraction(0), side.lower), side.upper) for side in self.sides]
        ends = [(side.lower, side.upper) for side in self.sides[:MOST_CORNERS]]
        centres = [(side.centre,) for side in self.sides[MOST_CORNERS:]]
        attained = None
        for point in (nearest, *product(*ends, *centres)):
            sides = tuple(side_of(Interval(v, v)) for v in point)
            attained = wider(attained, self.form.look(sides).attained)
        return attained

    def words(self, sides: Iterable[Interval]) -> str:
        """Return a box of the cell in words."""
        named = [self.meanings.get(symbol, symbol) for symbol in self.symbols]
        return ", ".join(f"{s} in {side}" for s, side in zip(named, sides, strict=True))


Part = TypeVar("Part", Sides, PolynomialBox)


def _exact_bounds(spot: tuple[CellEnclosures, PolynomialBox]) -> Bounded:
    cell, box = spot
    if has_pole(box):
        zero = sp.fraction(sp.cancel(cell.expression))[1]
        raise ModelError(
            f"{cell.expression} has a pole at {zero} = 0 inside {cell.words(box.sides)}; take it "
            "out of the box, or choose another premise"
        )
    return look_at_polynomial(box)


def _on(cell: CellEnclosures, halves: tuple[Part, Part]) -> tuple[Any, Any]:
    return (cell, halves[0]), (cell, halves[1])


def checked_symbols(
    expression: sp.Expr, box: Mapping[sp.Symbol, Interval]
) -> tuple[sp.Symbol, ...]:
    # By name, which a dummy symbol keeps when it is written to a file and read again.
    symbols = tuple(sorted(expression.free_symbols, key=lambda symbol: (symbol.name, str(symbol))))
    missing = [str(symbol) for symbol in symbols if symbol not in box]
    if missing:
        raise ModelError(
            f"{expression} depends on {', '.join(missing)}, for which no range was given; give "
            "each range = [low, high] (an interval of the box), or its value as a parameter"
        )
    return symbols


MOST_BOXES = 8000
TOLERANCE = Fraction(1, 10**6)
LOOSE = Fraction(5, 4)  # the width of bounds over what is attained, above which they are retried


def searched(
    expression: sp.Expr,
    cells: Sequence[Cell],
    *,
    tolerance: Fraction = TOLERANCE,
    most_boxes: int = MOST_BOXES,
) -> Range:
    """Return bounds of the expression over a union of cells; see ``expression_range``.

    Where |x| hides what cancels, the cells are searched again on both sides of x = 0.
    """
    plain = [(cell.written(expression), cell) for cell in cells]
    pieces_by_sign = parts_by_sign(expression, cells)
    if [written for written, _ in pieces_by_sign] == [written for written, _ in plain]:
        return _searched(plain, tolerance, most_boxes)
    try:
        bounds: Range | None = _searched(plain, tolerance, most_boxes // 16)
    except ModelError:
        # A pole of the whole may be none on either side; what else is wrong is wrong there too.
        bounds = None
    if bounds is not None and _excess(bounds) <= 2 * tolerance * bounds.inner.width:
        return bounds
    halves = _searched(pieces_by_sign, tolerance, most_boxes)
    return halves if bounds is None or _excess(halves) < _excess(bounds) else bounds


def _excess(bounds: Range) -> Fraction:
    return bounds.outer.width - bounds.inner.width


def _searched(
    pieces: Sequence[tuple[sp.Expr, Cell]], tolerance: Fraction, most_boxes: int
) -> Range:
    with flint.ctx.workprec(PRECISION):
        roots = [cell_root(expression, cell) for expression, cell in pieces]
        polynomials = [root.polynomial for root in roots if root.polynomial is not None]
        try:
            if len(polynomials) == len(roots):
                result = search(
                    _exact_bounds,
                    lambda spot, axis: _on(spot[0], halved_polynomial(spot[1], axis)),
                    list(zip(roots, polynomials, strict=True)),
                    tolerance=tolerance,
                    most_boxes=most_boxes,
                    tell=lambda spot: spot[0].words(spot[1].sides),
                )
                return _range_of(result, "Bernstein form")
            bounds = _in_balls(roots, tolerance, most_boxes)
            wide = bounds.outer.width > LOOSE * bounds.inner.width
            if wide and any(any(root.form.poles()) for root in roots):
                # These forms are several times longer.
                further = _in_balls([root.further() for root in roots], tolerance, most_boxes // 4)
                bounds = min(bounds, further, key=lambda bounds: bounds.outer.width)
            return bounds
        except ModelError as error:
            # Sums are written out where one variable stands for them.
            text = str(error)
            for symbol, base in (pair for root in roots for pair in root.meanings.items()):
                text = text.replace(str(symbol), f"({base})")
            raise type(error)(text) from error


def _in_balls(roots: Sequence[CellEnclosures], tolerance: Fraction, most_boxes: int) -> Range:
    attained = None
    for root in roots:
        attained = wider(attained, root.attained())
    result = search(
        lambda spot: spot[0].form.look(spot[1]),
        lambda spot, axis: _on(spot[0], halved(spot[1], axis)),
        [(root, tuple(map(side_of, root.sides))) for root in roots],
        tolerance=tolerance,
        most_boxes=most_boxes,
        tell=lambda spot: spot[0].words(side.interval() for side in spot[1]),
        refine=lambda spot: spot[0].form.refined(spot[1]),
        attained=attained,
    )
    return _range_of(result, "ball arithmetic")


def _range_of(result: SearchResult, method: str) -> Range:
    outer, inner = (
        Interval(*(e if isinstance(e, Fraction) else fraction_of(e) for e in ends))
        for ends in (result.outer, result.attained)
    )
    words = f"{method}, {result.boxes} box{'' if result.boxes == 1 else 'es'}"
    return Range(outer, inner, result.boxes, words)


MOST_PARTS = 32  # cells that signs make of one


def parts_by_sign(expression: sp.Expr, cells: Sequence[Cell]) -> list[tuple[sp.Expr, Cell]]:
    """Return the cells cut where an |a x + b| or sign(a x + b) is 0, with the expression there.

    The absolute value is a x + b on one side of its zero and -(a x + b) on the other, so that
    (x + |x|)/x is 2 there, or 0.  A sign is 0 at its zero, which is then a cell of its own.
    """
    finished, waiting = [], [(cell.written(expression), cell.box, 1) for cell in cells]
    while waiting:
        written, box, piece_count = waiting.pop(0)
        kink = _kink(written, box) if piece_count <= MOST_PARTS else None
        if kink is None:
            finished.append((written, Cell(box)))
            continue
        argument, symbol, zero = kink
        sides = [(-1, box[symbol].lower, zero), (1, zero, box[symbol].upper)]
        sides += [(0, zero, zero)] if written.has(sp.sign(argument)) else []
        for sign, low, high in sides:
            if low < high or sign == 0 or box[symbol].width == 0:
                half_box = {**box, symbol: Interval(low, high)}
                waiting.append((_with_sign(written, argument, sign), half_box, piece_count * 2))
    return finished


def _kink(
    written: sp.Expr, box: Mapping[sp.Symbol, Interval]
) -> tuple[sp.Expr, sp.Symbol, Fraction] | None:
    """Return the argument of an absolute value or sign, its only symbol, and its zero."""
    for function in sorted(written.atoms(sp.Abs, sp.sign), key=str):
        argument = function.args[0]
        symbols = list(argument.free_symbols)
        linear = linear_terms(argument, symbols) if len(symbols) == 1 else None
        if linear is None or symbols[0] not in box:
            continue
        zero = -linear[1] / linear[0][0][1]
        if box[symbols[0]].contains(zero):
            return argument, symbols[0], zero
    return None


def _with_sign(written: sp.Expr, argument: sp.Expr, sign: int) -> sp.Expr:
    """Return the expression where the argument has this sign; multiplied out if that is shorter."""
    substituted = written.xreplace(
        {sp.Abs(argument): sign * argument, sp.sign(argument): sp.S(sign)}
    )
    return min(substituted, sp.expand(substituted), key=lambda candidate: candidate.count_ops())


def cell_root(expression: sp.Expr, cell: Cell) -> CellEnclosures:
    """Return the expression on the cell.

    Raises
    ------
    ModelError : a symbol without range, a function without ball arithmetic, or an argument that
        leaves its table.
    """
    written, box, meanings = combined(cell.written(expression), cell.box)
    symbols = checked_symbols(written, box)
    sides = tuple(box[symbol] for symbol in symbols)
    polynomial = polynomial_box(written, symbols, sides)
    # The mean of width and magnitude: a range far from 0 matters less, but is not forgotten.
    sizes = tuple(math.sqrt(side.width * side.magnitude) for side in sides)
    positive = _positive(written, dict(zip(symbols, sides, strict=True)))
    form = BallForm(written, symbols, _covered(written, box), sizes=sizes, positive=positive)
    return CellEnclosures(written, symbols, sides, form, polynomial, meanings)


def _positive(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> frozenset[sp.Expr]:
    """Return polynomials under a root that reach 0 on the box, drawn out to 0, and go no lower.

    Rounding would put them below 0 there, where a root has no value.
    """
    zero = Interval(Fraction(0), Fraction(0))
    bases = set()
    for power in expression.atoms(sp.Pow):
        base = power.base
        if power.exp.is_integer or not base.is_polynomial() or base.is_Symbol:
            continue
        symbols = tuple(sorted(base.free_symbols, key=str))
        if not symbols or any(s not in box for s in symbols):
            continue
        exact = polynomial_box(base, symbols, [box[s].hull(zero) for s in symbols])
        ends = None if exact is None else look_at_polynomial(exact).outer
        if ends is not None and 0 <= ends[0] < ends[1] / 10**6:
            bases.add(base)
    return frozenset(bases)


def _covered(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> bool:
    """Return whether there are tables and every argument provably stays strictly inside its own."""
    tables = tables_class()
    calls = set() if tables is None else expression.atoms(tables)
    inside = bool(calls)
    for call in sorted(calls, key=str):
        from takagi.models.splines.table_function import table_ranges

        for argument, covers in zip(call.args, table_ranges(call.table), strict=True):
            argument_bounds = searched(argument, [Cell(box)])
            slack = EDGE * covers.width
            widened = Interval(covers.lower - slack, covers.upper + slack)
            if not widened.contains(argument_bounds.inner):
                raise ModelError(
                    f"an argument of {call}, {argument}, takes values in {argument_bounds.inner}, "
                    f"but the table covers {covers}; shrink the ranges or extend the table"
                )
            inside = inside and covers.contains(argument_bounds.outer)
    return inside
