"""An outcome of gains with limits: whether its no is one of the limits, and in which size it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.answer import Status
from takagi.lmi.condition.evaluate import holds, margin
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.assemble import Assembled, assemble, pack
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.gains.decay.condition import LARGEST_ELLIPSOID
from takagi.lmi.gains.decay.request import DecayRequest
from takagi.lmi.sums.relaxations import Relaxation

# Largest input effort nu, in inputs and states of order one, that is tried; the others only when
# the first is not enough, in better units or without: huge gains cost the solver digits.
EFFORTS = (1e4, 1e6, 1e8)
# The share in the bound on the margin from which the limit on Q may be what excludes gains.
HELD = 1e-3
# How far inside its limits an ellipsoid is put, in the squares of them.
INSIDE = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class LimitedOutcome:
    """An outcome with what it is an outcome of: the task's units may have changed for it.

    ``effort`` is the largest nu that was allowed.
    """

    task: DecayRequest
    condition: Condition
    data: Assembled
    outcome: Outcome
    effort: float = EFFORTS[0]


def stopped_by_limit(found: LimitedOutcome) -> bool:
    """Return whether a no says nothing of larger Q or greater effort than were allowed.

    Without limits on states and inputs Q may be divided by any number: nothing is lost then.  With
    them, a no counts where the bound on the margin is below zero by more than its multipliers leave
    to any Q and gains of the sizes that the condition allows.  The bound itself counts what is left
    of stationarity for unknowns about as large as those that were found only (``cone/duality``):
    where gains exist far from those, that is not a bound.
    """
    outcome, data = found.outcome, found.data
    if not found.task.limits.level or outcome.status == "candidate":
        return False
    if "scale of Q" not in outcome.multipliers:
        return False
    size = LARGEST_ELLIPSOID * float(np.trace(outcome.multipliers["scale of Q"][0]))
    if size > HELD * abs(outcome.bound) or not outcome.bound < 0:
        return True
    # Q <= 1000 I and [[Q, M'], [M, nu I]] >= 0 allow |Q_ij| <= 1000 and |M_ij|^2 <= 1000 nu.
    effort = EFFORTS[-1]
    allowed = {"Q": LARGEST_ELLIPSOID, "M": np.sqrt(effort * LARGEST_ELLIPSOID), "nu": effort}
    lmis = found.condition.lmis
    packed = np.concatenate([pack(outcome.multipliers[lmi.name]).ravel() for lmi in lmis])
    left = np.abs(data.matrix().T @ packed)
    total = 0.0
    for unknown in found.condition.unknowns:
        if unknown.name in allowed:
            part = left[data.offsets[unknown.name] :][: unknown.length]
            total += float(allowed[unknown.name] * part.sum())
    return total > abs(outcome.bound)


def in_fitting_size(
    plain: LimitedOutcome, limited: DecayRequest, rate: float, pose: str | Relaxation
) -> LimitedOutcome:
    """Return gains without limits as an outcome with them, their ellipsoid in a size that fits.

    Without limits every multiple of Q is as good: in the coordinates d x, d u the condition is the
    same for all d > 0 but for the limits, |d x| and |d u| against theirs.

    Parameters
    ----------
    plain : a candidate of ``limited`` without its limits.

    Returns
    -------
    A candidate where some power of two d serves all limits; "unknown" otherwise.
    """
    task, outcome = plain.task, plain.outcome
    limits = limited.limits.scaled(task.s, task.tau)
    Q, M = outcome.values["Q"][0], outcome.values["M"]
    low, high = 0.0, np.inf
    if limits.holds_starts:
        low = float(np.sqrt(INSIDE * limits.share_of_starts(Q)))
    if limits.states is not None:
        high = min(high, float((limits.states / np.sqrt(INSIDE * np.diag(Q))).min()))
    if limits.inputs is not None:
        K = np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        used = np.sqrt(INSIDE * np.einsum("rki,rki->rk", M, K).max(axis=0))
        high = min(high, float((limits.inputs / np.maximum(used, 1e-300)).min()))
    middle = np.sqrt(low * high) if low and np.isfinite(high) else (low or high)
    d = float(nearest_power(np.array([middle]))[0])
    if not low <= d:
        d *= 2.0
    if not d <= high:
        d /= 2.0
    task = replace(task, limits=limited.limits, s=task.s * d, tau=task.tau * d)
    condition = task.condition(rate, pose)
    found = margin(condition, outcome.values)
    status: Status = "candidate" if holds(condition, found) else "unknown"
    outcome = replace(outcome, status=status, margin=found, multipliers={}, bound=np.inf)
    return replace(plain, task=task, condition=condition, data=assemble(condition), outcome=outcome)
