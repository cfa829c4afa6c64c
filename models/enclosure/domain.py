"""Where a function is to be enclosed: a box, a band around a curve, a union of cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

__all__ = ["Cell", "Domain", "DomainLike", "as_domain"]


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
        for symbol, place in self.places.items():
            strange = sorted(str(s) for s in place.free_symbols if s not in self.box)
            if strange:
                raise ModelError(
                    f"the place of {symbol}, {place}, depends on {', '.join(strange)}, which the "
                    "box gives no range; add it to the box"
                )

    def written(self, expression: sp.Expr) -> sp.Expr:
        """Return the expression in the symbols of the box."""
        return expression.subs(dict(self.places), simultaneous=True) if self.places else expression


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
        *,
        check: bool = True,
    ) -> Domain:
        """Return {x : lower_i(v) <= x_i <= upper_i(v), v in box}, e.g. a band around a trim curve.

        x_i = lower_i + s_i (upper_i - lower_i) with a share s_i in [0, 1], so that an enclosure
        knows that v and x_i move together.

        Parameters
        ----------
        box : ranges of v (and of all else).
        between : variable -> (lower, upper), expressions in the symbols of the box.
        check : prove lower_i <= upper_i over the box; False takes the caller's word.

        Raises
        ------
        ModelError : a band whose lower edge is not provably below the upper one.
        """
        import sympy as sp

        sides, places = dict(box), {}
        for symbol, (lower, upper) in between.items():
            low, high = sp.sympify(lower), sp.sympify(upper)
            share = sp.Dummy(f"share_{symbol}", real=True)
            sides[share] = Interval.of(0, 1)
            places[symbol] = low + share * (high - low)
            if check:
                _check_order(symbol, high - low, box)
        return cls((Cell(sides, places),))

    def __or__(self, other: Domain) -> Domain:
        """Return the union of both."""
        return Domain((*self.cells, *other.cells))


DomainLike: TypeAlias = "Domain | Mapping[sp.Symbol, Interval]"


def as_domain(domain: Domain | Mapping[sp.Symbol, Interval]) -> Domain:
    """Return a domain; a mapping is the box that it gives."""
    return domain if isinstance(domain, Domain) else Domain.of_box(domain)


def _check_order(symbol: sp.Symbol, width: sp.Expr, box: Mapping[sp.Symbol, Interval]) -> None:
    from takagi.models.sector.ball import expression_range

    found = expression_range(width, box)
    if found.outer.lower < 0:
        raise ModelError(
            f"the band of {symbol}: upper minus lower is {width} in {found.outer}, which is not "
            "provably >= 0; swap the edges where they cross, or cut the box there"
        )
