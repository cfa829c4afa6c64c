"""How fast the inputs of a given law move on an ellipsoid: |u_k'|, or |u_k(x+) - u_k(x)|.

Continuous time, u = -K(h) x with G_il = A_i - B_i K_l:

    u' = -sum_jil h_j h_i h_l K_j G_il x  -  sum_j h_j' K_j x.

The first sum is a blend of its means over the orders of j, i and l, one for each multiset; the
second, with |h_j'| <= phi_j and sum_j h_j' = 0, of the corners of that set of rates.  A row c has
its largest |c x| on {x' P x <= 1} at (c P^-1 c')^(1/2), so each blend is bounded by its worst row.

Discrete time, where memberships may jump to any h+ from one sample to the next:

    u(x+) - u(x) = -sum_lij h+_l h_i h_j (K_l G_ij - K_j) x.

Both bounds grow with the level: on {x' P x <= c^2} they are c times as large.

Limits on how fast the inputs move: the input as a state, exact.

With u' = v (or u+ = u + v) a state of the model, limits on u are limits on states, limits on v are
input limits, and nothing is lost; the law is dynamic.  ``input_rate_bound`` gives the rates that a
design without these states needs.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement, permutations, product

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import (
    Vertices,
    input_stack,
    sample_time_of,
    symmetric,
    vertex_stack,
)
from takagi.lmi.condition.term import Array
from takagi.models import TSModel
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.vertex_arrays import finite_array


def gain_stack(gains: ArrayLike, r: int, m: int, n: int) -> Array:
    """Return K, (r, m, n), of u = -sum_j h_j K_j x; one (m, n) gain stands for all rules.

    Raises
    ------
    ModelError : another shape, or an entry that is not finite.
    """
    K = finite_array("K", gains)
    if K.shape not in ((r, m, n), (1, m, n), (m, n)):
        raise ModelError(
            f"gains have shape {K.shape}; ({r}, {m}, {n}) is needed, or ({m}, {n}) for the same "
            "gain in every rule"
        )
    return np.broadcast_to(K, (r, m, n))


def pairs_of(X: Array, Y: Array, K: Array) -> Array:
    """Return (X_i - Y_i K_j + X_j - Y_j K_i) / 2 for i <= j, (r (r + 1) / 2, ., .).

    sum_ij h_i h_j (X_i - Y_i K_j) is a blend of these, with weights h_i^2 and 2 h_i h_j.

    Parameters
    ----------
    X, Y, K : (r, p, n), (r, p, m), (r, m, n).
    """
    i, j = np.triu_indices(len(X))
    return np.asarray((X[i] - Y[i] @ K[j] + X[j] - Y[j] @ K[i]) / 2)


def pair_means(X: Array) -> Array:
    """Return (X_i + X_j) / 2 for i <= j: what does not depend on the gains, at the same pairs."""
    i, j = np.triu_indices(len(X))
    return np.asarray((X[i] + X[j]) / 2)


def of_pairs(answer: Answer, gains: ArrayLike | None) -> Answer:
    """Return a "no" whose vertices are rules and means of pairs, with what it proves."""
    if answer.found or gains is None or not answer.diagnosis:
        return answer
    words = "the vertices are rules and means of pairs of rules; a mean that fails excludes nothing"
    return replace(answer, diagnosis=f"{answer.diagnosis} ({words})")


# The most memberships whose rates' corners are listed, about r 2^(r-1) of them.
MOST_RULES = 12


def input_rate_bound(
    model: Vertices,
    gains: ArrayLike,
    P: ArrayLike,
    *,
    rate_bounds: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Array:
    """Return (m,) bounds on |u_k'| in 1/s of the input's unit, wherever x' P x <= 1.

    In discrete time on |u_k(x+) - u_k(x)|, for a step that starts in the ellipsoid.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    gains : K, (r, m, n), of u = -sum_j h_j K_j x; (m, n) for the same in every rule.
    P : (n, n), positive definite.
    rate_bounds : phi, (r,), |h_j'| <= phi_j in 1/s; needed in continuous time if the gains differ,
        because u can jump if the memberships can.

    Raises
    ------
    ModelError : shapes, numbers, rate bounds that are missing, or that are given in discrete time.
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    K = gain_stack(gains, r, m, n)
    Q = np.linalg.inv(symmetric("P", P, n, definite=True))
    step = sample_time_of(model, sample_time)
    phi = membership_rates(rate_bounds, K, discrete=step is not None)
    bounds = _largest(input_rate_rows(A, B, K, discrete=step is not None), Q)
    return bounds if phi is None else bounds + _largest_of_rates(K, phi, Q)


def input_rate_rows(A: Array, B: Array, K: Array, *, discrete: bool = False) -> Array:
    """Return the rows c of the module for constant memberships, (T, m, n).

    In discrete time the rows are those of memberships that may jump.
    """
    if len(K) == 1 or np.all(K == K[:1]):
        closed = A - B @ K[:1]
        return np.asarray(K[:1] @ (closed - np.eye(A.shape[1])) if discrete else K[:1] @ closed)
    if discrete:
        return np.concatenate([gain @ pairs_of(A, B, K) - pair_means(K) for gain in K])
    closed = A[:, None] - B[:, None] @ K[None]
    rows = []
    for chosen in combinations_with_replacement(range(len(A)), 3):
        orders = list(permutations(chosen))
        rows.append(sum(K[j] @ closed[i, k] for j, i, k in orders) / len(orders))
    return np.array(rows)


def membership_rates(rate_bounds: ArrayLike | None, K: Array, *, discrete: bool) -> Array | None:
    """Return phi, (r,), or None where the gains do not differ and no rate matters.

    Raises
    ------
    ModelError : missing, of another length, negative, or given in discrete time.
    """
    if discrete:
        if rate_bounds is not None:
            raise ModelError(
                "rate_bounds are of continuous time; in discrete time memberships may jump, and "
                "the bound covers that: leave them out"
            )
        return None
    alike = len(K) == 1 or bool(np.all(K == K[:1]))
    if rate_bounds is None:
        if alike:
            return None
        raise ModelError(
            "the gains differ from rule to rule, so the input moves with the memberships; give "
            "rate_bounds, |h_j'| <= rate_bounds_j in 1/s, or one gain for all rules"
        )
    phi = np.asarray(rate_bounds, dtype=np.float64)
    if phi.shape not in ((), (len(K),)) or not np.all(np.isfinite(phi) & (phi >= 0)):
        raise ModelError(
            f"rate_bounds is {rate_bounds!r}; one number or {len(K)} are needed, finite and not "
            "negative, in 1/s"
        )
    return None if alike else np.broadcast_to(phi, (len(K),))


def velocity_corners(bound: Floats) -> Floats:
    """Return the corners of the velocities, (count, corners of the simplex).

    All but one of the v_c are at their bounds, and the last balances them.

    Parameters
    ----------
    bound : phi, (corners of the simplex,), in 1/s; at most one is infinite.

    Raises
    ------
    ModelError : too many memberships for a list of corners.
    """
    phi = balanced_bounds(bound)
    moving = np.flatnonzero(phi > 0)
    if not len(moving):
        return np.zeros((1, len(phi)))
    if len(moving) > MOST_RULES:
        raise ModelError(
            f"{len(moving)} memberships move with rates of their own, more than {MOST_RULES}; "
            "give the model its premises, with a rate for each"
        )
    signs = np.array(list(product((-1.0, 1.0), repeat=len(moving) - 1)))
    corner_groups = []
    for free in range(len(moving)):
        other_rates = np.delete(moving, free)
        other_values = signs * phi[other_rates]
        balance = -other_values.sum(axis=1)
        # A rate that balances the others exactly is a corner, although rounding may exceed its
        # bound.
        fits = np.abs(balance) <= phi[moving[free]] * (1 + 1e-12)
        corners = np.zeros((int(fits.sum()), len(phi)))
        corners[:, other_rates] = other_values[fits]
        corners[:, moving[free]] = balance[fits]
        corner_groups.append(corners)
    return distinct_rows(np.concatenate(corner_groups), float(phi.max()))


def balanced_bounds(bound: Floats) -> Floats:
    """Return the bounds that matter: what the others cannot balance, no membership can do."""
    sums_of_others = np.array([np.delete(bound, c).sum() for c in range(len(bound))])
    return np.asarray(np.minimum(bound, sums_of_others))


def distinct_rows(corners: Floats, size: float) -> Floats:
    """Return the rows that differ by more than rounding."""
    _, first = np.unique(np.round(corners / size, 9), axis=0, return_index=True)
    return np.asarray(corners[np.sort(first)])


def _largest(rows: Array, Q: Array) -> Array:
    """Return (m,): the largest (c Q c')^(1/2) over the rows of each input."""
    squares = np.einsum("tmi,ij,tmj->tm", rows, Q, rows)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)).max(axis=0))


def _largest_of_rates(K: Array, phi: Array, Q: Array) -> Array:
    """Return (m,): a bound on |sum_j h_j' K_j x|."""
    if len(K) <= MOST_RULES:
        return _largest(np.tensordot(np.unique(velocity_corners(phi), axis=0), K, axes=1), Q)
    # The rates sum to zero, so the same gain may be subtracted from all gains.
    apart = np.stack([_norms(K - reference, Q) for reference in (*K, K.mean(axis=0))])
    return np.asarray((phi[:, None] * apart).sum(axis=1).min(axis=0))


def _norms(K: Array, Q: Array) -> Array:
    return np.asarray(np.sqrt(np.maximum(np.einsum("rmi,ij,rmj->rm", K, Q, K), 0.0)))


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
    eye = np.broadcast_to(np.eye(m), (r, m, m))
    kept_inputs = eye if discrete else 0 * eye
    zeros = np.zeros((r, m, n))
    measured, disturbed = model.C.shape[1] > 0, model.E.shape[2] > 0
    return TSModel(
        np.block([[A, B], [zeros, kept_inputs]]),
        np.concatenate([B if discrete else 0 * B, eye], axis=1),
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


def _moving(name: str, discrete: bool) -> str:
    """Return the name of an input's rate or change, with its unit."""
    if discrete:
        return f"change of {name}"
    if name.endswith("[-]"):
        return f"rate of {name[:-3]}[1/s]"
    return f"rate of {name[:-1]}/s]" if name.endswith("]") else f"rate of {name}"
