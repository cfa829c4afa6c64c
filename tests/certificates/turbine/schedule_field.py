"""The turbine's loop in absolute states, many at a time, from docs/running-loop.md in floats.

It shares no code with checkers, candidates or benchmarks.  States by row: rotor speed, pitch,
integral, wind, filtered speed, observer's speed, observer's wind, the wake's pitch, the two poles
of the band-stop, schedule wind.  What is sent to the pitch drive follows the law's command at no
more than the limit of its rate.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BivariateSpline

Floats = NDArray[np.float64]
WIND, SCHEDULE = 3, 10
# Where a state's distance from the trim at the schedule wind is taken from: rotor speed or pitch.
SPEEDS, PITCHES, WINDS = (0, 4, 5, 8, 9), (1, 7), (3, 6)


class Field:
    """The loop of a document's model, law, and first claim."""

    def __init__(self, document: Any) -> None:
        self.model, self.law, self.claim = (
            document["model"],
            document["gains"],
            document["claims"][0],
        )
        table = self.model["torque_surface"]
        axes = np.array(table["tip_speed_ratio_knots"]), np.array(table["pitch_knots"])
        spline: Any = cast("Any", BivariateSpline)._from_tck((
            *axes, np.array(table["coefficients"]).ravel(), 3, 3,
        ))  # fmt: skip
        self.surface: Callable[..., Any] = spline.ev
        self.n = self.model["gear_ratio"]
        self.J = self.model["rotor_inertia"] + self.n**2 * self.model["generator_inertia"]
        self.nodes = np.array(self.law["wind"])
        stated = sorted(self.claim["functions"], key=lambda one: float(one["wind"]))
        self.places = np.array([one["wind"] for one in stated])
        self.functions = np.array([one["P"] for one in stated])

    def at(self, name: str, wind: Any) -> Any:
        return np.interp(wind, self.nodes, self.law[name])

    def slope(self, name: str, k: Any) -> Any:
        column = np.array(self.law[name])
        return (column[k + 1] - column[k]) / (self.nodes[k + 1] - self.nodes[k])

    def ramp(self, s: Any) -> Any:
        eps = self.law["overlap"]
        return np.where(s <= -eps, 0.0, np.where(s >= eps, s, (s + eps) ** 2 / (4 * eps)))

    def torque(self, speed: Any, pitch: Any, wind: Any, dy: int = 0) -> Any:
        """Return T_r [N m], or what it gains by pitch."""
        ratio = self.model["rotor_radius"] * speed / wind
        return self.model["torque_constant"] * wind**2 * self.surface(ratio, pitch, dy=dy)

    def trim_pitch(self, wind: Any) -> Any:
        effort = self.ramp(self.at("trim_effort", wind))
        return self.law["pitch_min"] + effort / self.at("effectiveness", wind)

    def late(self, wind: Any) -> Any:
        """Return the largest h at a wind."""
        speed, pitch = self.at("rotor_speed", wind), self.trim_pitch(wind)
        own = -self.torque(speed, pitch, wind, dy=1) / self.J
        return np.maximum(self.at("effectiveness_limit", wind) - own, 0.0)

    def commands(self, y: Floats) -> tuple[Any, Any, Any]:
        """Return the law's torque, its pitch, and v_s'."""
        law, v_s, low, high = self.law, y[SCHEDULE], self.nodes[0], self.nodes[-1]
        k = np.clip(np.searchsorted(self.nodes, v_s, side="right") - 1, 0, len(self.nodes) - 2)
        rate = (np.clip(y[6], low, high) - v_s) / law["wind_filter"]
        signal = y[4] - self.at("rotor_speed", v_s) - y[2]
        U, b = (
            self.at("trim_effort", v_s) + self.at("proportional", v_s) * signal,
            self.at("effectiveness", v_s),
        )
        limit = np.array(law["feedforward_limit"])[k]
        ahead = np.clip(np.array(law["inertia_feedforward"])[k] * rate, -limit, limit)
        torque = law["rated_torque"] - law["effort_torque"] * (self.ramp(-U) + ahead)
        share = np.clip((U + law["overlap"]) / (2 * law["overlap"]), 0.0, 1.0)
        moved = self.slope("trim_effort", k) + self.slope("proportional", k) * signal
        N = share * moved - self.ramp(U) * self.slope("effectiveness", k) / b
        pitch = law["pitch_min"] + (self.ramp(U) + law["pitch_lead"] * rate * N) / b
        return (
            np.clip(torque, 0.0, law["rated_torque"]),
            np.clip(pitch, law["pitch_min"], law["pitch_max"]),
            rate,
        )

    def rates(
        self, y: Floats, sent: Any, inertia: Any, h: Any, length: Any, wind_rate: Any
    ) -> Floats:
        """Return the rates of the eleven states, for a pitch that is sent."""
        speed, pitch, _, v, m, o, seen, w, first, second, v_s = y
        model, law = self.model, self.law
        torque, _, rate = self.commands(y)
        k = np.clip(np.searchsorted(self.nodes, v_s, side="right") - 1, 0, len(self.nodes) - 2)
        most = model["pitch_rate_limit"]
        filters, observer = self.claim["measurement"], self.claim["observer"]
        stop, n, J = filters["torsion_filter"], self.n, self.J
        balance = (self.torque(speed, pitch, v) - n * torque) / J - h * (pitch - w)
        return np.array([
            balance / inertia,
            np.clip((sent - pitch) / model["pitch_time_constant"], -most, most),
            -np.array(law["integral_rate"])[k] * (m - self.at("rotor_speed", v_s)),
            wind_rate,
            filters["speed_filter"] * (speed - 2 * (1 - stop["passed"]) * (first - second) - m),
            (self.torque(m, pitch, seen) - n * torque) / J + observer["l1"] * (m - o),
            observer["l2"] * (m - o),
            v / length * (pitch - w),
            stop["frequency"] * (speed - first),
            stop["frequency"] * (first - second),
            rate,
        ])  # fmt: skip

    # The claim's coordinates.

    def distances(self, y: Floats) -> Floats:
        """Return xi, the distance from the trim at the schedule wind."""
        v_s, xi = y[SCHEDULE], y[:SCHEDULE].copy()
        xi[list(SPEEDS)] -= self.at("rotor_speed", v_s)
        xi[list(PITCHES)] -= self.trim_pitch(v_s)
        xi[list(WINDS)] -= v_s
        return xi

    def states(self, xi: Floats, v_s: Any) -> Floats:
        """Return the states with these distances."""
        y = np.array([*xi, v_s])
        y[list(SPEEDS)] += self.at("rotor_speed", v_s)
        y[list(PITCHES)] += self.trim_pitch(v_s)
        y[list(WINDS)] += v_s
        return y

    def P(self, v_s: Any) -> Any:
        """Return P at each schedule wind, (count, 10, 10)."""
        last = len(self.places) - 2
        k = np.clip(np.searchsorted(self.places, v_s, side="right") - 1, 0, last)
        t = ((v_s - self.places[k]) / (self.places[k + 1] - self.places[k]))[:, None, None]
        return (1 - t) * self.functions[k] + t * self.functions[k + 1]
