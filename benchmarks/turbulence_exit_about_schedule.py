r"""The turbine's nonlinear loop in turbulence, about the trim at the *schedule* wind v_s.

States, as distances from the trim at v_s = U + y - D, where the law's tables are read:

    e speed, p pitch (b(v_s) (beta - beta_min) - psi(q*(v_s))), x integral, D = v - v_s,
    m low-passed speed, o the observer's speed, q = vhat - v_s, eta the wake's pitch (as p),
    y = v - U, r = v'

About this point the law is u = gamma(v_s) (m - x) with numbers that v_s alone fixes, and v_s moves
slowly, by v_s' = q / tau_f.  About the trim at the present wind, as in ``turbulence_exit_loop``,
differences of the tables over the whole lag D are uncertain factors instead.

``rates`` is the nonlinear loop with its limits: torque from 0 to rated, pitch not below its lower
limit and its rate limit, the integral's limit, v_s within the tables.  Left out: the band-stop,
the torque's rate limit, torsion, tower and flap, sampling, and the wake's answer to the wind.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import erfc

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov
from turbulence_exit_loop import TURBINE, WAKE_LENGTH, Law, Wind

from takagi.models.turbine import rotor_torque, rotor_torque_gradient

Floats = NDArray[np.float64]
NAMES = ("e", "p", "x", "D", "m", "o", "q", "eta", "y", "r")
N = len(NAMES)
E, P, X, D, M, SEEN, Q, ETA, Y, R = range(N)
RATED = TURBINE.rated_rotor_speed
LEAST_WIND = 1.0  # m/s; the table of c_Q is held at its edges


@dataclass(frozen=True)
class Reach:
    """Bounds of y, D_0 and v_s0 - U = y - D_0 that the wind alone exceeds rarely [m/s].

    D_0' = r - D_0 / tau_f is the lag of a schedule with a perfect estimate.  Each of the three is a
    stationary Gaussian process with a derivative, so by Rice's formula it leaves [-b, b] within T
    with probability at most erfc(b / (s sqrt 2)) + T s' / (pi s) exp(-b^2 / (2 s^2)), s and s'
    its standard deviation and that of its rate; from rest it is no likelier, by Anderson's
    inequality (1955).
    """

    wind: float
    lag: float
    schedule: float
    probability: float

    @classmethod
    def of(cls, mean: float, tau: float, horizon: float, each: float) -> Reach:
        """Return the bounds that each of the three leaves with the probability ``each``."""
        wind = Wind.of_class_b(mean)
        A = np.array([[0, 1, 0], [-wind.stiffness, -wind.damping, 0], [0, 1, -1 / tau]])
        S = np.array([[0.0], [wind.noise], [0.0]])
        spread = solve_continuous_lyapunov(A, -S @ S.T)
        found = []
        for row in np.array([[1.0, 0, 0], [0, 0, 1], [1, 0, -1]]):
            s, moved = np.sqrt(row @ spread @ row), np.sqrt(row @ A @ spread @ A.T @ row)
            low, high = 0.0, 10 * float(s)
            for _ in range(50):
                b = (low + high) / 2
                left = erfc(b / s / 2**0.5) + horizon * moved / (np.pi * s) * np.exp(
                    -((b / s) ** 2) / 2
                )
                low, high = (b, high) if left > each else (low, b)
            found.append(high)
        wide, lag, schedule = found
        return cls(wide, lag, schedule, 3 * each)


class Loop:
    """The nonlinear loop at one mean wind; ``inertia`` is true over nominal."""

    def __init__(self, law: Law, mean: float, inertia: float = 1.0) -> None:
        self.law, self.mean, self.wind = law, mean, Wind.of_class_b(mean)
        self.inertia = inertia
        self.S = np.zeros((N, 1))
        self.S[R] = self.wind.noise
        nodes = law.tables["wind"]
        self.slopes = {
            name: np.diff(law.tables[name]) / np.diff(nodes)
            for name in ("rotor_speed", "trim_effort", "effectiveness", "proportional")
        }

    def psi(self, effort: Floats) -> Floats:
        eps = self.law.overlap
        inner = (np.clip(effort, -eps, eps) + eps) ** 2 / (4 * eps)
        return np.asarray(inner + np.maximum(effort - eps, 0))

    def share(self, effort: Floats) -> Floats:
        eps = self.law.overlap
        return np.asarray(np.clip((effort + eps) / (2 * eps), 0, 1))

    def rates(self, z: Floats) -> Floats:
        """Return dz/dt without the noise, (10, n), for states (10, n)."""
        law, J, tau = self.law, TURBINE.inertia, TURBINE.pitch_time_constant
        nodes = law.tables["wind"]
        e, p, x, lag, m, o, q, eta, y, r = z
        v, vs = np.maximum(self.mean + y, LEAST_WIND), self.mean + y - lag
        held = np.clip(vs, nodes[0], nodes[-1])
        k = np.clip(np.searchsorted(nodes, held, side="right") - 1, 0, len(nodes) - 2)
        omega, effort, b, gamma = (np.interp(held, nodes, law.tables[name]) for name in self.slopes)
        d_omega, d_effort, d_b, d_gamma = (slope[k] for slope in self.slopes.values())
        seen = np.clip(vs + q, nodes[0], nodes[-1])
        rate = (seen - vs) / law.filter
        rest = self.psi(effort)
        signal = m - x
        U = effort + gamma * signal
        shed, share = self.psi(U), self.share(U)
        pitch = np.maximum((p + rest) / b, 0)  # above the lower limit
        wake = (eta + rest) / b
        unit = law.share
        most = law.tables["feedforward_limit"][k]
        fed = np.clip(law.tables["inertia_feedforward"][k] * rate, -most, most)
        braking = np.clip(law.rated - unit * (shed - U + fed), 0, law.rated)
        lead = law.lead * (share * (d_effort + d_gamma * signal) - shed * d_b / b) / b * rate
        asked = np.maximum(shed / b + lead, 0)
        turned = np.clip((asked - pitch) / tau, -TURBINE.pitch_rate_limit, TURBINE.pitch_rate_limit)
        speed = omega + e
        table = rotor_torque(TURBINE, speed, pitch, v, clip=True) / J
        steep = -rotor_torque_gradient(TURBINE, speed, pitch, v, clip=True)[1] / J
        limit = np.interp(v, nodes, law.tables["effectiveness_limit"])
        late = np.maximum(limit - steep, 0)
        known = rotor_torque(
            TURBINE, np.maximum(omega + m, 0.1), pitch, np.maximum(vs + q, LEAST_WIND), clip=True
        )
        integral = -law.tables["integral_rate"][k] * m
        full = (np.abs(x) >= law.integral_limit) & (integral * x > 0)
        moved = d_b * rate
        aim = self.share(effort) * d_effort * rate
        away = d_omega * rate
        wind = self.wind
        return np.array([
            (table - late * (pitch - wake) - braking) / self.inertia - away,
            b * turned + moved * pitch - aim,
            np.where(full, 0, integral),
            r - rate,
            law.corner * (e - m) - away,
            known / J - braking + law.l1 * (m - o) - away,
            law.l2 * (m - o) - rate,
            v / WAKE_LENGTH * (p - eta) + moved * wake - aim,
            r,
            -wind.damping * r - wind.stiffness * y,
        ])  # fmt: skip

    def slope(self, z: Floats) -> Floats:
        """Return the Jacobian of ``rates`` at one state, by central differences."""
        h = np.array([1e-4, 1e-4, 1e-4, 1e-3, 1e-4, 1e-4, 1e-3, 1e-4, 1e-3, 1e-3])
        steps = np.diag(h)
        ahead, behind = (self.rates(z[:, None] + sign * steps) for sign in (1, -1))
        return np.asarray((ahead - behind) / (2 * h))

    def room(self, schedule: float, overspeed: float) -> float:
        return float((1 + overspeed) * RATED - self.law.at("rotor_speed", schedule))

    def simulated(self, horizon: float, runs: int, step: float = 0.04) -> Floats:
        """Return the largest rotor speed of each run from rest [rad/s]."""
        random, z = np.random.default_rng(1), np.zeros((N, runs))
        largest, root = np.zeros(runs), self.wind.noise * np.sqrt(step)
        for _ in range(round(horizon / step)):
            z = z + step * self.rates(z)
            z[R] += root * random.standard_normal(runs)
            schedule = self.mean + z[Y] - z[D]
            largest = np.maximum(
                largest,
                z[E] + np.interp(schedule, self.law.tables["wind"], self.law.tables["rotor_speed"]),
            )
        return largest
