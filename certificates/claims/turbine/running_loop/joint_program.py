r"""Functions of a chain of cells in moving wind, all at once: a semidefinite program.

For given boxes, alpha and rates of the wind the claim's inequalities are affine in the functions at
the winds between the cells, the multipliers and the weights of the inputs together, and

    h P^-1 h' <= bound^2 / t       <=>       P >= t (h / bound)' (h / bound) .

With t >= 1 the sets fit the box.  ``joint_functions`` finds functions at the winds where none is
given: a cell that has no multipliers with the least sets of its neighbours gets ends that suit it,
and its neighbours keep their rates.  The program is posed in units of the states in which the mean
of the inverses of first functions is the identity; in units of the boxes a solver fails.
Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from takagi.certificates.claims.turbine.running_loop.cell_program import unit_matrix
from takagi.certificates.claims.turbine.running_loop.moving_program import MovingLoop, turned
from takagi.certificates.claims.turbine.running_loop.sparse_program import (
    SparseProgram,
    of_function,
    of_numbers,
)
from takagi.models.arrays import Floats

# Least eigenvalues that the program asks of the inequalities, and the largest t that counts.
ROOM, ENOUGH = 1e-6, 1.05
# How much more the least t counts than the mean of all.
LEAST_COUNTS = 10.0
# The least half width, in units of the states, of the mean of the first sets.
LEAST_WIDTH = 1e-2


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """One cell of a chain, in units of the solver that all its cells have.

    Attributes
    ----------
    loops : its pieces.
    rows : (s, n), the rows of its box over their bounds.
    moved : the wind's rate over the cell's width [1/s].
    decay : alpha [1/s].
    """

    loops: Sequence[MovingLoop]
    rows: Floats
    moved: float
    decay: float


def joint_functions(
    chain: Sequence[Link], known: Mapping[int, Floats], first: Sequence[Floats]
) -> tuple[float, list[Floats]] | None:
    """Return the least t, and P at every end of the chain's cells, or None.

    With t >= 1 the sets fit the boxes.

    Parameters
    ----------
    known : P where it is given, by the place of the end.
    first : one function or more, which decide the units.
    """
    n = chain[0].rows.shape[1]
    mean = sum((np.linalg.inv(P) for P in first), np.zeros((n, n))) / len(first)
    T: Floats = np.asarray(np.linalg.cholesky(mean + LEAST_WIDTH**2 * np.eye(n)), dtype=np.float64)
    basis = [unit_matrix(n, i, j) for j in range(n) for i in range(j + 1)]
    program = SparseProgram()
    sizes, least = program.variable(len(chain)), program.variable()
    at: list[int | Floats] = [
        T.T @ known[end] @ T if end in known else program.variable(len(basis))
        for end in range(len(chain) + 1)
    ]
    for k, link in enumerate(chain):
        program.at_most({sizes + k: 1.0}, ENOUGH)
        program.at_most({least: 1.0, sizes + k: -1.0}, 0.0)
        _box(program, sizes + k, link.rows @ T, at[k : k + 2], basis)
        _inequalities(program, link, T, at[k : k + 2], basis)
    wanted = dict.fromkeys(range(sizes, sizes + len(chain)), -1.0)
    found = program.solved(wanted | {least: -LEAST_COUNTS * len(chain)})
    if found is None:
        return None
    back = np.linalg.inv(T)
    functions = []
    for end, place in enumerate(at):
        if isinstance(place, int):
            P = sum((found[place + i] * E for i, E in enumerate(basis)), np.zeros((n, n)))
            functions.append(back.T @ P @ back)
        else:
            functions.append(known[end])
    return float(found[least]), functions


def _box(
    program: SparseProgram,
    t: int,
    rows: Floats,
    ends: Sequence[int | Floats],
    basis: Sequence[Floats],
) -> None:
    """Ask that the sets at both ends fit the box; a given function may fill it but for t = 1."""
    n = rows.shape[1]
    for place in ends:
        if isinstance(place, int):
            function = {place + i: -E for i, E in enumerate(basis)}
            for h in rows:
                program.below(function | {t: np.outer(h, h)}, np.zeros((n, n)))


def _inequalities(
    program: SparseProgram,
    link: Link,
    T: Floats,
    ends: Sequence[int | Floats],
    basis: Sequence[Floats],
) -> None:
    """Ask for the claim's inequalities at both ends, for both signs of the wind's rate."""
    inputs = program.inputs(link.decay)
    for loop in (turned(one, T)[0] for one in link.loops):
        size = loop.rates.shape[1]
        for which in (0, 1):
            tau = program.positive(len(loop.outer))
            for moved in (link.moved, -link.moved):
                parts, constant = of_numbers(loop.outer, inputs, tau), -ROOM * np.eye(size)
                for side, place in enumerate(ends):
                    weight = float(side == which)
                    shift = 2 * link.decay * weight + moved * (2 * side - 1)
                    if isinstance(place, int):
                        for i, E in enumerate(basis):
                            parts[place + i] = of_function(E, weight * loop.rates, shift)
                    else:
                        constant -= of_function(place, weight * loop.rates, shift)
                program.below(parts, constant)
