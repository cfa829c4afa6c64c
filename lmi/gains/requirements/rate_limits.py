r"""Limits on how fast the inputs move, on the ellipsoid {x' P x <= 1}: two ways to ask for them.

State feedback, a convex sufficient condition.  Let |x'| <= nu |x| in the norm of P,

    G_ij' P G_ij <= nu^2 P  for every blend:   [ -nu Q   G_ij Q ]
                                               [ *       -nu Q  ]  summed,  a disc of radius nu,

and |K_j x|_k <= b_k on the ellipsoid.  Then u' = -K(h) x' - sum_j h_j' K_j x has

    |u_k'| <= b_k (nu + sum_j phi_j),     |h_j'| <= phi_j,

so b = limit / (nu + sum_j phi_j) is enough.  In discrete time the disc is about 1, |x+ - x| <= nu
|x|, and |u_k(x+) - u_k(x)| <= b_k (nu + 2), or b_k nu with one gain for all rules.  The speed nu is
free, and enters nonlinearly: try several.  What a design then keeps is told without that detour by
``input_rate_bound``.

The input as a state, exact.  With u' = v (or u+ = u + v) a state of the model, limits on u are
limits on states, limits on v are input limits, and nothing is lost; the law is dynamic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import input_stack, number, positive_vector, vertex_stack
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.term import LMI, Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.requirements.limits import input_lmis
from takagi.lmi.gains.requirements.region_sums import region_sums
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.models import TSModel
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError


def rate_sums(
    A: Array,
    B: Array,
    Q: Unknown,
    M: Unknown,
    *,
    limit: ArrayLike,
    speed: float,
    rate_bounds: ArrayLike | None = None,
    discrete: bool = False,
    corners: Indices | None = None,
) -> tuple[tuple[DoubleSum, ...], tuple[LMI, ...]]:
    """Return the disc of the module as a double sum, and |K_j x|_k <= b_k as LMIs.

    Every relaxation applies to the double sum.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns as in ``closed_loop``; M with one member has no h_j' to bound.
    limit : (m,), on |u_k'| in 1/s of the input's unit, or on its change in one sample.
    speed : nu in 1/s, or for one sample.
    rate_bounds : phi, (r,) in 1/s, |h_j'| <= phi_j; needed in continuous time where the gains
        may differ.
    discrete : x+ = A x + B u.
    corners : as in ``DoubleSum``.

    Raises
    ------
    ModelError : numbers that are not positive, rate bounds missing or not wanted.
    """
    bound = positive_vector("input_rate_limit", limit, M.rows)
    nu = float(number("speed", speed))
    if nu <= 0:
        raise ModelError(f"speed is {nu:g}; it must be positive: |x'| <= speed |x| in the P-norm")
    region = EigenvalueRegion.disc(nu, centre=1.0 if discrete else 0.0)
    (loop,) = region_sums(A, B, Q, M, region, corners=corners)
    share = nu + _rates(rate_bounds, len(A), M.count == 1, discrete)
    named = DoubleSum(
        rules=loop.rules,
        blocks=loop.blocks,
        parts=loop.parts,
        weight=loop.weight,
        name="speed",
        corners=loop.corners,
    )
    return (named,), input_lmis(Q, M, bound / share, name="input rate limit", symbol=r"\bar b")


def with_input_states(model: TSModel) -> TSModel:
    """Return the model with its inputs as states: u' = v, or u+ = u + v in discrete time.

    The new inputs v are the rates (in one sample: the changes) of the old ones, which are the
    last states.  In discrete time the change acts at once, x+ = A x + B (u + v), so that nothing
    is delayed.  A limit on u is then a ``state_box``, one on v an ``input_limit``.

    Raises
    ------
    ModelError : a model without inputs.
    """
    A, B = vertex_stack(model), np.asarray(model.B)
    r, n, m = B.shape
    if m == 0:
        raise ModelError(f"model {model.name!r} has no inputs; there is nothing to make a state")
    input_stack(model, A)
    discrete = model.sample_time is not None
    one = np.broadcast_to(np.eye(m), (r, m, m))
    held = one if discrete else 0 * one
    rest = np.zeros((r, m, n))
    measured, disturbed = model.C.shape[1] > 0, model.E.shape[2] > 0
    return TSModel(
        np.block([[A, B], [rest, held]]),
        np.concatenate([B if discrete else 0 * B, one], axis=1),
        C=np.concatenate([model.C, model.D], axis=2) if measured else None,
        D=(model.D if discrete else 0 * model.D) if measured else None,
        E=np.concatenate([model.E, np.zeros((r, m, model.E.shape[2]))], axis=1)
        if disturbed
        else None,
        states=(*model.states, *model.inputs),
        inputs=[_moving(name, discrete) for name in model.inputs],
        outputs=model.outputs if measured else None,
        disturbances=model.disturbances if disturbed else None,
        premises=model.premises,
        rules=model.rules,
        box=model.box,
        sample_time=model.sample_time,
        name=f"{model.name}, inputs as states" if model.name else "inputs as states",
        source=model.source,
    )


def _rates(rate_bounds: ArrayLike | None, r: int, one_gain: bool, discrete: bool) -> float:
    """Return sum_j phi_j; at most 2 in discrete time, where memberships sum to one."""
    if one_gain:
        return 0.0
    if discrete:
        if rate_bounds is not None:
            raise ModelError(
                "rate_bounds are of continuous time; in discrete time memberships may jump, and "
                "the condition covers that: leave them out"
            )
        return 2.0
    if rate_bounds is None:
        raise ModelError(
            "a gain for each rule makes the input move with the memberships; give rate_bounds, "
            '|h_j\'| <= rate_bounds_j in 1/s, or take the relaxation "common-gain"'
        )
    phi = np.asarray(rate_bounds, dtype=np.float64)
    if phi.shape not in ((), (r,)) or not np.all(np.isfinite(phi) & (phi >= 0)):
        raise ModelError(
            f"rate_bounds is {rate_bounds!r}; one number or {r} are needed, finite and not "
            "negative, in 1/s"
        )
    return float(np.broadcast_to(phi, (r,)).sum())


def _moving(name: str, discrete: bool) -> str:
    """Return the name of an input's rate or change, with its unit."""
    if discrete:
        return f"change of {name}"
    if name.endswith("[-]"):
        return f"rate of {name[:-3]}[1/s]"
    return f"rate of {name[:-1]}/s]" if name.endswith("]") else f"rate of {name}"
