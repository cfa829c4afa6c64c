"""The least gain of a path that one quadratic function shows: what all norms have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.common_quadratic import common_lyapunov
from takagi.lmi.analysis.disturbance.channel import ChannelUnits, DisturbanceChannel, hiding_states
from takagi.lmi.answer import Answer, ObjectiveUnit, Try
from takagi.lmi.argument_checks import slow_vertex
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.outcome import Outcome, binding_items, not_least, promised
from takagi.lmi.decision.rounds import ALL_AT_ONCE, optimise_by_rounds
from takagi.models.arrays import Floats

# The condition, of a path in the given units.
Pose: TypeAlias = Callable[[DisturbanceChannel, ChannelUnits], Condition]
# The gain that the unknowns show at all vertices, recomputed from them, and P; both in the units
# of the path as it was before it was scaled.
Measure: TypeAlias = Callable[
    [DisturbanceChannel, ChannelUnits, Mapping[str, Floats]], tuple[float, Floats]
]
# A guess of P, up to a factor, from a single system near the path.
Guess: TypeAlias = Callable[[DisturbanceChannel], Floats | None]

# Gains that differ by less are the same.
AGREED = 1e-6
# If an objective is as near to its lower bound, relatively, it is the least one in any coordinates.
SURE = 1e-5


def least_gain(
    path: DisturbanceChannel,
    scales: ArrayLike | None,
    pose: Pose,
    measure: Measure,
    *,
    decay_rate: float = 0.0,
    noise: bool = False,
    infinite: str = "",
    guess: Guess | None = None,
    tolerance: float = 1e-6,
) -> Answer:
    """Return the answer with the least gain: posed in units of order one, and recomputed from P.

    Parameters
    ----------
    scales : (n,) engineering range of each state; None balances the vertices.
    pose, measure : the condition, and what its unknowns show.
    decay_rate : alpha in 1/s that the condition also asks for.
    noise : the disturbance is white.
    infinite : why no gain is finite; empty when it may be.
    guess : of P; asked first, without scales.
    tolerance : how far above the least the objective may be, relative, so that P keeps a margin.

    Raises
    ------
    ModelError : scales that are not positive.
    """
    s = state_units(path.A, scales, step=path.sample_time)
    why = _hopeless_vertex(path, s, decay_rate) or infinite
    if why:
        return Answer(status="infeasible", margin=-np.inf, coordinates=s, diagnosis=why)
    T = hiding_states(path)
    if T is not None:
        hidden = gain_of_hidden(path.in_states(T), T, pose, measure, decay_rate, noise=noise)
        if hidden is not None:
            return hidden
    question = _Question(path, pose, measure, noise, tolerance)
    P = guess(path) if guess is not None and scales is None else None
    T = None if P is None else states_of(P)
    tries: tuple[Try, ...] = ()
    answer, sure = None, False
    if T is not None:
        answer, sure = question.in_states(T)
        tries = answer.tries
    if answer is None or answer.gain is None:
        answer, sure = question.attempt(path, s)
        answer = replace(answer, tries=(*tries, *answer.tries))
    if answer.gain is None:
        return _answer_without(path, s, answer, decay_rate)
    return answer if sure else question.confirmed(answer)


def gain_of_hidden(
    inside: DisturbanceChannel,
    T: Floats,
    pose: Pose,
    measure: Measure,
    decay_rate: float,
    *,
    noise: bool = False,
) -> Answer | None:
    """Return a gain of zero but for rounding, of a path in ``hiding_states``; None without a P.

    Nothing is near a least gain of zero by a share of it, so nothing is minimised.
    """
    unit_scales = np.ones(len(T))
    units = ChannelUnits.of(inside, unit_scales, noise=noise)
    scaled = inside.scaled(units)
    step = inside.sample_time
    stable = common_lyapunov(
        scaled.A, decay_rate=decay_rate / units.rate, scales=unit_scales, sample_time=step
    )
    if stable.P is None:
        return None
    gain, P = measure(scaled, units, {"P": stable.P[None]})
    back = np.linalg.inv(T)
    return replace(
        stable,
        P=back.T @ P @ back,
        decay_rate=None,
        gain=gain,
        coordinates=None,
        condition=pose(scaled, units),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Question:
    """The path, its condition, what the unknowns show; whether the disturbance is white."""

    path: DisturbanceChannel
    pose: Pose
    measure: Measure
    noise: bool
    slack: float

    def attempt(self, path: DisturbanceChannel, s: Floats) -> tuple[Answer, bool]:
        """Return the answer posed in x = s xhat; without a gain where no solver came near it.

        Also return whether the lower bound of the multipliers confirms that it is the least.
        """
        units = ChannelUnits.of(path, s, noise=self.noise)
        scaled = path.scaled(units)
        condition = self.pose(scaled, units)
        outcome = optimise_by_rounds(condition, slack=self.slack)
        gain, P, why = self._gain_of(outcome, scaled, units)
        good = gain is not None and not why
        sure = outcome.objective - outcome.lower_bound <= (self.slack + SURE) * abs(
            outcome.lower_bound
        )
        answer = replace(
            outcome.as_answer(condition, s),
            status="candidate" if good else outcome.status,
            P=P if good else None,
            gain=gain if good else None,
            objective_unit=self._unit(units),
            feasible={} if good else outcome.feasible,
            diagnosis=why,
        )
        return answer, bool(sure)

    def in_states(self, T: Floats) -> tuple[Answer, bool]:
        """Return the answer posed in x = T xhat, and whether its lower bound confirms it."""
        answer, sure = self.attempt(self.path.in_states(T), np.ones(len(T)))
        if answer.P is None:
            return replace(answer, coordinates=None), sure
        back = np.linalg.inv(T)
        return replace(answer, P=back.T @ answer.P @ back, coordinates=None), sure

    def confirmed(self, answer: Answer) -> Answer:
        """Return the answer in states where the first P is |x|^2, if its gain is less.

        In unsuitable coordinates a solver may report "solved" for a gain that is a per cent above
        the least. Only a second solution in other coordinates shows this.
        """
        assert answer.P is not None and answer.gain is not None  # a gain comes with its P
        T = None if len(self.path.A) > ALL_AT_ONCE else states_of(answer.P)
        if T is None:
            return answer
        second, _ = self.in_states(T)
        tries = (*answer.tries, *second.tries)
        if second.gain is None or second.P is None or not second.gain < (1 - AGREED) * answer.gain:
            return replace(answer, tries=tries)
        return replace(second, tries=tries)

    def _unit(self, units: ChannelUnits) -> ObjectiveUnit:
        """Return what the objective means; under white noise a variance, per unit of time."""
        factor = units.output / units.disturbance
        if self.noise:
            return ObjectiveUnit("gain", factor * float(np.sqrt(units.rate)), power=2)
        return ObjectiveUnit("gain", factor)

    def _gain_of(
        self, outcome: Outcome, scaled: DisturbanceChannel, units: ChannelUnits
    ) -> tuple[float | None, Floats | None, str]:
        """Return the gain that the unknowns show, its P, and why it is not the least, or None.

        If no solver brought the objective near the least, P may still show a smaller gain than it.
        """
        values = outcome.values if outcome.status == "candidate" else outcome.feasible
        if not values:
            return None, None, ""
        gain, P = self.measure(scaled, units, values)
        if outcome.status == "candidate":
            return gain, P, ""
        # The objective under white noise is a variance, and per unit of time.
        lower_bound = outcome.lower_bound
        if self.noise:
            lower_bound = np.sqrt(max(lower_bound, 0.0) * units.rate)
        lower_bound = float(lower_bound) * units.output / units.disturbance
        is_least = (
            np.isfinite(lower_bound) and abs(gain - lower_bound) <= promised(0.0) * lower_bound
        )
        return gain, P, "" if is_least else not_least(gain, lower_bound)


def states_of(P: Floats) -> Floats | None:
    """Return T of x = T xhat with x' P x = |xhat|^2; None where P is singular to rounding."""
    try:
        return np.asarray(np.linalg.inv(np.linalg.cholesky(P)).T)
    except np.linalg.LinAlgError:
        return None


def motion_of(channel: DisturbanceChannel, P: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the change of V = x' P x: V' or V(x+) - V = [x; w]' [[-F, G], [G', H]] [x; w].

    F = -He(P A_i), G = P B_i, H = 0; in discrete time P - A_i' P A_i, A_i' P B_i, B_i' P B_i.
    """
    A, B = channel.A, channel.B
    if channel.sample_time is None:
        fall = -(P @ A + (P @ A).transpose(0, 2, 1))
        return fall, P @ B, np.zeros((len(B), B.shape[2], B.shape[2]))
    back = A.transpose(0, 2, 1) @ P
    return P - back @ A, back @ B, B.transpose(0, 2, 1) @ P @ B


def _hopeless_vertex(channel: DisturbanceChannel, states: Floats, alpha: float) -> str:
    """Return why no bound can be finite: a vertex that is too slow; empty when none is."""
    A = channel.A * states / states[:, None]
    slow = slow_vertex(A, alpha, step=channel.sample_time)
    if slow is None:
        return ""
    vertex, eigenvalue, _ = slow
    vertex_name = f"vertex {vertex + 1} of {len(channel.A)}"
    if alpha > 0:
        return (
            f"{vertex_name}: its eigenvalue {eigenvalue:.6g} does not decay faster than {alpha:g} "
            "1/s, so no bound is finite at this decay rate; lower it, or stabilise the vertex"
        )
    return (
        f"{vertex_name} is not stable: its eigenvalue {eigenvalue:.6g} does not decay, so no bound "
        "is finite; stabilise it, or shrink the box so that this vertex moves"
    )


def _answer_without(
    channel: DisturbanceChannel, states: Floats, tried: Answer, alpha: float
) -> Answer:
    """Return the answer without a bound: no common P exists, or no solver decided it."""
    stable = common_lyapunov(
        channel.A, decay_rate=alpha, scales=states, sample_time=channel.sample_time
    )
    # A single stable vertex always has a P; a solver that finds none has failed numerically.
    no = stable.status == "infeasible" and len(channel.A) > 1
    rate = f" at the decay rate {alpha:g} 1/s" if alpha > 0 else ""
    why = (
        f"the vertices have a common P{rate}, so a bound exists, but"
        if stable.found
        else f"whether the vertices have a common P{rate} is not settled, and"
    )
    reason = tried.diagnosis or "no solver came near the least one"
    diagnosis = f"{why} {reason}; give scales, or leave out fast states"
    if no and stable.condition is not None:
        binding = binding_items(stable.condition, stable.multipliers, "vertex")
        diagnosis = (
            f"no bound by one quadratic function, for there is no common P{rate}: {binding}; "
            "shrink the box that these vertices span, or stabilise them with a margin"
        )
    return Answer(
        status="infeasible" if no else "unknown",
        margin=stable.margin if no else min(tried.margin, 0.0),
        bound=stable.bound if no else np.inf,
        multipliers=stable.multipliers if no else {},
        coordinates=states,
        condition=stable.condition if no else tried.condition,
        feasible={} if no else tried.feasible,
        diagnosis=diagnosis,
        tries=(*tried.tries, *stable.tries),
    )
