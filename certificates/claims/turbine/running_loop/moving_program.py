r"""The least set of the loop in moving wind, and the multipliers of given functions: two programs.

In the loop xi' = A xi + B_u u + B w, z = C xi + D_u u + D w, |u_1| <= r, |u_2| <= 1, with Q = P^-1,
S = diag(1/tau), and G = [B_u; D_u] for the inputs, the claim's inequality for a P that does not
change is, after a congruence,

    [ A Q + Q A' + 2 alpha Q + B S B'    Q C' + B S D' ]          r^2 a          b
    [ (the same)'                        D S D' - S    ]  +  G ( -------- , ----------- ) G'  < 0
                                                                 2 alpha      2 alpha

with 1/a + 1/b <= 1, which is (a - 1)(b - 1) >= 1.  It is affine in Q, S, a and b.  ``least_set``
asks for a larger alpha in the first block, by ``faster``: that is left for the change of P with
the wind.  It can also keep a least width in pitch and in the wake's pitch.  Where torque alone
follows the effort nothing moves these two, and a set without width in them would have to grow
without end up to the wind at which pitch begins.  For given P the claim's inequalities are affine
in tau, alpha and the weights of the inputs: ``multipliers_of`` finds these.
Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from takagi.certificates.checker.turbine.running_loop.equations import ETA
from takagi.certificates.checker.turbine.running_loop.equations import P as PITCH
from takagi.certificates.claims.turbine.running_loop.cell_program import (
    by_function,
    by_multipliers,
    packed,
    unit_matrix,
)
from takagi.lmi.cone.assemble import Cone
from takagi.lmi.cone.program import ConeProgram
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class MovingLoop:
    """One piece of a cell in units of the solver.

    Attributes
    ----------
    rates, outer : (n, n + 2 + k) and (k, n + 2 + k), over (xi, v'/r, residual, w).
    scale : units of the w.
    """

    rates: Floats
    outer: Floats
    scale: Floats


class _Program:
    """A cone program that is made column by column: sum x_i columns_i <= constants in each cone."""

    def __init__(self, variables: int) -> None:
        self.variables = variables
        self.columns: list[list[Floats]] = [[] for _ in range(variables)]
        self.constants: list[Floats] = []
        self.cones: list[Cone] = []
        self.rows = 0

    def below(self, parts: dict[int, Floats], constant: Floats) -> None:
        """Ask for constant - sum x_i parts_i >= 0, as a matrix."""
        n = len(constant)
        blank = np.zeros(n * (n + 1) // 2)
        for i, column in enumerate(self.columns):
            column.append(packed(parts[i]) if i in parts else blank)
        self.constants.append(packed(constant))
        self.cones.append(Cone(n, 1, self.rows))
        self.rows += len(blank)

    def solved(self, objective: Floats, linear: Floats, bounds: Floats) -> Floats | None:
        """Return the least objective'x with linear x <= bounds, or None."""
        A = np.vstack([linear, np.column_stack([np.concatenate(one) for one in self.columns])])
        b = np.concatenate([bounds, *self.constants])
        asked = ConeProgram(objective, sp.csc_array(A), b, len(linear), tuple(self.cones))
        raw = Session().solve(asked)
        if "Solved" not in raw.status or not np.all(np.isfinite(raw.y)):
            return None
        return np.asarray(raw.y)


def least_set(
    loops: Sequence[MovingLoop],
    sides: Floats,
    decay: float,
    faster: float,
    thinnest: float = 0.0,
) -> Floats | None:
    """Return Q of the set that is least by the sum of its squared widths, or None.

    Parameters
    ----------
    sides : rows h over their bounds, in which the widths are measured.
    decay, faster : alpha, and by how much the first block is asked to decay faster [1/s].
    thinnest : the least half width in pitch and in the wake's pitch, in units of the states.
    """
    n = sides.shape[1]
    pairs = [(i, j) for j in range(n) for i in range(j + 1)]
    counts = [len(loop.outer) for loop in loops]
    starts = len(pairs) + np.concatenate([[0], np.cumsum(counts)])
    one, other = int(starts[-1]), int(starts[-1]) + 1
    program = _Program(other + 1)
    basis = [unit_matrix(n, i, j) for i, j in pairs]
    for loop, start in zip(loops, starts[:-1], strict=True):
        parts = dict(enumerate(by_function(loop.rates, loop.outer, basis, decay + faster)))
        parts |= dict(enumerate(by_multipliers(loop.rates, loop.outer), start=int(start)))
        for variable, place in ((one, n), (other, n + 1)):
            along = np.concatenate([loop.rates[:, place], loop.outer[:, place]])
            parts[variable] = np.outer(along, along) / (2 * decay)
        program.below(parts, np.zeros((n + len(loop.outer),) * 2))
    thin = np.zeros(n)
    thin[[PITCH, ETA]] = thinnest**2
    program.below({p: -E for p, E in enumerate(basis)}, -np.diag(thin))
    corner = np.diag([1.0, 0.0]), np.diag([0.0, 1.0])
    program.below({one: -corner[0], other: -corner[1]}, np.array([[-1.0, 1.0], [1.0, -1.0]]))
    widths = np.zeros((len(sides), other + 1))
    for place, E in enumerate(basis):
        widths[:, place] = np.einsum("ri,ij,rj->r", sides, E, sides)
    found = program.solved(widths.sum(axis=0), widths[:0], np.zeros(0))
    if found is None:
        return None
    Q = sum((found[p] * E for p, E in enumerate(basis)), np.zeros((n, n)))
    return Q if np.linalg.eigvalsh(Q).min() > 0 else None


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """What ``multipliers_of`` found: alpha, the residual's share, tau by piece at both ends."""

    decay: float
    residual_share: float
    multipliers: list[tuple[Floats, Floats]]


def multipliers_of(
    loops: Sequence[MovingLoop], ends: tuple[Floats, Floats], drift: Floats
) -> Weights | None:
    """Return weights with which the inequalities hold for both functions and both signs, or None.

    The program is posed in units of the states and of each w in which the mean of the two
    functions is the identity and no z is longer than 1.

    Parameters
    ----------
    ends : P at the two winds, in units of the solver.
    drift : r (P(b) - P(a)) / (b - a).
    """
    n = len(drift)
    T = np.linalg.inv(np.linalg.cholesky((ends[0] + ends[1]) / 2)).T
    loops, scales = zip(*(turned(loop, T) for loop in loops), strict=True)
    ends, drift = (T.T @ ends[0] @ T, T.T @ ends[1] @ T), T.T @ drift @ T
    counts = [len(loop.outer) for loop in loops]
    starts = 3 + 2 * np.concatenate([[0], np.cumsum(counts)])
    least = int(starts[-1])  # Variables: alpha, two weights, tau by piece and end, the margin.
    program = _Program(least + 1)
    for loop, start in zip(loops, starts[:-1], strict=True):
        k = len(loop.outer)
        size = n + 2 + k
        for end, P in enumerate(ends):
            PF = np.zeros((size, size))
            PF[:n] = P @ loop.rates
            for sign in (1.0, -1.0):
                change = np.zeros((size, size))
                change[:n, :n] = sign * drift
                parts = {0: np.zeros((size, size)), 1: _corner(size, n), 2: _corner(size, n + 1)}
                parts[0][:n, :n] = -2 * P
                for i, z in enumerate(loop.outer):
                    parts[int(start) + end * k + i] = _corner(size, n + 2 + i) - np.outer(z, z)
                parts[least] = -np.eye(size)
                program.below({i: -M for i, M in parts.items()}, -(PF + PF.T + change))
    linear = np.zeros((2 + least, least + 1))
    linear[0, :3] = -2.0, 1.0, 1.0
    linear[1, least] = 1.0
    linear[2:, :least] = -np.eye(least)
    bounds = np.concatenate([[0.0, 1.0], np.zeros(least)])
    objective = np.zeros(least + 1)
    objective[least] = -1.0
    found = program.solved(objective, linear, bounds)
    if found is None or found[least] <= 0 or found[:least].min() <= 0:
        return None
    share = float(found[2] / (found[1] + found[2]))
    tau = [
        (found[a : a + k] / scale**2, found[a + k : a + 2 * k] / scale**2)
        for a, k, scale in zip(starts[:-1], counts, scales, strict=True)
    ]
    return Weights(float(found[0]), share, tau)


def _lengths(loop: MovingLoop, T: Floats) -> Floats:
    """Return for each w the length of its z, over the turned states, the inputs and earlier w."""
    n, k = len(T), len(loop.outer)
    found = np.ones(k)
    for i, z in enumerate(loop.outer):
        parts = (z[:n] @ T, z[n : n + 2], z[n + 2 :] * found)
        found[i] = max(float(np.linalg.norm(np.concatenate(parts))), 1e-9)
    return found


def turned(loop: MovingLoop, T: Floats) -> tuple[MovingLoop, Floats]:
    """Return the piece for states T^-1 xi, with no z longer than 1, and the units of its w."""
    scale = _lengths(loop, T)
    n, k = len(T), len(scale)
    W = np.zeros((n + 2 + k,) * 2)
    W[:n, :n], W[n : n + 2, n : n + 2] = T, np.eye(2)
    W[n + 2 :, n + 2 :] = np.diag(scale)
    rates: Floats = np.asarray(np.linalg.solve(T, loop.rates @ W), dtype=np.float64)
    outer: Floats = loop.outer @ W / scale[:, None]
    return MovingLoop(rates, outer, loop.scale), scale


def _corner(size: int, place: int) -> Floats:
    found = np.zeros((size, size))
    found[place, place] = 1.0
    return found
