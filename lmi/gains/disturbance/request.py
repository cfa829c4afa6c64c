"""What is asked of gains against disturbances, in coordinates where a guess of the cost is |x|^2.

Balanced vertices alone leave the Lyapunov function of a good design ill-conditioned, by 1e9 for a
turbo-generator of ten states; in coordinates where a regulator's cost is |x|^2 it is near I.  The
input is counted from that regulator, u = uhat - K0 x: then the loop is of order one too, where
A Q - B M is a small difference of large numbers.  With M = (K - K0) Q the LMIs are the same, entry
by entry, so nothing is changed by it but the rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.cone.balance import motion, nearest_power, state_units
from takagi.lmi.gains.decay.pdc import pdc
from takagi.lmi.gains.disturbance.disturbed_plant import (
    Disturbed,
    DisturbedPlant,
    Performance,
    plant_of,
)
from takagi.lmi.gains.requirements.closed_loop import check_stabilisable
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Complex, Floats

# Share of the largest weight that a state or an input has where the output does not show it, and
# how far the states' units may lie apart when it is added.  The second is for outputs that leave
# much free.
WEIGHTS = (1e-6, 1e-10)
SPREADS = (2.0**10, 1.0)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DisturbanceCoordinates:
    """x = states xhat, u = inputs uhat - feedback x, w = disturbance what, z = output zhat.

    Attributes
    ----------
    states : (n, n), diagonal where limits are to be posed in them.
    inputs : (m,).
    feedback : K0, (m, n), zero where limits are posed on the input.
    rate : time is counted in 1 / rate, in 1/s; 1 in discrete time, which counts samples.
    """

    states: Floats
    inputs: Floats
    feedback: Floats
    rate: float
    disturbance: float
    output: float

    @classmethod
    def of(
        cls,
        plant: DisturbedPlant,
        P: Floats,
        *,
        feedback: Floats | None = None,
        limits: Limits | None = None,
        peak: float | None = None,
        energy: float | None = None,
        noise: bool = False,
        growth: float = 1.0,
    ) -> DisturbanceCoordinates:
        """Return coordinates where x' P x is |xhat|^2 and the loop's numbers are of order one.

        Parameters
        ----------
        P : (n, n), a guess of the Lyapunov function, but for its size.
        feedback : (m, n), a guess of the gains, from which the input is counted; None, as with
            limits, counts it from zero.
        limits : where there are some, the states are only scaled, by powers of two.
        peak, energy : of w, to be 1 in these coordinates; None where its unit is free.
        growth : how much farther the states get under the disturbance than those of a loop that
            decays as fast as it moves; for peak and energy.
        noise : w is white noise, whose effect in one sample is the root of that share of time.
        """
        step = plant.sample_time
        K0 = np.zeros((plant.B.shape[2], plant.B.shape[1]))
        if feedback is not None and limits is None:
            K0, plant = feedback, plant.fed_back(feedback)
        if limits is None:
            T = np.asarray(np.linalg.inv(np.linalg.cholesky(P)).T)
        else:
            T = np.diag(nearest_power(np.diag(P) ** -0.5))
        speed = vertex_weight(np.linalg.solve(T, motion(plant.A, step) @ T)) / 2
        entering = _size(np.linalg.solve(T, plant.E))
        # In a sample V changes by a share, of the size of speed, of what it is.
        share = 1.0 if step is None else speed
        if peak is not None or energy is not None:
            disturbance = peak or ((energy or 1.0) * speed / share) ** 0.5
            moved = speed if peak is not None or step is None else share**0.5
            if entering:
                # The ellipsoid that such disturbances reach is about the unit ball.
                T = T * float(nearest_power(growth * entering * disturbance / moved))
        elif entering:
            disturbance = (speed if step is None else 1.0 if noise else share**0.5) / entering
        else:
            disturbance = 1.0
        showing = _size(plant.C @ T)
        output = showing or _size(plant.D12) or _size(plant.D11)
        output = output if peak is not None else output / share**0.5
        if limits is not None and limits.inputs is not None:
            inputs = nearest_power(limits.inputs)
        else:
            # An input of 1 moves the states, or shows, about as much as a state of 1 does.
            pushed = np.linalg.norm(np.linalg.solve(T, plant.B), axis=1).max(axis=0) / speed
            shown = np.linalg.norm(plant.D12, axis=1).max(axis=0) / (showing or 1.0)
            inputs = np.asarray(1.0 / np.maximum(pushed, shown))
        return cls(
            states=T,
            inputs=inputs,
            feedback=K0,
            rate=speed if step is None else 1.0,
            disturbance=disturbance,
            output=output,
        )

    @property
    def scales(self) -> Floats:
        """Return the diagonal of the states' unit, (n,)."""
        return np.diag(self.states)

    def gains(self, Q: Floats, M: Floats, rules: int) -> Floats:
        """Return K_i = K0 + M_i Q^-1 in the model's units, (r, m, n)."""
        K = np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        K = self.inputs[:, None] * np.linalg.solve(self.states.T, K.transpose(0, 2, 1)).transpose(
            0, 2, 1
        )
        K = self.feedback + K
        return np.broadcast_to(K, (rules, *K.shape[1:])).copy()

    def scaled_plant(self, plant: DisturbedPlant) -> DisturbedPlant:
        """Return the plant in these coordinates."""
        if self.feedback.any():
            plain = replace(self, feedback=np.zeros_like(self.feedback))
            return plain.scaled_plant(plant.fed_back(self.feedback))
        return plant.in_units(
            self.states,
            self.inputs,
            rate=self.rate,
            disturbance=self.disturbance,
            output=self.output,
        )

    def scaled_gains(self, K: Floats) -> Floats:
        """Return the gains (r, m, n) of the model in these coordinates: M_i = scaled_gains Q."""
        return np.asarray((K - self.feedback) @ self.states / self.inputs[:, None])

    def quadratic(self, Q: Floats) -> Floats:
        """Return P of x' P x = xhat' Q^-1 xhat, in the model's states."""
        back = np.linalg.inv(self.states)
        P = back.T @ np.linalg.solve(Q, back)
        return np.asarray((P + P.T) / 2)


class Regulator(NamedTuple):
    """x' P x, the cost of the linear-quadratic regulator at the mean vertex; its gains and poles.

    Attributes
    ----------
    gains : (m, n) of u = -K x.
    """

    P: Floats
    gains: Floats
    poles: Complex


def guessed_regulator(plant: DisturbedPlant, least_weight: float = WEIGHTS[0]) -> Regulator | None:
    """Return the regulator of the integral, or sum, of |z|^2; None if none exists.

    Every state and input is weighed a little, so that P is positive definite.  In which units the
    states are weighed alike is a guess: balanced ones, and the plant's own.  What is taken is that
    which costs the disturbance least, tr E' P E, so the weights that are added least.
    """
    s = state_units(plant.A, None, step=plant.sample_time)
    s = s / np.exp2(np.round(np.log2(s).mean()))
    # A spread of 1 keeps the plant's own units.
    units = {tuple(np.clip(s, 1 / spread, spread)): None for spread in SPREADS}
    candidates = [_regulator(plant, np.array(each), least_weight) for each in units]
    regulators = [regulator for regulator in candidates if regulator is not None]
    E = plant.E.mean(axis=0)
    return min(regulators, key=lambda regulator: float(np.sum(E * (regulator.P @ E))), default=None)


def _regulator(plant: DisturbedPlant, s: Floats, least_weight: float) -> Regulator | None:
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    A, B = plant.A.mean(axis=0) * s / s[:, None], plant.B.mean(axis=0) / s[:, None]
    C, D = plant.C.mean(axis=0) * s, plant.D12.mean(axis=0)
    tau = 1.0 / np.maximum(np.linalg.norm(B, axis=0), 1e-300)
    # With columns of B of length one the weight that is added below charges all inputs alike.
    B, D = B * tau, D * tau
    weight, spent, cross = C.T @ C, D.T @ D, C.T @ D
    weight = weight + least_weight * (np.abs(weight).max() or 1.0) * np.eye(len(A))
    spent = spent + least_weight * (np.abs(spent).max() or 1.0) * np.eye(B.shape[1])
    discrete = plant.sample_time is not None
    solve = solve_discrete_are if discrete else solve_continuous_are
    try:
        P = np.asarray(solve(A, B, weight, spent, s=cross))
    except (np.linalg.LinAlgError, ValueError):
        return None
    P = (P + P.T) / 2
    # Rounding may leave P indefinite in one of the two units although it is definite in the other.
    if not is_definite(P) or not is_definite(P / s / s[:, None]):
        return None
    if discrete:
        K = np.linalg.solve(spent + B.T @ P @ B, B.T @ P @ A + cross.T)
    else:
        K = np.linalg.solve(spent, B.T @ P + cross.T)
    poles = np.linalg.eigvals(A - B @ K)
    return Regulator(P / s / s[:, None], tau[:, None] * K / s, poles)


def is_definite(P: Floats) -> bool:
    """Return whether P can be |x|^2 in other states: positive definite, to rounding."""
    if not np.isfinite(P).all():
        return False
    try:
        np.linalg.cholesky(P)
    except np.linalg.LinAlgError:
        return False
    return True


def _size(matrices: Array) -> float:
    return float(np.linalg.norm(matrices, 2, axis=(1, 2)).max())


class Norm(NamedTuple):
    """What is made least, and what its number means in the model's units.

    Attributes
    ----------
    condition : builder of the LMIs, called as builder(plant, relaxation=, decay_rate=, limits=).
    gain : the bound, from the request, the coordinates and the objective.
    size : what x' Q^-1 x is multiplied by, from the request and the coordinates.
    """

    condition: Callable[..., Condition]
    gain: Callable[[DisturbanceRequest, DisturbanceCoordinates, float], float]
    size: Callable[[DisturbanceRequest, DisturbanceCoordinates], float]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DisturbanceRequest:
    """A plant, and the other requirements on its gains.

    Attributes
    ----------
    norm : of the disturbance's effect, to be made small.
    decay_rate : alpha in 1/s that is asked for.
    limits : in the model's units; None where there are none.
    given : the same, as they were given.
    tolerance : how far above its least value the objective may end, relative.
    peak, energy : of the disturbance, to be 1 where the limits are posed; None where free.
    noise : the disturbance is white.
    growth : as for ``DisturbanceCoordinates.of``.
    guess : of P, but for its size; None takes that of a regulator.
    feedback : a guess of the gains beside that of P; None takes a regulator's.
    """

    plant: DisturbedPlant
    norm: Norm
    relaxation: str
    decay_rate: float
    limits: Limits | None
    tolerance: float
    given: GivenLimits
    peak: float | None = None
    energy: float | None = None
    noise: bool = False
    growth: float = 1.0
    guess: Floats | None = None
    feedback: Floats | None = None

    @property
    def level(self) -> bool:
        """Return whether limits fix the size of the ellipsoid x' P x <= 1."""
        return self.limits is not None and self.limits.level

    def condition(self, units: DisturbanceCoordinates) -> Condition:
        """Return the LMIs in the given coordinates."""
        limits = None if self.limits is None else self.limits.scaled(units.scales, units.inputs)
        return self.norm.condition(
            units.scaled_plant(self.plant),
            relaxation=self.relaxation,
            decay_rate=self.decay_rate / units.rate,
            limits=limits,
        )

    def gain(self, units: DisturbanceCoordinates, objective: float) -> float:
        """Return the bound in the model's units that an objective stands for."""
        return self.norm.gain(self, units, objective)

    def plain(self) -> Design:
        """Return gains without regard to the disturbance, by ``pdc``."""
        reaching, limits = self.plant.reaching, self.given
        # Merged inputs are not those that limits on inputs and gains are about.
        same_inputs = reaching is self.plant
        return pdc(
            reaching,
            decay_rate=self.decay_rate,
            relaxation=self.relaxation,
            input_limit=limits.input_limit if same_inputs else None,
            initial_box=limits.initial_box,
            state_box=limits.state_box,
            gain_bound=limits.gain_bound if same_inputs else None,
        )

    def mean_of(self, plain: Design) -> Floats | None:
        """Return the mean (m, n) of plain gains; None where they are those of merged inputs."""
        if plain.gains is None or plain.gains.shape[1] != self.plant.B.shape[2]:
            return None
        return np.asarray(plain.gains.mean(axis=0))


def disturbance_request(
    model: Disturbed,
    limits_given: GivenLimits,
    norm: Norm,
    *,
    performance: Performance | None,
    relaxation: str,
    decay_rate: float,
    tolerance: float,
) -> DisturbanceRequest:
    """Return the checked task.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, no disturbance, no output, inputs that are
        dependent or do nothing, a vertex with an unstable mode that no input moves, a tolerance
        below 1e-7, which no solver keeps.
    """
    relaxation_named(relaxation)
    plant = plant_of(model, performance, limits_given.sample_time)
    limits = limits_given.limits(*plant.B.shape[1:])
    names = getattr(model, "states", ())
    check_stabilisable(plant.A, plant.B, names=names, step=plant.sample_time)
    return DisturbanceRequest(
        plant=plant,
        norm=norm,
        relaxation=relaxation,
        decay_rate=float(number("decay_rate", decay_rate, at_least=0.0)),
        limits=limits if limits.level or limits.gain is not None else None,
        tolerance=float(number("tolerance", tolerance, at_least=1e-7)),
        given=limits_given,
    )


# Shares of the rate of the loop at the mean vertex, at which a peak is bounded.
RATES = (0.5, 0.1, 0.02)


def _guesses(task: DisturbanceRequest) -> Iterator[tuple[Floats | None, Floats | None]]:
    """Yield guesses of P and of the gains; None for the P of plain compensation."""
    if task.guess is not None:
        regulator = guessed_regulator(task.plant)
        gains = None if regulator is None else regulator.gains
        yield task.guess, gains if task.feedback is None else task.feedback
    else:
        for weight in WEIGHTS:
            regulator = guessed_regulator(task.plant, weight)
            if regulator is not None:
                yield regulator.P, regulator.gains
    yield None, None
    if task.guess is None:
        yield np.eye(task.plant.A.shape[1]), None


ASK = "smaller gains have a larger norm, which norm_below asks for"


WHY = (
    "the vertices or the output differ too much in size, or these rules can hardly be stabilised; "
    "weigh every state and input a little in the output, allow a larger tolerance, or take a "
    "richer relaxation"
)


NOT_NEAR = "came near the least objective"


ROUNDED = (
    "gains were found, but rounded as they are they do not withstand their check: they are too "
    "large for it; allow a larger tolerance, or give a gain bound"
)
