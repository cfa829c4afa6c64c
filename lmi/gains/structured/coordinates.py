"""Coordinates in which a given function is |x|^2 and its value (rate, cost, gamma) is near 1."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.condition.rate_of_values import rate_of_parameter
from takagi.lmi.cone.balance import motion
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.structured.structure import Structure
from takagi.lmi.gains.structured.sums import Objective
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LocalUnits:
    """Units of x = states xhat, u = inputs uhat, w = disturbance what, z = output zhat, and time.

    In these units x' P x is |xhat|^2. With the value gamma, the supply rate gamma |w|^2 - |z|^2 /
    gamma is |what|^2 - |zhat|^2 times the rate. The solver then finds P near I and gamma near 1, or
    near a multiple of 1 if no value is known.

    Attributes
    ----------
    states, inputs : (n, n), (m,).
    time : in 1/s; 1 in discrete time, which counts samples.
    speed : size of x' (or of x+ - x) in these units; 1 in continuous time.
    sample_time : T in s; None for continuous time.
    """

    states: Floats
    inputs: Floats
    time: float
    speed: float
    disturbance: float
    output: float
    sample_time: float | None

    @classmethod
    def of(
        cls,
        plant: DisturbedPlant,
        objective: Objective,
        P: Floats,
        K: Floats,
        *,
        value: float | None = None,
    ) -> LocalUnits:
        """Return the units for the function x' P x and gains (r, m, n).

        ``value`` is an expected gamma for "hinf"; it sets the units of w and z.
        """
        T = np.linalg.inv(np.linalg.cholesky(P)).T
        step = plant.sample_time
        loop = motion(np.linalg.solve(T, (plant.A - plant.B @ K) @ T), step)
        free = motion(np.linalg.solve(T, plant.A @ T), step)
        size = float(max(np.linalg.norm(part, 2, axis=(1, 2)).max() for part in (loop, free)))
        size = size or 1.0
        time, speed = (size, 1.0) if step is None else (1.0, min(size, 1.0))
        # An input of size one then moves the state about as fast as the loop moves.
        reach = np.linalg.norm(np.linalg.solve(T, plant.B), axis=1).max(axis=0)
        disturbance = output = 1.0
        if objective == "hinf":
            gamma = value or 1.0
            disturbance, output = np.sqrt(time / gamma), np.sqrt(time * gamma)
        elif objective == "cost":
            output = np.sqrt(time)
        return cls(
            states=T,
            inputs=time * speed / np.where(reach > 0, reach, 1.0),
            time=time,
            speed=speed,
            disturbance=float(disturbance),
            output=float(output),
            sample_time=step,
        )

    def scaled_plant(self, plant: DisturbedPlant) -> DisturbedPlant:
        """Return the plant in these coordinates."""
        T, tau, d, c = self.states, self.inputs, self.disturbance, self.output
        return replace(
            plant,
            A=np.asarray(np.linalg.solve(T, plant.A @ T) / self.time, dtype=np.float64),
            B=np.asarray(np.linalg.solve(T, plant.B * tau) / self.time, dtype=np.float64),
            E=np.asarray(np.linalg.solve(T, plant.E) * (d / self.time), dtype=np.float64),
            C=plant.C @ T / c,
            D12=plant.D12 * tau / c,
            D11=plant.D11 * (d / c),
        )

    def scaled_gains(self, K: Floats) -> Floats:
        """Return gains in these coordinates."""
        return np.asarray(K @ self.states / self.inputs[:, None])

    def scaled_structure(self, structure: Structure) -> tuple[Structure, Floats]:
        """Return the structure with rows of C of length one, and their lengths before, (p,)."""
        C = structure.C @ self.states
        sizes = np.linalg.norm(C, axis=1)
        return replace(structure, C=C / sizes[:, None]), sizes

    def parameter(self, rate: float) -> float:
        """Return ``alpha`` in these units, or ``contraction``, of a decay rate in 1/s."""
        (value,) = rate_parameter(rate / self.time, self.sample_time).values()
        return value

    def rate_of(self, parameter: float) -> float:
        """Return the decay rate in 1/s of a parameter."""
        return rate_of_parameter(parameter, self.sample_time) * self.time
