"""One gain for all vertices at a guaranteed cost, in given engineering ranges."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.decide import optimise
from takagi.lmi.gains.cost.condition import lqr_pdc_condition
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel

# Of the least cost: the gain is the best conditioned one that costs no more than this above it.
SLACK = 1e-4


def guaranteed_cost_condition(A: Floats, B: Floats) -> Condition:
    """Return ``lqr_pdc_condition`` with one gain and unit weights.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m), in states and inputs of order one.
    """
    one, inputs = np.eye(A.shape[2]), np.eye(B.shape[2])
    return lqr_pdc_condition(TSModel(A, B), one, inputs, relaxation="common-gain")


def guaranteed_cost_gain(
    A: ArrayLike, B: ArrayLike, *, state_ranges: ArrayLike, input_ranges: ArrayLike
) -> Floats | None:
    """Return K (m, n) for u = -K x, or None where no gain serves all vertices.

    The integral of the squares of states and inputs over their ranges is at most x(0)' P x(0) for
    every blend of the vertices, and its mean over the ellipsoid of the ranges is least, to 1e-4.
    It is ``lqr_pdc`` of the relaxation "common-gain", solved in the ranges themselves, and
    centred a little farther from the least cost: for gains that are made by the dozen.

    Parameters
    ----------
    A : (r, n, n);  B : (r, n, m), one gain for all.
    state_ranges, input_ranges : (n,), (m,) engineering ranges.

    Raises
    ------
    ModelError : shapes, or a range that is not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.1; the ranges are Bryson's
    rule.
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
    outcome = optimise(condition, slack=SLACK)
    if outcome.status != "candidate":
        return None
    M, S = outcome.values["M"][0], outcome.values["S"][0]
    return np.asarray(u[:, None] * np.linalg.solve(S, M.T).T / x, dtype=np.float64)
