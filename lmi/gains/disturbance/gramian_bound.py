r"""A bound on the least H2 norm of one rule from below, by the other of its two programs.

The least mean of |z|^2 is also the least trace of V with

    -He(A X - B L) - E E' >= 0        [ V   C X - D L ]
                                      [ .   X         ]  >= 0,

X the controllability Gramian, L = K X.  Where the infimum is approached by ever larger gains,
these unknowns stay bounded while those of ``output_variance_sums`` do not: the multipliers of this
program are good there.  Its gains are not taken: a design needs the unknowns of the other one.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.assemble import assemble
from takagi.lmi.cone.balance import state_units
from takagi.lmi.cone.duality import least_objective_bound
from takagi.lmi.cone.program import ConeProgram, Raw, cone_program
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.solver.solve import attempts, rescaled
from takagi.models.arrays import Floats

# Solvers that are asked, and how often each is asked again where its own solution is of order one.
SOLVERS, RESCALED = 4, 2


def least_variance(plant: DisturbedPlant, enough: float) -> float:
    """Return the highest bound that any multipliers give, or the first that is enough.

    For one rule in continuous time without a direct path; in the square of z's unit over w's.
    In balanced states and in the plant's own: which are better is not known before.
    """
    best = -np.inf
    n, m = plant.A.shape[1], plant.B.shape[2]
    balanced = state_units(plant.A, None)
    for s in (balanced, np.ones(n)):
        A, B, E, C = (
            plant.A[0] * s / s[:, None],
            plant.B[0] / s[:, None],
            plant.E[0] / s[:, None],
            plant.C[0] * s,
        )
        size = float(np.linalg.norm(C, 2)) or 1.0
        pushed = np.linalg.norm(B, axis=0) / (np.linalg.norm(A, 2) or 1.0)
        shown = np.linalg.norm(plant.D12[0], axis=0) / size
        tau = 1.0 / np.maximum(pushed, shown) if s is balanced else np.ones(m)
        condition = _condition(A, B * tau, E, C / size, plant.D12[0] * tau / size)
        data = assemble(condition)
        program = cone_program(data, data.objective, (), margin=0.0)
        for raw in _answers(program):
            best = max(best, size**2 * least_objective_bound(program, raw))
            if best >= enough:
                return best
    return best


def _answers(program: ConeProgram) -> Iterator[Raw]:
    """Yield one solver's answer after another, the first also in units of its own solution."""
    for number, raw in enumerate(islice(attempts(program), SOLVERS)):
        yield raw
        again: Raw | None = raw
        for _ in range(RESCALED if number == 0 else 0):
            again = None if again is None else rescaled(program, again)
            if again is not None:
                yield again


def _condition(A: Floats, B: Floats, E: Floats, C: Floats, D: Floats) -> Condition:
    n, m, p = len(A), B.shape[1], len(C)
    one, output = np.eye(n)[None], np.eye(p)[None]
    X, L = Unknown("X", n, n, symmetric=True), Unknown("L", m, n)
    V = Unknown("V", p, p, symmetric=True)
    loop = LMI(
        name="Gramian",
        blocks=(n,),
        terms=(
            Term(unknown=X, left=-A[None], right=one, plus_transpose=True),
            Term(unknown=L, left=B[None], right=one, plus_transpose=True),
        ),
        constants=(Constant(value=-(E @ E.T)[None]),),
        strict=False,
    )
    shown = LMI(
        name="output",
        blocks=(p, n),
        terms=(
            Term(unknown=V, left=output, right=output),
            Term(unknown=X, left=C[None], right=one, at=(0, 1)),
            Term(unknown=L, left=-D[None], right=one, at=(0, 1)),
            Term(unknown=X, left=one, right=one, at=(1, 1)),
        ),
        strict=False,
    )
    return Condition(
        name="controllability Gramian",
        unknowns=(X, L, V),
        lmis=(loop, shown),
        objective={"V": output},
    )
