"""The request for a gain design, checked on entry and in states and inputs of order one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import input_stack, sample_time_of, vertex_stack
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.cone.balance import (
    balanced_inputs,
    balanced_states,
    motion,
    nearest_power,
    state_units,
)
from takagi.lmi.gains.decay.condition import Controlled, double_sums, pdc_condition, size_of_motion
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits
from takagi.lmi.gains.requirements.requirements import Requirements
from takagi.lmi.stabilisability import check_stabilisable, fixed_mode
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import Relaxation
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

    Attributes
    ----------
    A, B : (r, n, n), (r, n, m), scaled by powers of two: no digit is touched.
    sample_time : T in s; None for continuous time.
    premises, rules : the model's, for relaxations that know products of memberships.
    limits, requirements : in the model's own units.
    decay_rate : alpha in 1/s that is asked for.
    s, tau : (n,), (m,).
    """

    A: Floats
    B: Floats
    sample_time: float | None
    premises: Sequence[Premise]
    rules: Sequence[tuple[int, ...]]
    limits: Limits
    requirements: Requirements
    decay_rate: float
    s: Floats
    tau: Floats

    @property
    def gain_numbers(self) -> int:
        """Return how many numbers one gain for each rule has, r m n."""
        return self.B.size

    def condition(self, decay_rate: float, relaxation: str | Relaxation) -> Condition:
        """Return the LMIs at this decay rate, in the scaled coordinates."""
        return pdc_condition(
            self,
            decay_rate=decay_rate,
            relaxation=relaxation,
            limits=self.limits.scaled(self.s, self.tau),
            requirements=self.requirements.scaled(len(self.A), self.s, self.tau),
        )

    def double_sums(self, relaxation: str) -> tuple[DoubleSum, ...]:
        """Return what a relaxation is posed of, to know its size before it is."""
        requirements = self.requirements.scaled(len(self.A), self.s, self.tau)
        return double_sums(self, self.decay_rate, relaxation, requirements, self.sample_time).sums

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
        limits = replace(self.limits, inputs=None, initial=None, states=None, ball=None)
        A, B, d = _balanced(self.A, self.B / self.tau, self.sample_time)
        tau = _inputs(A, B, limits, self.decay_rate, self.sample_time)
        return replace(self, A=A, B=B * tau, s=self.s * d, tau=tau, limits=limits)

    def fixed_mode(self, decay_rate: float) -> tuple[int, complex] | None:
        """Return (vertex, eigenvalue) that no input moves and that decays slower than asked."""
        A, B, _ = _balanced(self.A, self.B, self.sample_time)
        mode = fixed_mode(A, B, decay_rate, step=self.sample_time)
        return None if mode is None else mode[:2]

    def slowness(self, eigenvalue: complex) -> float:
        """Return the decay rate of a mode in 1/s."""
        if self.sample_time is None:
            return -eigenvalue.real
        return float(-np.log(abs(eigenvalue)) / self.sample_time)


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
    requirements = limits_given.requirements(*B.shape)
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
        requirements=requirements,
        decay_rate=decay_rate,
        s=s,
        tau=tau,
    )
    names = tuple(getattr(model, "states", ()))
    balanced, scaled_B, d = _balanced(task.A, task.B, step)
    check_stabilisable(balanced, scaled_B, units=s * d, names=names, step=step)
    return task


def _states(motions: Array, limits: Limits, scales: ArrayLike | None) -> Floats:
    """Return powers of two, so that the scaled vertices are exactly the given ones."""
    if scales is None and limits.states is not None and np.isfinite(limits.states).all():
        return nearest_power(limits.states)
    initial = limits.initial_extent
    if scales is None and initial is not None:
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
