"""The turbine's nonlinear loop, made anew in floats from a certificate's own numbers.

The formulas are those of docs/effort-sharing-loop.md: the law with its limits, the pitch drive, the
rotor, and a wake between equilibrium and frozen, whose torque is

    Delta(beta) = -wake * integral from beta* to beta of max(0, b_fw + d(T_r/J)/dbeta).

Nothing is shared with the checker; the surface is scipy's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import NdBSpline

Data = dict[str, Any]
Floats = NDArray[np.float64]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)
MODEL = (
    *("torque_constant", "rotor_radius", "rotor_inertia", "generator_inertia", "gear_ratio"),
    *("rated_rotor_speed", "pitch_time_constant", "pitch_rate_limit", "pitch_min", "pitch_max"),
    "torque_rate_limit",
)
LAW = (
    *("overlap", "rated_torque", "effort_torque", "pitch_min", "pitch_max"),
    "integral_limit",
)
TABLES = ("rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit", "proportional")
STEPS = ("integral_rate",)


def column(values: Any) -> Floats:
    return np.array([float(value) for value in values])


def psi(s: Floats, overlap: float) -> Floats:
    """Return the ramp: 0 below -overlap, s beyond overlap, a parabola between."""
    bent = (s + overlap) ** 2 / (4 * overlap)
    return np.where(s <= -overlap, 0.0, np.where(s >= overlap, s, bent))


def share(s: Floats, overlap: float) -> Floats:
    """Return psi'."""
    return np.clip((s + overlap) / (2 * overlap), 0.0, 1.0)


@dataclass
class At:
    """Points of cells: the tables there, and one member of the family of plants each."""

    k: NDArray[np.int64]
    wind: Floats
    table: dict[str, Floats]
    slope: dict[str, Floats]
    kappa: Floats
    wake: Floats
    power: Floats


@dataclass
class Motion:
    """Where a state moves, and what the parts of the loop do there."""

    xi: Floats
    torque: Floats
    asked: Floats
    pitch: Floats
    drive: Floats
    turn: Floats


class Loop:
    """The loop of a document: plant, law, claim."""

    def __init__(self, document: Data, claim: Data) -> None:
        model, law = document["model"], document["gains"]
        self.claim, self.cells = claim, claim["cells"]
        self.number = {key: float(model[key]) for key in MODEL}
        self.law = {key: float(law[key]) for key in LAW}
        self.J = self.number["rotor_inertia"]
        self.J += self.number["gear_ratio"] ** 2 * self.number["generator_inertia"]
        self.c = self.number["torque_constant"] / self.J
        self.m = self.number["gear_ratio"] * self.law["effort_torque"] / self.J
        self.rated = self.number["gear_ratio"] * self.law["rated_torque"] / self.J
        surface = model["torque_surface"]
        knots = [column(surface[key]) for key in ("tip_speed_ratio_knots", "pitch_knots")]
        table = np.array([column(row) for row in surface["coefficients"]])
        self.surface = NdBSpline(tuple(knots), table, 3, extrapolate=False)
        self.wind, self.wind_filter = column(law["wind"]), float(law["wind_filter"])
        self.tables = {key: column(law[key]) for key in TABLES}
        self.steps = {key: column(law[key]) for key in STEPS}
        low, high = column(claim["uncertainty"]["inertia"])
        self.kappa = (1 / high, 1 / low)
        self.frozen = claim["uncertainty"]["frozen_wake"] is True
        self.power = column(claim["uncertainty"].get("power_coefficient", (1, 1)))
        self.box = {key: float(value) for key, value in claim["box"].items()}
        self.P = np.array([column(row) for row in claim["P"]])
        self.R = np.array([column(row) for row in claim["settling"]["P"]])

    def stated(self, key: str, k: NDArray[np.int64]) -> Floats:
        return np.array([float(cell[key]) for cell in self.cells])[k]

    def overspeed(self) -> float:
        """Return by how much of rated speed the set's fastest state exceeds it [%]."""
        fastest = self.tables["rotor_speed"].max() + np.sqrt(np.linalg.inv(self.P)[0, 0])
        return float(100 * (fastest / self.number["rated_rotor_speed"] - 1))

    def at(self, k: NDArray[np.int64], z: Floats) -> At:
        """Return points of cells k; z (n, 3) in [0, 1]: the place in the cell, inertia, wake.

        Power coefficients alternate between their ends: torque is affine in them.
        """
        place, width = z[:, 0], np.diff(self.wind)[k]
        table = {x: t[k] + place * np.diff(t)[k] for x, t in self.tables.items()}
        slope = {x: np.diff(t)[k] / width for x, t in self.tables.items()}
        kappa = self.kappa[0] + z[:, 1] * (self.kappa[1] - self.kappa[0])
        wake, power = z[:, 2] * self.frozen, np.resize(self.power, len(k))
        return At(k, self.wind[k] + place * width, table, slope, kappa, wake, power)

    def cq(self, speed: Floats, pitch: Floats, wind: Floats, nu: tuple[int, int]) -> Floats:
        """Return c_Q or a derivative at omega R / v."""
        ratio, angle = np.broadcast_arrays(speed * self.number["rotor_radius"] / wind, pitch)
        found: Floats = self.surface(np.stack([ratio, angle], axis=-1), nu=nu)
        return found

    def _steepness(self, at: At, pitch: Floats) -> tuple[Floats, Floats]:
        """Return -dT_r/dbeta / J at omega*, and what the wake adds to it."""
        shape = (-1,) + (1,) * (pitch.ndim - 1)
        speed, limit = (at.table[x].reshape(shape) for x in ("rotor_speed", "effectiveness_limit"))
        wind, wake, power = (x.reshape(shape) for x in (at.wind, at.wake, at.power))
        own = -self.c * power * wind**2 * self.cq(speed, pitch, wind, (0, 1))
        return own, wake * np.maximum(limit - own, 0)

    def steepness(self, at: At, pitch: Floats) -> Floats:
        """Return -dT/dbeta / J at omega*, with as much of the frozen wake as the plant has."""
        own, more = self._steepness(at, pitch)
        return own + more

    def added(self, at: At, pitch: Floats) -> Floats:
        """Return Delta: what the wake adds to torque over J, zero in the trim pitch."""
        low = self.law["pitch_min"]
        trim = low + psi(at.table["trim_effort"], self.law["overlap"]) / at.table["effectiveness"]
        half = (pitch - trim) / 2
        _, more = self._steepness(at, (trim + half)[:, None] + half[:, None] * NODES)
        return np.asarray(-half * (more @ WEIGHTS))

    def motion(self, at: At, xi: Floats, wind: Floats, rate: Floats) -> Motion:
        """Return xi' of the nonlinear loop at schedule winds that move at ``rate``."""
        e, zeta, x = xi.T
        law, t, s, k = self.law, at.table, at.slope, at.k
        b, gamma, eps = t["effectiveness"], t["proportional"], law["overlap"]
        U = t["trim_effort"] + gamma * (e - x)
        F, shed = share(U, eps), psi(U, eps)
        asked = law["rated_torque"] - law["effort_torque"] * psi(-U, eps)
        torque = np.clip(asked, 0, law["rated_torque"])
        N = F * (s["trim_effort"] + s["proportional"] * (e - x)) - shed * s["effectiveness"] / b
        wanted = law["pitch_min"] + shed / b
        reference = np.clip(wanted, law["pitch_min"], law["pitch_max"])
        pitch = law["pitch_min"] + (shed - zeta) / b
        lag, most = self.number["pitch_time_constant"], self.number["pitch_rate_limit"]
        drive = np.clip((reference - pitch) / lag, -most, most)
        speed = t["rotor_speed"] + e
        rotor = self.c * at.power * wind**2 * self.cq(speed, pitch, wind, (0, 0))
        rotor += self.added(at, pitch)
        held = self.number["gear_ratio"] * torque / self.J
        de = at.kappa * (rotor - held) - s["rotor_speed"] * rate
        dx = -self.steps["integral_rate"][k] * e
        dU = (s["trim_effort"] + s["proportional"] * (e - x)) * rate + gamma * (de - dx)
        dz = F * dU - s["effectiveness"] * rate * (pitch - law["pitch_min"]) - b * drive
        return Motion(np.stack([de, dz, dx], 1), asked, wanted, pitch, drive, rate * N)
