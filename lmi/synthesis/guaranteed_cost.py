r"""Guaranteed quadratic cost: one gain for all vertices, from an LMI.

With Y = P^-1, M = K Y, u = -K x and weights of one over the squares of the given ranges,

    [ He(A_i Y - B_i M)   Y    M' ]
    [ Y                  -I    0  ]  < 0,     [[W, I], [I, Y]] >= 0,     trace W least,
    [ M                   0   -I  ]

in states and inputs divided by their ranges, so that the integral of |x|^2 + |u|^2 is at most
x(0)' P x(0) for every blend of the vertices, and its mean over the unit sphere is least.  With a
gain for each rule: ``regulator``.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.1; the ranges are Bryson's rule.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.solver.stages import optimise
from takagi.lmi.term import LMI, Condition, Constant, Term, Unknown
from takagi.models.errors import ModelError

__all__ = ["guaranteed_cost_condition", "guaranteed_cost_gain"]

Floats = NDArray[np.float64]


def guaranteed_cost_condition(A: Floats, B: Floats) -> Condition:
    """Pose the module's LMIs for vertices in states and inputs of order one.

    Parameters
    ----------
    A : (r, n, n);  B : (r, n, m).
    """
    r, n, m = B.shape
    Y = Unknown("Y", n, n, symmetric=True)
    M = Unknown("M", m, n)
    W = Unknown("W", n, n, symmetric=True)
    one, inputs = np.eye(n)[None], np.eye(m)[None]
    cost = LMI(
        name="guaranteed cost",
        blocks=(n, n, m),
        terms=(
            Term(unknown=Y, left=A, right=one, plus_transpose=True, latex=("A_{i}", "")),
            Term(unknown=M, left=-B, right=one, plus_transpose=True, latex=("-B_{i}", "")),
            Term(unknown=Y, left=one, right=one, at=(0, 1)),
            Term(unknown=M, left=inputs, right=one, at=(2, 0)),
        ),
        constants=(
            Constant(value=-one, at=(1, 1), latex="-I"),
            Constant(value=-inputs, at=(2, 2), latex="-I"),
        ),
        sign=-1,
        count=r,
        index=rf"i = 1, \dots, {r}",
    )
    bound = LMI(
        name="bound of the cost",
        blocks=(n, n),
        terms=(
            Term(unknown=W, left=one, right=one),
            Term(unknown=Y, left=one, right=one, at=(1, 1)),
        ),
        constants=(Constant(value=one, at=(0, 1), latex="I"),),
    )
    return Condition(
        name="guaranteed quadratic cost",
        unknowns=(Y, M, W),
        lmis=(cost, bound),
        objective={"W": one},
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.1",
    )


def guaranteed_cost_gain(
    A: ArrayLike, B: ArrayLike, *, state_ranges: ArrayLike, input_ranges: ArrayLike
) -> Floats | None:
    """Return K (m, n) for u = -K x, or None where no gain serves all vertices.

    Parameters
    ----------
    A : (r, n, n);  B : (r, n, m), one gain for all.
    state_ranges, input_ranges : (n,), (m,) engineering ranges; the cost is the sum of squares of
        states and inputs over these.

    Raises
    ------
    ModelError : shapes, or a range that is not positive.
    """
    vertices, inputs = np.asarray(A, dtype=np.float64), np.asarray(B, dtype=np.float64)
    x, u = np.asarray(state_ranges, dtype=np.float64), np.asarray(input_ranges, dtype=np.float64)
    if vertices.ndim != 3 or inputs.shape[:2] != vertices.shape[:2]:
        raise ModelError(
            f"A {vertices.shape} and B {inputs.shape} were given; (r, n, n) and (r, n, m) are "
            "needed"
        )
    if x.shape != vertices.shape[2:] or u.shape != inputs.shape[2:] or min(x.min(), u.min()) <= 0:
        raise ModelError("one positive range per state and per input is needed")
    condition = guaranteed_cost_condition(vertices * x / x[:, None], inputs * u / x[:, None])
    outcome = optimise(condition, slack=1e-4)
    # Without an objective the solver failed and the centre is feasible at any cost.
    if outcome.status != "candidate" or not np.isfinite(outcome.objective):
        return None
    M, Y = outcome.values["M"][0], outcome.values["Y"][0]
    return np.asarray(u[:, None] * np.linalg.solve(Y, M.T).T / x, dtype=np.float64)
