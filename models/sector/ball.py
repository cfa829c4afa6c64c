"""Rigorous range of a symbolic expression: Bernstein form or ball arithmetic, branch and bound.

Quotients of polynomials with rational coefficients are enclosed exactly in Bernstein form, all
else in ball arithmetic with derivative forms.  See ``enclosure/polynomial`` and
``enclosure/ball_form``; what is said here is which of them is taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

from takagi.models.box_search import Ends, Look, search
from takagi.models.branch_and_bound import Range
from takagi.models.enclosure.domain import Cell, as_domain
from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.enclosure.domain import DomainLike
    from takagi.models.enclosure.evidence import Evidence

__all__ = ["expression_range", "expression_value"]

MOST_BOXES = 8000
MOST_CORNERS = 4  # sides whose ends are all tried as first samples
MOST_SIDES = 36  # letters of a tree that number the sides


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

    from takagi.models.enclosure.ball_form import PRECISION

    with flint.ctx.workprec(PRECISION):
        roots = [_root(expression, cell) for cell in as_domain(domain).cells]
        exact = all(root.polynomial is not None for root in roots)
        places = [(root, root.start(exact)) for root in roots]
        found = search(
            _look,
            _halve,
            places,
            tolerance=tolerance,
            most_boxes=most_boxes,
            tell=lambda place: place[0].told(place[1]),
            refine=None if exact else _refine,
            attained=None if exact else _attained([point for r in roots for point in r.points()]),
        )
    outer, inner = (Interval(*map(_fraction, ends)) for ends in (found.outer, found.attained))
    names = tuple(tuple(map(str, root.symbols)) for root in roots)
    from takagi.models.enclosure.evidence import Evidence

    evidence = Evidence(outer, names, found.trees, PRECISION)
    return Range(outer, inner, found.boxes, evidence)


def expression_value(expression: sp.Expr, point: Mapping[sp.Symbol, float]) -> float:
    """Return the expression at a point, also where a removable singularity sits.

    Raises
    ------
    ModelError : a free symbol without value, or no finite value there.
    """
    import flint

    from takagi.models.enclosure.ball_form import PRECISION
    from takagi.models.enclosure.side import side_of

    exactly = {s: Interval(Fraction(v), Fraction(v)) for s, v in point.items()}
    symbols = _checked_symbols(expression, exactly)
    with flint.ctx.workprec(PRECISION):
        found = _cached_form(expression, symbols).plain(tuple(side_of(exactly[s]) for s in symbols))
    if not found.is_finite():
        raise ModelError(f"{expression} has no finite value at {dict(point)}")
    return float(found.mid())


def replayed_ends(
    evidence: Evidence, expression: sp.Expr, domain: DomainLike
) -> tuple[Fraction, Fraction]:
    """Return the hull of the enclosures on the evidence's leaves; see ``evidence.replay``."""
    import flint

    from takagi.models.enclosure.evidence import leaves_of

    cells = as_domain(domain).cells
    if len(cells) != len(evidence.trees):
        raise ModelError(
            f"evidence for {len(evidence.trees)} cells was given; the domain has {len(cells)}"
        )
    ends: list[tuple[Fraction, Fraction]] = []
    with flint.ctx.workprec(evidence.precision):
        for cell, tree in zip(cells, evidence.trees, strict=True):
            root = _root(expression, cell)
            start = root.start("b" in tree)
            for low, high in leaves_of(
                tree, (root, start), len(root.symbols), _halve, _enclosed_by_letter
            ):
                ends.append((_fraction(low), _fraction(high)))
    return min(low for low, _ in ends), max(high for _, high in ends)


# ------------------------------------------------------------------ places of the search


class _Root(NamedTuple):
    """One cell with the expression in its coordinates, and both ways to enclose it."""

    expression: sp.Expr
    symbols: tuple[sp.Symbol, ...]
    sides: tuple[Interval, ...]
    form: Any  # BallForm
    polynomial: Any  # PolynomialBox; None where the expression is no quotient of polynomials

    def start(self, exact: bool) -> Any:
        """Return the whole cell as a box of the chosen way.

        Raises
        ------
        ModelError : Bernstein form for an expression that has none.
        """
        from takagi.models.enclosure.side import side_of

        if not exact:
            return tuple(map(side_of, self.sides))
        if self.polynomial is None:
            raise ModelError("the expression has no Bernstein form")
        return self.polynomial

    def points(self) -> list[tuple[_Root, Any]]:
        """Return corners, and the point nearest to 0, where an extreme often is."""
        from takagi.models.enclosure.side import side_of

        nearest = [min(max(Fraction(0), side.lower), side.upper) for side in self.sides]
        ends = [(side.lower, side.upper) for side in self.sides[:MOST_CORNERS]]
        rest = [(side.centre,) for side in self.sides[MOST_CORNERS:]]
        return [
            (self, tuple(side_of(Interval(v, v)) for v in point))
            for point in (nearest, *product(*ends, *rest))
        ]

    def told(self, box: Any) -> str:
        sides = box.sides if hasattr(box, "above") else [side.interval() for side in box]
        return ", ".join(f"{s} in {side}" for s, side in zip(self.symbols, sides, strict=True))


def _root(expression: sp.Expr, cell: Cell) -> _Root:
    from takagi.models.enclosure.polynomial import polynomial_box

    written = cell.written(expression)
    symbols = _checked_symbols(written, cell.box)
    if len(symbols) > MOST_SIDES:
        raise ModelError(
            f"the expression depends on {len(symbols)} symbols; at most {MOST_SIDES} can be bounded"
        )
    sides = tuple(cell.box[symbol] for symbol in symbols)
    polynomial = polynomial_box(written, symbols, sides)
    return _Root(written, symbols, sides, _form(written, symbols, cell), polynomial)


def _form(expression: sp.Expr, symbols: tuple[sp.Symbol, ...], cell: Cell) -> Any:
    from takagi.models.enclosure.ball_form import BallForm

    return BallForm(expression, symbols, _covered(expression, cell))


def _look(place: tuple[_Root, Any]) -> Look:
    from takagi.models.enclosure.polynomial import has_pole, look_at_polynomial

    root, box = place
    if not hasattr(box, "above"):
        seen: Look = root.form.look(box)
        return seen
    if has_pole(box):
        import sympy as sp

        zero = sp.fraction(sp.cancel(root.expression))[1]
        raise ModelError(
            f"{root.expression} has a pole at {zero} = 0 inside {root.told(box)}; take it out of "
            "the box, or choose another premise"
        )
    return look_at_polynomial(box)


def _refine(place: tuple[_Root, Any]) -> Look:
    seen: Look = place[0].form.refined(place[1])
    return seen


def _attained(points: Sequence[tuple[_Root, Any]]) -> Ends | None:
    """Return the ends of the values at points, each on the cautious side of its own enclosure."""
    looks = [root.form.look(point).attained for root, point in points]
    known = [ends for ends in looks if ends is not None]
    return (min(e[0] for e in known), max(e[1] for e in known)) if known else None


def _halve(place: tuple[_Root, Any], axis: int) -> tuple[tuple[_Root, Any], tuple[_Root, Any]]:
    from takagi.models.enclosure.balls import halved
    from takagi.models.enclosure.polynomial import halved_polynomial

    root, box = place
    first, second = (halved_polynomial if hasattr(box, "above") else halved)(box, axis)
    return (root, first), (root, second)


def _enclosed_by_letter(letter: str, place: tuple[_Root, Any]) -> tuple[Any, Any] | None:
    from takagi.models.enclosure.polynomial import look_at_polynomial

    root, box = place
    exact = hasattr(box, "above")
    if letter not in ("b" if exact else "ps"):
        raise ModelError(f"a tree of boxes has the letter {letter!r}, which means nothing there")
    if exact:
        return look_at_polynomial(box).outer
    ends: tuple[Any, Any] | None = root.form.by_letter(letter, box)
    return ends


def _covered(expression: sp.Expr, cell: Cell) -> bool:
    """Return whether there are tables and every argument provably stays strictly inside its own.

    Raises
    ------
    ModelError : an argument that takes values outside its table.
    """
    from takagi.models.enclosure.table_balls import EDGE, tables_class

    tables = tables_class()
    calls = set() if tables is None else expression.atoms(tables)
    inside = bool(calls)
    for call in sorted(calls, key=str):
        from takagi.models.plant.table_function import table_ranges

        for argument, covers in zip(call.args, table_ranges(call.table), strict=True):
            found = expression_range(argument, cell.box)
            slack = EDGE * covers.width
            held = Interval(covers.lower - slack, covers.upper + slack)
            if not held.contains(found.inner):
                raise ModelError(
                    f"an argument of {call}, {argument}, takes values in {found.inner}, but the "
                    f"table covers {covers}; shrink the ranges or extend the table"
                )
            inside = inside and covers.contains(found.outer)
    return inside


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
def _cached_form(expression: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> Any:
    from takagi.models.enclosure.ball_form import BallForm

    return BallForm(expression, symbols)


def _fraction(end: Any) -> Fraction:
    """Return an exact ball, or a fraction, as a fraction."""
    from takagi.models.enclosure.table_balls import fraction_of

    return end if isinstance(end, Fraction) else fraction_of(end)
