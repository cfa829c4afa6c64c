"""What is asked of gains with a decay rate, and its LMIs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.argument_checks import (
    corners_of,
    decay_parameter,
    fixed_mode,
    input_stack,
    number,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.statements import lmi_of, pose, positive_definite, scale_bound
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import (
    balanced_inputs,
    balanced_states,
    motion,
    nearest_power,
    state_units,
)
from takagi.lmi.expressions.expression import block, identity
from takagi.lmi.gains.requirements.closed_loop import (
    check_stabilisable,
    closed_loop,
    gain_unknown,
    region_sums,
)
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits, limit_lmis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import Relaxation, relaxation_named
from takagi.models.arrays import Floats
from takagi.models.ts.premise import Premise

# Bounds how far one guess of Q may move the units.
SMALLEST_UNIT = 2.0**-20
# The least unit of a state relative to those of the others, in balanced states.
FLATTEST = 2.0**-5


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DecayRequest:
    """A model in scaled states and inputs, x = s xhat and u = tau uhat, with its limits.

    It is itself what ``pdc_condition`` reads of a model.

    A, B : (r, n, n), (r, n, m), scaled by powers of two: no digit is touched.
    sample_time : T in s; None for continuous time.
    premises, rules : the model's, for relaxations that know products of memberships.
    limits : in the model's own units.
    region : of the eigenvalues, in 1/s; of x+ = A x without unit.
    decay_rate : alpha in 1/s that is asked for.
    s, tau : (n,), (m,).
    """

    A: Floats
    B: Floats
    sample_time: float | None
    premises: Sequence[Premise]
    rules: Sequence[tuple[int, ...]]
    limits: Limits
    region: EigenvalueRegion | None
    decay_rate: float
    s: Floats
    tau: Floats

    def condition(self, decay_rate: float, relaxation: str | Relaxation) -> Condition:
        """Return the LMIs at this decay rate, in the scaled coordinates."""
        return pdc_condition(
            self,
            decay_rate=decay_rate,
            relaxation=relaxation,
            limits=self.limits.scaled(self.s, self.tau),
            region=self.region,
        )

    def in_units_of(self, Q: Floats) -> DecayRequest:
        """Return the task in states where Q, found in the present ones, has a diagonal near 1.

        Balanced vertices do not make Q well conditioned; near the limit of what is feasible it
        may be wrong by 1e5, which costs the margin as much.  A diagonal of equal entries is the
        best of all scalings up to a factor n (van der Sluis, 1969).  Where limits fix the size of
        the ellipsoid, it has that of the unit ball then.
        """
        size = np.sqrt(np.diag(Q))
        size = size if self.limits.level else size / size.max()
        d = nearest_power(np.clip(size, SMALLEST_UNIT, 1 / SMALLEST_UNIT))
        A, B = self.A * d / d[:, None], self.B / self.tau / d[:, None]
        tau = _inputs(A, B, self.limits, self.decay_rate, self.sample_time)
        return replace(self, A=A, B=B * tau, s=self.s * d, tau=tau)

    def without_limits(self) -> DecayRequest:
        """Return the task without limits on states and inputs, in balanced states."""
        limits = replace(self.limits, inputs=None, initial=None, states=None)
        A, B, d = _balanced(self.A, self.B / self.tau, self.sample_time)
        tau = _inputs(A, B, limits, self.decay_rate, self.sample_time)
        return replace(self, A=A, B=B * tau, s=self.s * d, tau=tau, limits=limits)

    def fixed_mode(self, decay_rate: float) -> tuple[int, complex] | None:
        """Return (vertex, eigenvalue) that no input moves and that decays slower than asked."""
        A, B, _ = _balanced(self.A, self.B, self.sample_time)
        mode = fixed_mode(A, B, decay_rate, step=self.sample_time)
        return None if mode is None else mode[:2]


def decay_request(
    model: Controlled, limits_given: GivenLimits, *, decay_rate: float
) -> DecayRequest:
    """Return the task in coordinates of order one; ``model`` and ``decay_rate`` as for ``pdc``.

    Raises
    ------
    ModelError : shapes, numbers, inputs that are dependent or do nothing, a vertex with an
        unstable mode that no input moves.
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    limits = limits_given.limits(A.shape[1], B.shape[2])
    step = sample_time_of(model, limits_given.sample_time)
    s = _states(motion(A, step), limits, limits_given.scales)
    scaled = A * s / s[:, None]
    tau = _inputs(scaled, B / s[:, None], limits, decay_rate, step)
    task = DecayRequest(
        A=scaled,
        B=B * tau / s[:, None],
        sample_time=step,
        premises=tuple(getattr(model, "premises", ())),
        rules=tuple(getattr(model, "rules", ())),
        limits=limits,
        region=limits_given.region,
        decay_rate=decay_rate,
        s=s,
        tau=tau,
    )
    names = tuple(getattr(model, "states", ()))
    check_stabilisable(task.A, task.B, units=s, names=names, step=step)
    return task


def _states(motions: Array, limits: Limits, scales: ArrayLike | None) -> Floats:
    """Return powers of two, so that the scaled vertices are exactly the given ones."""
    if scales is None and limits.states is not None and np.isfinite(limits.states).all():
        return nearest_power(limits.states)
    if scales is None and limits.initial is not None:
        initial = np.abs(limits.initial).max(axis=0)
        shape = balanced_states(motions)
        # An ellipsoid that holds the box is never flat where the box is: states move each other.
        size = np.maximum(initial, FLATTEST * float((initial / shape).max()) * shape)
        return nearest_power(size if limits.states is None else np.minimum(size, limits.states))
    return state_units(motions, scales)


def _balanced(A: Floats, B: Floats, step: float | None) -> tuple[Floats, Floats, Floats]:
    """Return A and B in balanced states and their units d: limits make others, for other ends."""
    d = balanced_states(motion(A, step))
    return A * d / d[:, None], B / d[:, None], d


def _inputs(A: Floats, B: Floats, limits: Limits, decay_rate: float, step: float | None) -> Floats:
    if limits.inputs is not None:
        return nearest_power(limits.inputs)
    # A slow plant that is asked to be fast needs gains of the size of what is asked.
    return balanced_inputs(B, size_of_motion(A, decay_rate, step) / 2)


class Controlled(Protocol):
    """What pdc reads of a model: A (r, n, n) and B (r, n, m)."""

    @property
    def A(self) -> Array: ...

    @property
    def B(self) -> Array: ...


# Size of Q, in scaled states, where limits fix the ellipsoid and it is not a matter of scale.
LARGEST_ELLIPSOID = 1e3


def pdc_condition(
    model: Controlled,
    *,
    decay_rate: float = 0.0,
    relaxation: str | Relaxation = "wang-tanaka-griffin",
    limits: Limits | None = None,
    region: EigenvalueRegion | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0, Theta_ij = He(A_i Q - B_i M_j) + 2 alpha Q, Q > 0.

    Then u = -sum_j h_j K_j x with K_j = M_j Q^-1 gives V' <= -2 alpha V for V = x' Q^-1 x.  The
    objective is the input effort nu, K_j Q K_j' <= nu I: the largest input on x' P x <= 1.
    Discrete time: Theta_ij as in ``closed_loop``.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    decay_rate : alpha in 1/s.
    relaxation : how the double sum is made LMIs; see ``relaxations``.  Or what poses it.
    limits : on inputs, states and gains, in the model's coordinates.
    region : of the eigenvalues while the memberships stand still.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns the condition, in the model's coordinates as they are.  Nothing is solved.

    Raises ModelError: shapes, entries that are not finite, an unknown relaxation.

    Source: Tanaka and Wang (2001), section 3.3.
    """
    name = relaxation if isinstance(relaxation, str) else ""
    relaxed = relaxation if callable(relaxation) else relaxation_named(relaxation)
    alpha = number("decay_rate", decay_rate)
    step = sample_time_of(model, sample_time)
    Q, M, loops = double_sums(model, alpha, name, region, step)
    nu = Unknown("nu", 1, 1, latex=r"\nu")
    results = [relaxed(loop) for loop in loops]
    slack = tuple(unknown for unknowns, _ in results for unknown in unknowns)
    sums = tuple(lmi for _, lmis in results for lmi in lmis)
    limit_unknowns, restrictions = limit_lmis(Q, M, limits)
    # Without limits Q is determined up to a factor, and Q <= I fixes it; with limits its size
    # matters.
    largest = LARGEST_ELLIPSOID if limits is not None and limits.level else 1.0
    return pose(
        positive_definite(Q),
        scale_bound(Q, largest),
        *sums,
        effort_lmi(Q, M, nu),
        *restrictions,
        minimise=nu,
        unknowns=(Q, M, nu, *slack, *limit_unknowns),
        parameters=(decay_parameter(alpha, step),),
        name=", ".join(words for words in ("parallel distributed compensation", name) if words),
        source="Tanaka and Wang (2001), section 3.3",
    )


def double_sums(
    model: Controlled,
    alpha: float | Fraction,
    relaxation: str,
    region: EigenvalueRegion | None,
    step: float | None,
) -> tuple[Unknown, Unknown, tuple[DoubleSum, ...]]:
    """Return Q, M and the double sums of ``pdc_condition``, the first that of the decay rate.

    ``relaxation`` : for "common-gain" M has one member, for all others one a rule.
    ``step`` : T in s; None for continuous time.
    """
    A = vertex_stack(model)
    B = input_stack(model, A)
    r, n, m = B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    loop = closed_loop(
        A,
        B,
        Q,
        M,
        weight=theta_weight(A, float(alpha), step),
        discrete=step is not None,
        corners=corners_of(model),
    )
    if region is None:
        return Q, M, (loop,)
    return Q, M, (loop, *region_sums(A, B, Q, M, region, corners=loop.corners))


def size_of_motion(A: Array, alpha: float, step: float | None) -> float:
    """Return max_i 2 |A_i|, of A_i - I in discrete time, or what the decay rate asks if more."""
    asked_rate = alpha if step is None else -np.expm1(-alpha * step)
    return max(vertex_weight(motion(A, step)), 2.0 * asked_rate)


def theta_weight(A: Array, alpha: float, step: float | None) -> float:
    """Return the natural size of Theta_ij for Q <= I.

    In discrete time at most 1: Theta's own blocks -rho^2 Q and -Q leave no more.  It is small
    where the sample time is, since V then changes little in a step.
    """
    size = size_of_motion(A, alpha, step)
    return size if step is None else min(1.0, size)


def effort_lmi(Q: Unknown, M: Unknown, nu: Unknown) -> LMI:
    """Pose [[Q, M_i'], [M_i, nu I]] >= 0, which is K_i Q K_i' <= nu I."""
    M_i = M.members(np.arange(M.count), M.symbol if M.count == 1 else f"{M.symbol}_i")
    # At the least effort this inequality holds with equality, so it cannot keep a margin.
    effort = block([[Q, None], [M_i, nu * identity(M.rows)]]) >= 0
    return lmi_of(effort.named("input effort", rf"i = 1, \dots, {M.count}"))
