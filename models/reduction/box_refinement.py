"""A plant's box cut into cells, each with tighter proved bounds of its premises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.equations.equations import Factored
from takagi.models.equations.equilibrium import EquilibriumOption
from takagi.models.equations.problem import Problem, box_in_fractions, problem_of_plant
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.plant.plant import Plant
from takagi.models.reduction.cell_models import CellModels, ModelCell
from takagi.models.reduction.hull_spread import HullSpread
from takagi.models.sector.assembly import assemble
from takagi.models.sector.choice import Choice, chosen_form
from takagi.models.sector.model import MOST_RULES
from takagi.models.sector.premise_bounds import bounded_premise, check_rule_count
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise

if TYPE_CHECKING:
    import sympy as sp

Box: TypeAlias = "Mapping[sp.Symbol, Interval]"
ROUGH = Fraction(1, 50)  # excess of bounds that only tell where to cut


def refine(
    plant: Plant,
    *,
    cells: int = 8,
    choice: Choice = "fewest-rules",
    premises: Mapping[sp.Symbol, sp.Expr] | None = None,
    rest: EquilibriumOption = "given",
    tolerance: Number = "1e-3",
) -> CellModels:
    """Return a model of the plant for each of many cells of its box, bounds proved cell by cell.

    All cells share one factored form x' = A(z) x + B(z) u + E(z) w; in a cell the premises z move
    less, and premises of the same variable move together, so that the vertices of all cells have a
    smaller hull than those of the whole box.  The cell with the widest hull is halved, across the
    variable for which its quarters are narrowest.  A single premise has nothing
    to move together with: then the hull of all cells is that of the whole box.  For the same reason
    it is a plant that is cut, and not the ranges of a model's premises: the vertices over a part of
    those are convex sums of the whole's, and one P says no more of them.

    Parameters
    ----------
    plant : with ranges for the variables that matter; deviations from its rest values are what the
        cells are boxes of, as in ``sector_model``.
    cells : at most this many; fewer where nothing varies any more.
    choice, premises, rest, tolerance : as in ``sector_model``.

    Returns
    -------
    ``CellModels``, whose docstring says what may be concluded from one P for all cells.

    Raises
    ------
    ModelError : no plant, fewer than 1 cell, or as ``sector_model``.
    """
    if not isinstance(plant, Plant):
        raise ModelError(f"a {type(plant).__name__} was given; only a Plant can be refined")
    if cells < 1:
        raise ModelError(f"{cells} cells were asked for; at least 1 is needed")
    problem = problem_of_plant(plant, premises, rest)
    cutter = _Cutter(problem, chosen_form(problem, choice), exact(tolerance))
    pieces = [cutter.root]
    while len(pieces) < cells:
        widest = max(pieces, key=lambda piece: piece.width)
        halves = cutter.halves(widest)
        if widest.width == 0.0 or not halves:
            break
        pieces.remove(widest)
        pieces += halves
    pieces.sort(key=lambda piece: [side.lower for side in piece.box.values()])
    return CellModels(
        cutter.model(cutter.root),
        tuple(
            ModelCell(
                MappingProxyType({symbol.name: side for symbol, side in piece.box.items()}),
                cutter.model(piece),
                piece.width,
            )
            for piece in pieces
        ),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """A box, rough ranges of the premises on it, and the width of its vertices' hull."""

    box: Box
    ranges: tuple[Interval, ...]
    width: float


class _Cutter:
    def __init__(self, problem: Problem, factored: Factored, tolerance: Fraction) -> None:
        self.problem, self.factored, self.tolerance = problem, factored, tolerance
        self.expressions = list(factored.premises.values())
        check_rule_count(self._premises(problem.box, max(ROUGH, tolerance)), MOST_RULES)
        ranges = tuple(premise.bounds for premise in self._premises(problem.box, tolerance))
        self.spread = HullSpread(factored, ranges)
        self.root = _Piece(problem.box, ranges, self.spread(ranges))
        used = {s for expression in self.expressions for s in expression.free_symbols}
        self.axes = [s for s, side in problem.box.items() if s in used and side.width > 0]

    def halves(self, piece: _Piece) -> list[_Piece]:
        """Return the two halves across the variable that narrows the quarters most."""
        best: list[_Piece] = []
        least = float("inf")
        for axis in self.axes:
            halves = self._halved(piece, axis)
            # One halving of an even function gains nothing, but the next one does.
            quarters = [quarter for half in halves for quarter in self._halved(half, axis)]
            width = sum(quarter.width for quarter in quarters)
            # A tie keeps the first variable, whichever way the last digits fall on a processor.
            if width < least * (1 - 1e-9):
                best, least = halves, width
        return best

    def model(self, piece: _Piece) -> TSModel:
        """Return the model with premises bounded over this piece, proved to the tolerance."""
        problem = replace(self.problem, box=piece.box)
        members = self._premises(piece.box, self.tolerance)
        return assemble(
            problem.equations,
            self.factored,
            members,
            steps=problem.steps,
            names=problem.names,
            box=box_in_fractions(problem),
            sides=problem.box,
            name=problem.name,
            source=problem.source,
        )

    def _halved(self, piece: _Piece, axis: sp.Symbol) -> list[_Piece]:
        side = piece.box[axis]
        halves = []
        for part in (Interval(side.lower, side.centre), Interval(side.centre, side.upper)):
            box = {**piece.box, axis: part}
            ranges = tuple(
                self._range(expression, box, known) if axis in expression.free_symbols else known
                for expression, known in zip(self.expressions, piece.ranges, strict=True)
            )
            halves.append(_Piece(box, ranges, self.spread(ranges)))
        return halves

    def _range(self, expression: sp.Expr, box: Box, known: Interval) -> Interval:
        from takagi.models.ranges.expression_range import expression_range

        return expression_range(expression, box, tolerance=ROUGH).outer.intersect(known)

    def _premises(self, box: Box, tolerance: Fraction) -> list[Premise]:
        problem = replace(self.problem, box=box)
        return [
            bounded_premise(symbol, expression, problem, None, tolerance)
            for symbol, expression in self.factored.premises.items()
        ]
