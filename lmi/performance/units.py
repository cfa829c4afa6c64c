"""Coordinates for a design against disturbances, in which a guess of its cost is about |x|^2.

Balanced vertices alone leave the Lyapunov function of a good design ill-conditioned, by 1e9 for a
turbo-generator of ten states; in coordinates where a regulator's cost is |x|^2 it is near I.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.analysis.quadratic import vertex_weight
from takagi.lmi.performance.disturbed_plant import DisturbedPlant
from takagi.lmi.solver.balance import motion, nearest_power, state_units
from takagi.lmi.synthesis.limits import Limits
from takagi.lmi.term import Array

__all__ = ["PerformanceUnits", "Regulator", "guessed_regulator"]

Floats: TypeAlias = NDArray[np.float64]

# Share of the largest weight that a state or an input has where the output does not show it.
LEAST_WEIGHT = 1e-3


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PerformanceUnits:
    """x = states xhat, u = inputs uhat, w = disturbance what, z = output zhat, time in 1 / rate.

    Attributes
    ----------
    states : (n, n), diagonal where limits are to be posed in them.
    inputs : (m,).
    rate : in 1/s; 1 in discrete time, which counts samples.
    """

    states: Floats
    inputs: Floats
    rate: float
    disturbance: float
    output: float

    @classmethod
    def of(
        cls,
        plant: DisturbedPlant,
        P: Floats,
        *,
        limits: Limits | None = None,
        peak: float | None = None,
        energy: float | None = None,
        noise: bool = False,
    ) -> PerformanceUnits:
        """Return coordinates where x' P x is |xhat|^2 and the loop's numbers are of order one.

        Parameters
        ----------
        P : (n, n), a guess of the Lyapunov function, but for its size.
        limits : where there are some, the states are only scaled, by powers of two.
        peak, energy : of w, to be 1 in these coordinates; None where its unit is free.
        noise : w is white noise, whose effect in one sample is the root of that share of time.
        """
        step = plant.sample_time
        T = _states(P, diagonal=limits is not None)
        speed = vertex_weight(np.linalg.solve(T, motion(plant.A, step) @ T)) / 2
        entering = _size(np.linalg.solve(T, plant.E))
        # In a sample V changes by a share, of the size of speed, of what it is.
        share = 1.0 if step is None else speed
        if peak is not None or energy is not None:
            disturbance = peak or ((energy or 1.0) * speed / share) ** 0.5
            pushed = speed if peak is not None or step is None else share**0.5
            if entering:
                # The ellipsoid that such disturbances reach is about the unit ball.
                T = T * _power(entering * disturbance / pushed)
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
            inputs = _inputs(plant, T, speed, showing)
        return cls(
            states=T,
            inputs=inputs,
            rate=speed if step is None else 1.0,
            disturbance=disturbance,
            output=output,
        )

    @property
    def scales(self) -> Floats:
        """Return the diagonal of the states' unit, (n,)."""
        return np.diag(self.states)

    def gains(self, Q: Floats, M: Floats, rules: int) -> Floats:
        """Return K_i = M_i Q^-1 in the model's units, (r, m, n)."""
        K = np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        K = self.inputs[:, None] * np.linalg.solve(self.states.T, K.transpose(0, 2, 1)).transpose(
            0, 2, 1
        )
        return np.broadcast_to(K, (rules, *K.shape[1:])).copy()

    def quadratic(self, Q: Floats) -> Floats:
        """Return P of x' P x = xhat' Q^-1 xhat, in the model's states."""
        back = np.linalg.inv(self.states)
        P = back.T @ np.linalg.solve(Q, back)
        return np.asarray((P + P.T) / 2)


class Regulator(NamedTuple):
    """x' P x, the cost of the linear-quadratic regulator at the mean vertex, and its poles."""

    P: Floats
    poles: NDArray[np.complex128]


def guessed_regulator(plant: DisturbedPlant) -> Regulator | None:
    """Return the regulator of the integral, or sum, of |z|^2; None if there is none.

    Every state and input is weighed a little, so that P is positive definite.
    """
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    s = state_units(plant.A, None, step=plant.sample_time)
    A, B = plant.A.mean(axis=0) * s / s[:, None], plant.B.mean(axis=0) / s[:, None]
    C, D = plant.C.mean(axis=0) * s, plant.D12.mean(axis=0)
    tau = 1.0 / np.maximum(np.linalg.norm(B, axis=0), 1e-300)
    B, D = B * tau, D * tau
    weight, spent, both = C.T @ C, D.T @ D, C.T @ D
    weight = weight + LEAST_WEIGHT * (np.abs(weight).max() or 1.0) * np.eye(len(A))
    spent = spent + LEAST_WEIGHT * (np.abs(spent).max() or 1.0) * np.eye(B.shape[1])
    discrete = plant.sample_time is not None
    solve = solve_discrete_are if discrete else solve_continuous_are
    try:
        P = np.asarray(solve(A, B, weight, spent, s=both))
    except (np.linalg.LinAlgError, ValueError):
        return None
    P = (P + P.T) / 2
    if not np.isfinite(P).all() or np.linalg.eigvalsh(P)[0] <= 0:
        return None
    if discrete:
        K = np.linalg.solve(spent + B.T @ P @ B, B.T @ P @ A + both.T)
    else:
        K = np.linalg.solve(spent, B.T @ P + both.T)
    return Regulator(P / s / s[:, None], np.linalg.eigvals(A - B @ K))


def _states(P: Floats, *, diagonal: bool) -> Floats:
    if diagonal:
        return np.diag(nearest_power(np.diag(P) ** -0.5))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(P)).T)


def _inputs(plant: DisturbedPlant, T: Floats, speed: float, showing: float) -> Floats:
    """Return (m,): an input of 1 moves the states, or shows, about as much as a state of 1 does."""
    pushed = np.linalg.norm(np.linalg.solve(T, plant.B), axis=1).max(axis=0) / speed
    shown = np.linalg.norm(plant.D12, axis=1).max(axis=0) / (showing or 1.0)
    return np.asarray(1.0 / np.maximum(pushed, shown))


def _power(value: float) -> float:
    return float(nearest_power(np.array([value]))[0])


def _size(matrices: Array) -> float:
    return float(np.linalg.norm(matrices, 2, axis=(1, 2)).max())
