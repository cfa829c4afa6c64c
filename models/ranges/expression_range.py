"""Rigorous range of a symbolic expression, and its value at a point.

Quotients of polynomials with rational coefficients are enclosed exactly in Bernstein form
(``bernstein_form``).  All other expressions are enclosed in ball arithmetic with derivative forms
(``ball_form``).

Sets on which ranges are sought, and their samples.

Bounds from samples of a function: values between the samples may lie outside the bounds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import flint
import numpy as np
import sympy as sp

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Range
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.ranges.ball_form import PRECISION, BallForm, side_of
from takagi.models.ranges.cell_search import (
    MOST_BOXES,
    TOLERANCE,
    Cell,
    checked_symbols,
    parts_by_sign,
    searched,
)
from takagi.models.ranges.float_value import float_function
from takagi.models.ranges.symbolic_steps import combined

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
        cls, box: Mapping[sp.Symbol, Interval], between: Mapping[sp.Symbol, tuple[sp.Expr, sp.Expr]]
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
        sides, expressions = dict(box), {}
        for symbol, (lower, upper) in between.items():
            low, high = sp.sympify(lower), sp.sympify(upper)
            # A dummy symbol differs from every symbol of an expression, even with the same name.
            share = sp.Dummy(f"share_{symbol}", real=True)
            sides[share] = Interval.of(0, 1)
            expressions[symbol] = low + share * (high - low)
            width = searched(high - low, [Cell(box)]).outer
            if width.lower < 0:
                raise ModelError(
                    f"the band of {symbol}: upper minus lower is {high - low} in {width}, which is "
                    "not provably >= 0; swap the edges where they cross, or cut the box there"
                )
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
    return searched(number, [Cell({})]).outer.outward(DIGITS)


def _side(cell: Cell, symbol: sp.Symbol) -> Interval | None:
    if symbol in cell.box:
        return cell.box[symbol]
    if symbol not in cell.places:
        return None
    return searched(cell.places[symbol], [Cell(cell.box)]).outer.outward(DIGITS)


class SampledBounds(NamedTuple):
    """Smallest and largest sampled value, widened, and words that say so.

    Attributes
    ----------
    bounds : contains every sampled value; values between the samples may lie outside.
    evidence : for ``Premise(evidence=...)``; says "sampled", and that it is not a proof.
    """

    bounds: Interval
    evidence: str


def sampled_bounds(
    expression: sp.Expr,
    domain: DomainLike,
    *,
    points: int = 1000,
    margin: Number = 0,
    seed: int = 0,
) -> SampledBounds:
    """Return [min f, max f] over random points of the domain, widened by a margin.  NO PROOF.

    For functions that cannot be enclosed, and only where a model without proof will do; the
    range that holds is ``expression_range``.

    Parameters
    ----------
    points : in each cell; half of the coordinates lie at ends of their sides.
    margin : added at each end, as a share of the sampled width.
    seed : of the random points.

    Raises
    ------
    ModelError : fewer than two points, a negative margin, a symbol without range, or a value that
        is not a finite number.
    """
    share = exact(margin)
    if points < 2 or share < 0:
        raise ModelError(
            f"{points} points and a margin of {margin} were given; at least 2 points and a "
            "margin >= 0 are needed"
        )
    chance = np.random.default_rng(seed)
    low, high = np.inf, -np.inf
    for cell in as_domain(domain).cells:
        written = cell.written(expression)
        symbols = sorted(written.free_symbols, key=str)
        missing = ", ".join(str(s) for s in symbols if s not in cell.box)
        if missing:
            raise ModelError(f"{expression} depends on {missing}, which has no range; give one")
        samples = _drawn(cell, symbols, points, chance)
        value = float_function(symbols, written)
        with np.errstate(all="ignore"):
            values = np.broadcast_to(np.asarray(value(*samples.T), dtype=np.float64), (points,))
        if not np.all(np.isfinite(values)):
            worst = int(np.argmin(np.isfinite(values)))
            at = ", ".join(f"{s} = {v:.6g}" for s, v in zip(symbols, samples[worst], strict=True))
            raise ModelError(
                f"{expression} has no finite value at {at or 'any point'}; take that point out of "
                "the domain, or write the expression without the singularity"
            )
        low, high = min(low, float(values.min())), max(high, float(values.max()))
    first, last = Fraction(low), Fraction(high)
    wider = share * (last - first)
    total = points * len(as_domain(domain).cells)
    return SampledBounds(
        Interval(first - wider, last + wider),
        f"sampled at {total} random points (seed {seed}), which is no proof",
    )


def moved_into(
    domain: Domain, symbols: Sequence[sp.Symbol], points: Floats, chance: np.random.Generator
) -> Floats:
    """Return points, (k, number of symbols), with the domain's variables moved into its cells.

    Columns of symbols that a cell does not contain stay as they are.
    """
    moved_points = points.copy()
    turns = np.arange(len(points)) % len(domain.cells)
    for number, cell in enumerate(domain.cells):
        rows = np.flatnonzero(turns == number)
        cell_symbols = list(cell.box)
        drawn = _drawn(cell, cell_symbols, len(rows), chance)
        for column, symbol in enumerate(symbols):
            if symbol in cell.box:
                moved_points[rows, column] = drawn[:, cell_symbols.index(symbol)]
            elif symbol in cell.places:
                function = float_function(cell_symbols, cell.places[symbol])
                moved_points[rows, column] = function(*drawn.T)
    return moved_points


def _drawn(
    cell: Cell, symbols: Sequence[sp.Symbol], points: int, chance: np.random.Generator
) -> Floats:
    """Return random points of the cell's box, (points, number of symbols)."""
    shares = chance.random((points, len(symbols)))
    at_ends = chance.random(shares.shape) < 0.5
    # Extremes are more often at the ends than inside.
    shares = np.where(at_ends, np.round(shares), shares)
    ends = np.array([cell.box[s].outward_floats() for s in symbols]).reshape(-1, 2)
    return np.asarray(ends[:, 0] + (ends[:, 1] - ends[:, 0]) * shares)


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
    cells = as_domain(domain).cells
    return searched(expression, cells, tolerance=tolerance, most_boxes=most_boxes)


@dataclass(frozen=True, slots=True, eq=False)
class RangeProof:
    """What proves bounds: the expression is enclosed over the domain, to the tolerance."""

    expression: sp.Expr
    domain: DomainLike
    tolerance: Fraction

    def replay(self, bounds: Interval) -> Interval:
        """Return the enclosure, made again; it lies inside the bounds.

        Raises
        ------
        ModelError : it leaves the bounds, or there is none.
        """
        outer = expression_range(self.expression, self.domain, tolerance=self.tolerance).outer
        if not bounds.contains(outer):
            raise ModelError(
                f"the bounds {bounds} of {self.expression} are not proved: its enclosure is "
                f"{outer}; bound the expression again"
            )
        return outer


def expression_value(
    expression: sp.Expr, point: Mapping[sp.Symbol, float] | Mapping[sp.Symbol, Fraction]
) -> float:
    """Return the expression at a point, also at a removable singularity.

    Where x/|x| jumps it is the value beside the point, on the side where x > 0.

    Raises
    ------
    ModelError : a free symbol without value, or no finite value there.
    """
    sides = {s: Interval(Fraction(v), Fraction(v)) for s, v in point.items()}
    ball = _at(expression, sides)
    if not ball.is_finite():
        # One cell for each sign that what stands in |x| may have there: below and above.
        for written, cell in parts_by_sign(expression, [Cell(sides)]):
            ball = _at(written, cell.box)
    if not ball.is_finite():
        raise ModelError(f"{expression} has no finite value at {dict(point)}")
    return float(ball.mid())


def _at(expression: sp.Expr, sides: Mapping[sp.Symbol, Interval]) -> Any:
    written, exactly, _ = combined(expression, sides)
    symbols = checked_symbols(written, exactly)
    with flint.ctx.workprec(PRECISION):
        return _cached_form(written, symbols).plain(tuple(side_of(exactly[s]) for s in symbols))


_cached_form = lru_cache(maxsize=256)(BallForm)
