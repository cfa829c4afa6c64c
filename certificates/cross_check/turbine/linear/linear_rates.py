r"""The turbine's loop at one mean wind U as a matrix, with FLINT's rationals.

    xi' = A xi + S W,    xi = (e, p, x, s, m, o, z, eta, k, y, r [, y_1, y_2])

as docs/turbine-crossing.md states it.  All numbers of turbine and law at U are rational, and so is
A for rational values of the parameters.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.reading import Refusal, entry, rational, rationals
from takagi.certificates.cross_check.turbine.effort_ramp import ramp, ramp_slope
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.running.machine import Machine
from takagi.certificates.cross_check.turbine.surface import Outside

ZERO, FULL = fmpq(0), fmpq(1)
NAMES = (
    "inertia",
    "speed_damping",
    "pitch_effectiveness",
    "wake_of_pitch",
    "wake_of_wind",
    "wake_length",
)
STATES = ("e", "p", "x", "s", "m", "o", "z", "eta", "k", "y", "r", "y1", "y2")
Ends = dict[str, tuple[fmpq, fmpq]]
Row = dict[str, fmpq]


def parameters(claim: Any) -> Ends:
    """Return the range of each parameter."""
    stated, found = entry(claim, "uncertainty"), {}
    for name in NAMES:
        low, high = rationals(stated, name, 2)
        may_be_zero = name in ("wake_of_pitch", "wake_of_wind")
        if low < 0 or (low == 0 and not may_be_zero) or low > high:
            raise Refusal("uncertainty: ranges of positive numbers are needed")
        found[name] = low, high
    return found


class LinearRates:
    """The loop at the wind ``mean``.

    Raises
    ------
    Outside : the loop has no derivative at the trim, or the trim is not in the coefficient table.
    """

    def __init__(self, rotor: Rotor, machine: Machine, claim: Any, mean: fmpq) -> None:
        self.rotor, self.machine, self.mean = rotor, machine, mean
        wind = entry(claim, "turbulence")
        deviation, rate, t_r = (
            rational(wind, name) for name in ("deviation", "rate", "rotor_time")
        )
        if min(deviation, rate, t_r) <= 0:
            raise Refusal("turbulence: positive numbers are needed")
        # 1/(t_r t_L), 1/t_r + 1/t_L, and the square of s.
        self.product = rate * rate / (deviation * deviation)
        self.sum = 1 / t_r + self.product * t_r
        self.noise = 2 * self.sum * rate * rate
        self._tables()
        self._torque()

    def _tables(self) -> None:
        rotor, v = self.rotor, self.mean
        inside = [k for k, (low, high) in enumerate(pairwise(rotor.wind)) if low < v < high]
        if not inside:
            raise Outside("a wind at a node of the tables, or beyond them")
        if v <= self.machine.least_wind or v >= self.machine.most_wind:
            raise Outside("a wind that the estimate cannot take")
        self.k = k = inside[0]
        width = rotor.wind[k + 1] - rotor.wind[k]
        near = (v - rotor.wind[k]) / width

        def line(column: list[fmpq]) -> tuple[fmpq, fmpq]:
            low, high = column[k], column[k + 1]
            return (FULL - near) * low + near * high, (high - low) / width

        self.omega, self.omega_slope = line(rotor.speed)
        self.q, self.q_slope = line(rotor.effort)
        self.b, self.b_slope = line(rotor.effectiveness)
        self.most_effect, _ = line(rotor.limit)
        self.gamma, _ = line(rotor.proportional)
        self.F = ramp_slope(self.q, rotor.overlap)
        self.shed, self.braked = ramp(self.q, rotor.overlap), ramp(-self.q, rotor.overlap)
        self.f = rotor.ahead[k]
        if rotor.per_effort * self.braked >= rotor.torque:
            raise Outside("no torque at the trim")
        if self.f != 0 and (self.braked == 0 or rotor.ahead_limit[k] == 0):
            raise Outside("a feed-forward that is cut at the trim")
        self.pitch = rotor.pitch_min + self.shed / self.b
        if self.pitch >= rotor.pitch_max:
            raise Outside("pitch at its upper limit")
        # psi b'/b^2, and the slope of the trim's pitch.
        self.psi_term = self.shed * self.b_slope / (self.b * self.b)
        self.pitch_slope = self.F * self.q_slope / self.b - self.psi_term

    def _torque(self) -> None:
        rotor, v = self.rotor, self.mean
        ratio = rotor.radius * self.omega / v
        ratios, pitches = rotor.surface.x.breaks, rotor.surface.y.breaks
        # psi = 0 holds the law's pitch at its lower limit, so that no slope along pitch acts.
        if ratio in (ratios[0], ratios[-1]):
            raise Outside("a tip-speed ratio at the table's edge")
        if self.shed != 0 and self.pitch in (pitches[0], pitches[-1]):
            raise Outside("a pitch at the table's edge")
        C, by_ratio, by_pitch = rotor.surface.at(ratio, self.pitch)
        drive, brake = rotor.c * v * v * C, rotor.rated - rotor.m * self.braked
        if 10 * abs(drive - brake) > rotor.overlap:
            raise Outside("no trim: torques that differ by over a tenth of the overlap")
        self.a = rotor.c * rotor.radius * v * by_ratio
        self.sigma = -rotor.c * v * v * by_pitch
        self.d = rotor.c * v * (2 * C - ratio * by_ratio)
        self.h = max(ZERO, self.most_effect - self.sigma)

    @property
    def order(self) -> int:
        return 11 if self.machine.stop is None else 13

    def signal(self) -> fmpq_mat:
        """Return the row of e - omega*' y."""
        return self._matrix([{"e": FULL, "y": -self.omega_slope}])

    def spread(self) -> fmpq_mat:
        """Return S S'."""
        rows: list[Row] = [{} for _ in range(self.order)]
        rows[STATES.index("r")] = {"r": self.noise}
        return self._matrix(rows)

    def at(self, value: dict[str, fmpq]) -> fmpq_mat:
        """Return A for values of the parameters."""
        rotor, machine = self.rotor, self.machine
        error: Row = {"m": FULL, "s": -self.omega_slope}
        u = _plus({"s": self.q_slope, "x": -self.gamma}, _by(self.gamma, error))
        rate: Row = {"z": 1 / machine.lag, "s": -1 / machine.lag}
        E = _plus(_by(rotor.m * (1 - self.F), u), _by(-rotor.m * self.f, rate))
        k_a, k_s = value["speed_damping"], value["pitch_effectiveness"]
        d = (
            self.d
            + (1 - k_a) * self.a * self.omega_slope
            + (k_s - 1) * self.sigma * (self.pitch_slope)
        )
        late, first = value["wake_of_pitch"] * self.h, value["wake_of_wind"] * self.d
        rotor_torque: Row = {
            "e": k_a * self.a,
            "p": -k_s * self.sigma - late,
            "eta": late,
            "y": d + first,
            "k": -first,
        }
        seen: Row = {"m": self.a, "p": -self.sigma, "z": self.d}
        asked = _plus(
            _by(self.F / self.b, u),
            {"s": -self.psi_term, "p": -FULL},
            _by(rotor.lead * self.pitch_slope, rate),
        )
        moves = self.mean / value["wake_length"]
        gap: Row = {"m": FULL, "o": -FULL}
        filtered: Row = {"e": FULL, "m": -FULL}
        if machine.stop is not None:
            left = 2 * (1 - machine.stop[1])
            filtered |= {"y1": -left, "y2": left}
        rows = [
            _by(1 / value["inertia"], _plus(rotor_torque, _by(-FULL, E))),
            _by(1 / rotor.drive, asked),
            _by(-rotor.integral_rates[self.k], error),
            rate,
            _by(machine.corner, filtered),
            _plus(
                _by(machine.inertia_ratio, _plus(seen, _by(-FULL, E))),
                _by(machine.l1, gap),
            ),
            _by(machine.l2, gap),
            {"p": moves, "eta": -moves},
            {"y": moves, "k": -moves},
            {"r": FULL},
            {"r": -self.sum, "y": -self.product},
        ]
        if machine.stop is not None:
            w = machine.stop[0]
            rows += [{"e": w, "y1": -w}, {"y1": w, "y2": -w}]
        return self._matrix(rows)

    def _matrix(self, rows: list[Row]) -> fmpq_mat:
        return fmpq_mat([[row.get(name, ZERO) for name in STATES[: self.order]] for row in rows])


def _plus(*rows: Row) -> Row:
    found: Row = {}
    for row in rows:
        for name, value in row.items():
            found[name] = found.get(name, ZERO) + value
    return found


def _by(factor: fmpq, row: Row) -> Row:
    return {name: factor * value for name, value in row.items()}
