"""A cell: a box, and variables that are functions of the coordinates of the box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

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
