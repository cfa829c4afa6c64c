"""Steps of a quadratic function and structured gains: P for given gains, then both at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from takagi.lmi.answer import Try
from takagi.lmi.argument_checks import decay_parameter, rate_parameter
from takagi.lmi.condition.evaluate import margin, rate_of_parameter
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion
from takagi.lmi.decision.decide import optimise
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.expressions.expression import Inequality, block, identity, matrix, placement, trace
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.disturbance.request import DisturbanceCoordinates
from takagi.lmi.gains.structured.structure import Objective, Structure, StructuredGains, loop_sum
from takagi.lmi.parameter_search.largest_parameter import extreme_parameter
from takagi.lmi.parameter_search.parameter_sweep import unknowns_near_least
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats


def local_units(
    plant: DisturbedPlant, objective: Objective, P: Floats, K: Floats, value: float | None
) -> tuple[DisturbanceCoordinates, float]:
    """Return coordinates for the function x' P x and gains (r, m, n), and the speed in them.

    In these x' P x is |xhat|^2.  With the value gamma, the supply rate gamma |w|^2 - |z|^2 / gamma
    is |what|^2 - |zhat|^2 times the rate.  The solver then finds P near I and gamma near 1, or near
    a multiple of 1 if no value is known.  The speed is the size of x' (or of x+ - x); 1 in
    continuous time.
    """
    T = np.linalg.inv(np.linalg.cholesky(P)).T
    step = plant.sample_time
    loop = motion(np.linalg.solve(T, (plant.A - plant.B @ K) @ T), step)
    free = motion(np.linalg.solve(T, plant.A @ T), step)
    size = float(max(np.linalg.norm(matrix, 2, axis=(1, 2)).max() for matrix in (loop, free)))
    size = size or 1.0
    rate, speed = (size, 1.0) if step is None else (1.0, min(size, 1.0))
    # An input of size one then moves the state about as fast as the loop moves.
    reach = np.linalg.norm(np.linalg.solve(T, plant.B), axis=1).max(axis=0)
    disturbance = output = 1.0
    if objective == "hinf":
        gamma = value or 1.0
        disturbance, output = np.sqrt(rate / gamma), np.sqrt(rate * gamma)
    elif objective == "cost":
        output = np.sqrt(rate)
    units = DisturbanceCoordinates(
        states=T,
        inputs=rate * speed / np.where(reach > 0, reach, 1.0),
        feedback=np.zeros(K.shape[1:]),
        rate=rate,
        disturbance=float(disturbance),
        output=float(output),
    )
    return units, speed


# Largest eigenvalue of P in a step, in states where P is I at its start; it only keeps the unknowns
# bounded.
LARGEST = 16.0
# Steps of ``extreme_parameter`` that suffice while the gains still move.
FEW = 3


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StructuredPoint:
    """Gains with the best function found for them, in the model's units.

    Attributes
    ----------
    F : (groups, m, p).
    P : (n, n).
    value : decay rate in 1/s, cost, or gamma, that P shows for F.
    outcome, condition : the solver call that found P, and its condition.
    """

    F: Floats
    P: Floats
    value: float
    outcome: Outcome
    condition: Condition


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StepSearch:
    """The objective of the search, with what all its steps need.

    Attributes
    ----------
    plant : in the model's units.
    deviations : L of the covariance L L' of x(0), for the cost.
    gain_bound : on the spectral norm of every K_i; None without.
    required_margin : margin that the LMIs must keep while cost or gamma is minimised; a larger
        margin keeps P better conditioned.
    fine : relative distance from the largest decay rate at which P is taken, for the same reason.
    tries : the record of all solver calls; every call adds to it.
    """

    plant: DisturbedPlant
    structure: Structure
    objective: Objective
    relaxation: str
    deviations: Floats
    gain_bound: float | None = None
    required_margin: float = 1e-6
    fine: float = 1e-4
    tries: list[Try] = field(default_factory=list)

    @property
    def sense(self) -> float:
        """Return 1 where more is better, -1 where less is."""
        return 1.0 if self.objective == "decay_rate" else -1.0

    @property
    def rate(self) -> str:
        """Return the parameter of the decay rate."""
        return "alpha" if self.plant.sample_time is None else "contraction"

    def assessed(
        self, F: Floats, P: Floats, *, value: float | None = None, settle: bool = False
    ) -> StructuredPoint | None:
        """Return the best P for the gains; None if none is found.

        The problem is posed in states in which the given P is I, so that the solver's numbers are
        near 1.

        ``value`` : an expected gamma, which only sets units.
        ``settle`` : True for the final answer: no margin is kept, and more solvers are tried.
        """
        K = self.structure.gains(F)
        units, speed = local_units(self.plant, self.objective, P, K, value)
        n = len(P)
        unknown = Unknown("P", n, n, symmetric=True)
        gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
        fixed_gains = StructuredGains(reference=units.scaled_gains(K))
        condition = self._condition(units, unknown, gamma, fixed_gains)
        outcome, value = self._best(condition, units, speed, fixed_gains.reference, settle)
        if value is None:
            return None
        back = np.linalg.inv(units.states)
        lyapunov = back.T @ outcome.values["P"][0] @ back
        return StructuredPoint(
            F=F,
            P=(lyapunov + lyapunov.T) / 2,
            value=value,
            outcome=outcome,
            condition=condition,
        )

    def guessed(self, decaying: StructuredPoint) -> tuple[Floats, float | None]:
        """Return P of about the right size, and gamma, from a function that decays.

        With V' <= -2 alpha V, |z|^2 <= c^2 V and an effect of w of size e, c^2 / (2 alpha) V bounds
        the cost, and gamma is about c e / alpha, with c / e V.
        """
        K = self.structure.gains(decaying.F)
        T = np.linalg.inv(np.linalg.cholesky(decaying.P)).T
        step = self.plant.sample_time
        alpha = decaying.value * (1.0 if step is None else step)
        output_size = float(
            np.linalg.norm((self.plant.C - self.plant.D12 @ K) @ T, 2, axis=(1, 2)).max()
        )
        entering = float(np.linalg.norm(np.linalg.solve(T, self.plant.E), 2, axis=(1, 2)).max())
        if self.objective == "cost":
            return decaying.P * ((output_size or 1.0) ** 2 / (2.0 * alpha)), None
        if not (output_size and entering):
            return decaying.P, None
        return decaying.P * (output_size / entering), output_size * entering / alpha

    def moved(self, spot: StructuredPoint, spread: float) -> Floats | None:
        """Return the gains of the inner convex step from a point; None where it finds none."""
        K = self.structure.gains(spot.F)
        units, speed = local_units(self.plant, self.objective, spot.P, K, spot.value)
        C = self.structure.C @ units.states
        sizes = np.linalg.norm(C, axis=1)
        inside = replace(self.structure, C=C / sizes[:, None])
        n = len(spot.P)
        unknown = Unknown("P", n, n, symmetric=True)
        gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
        rows = self.structure.unknowns()
        varying_gains = StructuredGains(
            reference=units.scaled_gains(K), structure=inside, unknowns=rows, spread=spread
        )
        condition = self._condition(units, unknown, gamma, varying_gains)
        if self.objective == "decay_rate":
            # The search starts a little below the rate that is known, where (P, L) is feasible
            # with a margin.
            (at,) = rate_parameter(spot.value / units.rate, self.plant.sample_time).values()
            rate_tolerance = self._hair(speed, self.fine / 10)(at)
            origin = at - (rate_tolerance if self.rate == "alpha" else -rate_tolerance)
            extreme = extreme_parameter(
                condition.with_parameters(**{self.rate: origin}),
                self.rate,
                largest=self.rate == "alpha",
                steps=FEW,
                step=lambda _: rate_tolerance / 10,
                centre=False,
            )
            self.tries.extend(extreme.outcome.tries)
            values: Mapping[str, Floats] = extreme.best
        else:
            values = unknowns_near_least(condition, required_margin=self.required_margin)
        if not values:
            return None
        F = self.structure.assembled([values[row.name] for row in rows])
        return self.bounded(F * units.inputs[:, None] / sizes)

    def bounded(self, F: Floats) -> Floats:
        """Return the gains; those beyond the bound are scaled down to it."""
        if self.gain_bound is None:
            return F
        size = np.linalg.norm(F @ self.structure.C, 2, axis=(1, 2))
        return np.asarray(
            F * np.minimum(1.0, self.gain_bound / np.maximum(size, 1e-300))[:, None, None]
        )

    def _condition(
        self, units: DisturbanceCoordinates, P: Unknown, gamma: Unknown, gains: StructuredGains
    ) -> Condition:
        plant = units.scaled_plant(self.plant)
        slack, sums = relaxation_named(self.relaxation)(
            loop_sum(plant, self.objective, P, gamma, gains)
        )
        statements: tuple[Inequality | LMI, ...] = (positive_definite(P), *sums)
        if self.objective == "decay_rate" or gains.structure is not None:
            statements += (scale_bound(P, 1.0 if gains.structure is None else LARGEST),)
        if self.gain_bound is not None and gains.structure is not None:
            statements += (_bound_lmi(gains, units, self.gain_bound),)
        unknowns, minimise = (P, *gains.unknowns, *slack), None
        if self.objective == "hinf":
            unknowns, minimise = (*unknowns, gamma), +gamma
        elif self.objective == "cost":
            L = np.linalg.solve(units.states, self.deviations)
            minimise = trace((L @ L.T / np.trace(L @ L.T)) @ P)
        return pose(
            *statements,
            minimise=minimise,
            unknowns=unknowns,
            parameters=(decay_parameter(0.0, self.plant.sample_time),)
            if self.objective == "decay_rate"
            else (),
            name=f"structured gains, {self.objective}, {self.relaxation}",
        )

    def _best(
        self,
        condition: Condition,
        units: DisturbanceCoordinates,
        speed: float,
        K: Floats,
        settle: bool,
    ) -> tuple[Outcome, float | None]:
        """Return the best P in the given coordinates, and its value in the model's units."""
        if self.objective != "decay_rate":
            outcome = optimise(condition, slack=1e-5) if settle else self._near_least(condition)
            self.tries.extend(outcome.tries)
            if outcome.status != "candidate":
                return outcome, None
            if self.objective == "hinf":
                gamma = outcome.values["gamma"][0, 0, 0]
                return outcome, float(gamma * units.output / units.disturbance)
            L = np.linalg.solve(units.states, self.deviations)
            return outcome, float(np.trace(L.T @ outcome.values["P"][0] @ L))
        plant = units.scaled_plant(self.plant)
        # P = I is feasible at this rate, however unstable the loop is: |x'| <= size |x|.
        size = float(np.linalg.norm(plant.A[:, None] - plant.B[:, None] @ K, 2, axis=(2, 3)).max())
        origin = -1.01 * size - speed if self.rate == "alpha" else 1.01 * size**2 + 1.0
        extreme = extreme_parameter(
            condition.with_parameters(**{self.rate: origin}),
            self.rate,
            largest=self.rate == "alpha",
            step=self._hair(speed, self.fine),
        )
        self.tries.extend(extreme.outcome.tries)
        if not extreme.found:
            return extreme.outcome, None
        parameter = extreme.condition.parameters[self.rate]
        return extreme.outcome, rate_of_parameter(parameter, self.plant.sample_time) * units.rate

    def _near_least(self, condition: Condition) -> Outcome:
        values = unknowns_near_least(condition, required_margin=self.required_margin)
        checked_margin = margin(condition, values) if values else -np.inf
        return Outcome(
            "candidate" if checked_margin > 0 else "unknown", values, checked_margin, np.inf, {}, ()
        )

    def _hair(self, speed: float, fine: float) -> Callable[[float], float]:
        """Return the tolerance of the rate's parameter: ``fine`` relative, never quite 0."""
        no_decay = 0.0 if self.rate == "alpha" else 1.0
        return lambda at: fine * max(abs(at - no_decay), 1e-3 * speed)


def _bound_lmi(gains: StructuredGains, units: DisturbanceCoordinates, bound: float) -> Inequality:
    """Pose [[I, K_j / b], [K_j' / b, I]] >= 0, |K_j| <= b in the model's units, for each group."""
    assert gains.structure is not None
    back = gains.structure.C @ np.linalg.inv(units.states)
    inputs, groups = np.diag(units.inputs / bound), np.arange(gains.structure.groups)
    rows = [
        matrix(inputs[:, [k]], f"e_{{{k + 1}}}")
        @ row.members(groups, row.symbol)
        @ placement(back[gains.structure.pattern[k]])
        for k, row in zip(gains.structure.rows, gains.unknowns, strict=True)
    ]
    gain = block([[identity(len(inputs)), sum(rows[1:], rows[0])], [None, identity(len(back.T))]])
    return (gain >> 0).named("gain bound")
