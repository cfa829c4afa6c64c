"""The range of an expression over cells, searched for by branch and bound.

An argument of a table has to stay inside the table, so a cell whose expression has tables is
searched for the ranges of their arguments first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Bounded, Ends, search
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.symbolic_steps import combined, linear_terms

if TYPE_CHECKING:
    import sympy as sp


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
    form: Any  # BallForm
    polynomial: Any  # PolynomialBox; None where the expression is no quotient of polynomials
    meanings: Mapping[sp.Symbol, sp.Expr]  # sums that a symbol stands for

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(symbol.name for symbol in self.symbols)

    def start(self, exact: bool) -> Any:
        """Return the whole cell as a box of the chosen way.

        Raises
        ------
        ModelError : Bernstein form for an expression that has none.
        """
        from takagi.models.ranges.ball_operations import side_of

        if not exact:
            return tuple(map(side_of, self.sides))
        if self.polynomial is None:
            raise ModelError("the expression has no Bernstein form")
        return self.polynomial

    def further(self) -> CellEnclosures:
        """Return the same cell with Taylor forms towards removable poles on every box."""
        return self._replace(form=self.form.further())

    def points(self) -> list[CellBox]:
        """Return corners, and the point nearest to 0, where an extreme often is."""
        from takagi.models.ranges.ball_operations import side_of

        nearest = [min(max(Fraction(0), side.lower), side.upper) for side in self.sides]
        ends = [(side.lower, side.upper) for side in self.sides[:MOST_CORNERS]]
        centres = [(side.centre,) for side in self.sides[MOST_CORNERS:]]
        return [
            (self, tuple(side_of(Interval(v, v)) for v in point))
            for point in (nearest, *product(*ends, *centres))
        ]

    def told(self, box: Any) -> str:
        sides = box.sides if hasattr(box, "above") else [side.interval() for side in box]
        named = [self.meanings.get(symbol, symbol) for symbol in self.symbols]
        return ", ".join(f"{s} in {side}" for s, side in zip(named, sides, strict=True))


CellBox: TypeAlias = tuple[CellEnclosures, Any]  # with a box: Sides, or a PolynomialBox


def enclose(spot: CellBox) -> Bounded:
    """Return the cheap enclosure on a place; see ``search``."""
    from takagi.models.ranges.bernstein_form import has_pole, look_at_polynomial

    root, box = spot
    if not hasattr(box, "above"):
        bounds: Bounded = root.form.look(box)
        return bounds
    if has_pole(box):
        import sympy as sp

        zero = sp.fraction(sp.cancel(root.expression))[1]
        raise ModelError(
            f"{root.expression} has a pole at {zero} = 0 inside {root.told(box)}; take it out of "
            "the box, or choose another premise"
        )
    return look_at_polynomial(box)


def refined(spot: CellBox) -> Bounded:
    """Return the tight enclosure on a place of balls."""
    bounds: Bounded = spot[0].form.refined(spot[1])
    return bounds


def attained_at_points(points: Sequence[CellBox]) -> Ends | None:
    """Return the ends of the values at points, each on the cautious side of its own enclosure."""
    attained = [root.form.look(point).attained for root, point in points]
    ends_known = [ends for ends in attained if ends is not None]
    return (min(e[0] for e in ends_known), max(e[1] for e in ends_known)) if ends_known else None


def halve(spot: CellBox, axis: int) -> tuple[CellBox, CellBox]:
    """Return both halves of a place along one side."""
    from takagi.models.ranges.ball_operations import halved
    from takagi.models.ranges.bernstein_form import halved_polynomial

    root, box = spot
    first, second = (halved_polynomial if hasattr(box, "above") else halved)(box, axis)
    return (root, first), (root, second)


def enclosed_by_letter(letter: str, spot: CellBox) -> tuple[Any, Any] | None:
    """Return the enclosure that a leaf's letter names; None where it cannot decide."""
    from takagi.models.ranges.bernstein_form import look_at_polynomial

    root, box = spot
    exact = hasattr(box, "above")
    if letter not in ("b" if exact else "psqt"):
        raise ModelError(f"a tree of boxes has the letter {letter!r}, which means nothing there")
    if exact:
        return look_at_polynomial(box).outer
    ends: tuple[Any, Any] | None = root.form.by_letter(letter, box)
    return ends


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
MOST_SIDES = 36  # letters of a tree that number the sides


class Bounds(NamedTuple):
    """Bounds of the values, with the trees of boxes that prove ``outer``; see ``Range``.

    ``names`` are those of the sides of each cell, in the order in which the trees number them;
    with ``by_sign`` of each cell of ``parts_by_sign``.
    """

    outer: Interval
    inner: Interval
    boxes: int
    names: tuple[tuple[str, ...], ...]
    trees: tuple[str, ...]
    by_sign: bool = False


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
    """Return bounds of the expression over a union of cells; see ``expression_range``.

    Where |x| hides what cancels, the cells are searched again on both sides of x = 0.
    """
    plain = [(cell.written(expression), cell) for cell in cells]
    pieces_by_sign = parts_by_sign(expression, cells)
    if [written for written, _ in pieces_by_sign] == [written for written, _ in plain]:
        return _searched(plain, tolerance, most_boxes)
    try:
        bounds: Bounds | None = _searched(plain, tolerance, most_boxes // 16)
    except ModelError:
        # A pole of the whole may be none on either side; what else is wrong is wrong there too.
        bounds = None
    if bounds is not None and _excess(bounds) <= 2 * tolerance * bounds.inner.width:
        return bounds
    halves = _searched(pieces_by_sign, tolerance, most_boxes)._replace(by_sign=True)
    return halves if bounds is None or _excess(halves) < _excess(bounds) else bounds


def _excess(bounds: Bounds) -> Fraction:
    return bounds.outer.width - bounds.inner.width


def _searched(
    pieces_by_sign: Sequence[tuple[sp.Expr, Cell]], tolerance: Fraction, most_boxes: int
) -> Bounds:
    import flint

    from takagi.models.ranges.ball_form import PRECISION

    with flint.ctx.workprec(PRECISION):
        roots = [cell_root(expression, cell) for expression, cell in pieces_by_sign]
        exact = all(root.polynomial is not None for root in roots)

        def bounds_of(roots: Sequence[CellEnclosures], most_boxes: int) -> Bounds:
            points = [] if exact else [point for root in roots for point in root.points()]
            best_bounds = search(
                enclose,
                halve,
                [(root, root.start(exact)) for root in roots],
                tolerance=tolerance,
                most_boxes=most_boxes,
                tell=lambda spot: spot[0].told(spot[1]),
                refine=None if exact else refined,
                attained=None if exact else attained_at_points(points),
            )
            outer, inner = (
                Interval(*map(fraction, ends)) for ends in (best_bounds.outer, best_bounds.attained)
            )
            names = tuple(root.names for root in roots)
            return Bounds(outer, inner, best_bounds.boxes, names, best_bounds.trees)

        try:
            best_bounds = bounds_of(roots, most_boxes)
            wide = best_bounds.outer.width > LOOSE * best_bounds.inner.width
            if wide and not exact and any(any(root.form.poles()) for root in roots):
                # These forms are several times longer.
                further = bounds_of([root.further() for root in roots], most_boxes // 4)
                best_bounds = min(best_bounds, further, key=lambda bounds: bounds.outer.width)
        except ModelError as error:
            raise _without_combinations(error, roots) from error
    return best_bounds


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
        sides += [(0, zero, zero)] if written.has(_sign(argument)) else []
        for sign, low, high in sides:
            if low < high or sign == 0 or box[symbol].width == 0:
                half_box = {**box, symbol: Interval(low, high)}
                waiting.append((_with_sign(written, argument, sign), half_box, piece_count * 2))
    return finished


def _kink(
    written: sp.Expr, box: Mapping[sp.Symbol, Interval]
) -> tuple[sp.Expr, sp.Symbol, Fraction] | None:
    """Return the argument of an absolute value or sign, its only symbol, and its zero."""
    import sympy as sp

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


def _sign(argument: sp.Expr) -> sp.Expr:
    import sympy as sp

    return sp.sign(argument)


def _with_sign(written: sp.Expr, argument: sp.Expr, sign: int) -> sp.Expr:
    """Return the expression where the argument has this sign; multiplied out if that is shorter."""
    import sympy as sp

    substituted = written.xreplace(
        {sp.Abs(argument): sign * argument, sp.sign(argument): sp.S(sign)}
    )
    return min(substituted, sp.expand(substituted), key=lambda candidate: candidate.count_ops())


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
    # The mean of width and magnitude: a range far from 0 matters less, but is not forgotten.
    sizes = tuple(math.sqrt(side.width * side.magnitude) for side in sides)
    positive = _positive(written, dict(zip(symbols, sides, strict=True)))
    form = BallForm(written, symbols, _covered(written, box), sizes=sizes, positive=positive)
    return CellEnclosures(written, symbols, sides, form, polynomial, meanings)


def _positive(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> frozenset[sp.Expr]:
    """Return polynomials under a root that reach 0 on the box, drawn out to 0, and go no lower.

    Rounding would put them below 0 there, where a root has no value.
    """
    import sympy as sp

    from takagi.models.ranges.bernstein_form import look_at_polynomial, polynomial_box

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


def fraction(end: Any) -> Fraction:
    """Return an exact ball, or a fraction, as a fraction."""
    from takagi.models.ranges.tape import fraction_of

    return end if isinstance(end, Fraction) else fraction_of(end)


def _covered(expression: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> bool:
    """Return whether there are tables and every argument provably stays strictly inside its own.

    Raises
    ------
    ModelError : an argument that takes values outside its table.
    """
    from takagi.models.ranges.tape import EDGE, tables_class

    tables = tables_class()
    calls = set() if tables is None else expression.atoms(tables)
    inside = bool(calls)
    for call in sorted(calls, key=str):
        from takagi.models.splines.table_function import table_ranges

        for argument, covers in zip(call.args, table_ranges(call.table), strict=True):
            argument_bounds = bounds_on(argument, Cell(box))
            slack = EDGE * covers.width
            widened = Interval(covers.lower - slack, covers.upper + slack)
            if not widened.contains(argument_bounds.inner):
                raise ModelError(
                    f"an argument of {call}, {argument}, takes values in {argument_bounds.inner}, "
                    f"but the table covers {covers}; shrink the ranges or extend the table"
                )
            inside = inside and covers.contains(argument_bounds.outer)
    return inside


def _without_combinations(error: ModelError, roots: Sequence[CellEnclosures]) -> ModelError:
    """Return the error with sums written out where one variable stands for them."""
    text = str(error)
    for root in roots:
        for symbol, base in root.meanings.items():
            text = text.replace(str(symbol), f"({base})")
    return type(error)(text)
