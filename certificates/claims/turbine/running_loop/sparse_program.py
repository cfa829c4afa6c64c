"""A cone program whose parts are matrices with few entries, and parts that several programs have.

Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sp

from takagi.certificates.claims.turbine.running_loop.cell_program import packed
from takagi.lmi.cone.assemble import Cone
from takagi.lmi.cone.program import ConeProgram
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats, Indices

# The least multiplier, in the program's units.
LEAST = 1e-7


class SparseProgram:
    """sum x_i parts_i <= constant in each cone, and rows of numbers; entries are kept sparse."""

    def __init__(self) -> None:
        self.variables = 0
        self.entries: list[tuple[Indices, Indices, Floats]] = []
        self.constants: list[Floats] = []
        self.cones: list[Cone] = []
        self.rows = 0
        self.linear: list[tuple[dict[int, float], float]] = []

    def variable(self, count: int = 1) -> int:
        """Return the first of new variables."""
        first = self.variables
        self.variables += count
        return first

    def positive(self, count: int) -> int:
        """Add variables that are positive, and return the first."""
        first = self.variable(count)
        for i in range(first, first + count):
            self.at_most({i: -1.0}, -LEAST)
        return first

    def inputs(self, decay: float) -> int:
        """Add the weights of the two inputs, with a sum of 2 alpha at most; return the first."""
        first = self.positive(2)
        self.at_most({first: 1.0, first + 1: 1.0}, 2 * decay)
        return first

    def below(self, parts: Mapping[int, Floats], constant: Floats) -> None:
        """Ask for constant - sum x_i parts_i >= 0, as a matrix."""
        n = len(constant)
        for i, part in parts.items():
            column = packed(part)
            places = np.flatnonzero(column)
            self.entries.append((places + self.rows, np.full(len(places), i), column[places]))
        self.constants.append(packed(constant))
        self.cones.append(Cone(n, 1, self.rows))
        self.rows += n * (n + 1) // 2

    def at_most(self, row: dict[int, float], bound: float) -> None:
        self.linear.append((row, bound))

    def solved(self, objective: Mapping[int, float]) -> Floats | None:
        """Return the least sum of objective_i x_i, or None."""
        count = len(self.linear)
        rows, columns, values = (np.concatenate(part) for part in zip(*self.entries, strict=True))
        extra = [(i, j, x) for i, (row, _) in enumerate(self.linear) for j, x in row.items()]
        rows = np.concatenate([[i for i, _, _ in extra], rows + count])
        columns = np.concatenate([[j for _, j, _ in extra], columns])
        values = np.concatenate([[x for _, _, x in extra], values])
        shape = (count + self.rows, self.variables)
        A = sp.csc_array((values, (rows.astype(int), columns.astype(int))), shape=shape)
        b = np.concatenate([[bound for _, bound in self.linear], *self.constants])
        q = np.zeros(self.variables)
        for i, value in objective.items():
            q[i] = value
        raw = Session().solve(ConeProgram(q, A, b, count, tuple(self.cones)))
        if "Solved" not in raw.status or not np.all(np.isfinite(raw.y)):
            return None
        return np.asarray(raw.y)


def of_function(E: Floats, rates: Floats, shift: float) -> Floats:
    """Return the contribution of P = E, for rates over (xi, inputs, w) and ``shift`` times E."""
    n, size = rates.shape
    found = np.zeros((size, size))
    found[:n] = E @ rates
    found += found.T
    found[:n, :n] += shift * E
    return found


def of_numbers(outer: Floats, inputs: int, tau: int) -> dict[int, Floats]:
    """Return the contributions of the inputs' weights and of the multipliers, by variable.

    Parameters
    ----------
    outer : (k, n + 2 + k), over (xi, inputs, w).
    inputs, tau : the first variable of each.
    """
    k, size = outer.shape
    n = size - 2 - k
    parts = {inputs + i: -_corner(size, n + i) for i in range(2)}
    for i, z in enumerate(outer):
        parts[tau + i] = np.outer(z, z) - _corner(size, n + 2 + i)
    return parts


def _corner(size: int, place: int) -> Floats:
    found = np.zeros((size, size))
    found[place, place] = 1.0
    return found
