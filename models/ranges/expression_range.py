"""Rigorous ranges of expressions, with evidence that can be replayed.

Evidence of a proved range: the tree of boxes and how each leaf is enclosed.

A tree is text in preorder.  A digit or capital letter is the number of the side that is halved
(0-9, A-Z), followed by the lower and the upper half; a small letter ends a branch:

    p   plain evaluation in ball arithmetic
    s   with slopes: monotone variables at their ends, mean-value form in the others
    q   p, with the Taylor form towards removable poles on every box, not only near them
    t   s, likewise
    b   Bernstein coefficients, exact

Replaying needs no search: one enclosure for each leaf.

Rigorous range of a symbolic expression, or of any function that has an interval enclosure.

Quotients of polynomials with rational coefficients are enclosed exactly in Bernstein form
(``bernstein_form``).  All other expressions are enclosed in ball arithmetic with derivative forms
(``ball_form``).  This module chooses between the two.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import SIDES, Bounded, Ends, search
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.cell_search import (
    MOST_BOXES,
    TOLERANCE,
    Cell,
    cell_root,
    checked_symbols,
    enclosed_by_letter,
    fraction,
    halve,
    parts_by_sign,
    searched,
)
from takagi.models.ranges.domain import Domain, DomainLike, as_domain
from takagi.models.ranges.symbolic_steps import combined

if TYPE_CHECKING:
    import sympy as sp


Node = TypeVar("Node")


def replayed_bounds(
    expression: sp.Expr,
    cells: Sequence[Cell],
    symbols: Sequence[tuple[str, ...]],
    trees: Sequence[str],
    precision: int,
    by_sign: bool = False,
) -> tuple[Fraction, Fraction]:
    """Return the hull of the enclosures on the leaves of all trees; see ``Evidence.replay``."""
    import flint

    pieces_by_sign = (
        parts_by_sign(expression, cells) if by_sign else [(expression, c) for c in cells]
    )
    if not len(pieces_by_sign) == len(trees) == len(symbols):
        raise ModelError(
            f"evidence for {len(trees)} cells was given; the domain has {len(pieces_by_sign)}"
        )
    ends: list[tuple[Fraction, Fraction]] = []
    with flint.ctx.workprec(precision):
        listed = zip(pieces_by_sign, trees, symbols, strict=True)
        for number, (piece_by_sign, tree, names) in enumerate(listed, start=1):
            root = cell_root(*piece_by_sign)
            if root.names != names:
                raise ModelError(
                    f"the trees of cell {number} halve {', '.join(names) or 'nothing'}; the "
                    f"expression has the sides {', '.join(root.names) or 'none'}"
                )
            start = root.start("b" in tree)
            for low, high in leaves_of(
                tree, (root, start), len(root.symbols), halve, enclosed_by_letter
            ):
                ends.append((fraction(low), fraction(high)))
    return min(low for low, _ in ends), max(high for _, high in ends)


def leaves_of(
    tree: str,
    root: Node,
    sides: int,
    halve: Callable[[Node, int], tuple[Node, Node]],
    enclose: Callable[[str, Node], Ends | None],
) -> list[Ends]:
    """Return the enclosure on each leaf of a tree.

    Raises
    ------
    ModelError : a letter that is unknown, a tree that ends early or late, a leaf without bound.
    """
    enclosures, waiting = [], [root]
    for position, letter in enumerate(tree, start=1):
        if not waiting:
            raise ModelError(f"a tree of boxes goes on after its end, at character {position}")
        box = waiting.pop()
        number = SIDES.find(letter)
        if number >= 0:
            if number >= sides:
                raise ModelError(
                    f"a tree of boxes halves side {number} at character {position}; there are "
                    f"{sides} sides"
                )
            waiting += reversed(halve(box, number))
            continue
        ends = enclose(letter, box)
        if ends is None:
            raise ModelError(f"the leaf {letter!r} at character {position} of a tree has no bound")
        enclosures.append(ends)
    if waiting:
        raise ModelError(f"a tree of boxes ends early: {len(waiting)} boxes are missing")
    return enclosures


LONGEST = 100_000  # characters of all trees together that a reader accepts


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Evidence that the values of an expression over a domain lie in ``bounds``.

    Attributes
    ----------
    bounds : the claim, with rational ends.
    expression, domain : what the claim is about.
    symbols : names of the sides in the order in which the trees number them, for each cell.
    trees : one for each cell of the domain.
    by_sign : the cells are those of ``parts_by_sign``.
    precision : bits of the ball arithmetic; Bernstein leaves are exact.
    """

    bounds: Interval
    expression: sp.Expr = field(repr=False)
    domain: Domain = field(repr=False)
    symbols: tuple[tuple[str, ...], ...]
    trees: tuple[str, ...]
    precision: int
    by_sign: bool = False

    def replay(self) -> Interval:
        """Return the hull of the enclosures on the leaves; it lies inside ``bounds``.

        Raises
        ------
        ModelError : a leaf that leaves the bounds or has none (a wrong or foreign evidence), a
            tree that is not well formed or too long, other cells or symbols than the domain's.
        """
        if sum(map(len, self.trees)) > LONGEST:
            raise ModelError(
                f"evidence of {sum(map(len, self.trees))} characters; at most {LONGEST} are read"
            )
        hull = Interval(
            *replayed_bounds(
                self.expression,
                self.domain.cells,
                self.symbols,
                self.trees,
                self.precision,
                self.by_sign,
            )
        )
        if not self.bounds.contains(hull):
            raise ModelError(
                f"the bounds {self.bounds} of {self.expression} are not proved by their evidence: "
                f"its boxes give {hull}; bound the expression again"
            )
        return hull

    def claiming(self, bounds: Interval) -> Evidence:
        """Return the same trees as evidence of other bounds; ``replay`` decides if they hold."""
        return replace(self, bounds=bounds)

    @property
    def boxes(self) -> int:
        """Number of leaves."""
        return sum(letter.islower() for tree in self.trees for letter in tree)

    @property
    def words(self) -> str:
        """Return how the bounds were proved, e.g. ``"ball arithmetic, 12 boxes"``."""
        letters = {letter for tree in self.trees for letter in tree if letter.islower()}
        methods = [
            name
            for name, of in (("Bernstein form", "b"), ("ball arithmetic", "psqt"))
            if letters & set(of)
        ]
        return f"{' and '.join(methods)}, {self.boxes} box{'' if self.boxes == 1 else 'es'}"


def replay(evidence: Evidence, expression: sp.Expr, domain: DomainLike) -> Interval:
    """Return what the evidence gives for that expression over that domain.

    Raises
    ------
    ModelError : as ``Evidence.replay``.
    """
    return replace(evidence, expression=expression, domain=as_domain(domain)).replay()


Box: TypeAlias = tuple[Interval, ...]
Enclose: TypeAlias = Callable[[Box], Interval | None]
Changes: TypeAlias = Callable[[Box], Sequence[float]]


@dataclass(frozen=True, slots=True)
class Range:
    """Outer and inner bounds of the set {f(x) : x in the boxes}.

    Attributes
    ----------
    outer : contains every value of f.
    inner : reaches from one attained value to another; the excess of outer is due to stopping
        early.
    boxes : number of boxes whose enclosures prove ``outer``.
    evidence : what ``replay`` recomputes ``outer`` from without a search; None where the maker
        of the range offers none.
    """

    outer: Interval
    inner: Interval
    boxes: int
    evidence: Evidence | None = field(default=None, repr=False, compare=False)


def range_over(
    enclose: Enclose,
    boxes: Sequence[Box],
    *,
    changes: Changes | None = None,
    tolerance: Fraction = Fraction(1, 1000),
    most_boxes: int = 8000,
) -> Range:
    """Return an enclosure of the range of f over the union of the boxes.

    Parameters
    ----------
    enclose : an interval that contains f over a box, shrinking to f(x) with the box; None where
        it cannot decide.  A box of zero width is a point.
    changes : how much f may change along each side of a box, roughly; the side with the largest
        change is halved.  None takes the sides of the first box as equally important.
    tolerance : excess allowed at each end, as a share of the width of the range.
    most_boxes : when it is reached the bounds are valid and less tight.

    Raises
    ------
    ModelError : no box, or ``enclose`` cannot decide even on tiny boxes (a pole).
    """
    if not boxes:
        raise ModelError("no box was given; a range needs at least one")
    result = search(
        partial(_look, enclose, changes or partial(_shares, boxes[0])),
        _halves,
        boxes,
        tolerance=tolerance,
        most_boxes=most_boxes,
        tell=lambda box: ", ".join(str(side) for side in box),
        attained=_attained(enclose, [point for box in boxes for point in _diagonal(box)]),
    )
    return Range(Interval(*result.outer), Interval(*result.attained), result.boxes)


def _look(enclose: Enclose, changes: Changes, box: Box) -> Bounded:
    attained = _attained(enclose, [tuple(Interval(side.centre, side.centre) for side in box)])
    outer = enclose(box)
    size = changes(box)
    axis = max(range(len(box)), key=lambda index: (size[index], box[index].width), default=None)
    if axis is not None and box[axis].width == 0:
        axis = None
    return Bounded(None if outer is None else (outer.lower, outer.upper), attained, axis)


def _halves(box: Box, axis: int) -> tuple[Box, Box]:
    middle = box[axis].centre
    half_sides = Interval(box[axis].lower, middle), Interval(middle, box[axis].upper)
    first, second = ((*box[:axis], half_side, *box[axis + 1 :]) for half_side in half_sides)
    return first, second


def _attained(enclose: Enclose, points: Sequence[Box]) -> Ends | None:
    """Return the ends of values at points, each on the cautious side of its own enclosure."""
    values = [value for point in points if (value := enclose(point)) is not None]
    return (min(v.upper for v in values), max(v.lower for v in values)) if values else None


def _diagonal(box: Box) -> tuple[Box, Box]:
    """Return the two ends of the box's diagonal."""
    lower = tuple(Interval(side.lower, side.lower) for side in box)
    upper = tuple(Interval(side.upper, side.upper) for side in box)
    return lower, upper


def _shares(root: Box, box: Box) -> list[float]:
    """Return each side's width as a share of the whole's."""
    return [float(b.width / w.width) if w.width else 0.0 for b, w in zip(box, root, strict=True)]


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
    from takagi.models.ranges.ball_form import PRECISION

    over = as_domain(domain)
    bounds = searched(expression, over.cells, tolerance=tolerance, most_boxes=most_boxes)
    evidence = Evidence(
        bounds.outer, expression, over, bounds.names, bounds.trees, PRECISION, bounds.by_sign
    )
    return Range(bounds.outer, bounds.inner, bounds.boxes, evidence)


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
    import flint

    from takagi.models.ranges.ball_form import PRECISION
    from takagi.models.ranges.ball_operations import side_of

    written, exactly, _ = combined(expression, sides)
    symbols = checked_symbols(written, exactly)
    with flint.ctx.workprec(PRECISION):
        return _cached_form(written, symbols).plain(tuple(side_of(exactly[s]) for s in symbols))


@lru_cache(maxsize=256)
def _cached_form(expression: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> Any:
    from takagi.models.ranges.ball_form import BallForm

    return BallForm(expression, symbols)
