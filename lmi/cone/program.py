"""What a solver is given and what it gives back: cone data, and numbers with words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from takagi.lmi.cone.assemble import Assembled, Cone
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class SolverRow:
    """coefficients . (x, t) <= bound."""

    coefficients: Floats
    bound: float


@dataclass(frozen=True, slots=True, eq=False)
class ConeProgram:
    """Minimise q . y with b - A y nonnegative in the first ``linear`` rows, then in ``cones``."""

    q: Floats
    A: sp.csc_array
    b: Floats
    linear: int
    cones: tuple[Cone, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Raw:
    """What a solver returned: its name and words, variables y, multipliers z, work done."""

    solver: str
    status: str
    y: Floats
    z: Floats
    iterations: int
    seconds: float


def cone_program(
    assembled: Assembled,
    minimise: Floats,
    rows: tuple[SolverRow, ...],
    *,
    margin: float | None = None,
) -> ConeProgram:
    """Return: minimise over y = (x, t) with rows, and every LMI held with margin t.

    Parameters
    ----------
    margin : None keeps t as the last variable; a number fixes it, then y = x.
    """
    G = assembled.matrix()
    b = assembled.constant
    if margin is None:
        G = sp.hstack([G, -sp.csc_array(assembled.margin_column[:, None])], format="csc")
    else:
        b = b - margin * assembled.margin_column
    if rows:
        extra = sp.csc_array(np.array([row.coefficients for row in rows]))
        A = sp.vstack([extra, -G], format="csc")
    else:
        A = -G
    bounds = np.array([row.bound for row in rows])
    return ConeProgram(minimise, A, np.concatenate([bounds, b]), len(rows), assembled.cones)
