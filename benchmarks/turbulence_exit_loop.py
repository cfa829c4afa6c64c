r"""The turbine's loop in turbulence, linearised at one wind: what `turbulence_exit.py` is about.

States, as deviations from the trim that moves with the wind v, so that v' = r enters:

    e speed, p pitch, x integral, s schedule wind, m low-passed speed, o and z the observer's speed
    and wind, eta the wake's pitch, q the wake's lag behind the wind, y = v - U, r = v'

    e'   = kappa (a e - sigma p - h (p - eta) + w q - E) - omega*' r
    p'   = (g / b - psi b'/b^2 s + lead rate - p) / tau - beta*' r
    x'   = -nu (m - omega*' s),   s' = rate - r,   rate = (z - s) / tau_f
    m'   = c (e - m) - omega*' r
    o'   = a e - sigma p + a (m - e) + d z - E + l_1 (m - o) - omega*' r,   z' = l_2 (m - o) - r
    eta' = (v/L)(p - eta) - beta*' r,   q' = r - (v/L) q
    y'   = r,   r' = -(1/t_r + 1/t_L) r - y / (t_r t_L) + s_r W

with u = q*' s + gamma (m - x - omega*' s), g = f u, E = m_E (u - g - f_v rate).  The wind model is
that of docs/turbulence-exit.md: rotor filter t_r and eddies t_L.
Uncertain, as vertices: inertia (kappa), a, h and w by 20 %, sigma by 10 %.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.analysis.disturbance.exit_exponent import NoisyVertices
from takagi.models import nrel5mw
from takagi.models.turbine import CLASS_B, rotor_torque_gradient

Floats = NDArray[np.float64]
STATES = ("e", "p", "x", "s", "m", "o", "z", "eta", "q", "y", "r")
E, R = STATES.index("e"), STATES.index("r")
WAKE_LENGTH, WIND_EXCESS = 63.0, 0.25  # m; share of d that the frozen wake adds at first
TURBINE = nrel5mw()


@dataclass(frozen=True)
class Wind:
    """The wind model: y' = r, r' = -(1/t_r + 1/t_L) r - y / (t_r t_L) + noise W.

    ``deviation`` of y [m/s], ``rate`` the rms of r [m/s^2]; t_r t_L = (deviation / rate)^2.
    """

    deviation: float
    rate: float
    rotor: float = 4.0

    @classmethod
    def of_class_b(cls, mean: float) -> Wind:
        winds, *columns = np.array(CLASS_B, dtype=np.float64).T
        return cls(*(float(np.interp(mean, winds, column)) for column in columns))

    @property
    def stiffness(self) -> float:
        return (self.rate / self.deviation) ** 2

    @property
    def damping(self) -> float:
        return 1 / self.rotor + self.rotor * self.stiffness

    @property
    def noise(self) -> float:
        return self.rate * float(np.sqrt(2 * self.damping))


@dataclass(frozen=True)
class Law:
    """The numbers of a gain file that the linear loop needs; ``filter`` replaces tau_f [s]."""

    tables: dict[str, Floats]
    overlap: float
    lead: float
    share: float
    l1: float
    l2: float
    corner: float
    filter: float
    rated: float  # n_g T_rated / J [rad/s^2]
    integral_limit: float

    @classmethod
    def read(cls, path: Path, tau: float | None = None) -> Law:
        gains = json.loads(path.read_text(encoding="utf-8"))
        law, observer = gains["law"], gains["observer"]
        names = (
            *("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit"),
            *("proportional", "integral_rate", "inertia_feedforward", "feedforward_limit"),
        )
        return cls(
            tables={name: np.array(law[name], dtype=float) for name in names},
            overlap=float(law["overlap"]),
            lead=float(law["pitch_lead"]),
            share=float(law["effort_torque"]) * TURBINE.gear_ratio / TURBINE.inertia,
            l1=float(observer["l1"]),
            l2=float(observer["l2"]),
            corner=float(gains["measurement"]["speed_filter"]),
            filter=float(law["wind_filter"]) if tau is None else tau,
            rated=float(law["rated_torque"]) * TURBINE.gear_ratio / TURBINE.inertia,
            integral_limit=float(law["integral_limit"]),
        )

    def at(self, name: str, wind: float) -> float:
        return float(np.interp(wind, self.tables["wind"], self.tables[name]))

    def segment(self, wind: float) -> int:
        nodes = self.tables["wind"]
        return int(np.clip(np.searchsorted(nodes, wind, side="right") - 1, 0, len(nodes) - 2))

    def slope(self, name: str, wind: float) -> float:
        k, nodes, column = self.segment(wind), self.tables["wind"], self.tables[name]
        return float((column[k + 1] - column[k]) / (nodes[k + 1] - nodes[k]))

    def held(self, name: str, wind: float) -> float:
        return float(self.tables[name][self.segment(wind)])


def linear_loop(law: Law, v: float, wind: Wind, scales: tuple[float, ...] = (1.0,) * 5) -> Floats:
    """Return A, (11, 11), at the wind v; ``scales`` of kappa, a, sigma, h and w."""
    kappa, by_a, by_sigma, by_h, by_w = scales
    eps, b, db = law.overlap, law.at("effectiveness", v), law.slope("effectiveness", v)
    q, dq, dw = law.at("trim_effort", v), law.slope("trim_effort", v), law.slope("rotor_speed", v)
    f = float(np.clip((q + eps) / (2 * eps), 0, 1))
    psi = 0.0 if q <= -eps else q if q >= eps else (q + eps) ** 2 / (4 * eps)
    rest = psi / b + TURBINE.pitch_min
    a, by_pitch, d = (
        float(part) / TURBINE.inertia
        for part in rotor_torque_gradient(TURBINE, law.at("rotor_speed", v), rest, v)
    )
    late = max(law.at("effectiveness_limit", v) + by_pitch, 0.0)
    bend = (f * dq - psi * db / b) / b
    one = np.eye(len(STATES))
    e, p, x, s, m, o, z, eta, lag, y, r = one
    gamma = law.at("proportional", v)
    u = dq * s + gamma * (m - x - dw * s)
    rate = (z - s) / law.filter
    braking = law.share * ((1 - f) * u - law.held("inertia_feedforward", v) * rate)
    known = a * e - (-by_pitch) * p
    torque = by_a * a * e + by_sigma * by_pitch * p - by_h * late * (p - eta)
    torque = torque + by_w * WIND_EXCESS * d * lag - braking
    wake = v / WAKE_LENGTH
    owed = f / b * u - psi * db / b**2 * s + law.lead * bend * rate - p
    return np.array([
        kappa * torque - dw * r,
        owed / TURBINE.pitch_time_constant - bend * r,
        -law.held("integral_rate", v) * (m - dw * s),
        rate - r,
        law.corner * (e - m) - dw * r,
        known + a * (m - e) + d * z - braking + law.l1 * (m - o) - dw * r,
        law.l2 * (m - o) - r,
        wake * (p - eta) - bend * r,
        r - wake * lag,
        r,
        -wind.damping * r - wind.stiffness * y,
    ])  # fmt: skip


UNCERTAIN = tuple(product((1 / 1.1, 1 / 0.9), (0.8, 1.2), (0.9, 1.1), (0.8, 1.2), (0.8, 1.2)))


def system(law: Law, v: float, overspeed: float, *, uncertain: bool) -> NoisyVertices:
    """Return the vertices at v, and the row of |e| <= (1 + overspeed) rated - omega*(v)."""
    wind = Wind.of_class_b(v)
    corners = UNCERTAIN if uncertain else ((1.0,) * 5,)
    A = np.array([linear_loop(law, v, wind, scales) for scales in corners])
    noise = np.zeros((len(A), len(STATES), 1))
    noise[:, R] = wind.noise
    row = np.zeros((1, len(STATES)))
    row[0, E] = 1 / room(law, v, overspeed)
    return NoisyVertices(A, np.zeros((len(A), len(STATES), 0)), noise, row)


def room(law: Law, v: float, overspeed: float) -> float:
    return (1 + overspeed) * TURBINE.rated_rotor_speed - law.at("rotor_speed", v)


def deviation(law: Law, v: float) -> float:
    """Return the standard deviation of the nominal speed error [rad/s]."""
    one = system(law, v, 0.1, uncertain=False)
    S = one.S[0]
    return float(np.sqrt(solve_continuous_lyapunov(one.A[0], -S @ S.T)[E, E]))
