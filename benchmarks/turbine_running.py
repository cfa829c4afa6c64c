"""The turbine's loop with observer and filters, written anew from docs/running-loop.md in floats.

It reads a certificate's own decimals and shares no code with checkers or candidates: splines and
integration are scipy's, tables numpy's.  ``why_running_false`` searches a claim of kind
``running-loop`` for a state of a cell's set at which V does not fall as claimed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import bisplev
from scipy.linalg import eigh
from scipy.optimize import brentq

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Plant:
    """What is uncertain: true over nominal inertia, the wake's length [m], h over its most [-]."""

    inertia: float = 1.0
    length: float = 60.0
    late: float = 0.5


class Motion:
    """The nonlinear loop at one constant wind of a cell, in distances from its rest."""

    def __init__(self, document: Any, cell: Any, wind: float, plant: Plant) -> None:
        self.model, self.law, self.claim = (
            document["model"],
            document["gains"],
            document["claims"][0],
        )
        self.cell, self.v, self.plant = cell, wind, plant
        model = self.model
        n = model["gear_ratio"]
        self.J = model["rotor_inertia"] + n * n * model["generator_inertia"]
        self.n = n
        table = model["torque_surface"]
        axes = np.array(table["tip_speed_ratio_knots"]), np.array(table["pitch_knots"])
        self.surface = (*axes, np.array(table["coefficients"]).ravel(), 3, 3)
        self.nodes = np.array(self.law["wind"])
        low, high = cell["wind"]
        inner = self.nodes[(self.nodes > low) & (self.nodes < high)]
        b = [self.at("effectiveness", v) for v in (low, *inner, high)]
        self.b0 = round((min(b) + max(b)) * 500) / 1000
        self.speed = self.at("rotor_speed", wind)
        gamma = self.at("proportional", wind)
        self.effort = float(
            brentq(self.balance, *(self.at("trim_effort", wind) + np.array([-0.01, 0.01])))
        )
        self.x_rest = (self.at("trim_effort", wind) - self.effort) / gamma
        self.pitch = self.law["pitch_min"] + self.psi(self.effort) / self.at("effectiveness", wind)

    # Tables, ramp, torque.

    def at(self, name: str, wind: float) -> float:
        return float(np.interp(wind, self.law["wind"], self.law[name]))

    def interval(self, wind: float) -> int:
        found = int(np.searchsorted(self.nodes, wind, side="right")) - 1
        return min(max(found, 0), len(self.nodes) - 2)

    def psi(self, s: float) -> float:
        eps = self.law["overlap"]
        return 0.0 if s <= -eps else s if s >= eps else (s + eps) ** 2 / (4 * eps)

    def torque(self, speed: float, pitch: float, wind: float, dx: int = 0, dy: int = 0) -> float:
        """Return T_r / J [rad/s^2], or a derivative of c_Q with the same factor in front."""
        ratio = speed * self.model["rotor_radius"] / wind
        value = float(cast("Any", bisplev)(ratio, pitch, self.surface, dx=dx, dy=dy))
        return float(self.model["torque_constant"] / self.J * wind**2 * value)

    def load(self, effort: float) -> float:
        """Return n_g T / J for a demanded effort."""
        law = self.law
        asked = law["rated_torque"] - law["effort_torque"] * self.psi(-effort)
        return float(self.n * min(max(asked, 0.0), law["rated_torque"]) / self.J)

    def balance(self, effort: float) -> float:
        pitch = self.law["pitch_min"] + self.psi(effort) / self.at("effectiveness", self.v)
        return self.torque(self.speed, pitch, self.v) - self.load(effort)

    # The loop.

    def commands(self, xi: Floats) -> tuple[float, float]:
        """Return n_g T_c / J [rad/s^2] and beta_c [rad]."""
        law, x, s, m = self.law, *xi[2:5]
        v_s = self.v + s
        signal = self.speed + m - self.at("rotor_speed", v_s) - self.x_rest - x
        U = self.at("trim_effort", v_s) + self.at("proportional", v_s) * signal
        asked = law["pitch_min"] + self.psi(U) / self.at("effectiveness", v_s)
        return self.load(U), min(max(asked, law["pitch_min"]), law["pitch_max"])

    def late(self) -> float:
        """Return h [rad/s^2 per rad]: at most what the table's effectiveness lacks to its limit."""
        own = -self.torque(self.speed, self.pitch, self.v, 0, 1)
        return self.plant.late * max(self.at("effectiveness_limit", self.v) - own, 0.0)

    def rate(self, xi: Floats) -> Floats:
        """Return xi'; the last two states are the band-stop's, where the law has one."""
        law, model, seen = self.law, self.model, self.claim["observer"]
        e, p, x, s, m, o, z, eta = xi[:8]
        load, asked = self.commands(xi)
        pitch = self.pitch + p / self.b0
        moving = (asked - pitch) / model["pitch_time_constant"]
        moving = min(max(moving, -model["pitch_rate_limit"]), model["pitch_rate_limit"])
        v_s = self.v + s
        held = min(max(self.v + z, self.nodes[0]), self.nodes[-1])
        error = self.speed + m - self.at("rotor_speed", v_s)
        torque = self.torque(self.speed + e, pitch, self.v) - self.late() * (p - eta) / self.b0
        observed = self.torque(self.speed + m, pitch, self.v + z)
        filters = self.claim["measurement"]
        stopped, moved = self.band_stop(e, xi)
        return np.array([
            (torque - load) / self.plant.inertia,
            self.b0 * moving,
            -law["integral_rate"][self.interval(v_s)] * error,
            (held - v_s) / law["wind_filter"],
            filters["speed_filter"] * (stopped - m),
            observed - load + seen["l1"] * (m - o),
            seen["l2"] * (m - o),
            (p - eta) * self.v / self.plant.length,
            *moved,
        ])  # fmt: skip

    def band_stop(self, e: float, xi: Floats) -> tuple[float, list[float]]:
        """Return what the band-stop passes on of the speed, and the rates of its states."""
        stop = self.claim["measurement"].get("torsion_filter")
        if stop is None:
            return e, []
        w, left = stop["frequency"], 2 * (1 - stop["passed"])
        return e - left * (xi[8] - xi[9]), [w * (e - xi[8]), w * (xi[8] - xi[9])]

    # Secants.

    def secants(self, xi: Floats) -> dict[str, float]:
        """Return the factors of docs/running-loop.md between a state and the rest."""
        e, p, x, s, m, o, z, eta = xi[:8]
        law, v, v_s = self.law, self.v, self.v + s
        pitch, b, b_s = (
            self.pitch + p / self.b0,
            self.at("effectiveness", v),
            self.at("effectiveness", v_s),
        )
        signal = self.speed + m - self.at("rotor_speed", v_s) - self.x_rest - x
        U = self.at("trim_effort", v_s) + self.at("proportional", v_s) * signal
        bent = (self.at("proportional", v_s) - self.at("proportional", v)) / s
        steep = (self.at("trim_effort", v_s) - self.at("trim_effort", v)) / s
        _, asked = self.commands(xi)
        owed = (asked - pitch) / self.model["pitch_time_constant"]
        away = self.torque(self.speed, pitch, v) - self.torque(self.speed, self.pitch, v)
        return {
            "speed slope": (self.at("rotor_speed", v_s) - self.speed) / s,
            "effort slope": steep - bent * self.x_rest,
            "gamma": self.at("proportional", v_s),
            "share": (self.psi(U) - self.psi(self.effort)) / (U - self.effort),
            "held estimate": (self.rate(xi)[3] * law["wind_filter"] + s) / z,
            "pitch per effort": self.b0 / b_s,
            "pitch by schedule": self.psi(self.effort) * (b_s - b) / s * self.b0 / (b_s * b),
            "integral rate": law["integral_rate"][self.interval(v_s)],
            "stiffness": (
                self.torque(self.speed + e, pitch, v) - self.torque(self.speed, pitch, v)
            ) / e,
            "pitch gain": -away / p,
            "late pitch gain": self.late() / self.b0,
            "inertia": 1 / self.plant.inertia,
            "observed stiffness": (
                self.torque(self.speed + m, pitch, v) - self.torque(self.speed + e, pitch, v)
            ) / (m - e),
            "wind gain": (
                self.torque(self.speed + m, pitch, v + z) - self.torque(self.speed + m, pitch, v)
            ) / z,
            "observer inertia": 1.0,
            "wake rate": v / self.plant.length,
            "drive": self.rate(xi)[1] / self.b0 / owed,
        }  # fmt: skip


def boundary(P: Floats, count: int, seed: int) -> Floats:
    """Return points with xi'P xi = 1."""
    rng = np.random.default_rng(seed)
    found = rng.normal(size=(count, len(P)))
    sizes = np.sqrt(np.einsum("ki,ij,kj->k", found, P, found))
    return np.asarray(found / sizes[:, None])


MARGIN = 1e-6
# Cells that are tried of a claim, and points and plants of each.
TRIED, POINTS = 12, 12


def why_running_false(document: Any, claim: Any, draw: np.random.Generator) -> str:
    """Return a state at which a claim is false; empty when none was seen."""
    whole = as_floats({**document, "claims": [claim]})
    claim = whole["claims"][0]
    cells, alpha, least = claim["cells"], claim["decay_rate"], whole["gains"]["pitch_min"]
    (light, heavy), (short, long) = (
        claim["uncertainty"][name] for name in ("inertia", "wake_length")
    )
    for k in draw.choice(len(cells), size=min(TRIED, len(cells)), replace=False):
        P = np.array(cells[k]["P"])
        if np.linalg.eigvalsh((P + P.T) / 2).min() <= 0:
            return f"cell {k + 1}: P is not positive definite"
        plant = Plant(draw.uniform(light, heavy), draw.uniform(short, long), draw.uniform(0, 1))
        at = Motion(whole, cells[k], draw.uniform(*cells[k]["wind"]), plant)
        for xi in (*slowest(at, P), *boundary(P, POINTS, int(draw.integers(1 << 30)))):
            if at.pitch + xi[1] / at.b0 < least:
                continue
            slope, V = 2 * xi @ P @ at.rate(xi), xi @ P @ xi
            if slope > -2 * alpha * V + MARGIN:
                return f"cell {k + 1}: V moves at {slope:.4g} 1/s where it is {V:.4g}"
    return ""


def slowest(at: Motion, P: Floats) -> list[Floats]:
    """Return points of V = 1, and near 0, where V moves slowest by differences at the rest."""
    sizes = 1e-3 / np.sqrt(np.diag(P))
    units = zip(sizes, np.eye(len(P)), strict=True)
    columns = [at.rate(size * e) - at.rate(-size * e) for size, e in units]
    PJ = P @ (np.array(columns).T / (2 * sizes))
    direction = eigh(PJ + PJ.T, P)[1][:, -1]
    return [factor * direction for factor in (1.0, -1.0, 0.3, -0.3)]


def why_running_misshown(claim: Any, statement: str) -> str:
    """Return a rate, or a range of winds, that is shown better than it is stated."""
    claim = as_floats(claim)
    shown = re.search(r"a rate of (\S+) 1/s", statement)
    if shown and float(shown[1]) > claim["decay_rate"]:
        return f"more is shown than is stated: {shown[0]}"
    shown = re.search(r"in (\d+) cells", statement)
    if shown and int(shown[1]) != len(claim["cells"]):
        return f"more is shown than is stated: {shown[0]}"
    covered = sum(high - low for low, high in claim["winds"])
    ends = re.search(r"constant wind from (\S+) to (\S+) m/s", statement)
    left = re.findall(r"(\S+) to (\S+) m/s", statement.partition("NOT at winds ")[2].partition(
        ", of which")[0])  # fmt: skip
    told = sum(float(high) - float(low) for low, high in left)
    if ends and float(ends[2]) - float(ends[1]) - told > covered + MARGIN:
        return "winds are shown that no cell covers"
    return ""


def as_floats(value: Any) -> Any:
    """Return plain data with its numbers, however they are written, as floats."""
    if isinstance(value, dict):
        return {key: as_floats(item) for key, item in value.items()}
    if isinstance(value, list):
        return [as_floats(item) for item in value]
    if isinstance(value, bool) or value is None:
        return value
    try:
        return float(value)
    except (TypeError, ValueError):
        return value
