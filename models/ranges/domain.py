"""Where a function is to be enclosed: a box, a band around a curve, a union of cells."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.cell_search import Cell, bounds_on

if TYPE_CHECKING:
    import sympy as sp

DIGITS = 12  # decimals of a range that is rounded outward


@dataclass(frozen=True, slots=True, eq=False)
class Domain:
    """A union of cells.

    Raises
    ------
    ModelError : no cell.
    """

    cells: tuple[Cell, ...]

    def __post_init__(self) -> None:
        if not self.cells:
            raise ModelError("an empty domain was given; at least one cell is needed")

    @classmethod
    def of_box(cls, box: Mapping[sp.Symbol, Interval]) -> Domain:
        """Return the box as a domain."""
        return cls((Cell(box),))

    @classmethod
    def union(cls, boxes: Sequence[Mapping[sp.Symbol, Interval]]) -> Domain:
        """Return the union of boxes over the same symbols, which may touch or overlap."""
        return cls(tuple(Cell(box) for box in boxes))

    @classmethod
    def band(
        cls,
        box: Mapping[sp.Symbol, Interval],
        between: Mapping[sp.Symbol, tuple[sp.Expr, sp.Expr]],
    ) -> Domain:
        """Return {x : lower_i(v) <= x_i <= upper_i(v), v in box}, e.g. a band around a trim curve.

        x_i = lower_i + s_i (upper_i - lower_i) with a share s_i in [0, 1].  An enclosure in
        v and s_i keeps the dependence of x_i on v.

        Parameters
        ----------
        box : ranges of v (and of all else).
        between : variable -> (lower, upper), expressions in the symbols of the box.

        Raises
        ------
        ModelError : a band whose lower edge is not provably below the upper one.
        """
        import sympy as sp

        sides, expressions = dict(box), {}
        for symbol, (lower, upper) in between.items():
            low, high = sp.sympify(lower), sp.sympify(upper)
            # A dummy symbol differs from every symbol of an expression, even with the same name.
            share = sp.Dummy(f"share_{symbol}", real=True)
            sides[share] = Interval.of(0, 1)
            expressions[symbol] = low + share * (high - low)
            _check_order(symbol, high - low, box)
        return cls((Cell(sides, expressions),))

    def __or__(self, other: Domain) -> Domain:
        """Return the union of both."""
        return Domain((*self.cells, *other.cells))

    @property
    def rectangle(self) -> Mapping[sp.Symbol, Interval] | None:
        """The box that the domain is; None for a band or several cells."""
        first, *further = self.cells
        return None if further or first.places else first.box

    def within(self, box: Mapping[sp.Symbol, Interval]) -> Domain:
        """Return the points whose variables that no cell contains lie in the box."""
        return Domain(
            tuple(
                Cell(
                    {**{s: r for s, r in box.items() if s not in cell.places}, **cell.box},
                    expressions,
                )
                for cell in self.cells
                for expressions in [cell.places]
            )
        )

    def moved(self, shifts: Mapping[sp.Symbol, tuple[sp.Symbol, sp.Expr]]) -> Domain:
        """Return the domain in other variables: x -> (d, r) writes x = r + d.

        A range is moved outward where r is not a rational number.
        """
        return Domain(tuple(_moved(cell, shifts) for cell in self.cells))

    def sides(self, symbols: Iterable[sp.Symbol]) -> dict[sp.Symbol, Interval]:
        """Return a range of each symbol that every cell bounds: the smallest box, or little more.

        Raises
        ------
        ModelError : a place that has no finite range.
        """
        sides = {}
        for symbol in symbols:
            cell_sides = [_side(cell, symbol) for cell in self.cells]
            known_sides = [side for side in cell_sides if side is not None]
            if len(known_sides) == len(cell_sides):
                sides[symbol] = Interval(
                    min(k.lower for k in known_sides), max(k.upper for k in known_sides)
                )
        return sides


DomainLike: TypeAlias = "Domain | Mapping[sp.Symbol, Interval]"


def as_domain(domain: Domain | Mapping[sp.Symbol, Interval]) -> Domain:
    """Return a domain; a mapping is the box that it gives."""
    return domain if isinstance(domain, Domain) else Domain.of_box(domain)


def _check_order(symbol: sp.Symbol, width: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> None:
    width_range = bounds_on(width, Cell(box)).outer
    if width_range.lower < 0:
        raise ModelError(
            f"the band of {symbol}: upper minus lower is {width} in {width_range}, which is not "
            "provably >= 0; swap the edges where they cross, or cut the box there"
        )


def _moved(cell: Cell, shifts: Mapping[sp.Symbol, tuple[sp.Symbol, sp.Expr]]) -> Cell:
    deviations = {deviation for s, (deviation, _) in shifts.items() if deviation != s}
    clash = sorted(str(symbol) for symbol in cell.box if symbol in deviations)
    if clash:
        raise ModelError(
            f"a coordinate of the domain is called {', '.join(clash)}, as the deviation of a "
            "variable from its rest is; rename the coordinate"
        )
    written = {s: rest + deviation for s, (deviation, rest) in shifts.items()}
    box = {}
    for symbol, side in cell.box.items():
        deviation, rest = shifts.get(symbol, (symbol, None))
        box[deviation] = side if rest is None else side - value_of(rest)
    moved_places = {}
    for symbol, expression in cell.places.items():
        deviation, rest = shifts.get(symbol, (symbol, 0))
        moved_places[deviation] = expression.subs(written, simultaneous=True) - rest
    return Cell(box, moved_places)


def value_of(number: sp.Expr) -> Interval:
    """Return the number as an interval; one point if it is rational."""
    if number.is_Rational:
        exactly = Fraction(int(number.p), int(number.q))
        return Interval(exactly, exactly)
    return bounds_on(number, Cell({})).outer.outward(DIGITS)


def _side(cell: Cell, symbol: sp.Symbol) -> Interval | None:
    if symbol in cell.box:
        return cell.box[symbol]
    if symbol not in cell.places:
        return None
    return bounds_on(cell.places[symbol], Cell(cell.box)).outer.outward(DIGITS)
