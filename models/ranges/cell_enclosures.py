"""A cell as the search for a range sees it: an expression on a box, and its enclosures there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Bounded, Ends
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    import sympy as sp

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
        from takagi.models.ranges.box_side import side_of

        if not exact:
            return tuple(map(side_of, self.sides))
        if self.polynomial is None:
            raise ModelError("the expression has no Bernstein form")
        return self.polynomial

    def further(self) -> CellEnclosures:
        """Return the same cell with Taylor forms towards removable poles on every box."""
        return self._replace(form=self.form.further())

    def points(self) -> list[Place]:
        """Return corners, and the point nearest to 0, where an extreme often is."""
        from takagi.models.ranges.box_side import side_of

        nearest = [min(max(Fraction(0), side.lower), side.upper) for side in self.sides]
        ends = [(side.lower, side.upper) for side in self.sides[:MOST_CORNERS]]
        rest = [(side.centre,) for side in self.sides[MOST_CORNERS:]]
        return [
            (self, tuple(side_of(Interval(v, v)) for v in point))
            for point in (nearest, *product(*ends, *rest))
        ]

    def told(self, box: Any) -> str:
        sides = box.sides if hasattr(box, "above") else [side.interval() for side in box]
        named = [self.meanings.get(symbol, symbol) for symbol in self.symbols]
        return ", ".join(f"{s} in {side}" for s, side in zip(named, sides, strict=True))


Place: TypeAlias = tuple[CellEnclosures, Any]  # with a box: Sides, or a PolynomialBox


def enclose(place: Place) -> Bounded:
    """Return the cheap enclosure on a place; see ``search``."""
    from takagi.models.ranges.bernstein_form import has_pole, look_at_polynomial

    root, box = place
    if not hasattr(box, "above"):
        seen: Bounded = root.form.look(box)
        return seen
    if has_pole(box):
        import sympy as sp

        zero = sp.fraction(sp.cancel(root.expression))[1]
        raise ModelError(
            f"{root.expression} has a pole at {zero} = 0 inside {root.told(box)}; take it out of "
            "the box, or choose another premise"
        )
    return look_at_polynomial(box)


def refined(place: Place) -> Bounded:
    """Return the tight enclosure on a place of balls."""
    seen: Bounded = place[0].form.refined(place[1])
    return seen


def attained_at_points(points: Sequence[Place]) -> Ends | None:
    """Return the ends of the values at points, each on the cautious side of its own enclosure."""
    looks = [root.form.look(point).attained for root, point in points]
    known = [ends for ends in looks if ends is not None]
    return (min(e[0] for e in known), max(e[1] for e in known)) if known else None


def halve(place: Place, axis: int) -> tuple[Place, Place]:
    """Return both halves of a place along one side."""
    from takagi.models.ranges.ball_operations import halved
    from takagi.models.ranges.bernstein_form import halved_polynomial

    root, box = place
    first, second = (halved_polynomial if hasattr(box, "above") else halved)(box, axis)
    return (root, first), (root, second)


def enclosed_by_letter(letter: str, place: Place) -> tuple[Any, Any] | None:
    """Return the enclosure that a leaf's letter names; None where it cannot decide."""
    from takagi.models.ranges.bernstein_form import look_at_polynomial

    root, box = place
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
