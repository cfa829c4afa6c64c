"""The largest ellipsoid from which a loop with limits settles, for gains given or sought."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.analysis.gain_pairs import gain_stack, pairs_of
from takagi.lmi.answer import Answer, Design
from takagi.lmi.argument_checks import Vertices, check_stabilisable, input_stack, vertex_stack
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.balance import balanced_inputs, balanced_states, nearest_power
from takagi.lmi.decision.decide import optimise
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, asks_for_decay, binding_items
from takagi.lmi.gains.attraction.condition import (
    AttractionRequest,
    attraction_condition,
    attraction_request,
)
from takagi.lmi.gains.decay.condition import Controlled
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

ROUNDS = 4
# The measure is within this share of its largest value, so that the LMIs keep a margin.
SLACK = 1e-4


def largest_ellipsoid(task: AttractionRequest) -> tuple[Condition, Outcome, Floats, Floats]:
    """Return the condition, its outcome, and the units of states and inputs it is posed in.

    Solved in coordinates of the ellipsoid's own size, found in a few rounds.
    """
    tau = np.ones(task.B.shape[2])
    if task.input_limit is not None:
        tau = nearest_power(task.input_limit)
    s = _first_units(task)
    condition = attraction_condition(task.scaled(s, tau))
    outcome = optimise(condition, slack=SLACK)
    for _ in range(ROUNDS):
        if outcome.status != "candidate" and not outcome.feasible:
            break
        axes = np.sqrt(np.diag(outcome.values["Q"][0]))
        if axes.max() <= 4 and axes.min() >= 0.25:
            break
        nearer = s * nearest_power(axes)
        rescaled = attraction_condition(task.scaled(nearer, tau))
        new_outcome = optimise(rescaled, slack=SLACK)
        if new_outcome.status != "candidate" and (
            outcome.status == "candidate" or not new_outcome.feasible
        ):
            break
        condition, outcome, s = rescaled, new_outcome, nearer
    return condition, outcome, s, tau


def _first_units(task: AttractionRequest) -> Floats:
    """Return units of the states, powers of two, in which the limits are of order one."""
    closed = task.A if task.gains is None else _closed(task)
    s = balanced_states(closed)
    sizes = []
    if task.state_box is not None:
        sizes.append(np.min(task.state_box / s))
    if task.input_limit is not None and task.gains is not None:
        reach = np.abs(task.gains * s).max(axis=(0, 2))
        sizes.append(np.min(task.input_limit / np.maximum(reach, 1e-300)))
    elif task.input_limit is not None:
        pushed = np.abs(task.B * task.input_limit / s[:, None]).max()
        sizes.append(2 * pushed / vertex_weight(task.A * s / s[:, None]))
    usable = [size for size in sizes if np.isfinite(size) and 0 < size < 1e200]
    return s * float(nearest_power(np.array(min(usable, default=1.0))))


def _closed(task: AttractionRequest) -> Floats:
    assert task.gains is not None
    K = np.broadcast_to(task.gains, (len(task.A), *task.gains.shape[1:]))
    return pairs_of(task.A, task.B, K)


def attraction_ellipsoid(
    model: Vertices,
    *,
    gains: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    input_limit: ArrayLike | None = None,
    saturation: str | None = None,
    decay_rate: float = 0.0,
    saturated_decay_rate: float = 0.0,
    relaxation: str = "tanaka-wang",
    measure: str | ArrayLike = "volume",
    sample_time: float | None = None,
) -> Answer:
    """Return P of the largest {x' P x <= 1} that no trajectory leaves, with V' <= -2 alpha V in it.

    Every trajectory that starts in the ellipsoid tends to 0, for memberships that move in any
    way, and keeps every limit.  P is not scaled: the ellipsoid is the level 1 of V = x' P x.

    Parameters
    ----------
    model : a model, or A (r, n, n) for a loop without inputs.
    gains : K, (r, m, n), of u = -sum_j h_j K_j x; None for u = 0.
    state_box : (n,) half-widths, inf for none, that the ellipsoid lies in; None takes the box of
        the model, outside which the vertices say nothing about the plant.
    input_limit : (m,) ubar with |u_k| <= ubar_k.
    saturation : None asks that the command never exceeds the limit in the ellipsoid; "polytope"
        lets it, and counts with the saturated input (``condition``).
    decay_rate : alpha in 1/s; V(x+) <= e^(-2 alpha T) V(x) in discrete time.
    saturated_decay_rate : alpha in 1/s where an input saturates; then this is the answer's.
    relaxation : as for ``pdc``; "common-gain" only for gains that do not differ.
    measure : "volume"; "trace", the sum of the squared semi-axes in units of the state box, or of
        the states where none exists; or points (k, n), whose largest multiple in the ellipsoid,
        1 / max_k (x_k' P x_k)^(1/2), counts.  (n,) half-widths stand for the corners of a box.
    sample_time : T in s for raw arrays of discrete time; None takes the model's own.

    Returns an ``Answer``, about 1e-4 below the largest measure by this condition, so that every LMI
    keeps a margin, and a thousandth at most; "unknown" where no solver gets so near.  Nothing is
    proved here.  Not promised: that it is the largest region of attraction, which need not be an
    ellipsoid; nor a finite one where neither box nor limit bounds it: it is cut off where Q reaches
    1000 times the size of the last coordinates.

    Raises ModelError: shapes, numbers, unknown names, nothing that limits the ellipsoid, a
    saturation without a limit.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.2; Hu and Lin (2001).
    """
    A = vertex_stack(model).astype(np.float64)
    r, n = A.shape[:2]
    B, K = np.zeros((r, n, 0)), None
    if gains is not None:
        B = input_stack(model, A).astype(np.float64)
        K = gain_stack(gains, r, B.shape[2], n)
        K = K[:1] if np.all(K == K[:1]) else K
        if relaxation == "common-gain" and len(K) > 1:
            raise ModelError(
                'the gains differ from rule to rule, which the relaxation "common-gain" does not '
                'allow; take another, such as "tanaka-wang"'
            )
    elif input_limit is not None or saturation is not None:
        raise ModelError("limits on inputs and saturation are about u = -K x; give gains")
    task = attraction_request(
        model,
        A,
        B,
        K,
        state_box=state_box,
        input_limit=input_limit,
        saturation=saturation,
        overdrive=1.0,
        decay_rate=decay_rate,
        saturated_decay_rate=saturated_decay_rate,
        relaxation=relaxation,
        measure=measure,
        sample_time=sample_time,
    )
    if task.state_box is None and task.input_limit is None:
        raise ModelError(
            "nothing limits the ellipsoid; give state_box, or input_limit with gains (for a loop "
            "without limits common_lyapunov shows that it decays from everywhere)"
        )
    condition, outcome, s, _ = largest_ellipsoid(task)
    return _answer(condition, outcome, s, task)


def attraction_pdc(
    model: Controlled,
    *,
    input_limit: ArrayLike,
    state_box: ArrayLike | None = None,
    saturation: str | None = "polytope",
    overdrive: float = 10.0,
    decay_rate: float = 0.0,
    saturated_decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    measure: str | ArrayLike = "volume",
    sample_time: float | None = None,
) -> Design:
    """Return gains K_i for u = -sat(sum_i h_i K_i x) with the largest {x' P x <= 1} to start from.

    As ``attraction_ellipsoid``, with the gains sought too.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    overdrive : bound on |v_k| / input_limit_k for the command v = sum_i h_i K_i x in the
        ellipsoid; larger ones make harder gains.
    others : as for ``attraction_ellipsoid``.

    Returns a ``Design``; its P is not scaled, as its level 1 is the ellipsoid.  Nothing is proved
    here.

    Raises ModelError: as ``attraction_ellipsoid``, and a vertex with an unstable mode that no input
    moves.
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    task = attraction_request(
        model,
        A,
        B,
        None,
        state_box=state_box,
        input_limit=input_limit,
        saturation=saturation,
        overdrive=overdrive,
        decay_rate=decay_rate,
        saturated_decay_rate=saturated_decay_rate,
        relaxation=relaxation,
        measure=measure,
        sample_time=sample_time,
    )
    task = replace(task, sought=True)
    s = balanced_states(A)
    units = balanced_inputs(B / s[:, None], vertex_weight(A * s / s[:, None]) / 2)
    names = tuple(getattr(model, "states", ()))
    check_stabilisable(
        A * s / s[:, None], B * units / s[:, None], units=s, names=names, step=task.step
    )
    condition, outcome, s, tau = largest_ellipsoid(task)
    answer = _answer(condition, outcome, s, task)
    gains = None
    if answer.found:
        Q, M = outcome.values["Q"][0], outcome.values["M"]
        hat = np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        gains = np.broadcast_to(hat * tau[:, None] / s, (len(A), *hat.shape[1:])).copy()
    return Design(
        gains=gains,
        P=answer.P,
        decay_rate=task.slowest,
        margin=outcome.margin,
        relaxation=relaxation,
        answer=answer,
    )


def _answer(condition: Condition, outcome: Outcome, s: Floats, task: AttractionRequest) -> Answer:
    P = None
    if outcome.status == "candidate":
        inverse = np.linalg.inv(outcome.values["Q"][0])
        P = (inverse + inverse.T) / 2 / s / s[:, None]
    return replace(
        outcome.as_answer(condition, s),
        P=P,
        decay_rate=None if P is None else task.slowest,
        feasible=outcome.feasible,
        diagnosis="" if P is not None else _diagnosis(condition, outcome, task),
    )


def _diagnosis(condition: Condition, outcome: Outcome, task: AttractionRequest) -> str:
    if outcome.feasible:
        return (
            f"there is an ellipsoid, but in the coordinates of the condition {outcome.reason}; "
            "give a state box and input limits of the size that matters"
        )
    if outcome.status == "unknown":
        return outcome.unsettled(advice_about_limit(condition))
    names = [lmi.name for lmi in condition.lmis[1:] if lmi.strict]
    binding = binding_items(condition, outcome.multipliers, *names)
    slower = "lower the decay rate, " if asks_for_decay(condition) else ""
    return (
        f"no ellipsoid, however small: {binding}; {slower}take a richer relaxation "
        f"than {task.relaxation}, or shrink the box that these vertices span"
    )
