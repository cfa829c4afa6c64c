"""Parallel distributed compensation: one gain a rule, one Lyapunov function for all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.quadratic import vertex_weight
from takagi.lmi.answer import Answer, Design, Floats
from takagi.lmi.intake import (
    check_stabilisable,
    fixed_mode,
    input_stack,
    number,
    vertex_stack,
)
from takagi.lmi.solver.assemble import assemble
from takagi.lmi.solver.balance import balanced_inputs, nearest_power, state_units
from takagi.lmi.solver.diagnosis import binding_items
from takagi.lmi.solver.stages import Outcome, decide, improve
from takagi.lmi.synthesis.compensation_condition import Controlled, pdc_condition
from takagi.lmi.synthesis.limits import Limits, limits_of
from takagi.lmi.synthesis.relaxations import relaxation_named
from takagi.lmi.term import Array, Condition

__all__ = ["pdc"]


# Largest input effort nu, in inputs and states of order one, that is tried; the second only when
# the first is not enough, because huge gains cost the solver digits.
EFFORTS = (1e4, 1e8)


def pdc(
    model: Controlled,
    *,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    scales: ArrayLike | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with V' <= -2 alpha V, V = x' P x.

    First the largest margin decides whether there are gains; then, at half that margin, those of
    least input effort are taken.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    decay_rate : alpha in 1/s that must hold.
    relaxation : "common-gain", "wang-tanaka-griffin" (all pairs), "tanaka-wang", "tuan",
        "kim-lee", "liu-zhang" or "polya-<d>", roughly from cheap to rich.
    input_limit : (m,) with |u_k| <= input_limit_k wherever x' P x <= 1.
    initial_box : (n,) half-widths; the box lies inside x' P x <= 1.
    state_box : (n,) half-widths, inf for none; x' P x <= 1 lies inside the box.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition.
    scales : (n,) engineering range of each state; None takes the boxes, or balances.

    Returns
    -------
    A ``Design``; without gains its answer says which rules bind and what to relax.  Nothing is
    proved here.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, inputs that are dependent or do nothing,
        a vertex with an unstable mode that no input moves.

    Source: Tanaka and Wang (2001), chapter 3.
    """
    relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    alpha = float(number("decay_rate", decay_rate))
    r, n, m = B.shape
    limits = limits_of(
        n,
        m,
        input_limit=input_limit,
        initial_box=initial_box,
        state_box=state_box,
        gain_bound=gain_bound,
    )
    s = _state_units(A, limits, scales)
    scaled_A = A * s / s[:, None]
    tau = balanced_inputs(B / s[:, None], vertex_weight(scaled_A) / 2)
    tau = tau if limits.inputs is None else nearest_power(limits.inputs)
    scaled = _Scaled(scaled_A, B * tau / s[:, None])
    names = tuple(getattr(model, "states", ()))
    check_stabilisable(scaled.A, scaled.B, units=s, names=names)
    fixed = fixed_mode(scaled.A, scaled.B, alpha)
    condition = pdc_condition(
        scaled, decay_rate=alpha, relaxation=relaxation, limits=limits.scaled(s, tau)
    )
    if fixed is not None:
        return _no_by_fixed_mode(condition, fixed, r, alpha, relaxation, s)
    return _design(condition, _solved(condition), s, tau, r, relaxation, limits)


class _Scaled:
    """The vertices in scaled states and inputs."""

    def __init__(self, A: Floats, B: Floats) -> None:
        self.A, self.B = A, B


def _state_units(A: Floats, limits: Limits, scales: ArrayLike | None) -> Floats:
    """Return powers of two, so that the scaled vertices are exactly the given ones."""
    if scales is None and limits.states is not None and np.isfinite(limits.states).all():
        return nearest_power(limits.states)
    if scales is None and limits.initial is not None:
        return nearest_power(np.abs(limits.initial).max(axis=0))
    return state_units(A, scales)


def _solved(condition: Condition) -> Outcome:
    data = assemble(condition)
    modest, huge = EFFORTS
    found = decide(condition, rows={"nu": modest}, assembled=data)
    if found.status != "candidate":
        more = decide(condition, rows={"nu": huge}, assembled=data, most=1)
        tries = found.tries + more.tries
        if more.status != "candidate":
            return replace(found, tries=tries)
        found = replace(more, tries=tries)
    return improve(condition, found, assembled=data)


def _design(
    condition: Condition,
    outcome: Outcome,
    s: Floats,
    tau: Floats,
    rules: int,
    relaxation: str,
    limits: Limits,
) -> Design:
    gains, P = None, None
    if outcome.status == "candidate":
        Q, M = outcome.values["Q"][0], outcome.values["M"]
        inverse = np.linalg.inv(Q)
        inverse = (inverse + inverse.T) / 2
        K = np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        gains = np.broadcast_to(K * tau[:, None] / s, (rules, len(tau), len(s))).copy()
        if not limits.level:
            inverse /= np.exp2(np.floor(np.log2(np.linalg.eigvalsh(inverse)[0])))
        P = inverse / s / s[:, None]
    answer = Answer(
        status=outcome.status,
        P=P,
        margin=outcome.margin,
        decay_rate=condition.parameters["alpha"] if P is not None else None,
        bound=outcome.bound,
        values=outcome.values,
        multipliers=outcome.multipliers,
        coordinates=s,
        condition=condition,
        diagnosis="" if P is not None else _diagnosis(condition, outcome, relaxation, limits),
        tries=outcome.tries,
    )
    return Design(
        gains=gains,
        P=P,
        decay_rate=condition.parameters["alpha"],
        margin=outcome.margin,
        relaxation=relaxation,
        answer=answer,
    )


def _no_by_fixed_mode(
    condition: Condition,
    fixed: tuple[int, complex, Array],
    rules: int,
    alpha: float,
    relaxation: str,
    s: Floats,
) -> Design:
    vertex, eigenvalue, _ = fixed
    answer = Answer(
        status="infeasible",
        P=None,
        margin=-np.inf,
        bound=0.0,
        coordinates=s,
        condition=condition,
        diagnosis=(
            f"vertex {vertex + 1} of {rules}: no input moves the mode at {eigenvalue:.6g}, which "
            f"decays slower than {alpha:g} 1/s; ask for a decay rate below "
            f"{-eigenvalue.real:.6g} 1/s"
        ),
    )
    return Design(
        gains=None,
        P=None,
        decay_rate=alpha,
        margin=-np.inf,
        relaxation=relaxation,
        answer=answer,
    )


def _diagnosis(condition: Condition, outcome: Outcome, relaxation: str, limits: Limits) -> str:
    if outcome.status == "unknown":
        return (
            f"no solver settled it: the best margin was {outcome.margin:.2g}, the bound on it "
            f"{outcome.bound:.2g}; the condition is at its limit or badly scaled: lower the "
            "decay rate a little, or give scales"
        )
    names = [lmi.name for lmi in condition.lmis if lmi.weight > 0]
    names.remove("Q positive definite")
    cures = ["lower the decay rate", "shrink the box that the rules span"]
    if limits.level or limits.gain is not None:
        cures.insert(0, "widen the limits or shrink the initial box")
    if relaxation not in ("liu-zhang",):
        cures.insert(0, 'take a richer relaxation ("liu-zhang", "polya-2")')
    binding = binding_items(condition, outcome.multipliers, *names)
    return f"no gains by {relaxation}: {binding}; {', or '.join(cures)}"
