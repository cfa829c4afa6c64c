"""A quadratic function for the running loop at the winds of one cell.

The function is sought in floating point, rounded to decimals, and its inequalities are then decided
in exact arithmetic.  That is a candidate: no checker replays it from a file, so it is not PROVED.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from math import floor, log10
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.definite import is_positive_definite
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.claims.turbine.running_loop.running import (
    STATES,
    Machine,
    Running,
    Sides,
    cut,
)
from takagi.certificates.claims.turbine.running_loop.signals import Rows, Signal, Signals, Span
from takagi.certificates.claims.turbine.running_loop.signals import decay_form as form
from takagi.models.arrays import Floats

# The largest box to try, and fractions of it, the largest first.
LARGEST = Sides(*map(Fraction, ("0.04", "0.04", "0.03", "0.04", "0.03", "0.5", "0.5", "0.06")))
SIZES = tuple(map(Fraction, ("1", "0.5", "0.25", "0.1", "0.05")))
# A wider range of the pitch share is divided into pieces, each with its own multipliers.
WIDEST_SHARE, DIGITS, MARGIN = Fraction(1, 5), 9, 1e-7


@dataclass(frozen=True, slots=True)
class RunningCandidate:
    """V = xi'P xi decays as exp(-2 decay t) inside V <= 1, at each constant wind of the cell.

    Attributes
    ----------
    winds, sides : the cell [m/s] and the box that contains the set.
    P : in decimals;  multipliers : of each piece.
    """

    winds: Span
    sides: Sides
    decay: Fraction
    P: Rows
    multipliers: list[list[Fraction]]

    def reach(self, state: int) -> float:
        """Return the largest value of a state on V <= 1."""
        P = np.array([[float(value) for value in row] for row in self.P])
        return float(np.sqrt(np.linalg.inv(P)[state, state]))


def running_candidate(
    subject: Subject,
    machine: Machine,
    k: int,
    winds: Span,
    *,
    decay: Fraction = Fraction(1, 200),
    sizes: Sequence[Fraction] = SIZES,
) -> tuple[RunningCandidate | None, str]:
    """Return the candidate with the largest box, or None and the reason of the last failure."""
    why = "no size was tried"
    for size in sizes:
        names = LARGEST.__dataclass_fields__
        sides = Sides(*(size * getattr(LARGEST, name) for name in names))
        try:
            loop = Running(subject, machine, k, winds, sides)
            why = loop.limits_failure()
        except Refused as reason:
            why = str(reason)
        if why:
            continue
        found = _solved(loop, decay)
        if found is None:
            why = "no quadratic function was found"
            continue
        candidate = RunningCandidate(winds, sides, decay, *found)
        why = inequality_failure(loop, candidate)
        if not why:
            return candidate, ""
    return None, why


def inequality_failure(loop: Running, candidate: RunningCandidate) -> str:
    """Return the inequality that fails in exact arithmetic, or an empty text."""
    P = candidate.P
    if not is_positive_definite(P):
        return "P is not positive definite"
    for name, (h, bound) in loop.rows().items():
        inside = [[bound**2 * P[i][j] - h[i] * h[j] for j in range(STATES)] for i in range(STATES)]
        if bound <= 0 or not is_positive_definite(inside):
            return f"the set leaves its box in {name}"
    for (signals, rates), tau in zip(_pieces(loop), candidate.multipliers, strict=True):
        if min(tau, default=Fraction(1)) <= 0:
            return "a multiplier is not positive"
        if not is_positive_definite(form(signals, rates, P, tau, candidate.decay)):
            return "the decay inequality fails"
    return ""


def _pieces(loop: Running) -> Iterator[tuple[Signals, list[Signal]]]:
    """Yield the loop for each piece of the pitch share: at every instant one of them applies."""
    share = loop.secant_share()
    parts = 1 if share[1] - share[0] < WIDEST_SHARE else 2
    for piece in cut(share, parts):
        yield loop.equations(piece, loop.factors["inertia"])


def _solved(loop: Running, decay: Fraction) -> tuple[Rows, list[list[Fraction]]] | None:
    """Return P and multipliers found by a solver, in decimals."""
    cp: Any = import_module("cvxpy")
    sides = loop.sides
    unit = np.array([
        float(side)
        for side in (
            sides.speed, sides.pitch, sides.integral, sides.schedule,
            sides.measured, sides.measured, sides.estimate, sides.pitch,
        )
    ])  # fmt: skip
    X = cp.Variable((STATES, STATES), PSD=True)
    conditions, weights = [], []
    for h, bound in loop.rows().values():
        if bound <= 0:
            return None
        g = (np.array(h, dtype=np.float64) * unit / float(bound))[:, None]
        conditions.append(X - (1 + MARGIN) * (g @ g.T) >> 0)
    for signals, rates in _pieces(loop):
        F, Z, scale = _scaled(signals, rates, unit)
        t = cp.Variable(len(scale), nonneg=True)
        states = np.eye(STATES, len(unit) + len(scale))
        A = states.T @ X @ F
        left = A + A.T + 2 * float(decay) * states.T @ X @ states
        left += Z.T @ cp.diag(t) @ Z - cp.diag(cp.hstack([np.zeros(STATES), t]))
        conditions.append(left << -MARGIN * np.eye(len(F.T)))
        weights.append((t, scale))
    problem = cp.Problem(cp.Minimize(cp.trace(X)), conditions)
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return None
    if X.value is None:
        return None
    P = X.value / np.outer(unit, unit)
    exact = [[_decimal((P[i, j] + P[j, i]) / 2) for j in range(STATES)] for i in range(STATES)]
    return exact, [[_decimal(v) for v in t.value / scale**2] for t, scale in weights]


def _scaled(signals: Signals, rates: list[Signal], unit: Floats) -> tuple[Floats, Floats, Floats]:
    """Return rates and outer signals in units of the box, and the units of the w."""
    F = np.array([signals.row(rate) for rate in rates], dtype=np.float64)
    Z = np.array([signals.row(one) for one in signals.outer], dtype=np.float64)
    scale = np.zeros(len(Z))
    for i, row in enumerate(np.abs(Z)):
        scale[i] = max(float((row[:STATES] * unit).max()), 1e-9)
        scale[i] = max(scale[i], float((row[STATES:] * scale).max()))
    whole = np.concatenate([unit, scale])
    return F * whole / unit[:, None], Z * whole / scale[:, None], scale


def _decimal(value: float) -> Fraction:
    if value == 0:
        return Fraction(0)
    places = DIGITS - 1 - floor(log10(abs(value)))
    ten = Fraction(10) ** places
    return round(Fraction(value) * ten) / ten
