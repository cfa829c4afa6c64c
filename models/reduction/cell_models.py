"""One model for each cell of a plant's box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.ts.model import TSModel


@dataclass(frozen=True, slots=True, eq=False)
class ModelCell:
    """A closed box and the model that equals the plant on it.

    Attributes
    ----------
    sides : variable -> its range, in the variables that the model's premises are evaluated at.
    model : with premises bounded over this cell alone.
    width : mean width of the hull of the vertices, as a share of the whole box's; approximate.
    """

    sides: Mapping[str, Interval]
    model: TSModel
    width: float

    def contains(self, **point: float) -> bool:
        """Return whether the point lies in the cell or on its boundary; other names are ignored."""
        return all(side.contains(exact(point[name])) for name, side in self.sides.items())


@dataclass(frozen=True, slots=True, eq=False)
class CellModels:
    """Closed cells that cover a box, each with its own model of the same plant.

    The plant's x' lies, at a point of cell c, in the hull of that cell's vertices.  Hence a claim
    that is affine in the vertices and uses one function V = x' P x for all of them, such as
    A_i' P + P A_i + 2 alpha P <= 0 at every vertex of every cell (``union()``), holds along every
    solution that stays in the whole box: each x' is in one of the hulls, and V does not care which.
    V itself has no jumps.  The decay holds for solutions that start in a level set of V inside the
    box, for these cannot leave it.

    A law may use gains of its own in each cell, u = -sum_i h_i(x) K_i x with the memberships of a
    cell that x lies in; rules of different cells then never act together (``overlap``).  It may
    jump where cells meet.  There x' of a sliding motion is a convex sum of what the cells' laws
    give at that point, and V' is affine in x', so that the decay holds for it too.

    Not allowed: a P of its own for each cell, without more; V would jump where cells meet.

    Attributes
    ----------
    whole : the model of the whole box, in the same form.
    cells : in the order in which they lie in the box, first variable first.
    """

    whole: TSModel
    cells: tuple[ModelCell, ...]

    def index_at(self, **point: float) -> int:
        """Return the number of the first cell that contains the point.

        Raises
        ------
        ModelError : a variable is missing, or the point lies outside the box.
        """
        sides = self.cells[0].sides
        missing = [name for name in sides if name not in point]
        if missing:
            raise ModelError(
                f"{', '.join(missing)} missing; give each of {', '.join(sides)} a value"
            )
        for index, cell in enumerate(self.cells):
            if cell.contains(**point):
                return index
        told = ", ".join(f"{name} = {point[name]:.9g}" for name in sides)
        raise ModelError(
            f"{told} lies in none of the {len(self.cells)} cells; stay inside the box of model "
            f"{self.whole.name!r}, or refine a larger one"
        )

    def model_at(self, **point: float) -> TSModel:
        """Return the model of the first cell that contains the point; raises as ``index_at``."""
        return self.cells[self.index_at(**point)].model

    def memberships(self, **point: float) -> Floats:
        """Return the weights of the rules of ``union()``: those of one cell, and 0 elsewhere."""
        chosen = self.index_at(**point)
        found = np.zeros(self._ends[-1])
        model = self.cells[chosen].model
        values = model.premise_values(**point)
        weights = model.memberships(values) if model.premises else np.ones(1)
        found[self._ends[chosen] : self._ends[chosen + 1]] = weights
        return found

    def union(self) -> TSModel:
        """Return the vertices of all cells, cell by cell, as one model without premises."""
        models = [cell.model for cell in self.cells]
        stacks = {
            letter: np.concatenate([getattr(model, letter) for model in models])
            for letter in ("A", "B", "C", "D", "E")
        }
        whole = self.whole
        return TSModel(
            stacks["A"],
            stacks["B"],
            C=stacks["C"],
            D=stacks["D"],
            E=stacks["E"],
            states=whole.states,
            inputs=whole.inputs,
            outputs=whole.outputs,
            disturbances=whole.disturbances,
            box=whole.box,
            sample_time=whole.sample_time,
            name=whole.name,
            source=whole.source,
        )

    @property
    def overlap(self) -> Floats:
        """Return bounds on h_i h_j for the rules of ``union()``: 0 across cells, inf within one.

        ``takagi.lmi.pdc(cells.union(), overlap=cells.overlap)`` designs gains for each cell, with
        one P.
        """
        found = np.zeros((self._ends[-1],) * 2)
        for first, last in zip(self._ends[:-1], self._ends[1:], strict=True):
            found[first:last, first:last] = np.inf
        return found

    @property
    def _ends(self) -> tuple[int, ...]:
        counts = [len(cell.model.rules) for cell in self.cells]
        return (0, *(int(end) for end in np.cumsum(counts)))
