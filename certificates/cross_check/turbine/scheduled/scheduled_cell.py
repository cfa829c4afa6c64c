r"""Ranges of the factors of the loop about the trim at the schedule wind; docs/schedule-rate.md.

With X = (e, p, D) and T_r/J - T_r*/J = g* X + X' [int (1 - t) H(tX) dt] X, the slopes from the trim
are within g*_i -+ sum_k (2 (n - k) + 1)/(2 n^2) sum_j |H_ij| s_j, H over k/n times the box, n = 3.
"""

from __future__ import annotations

from copy import copy
from itertools import pairwise
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import Refusal
from takagi.certificates.cross_check.turbine.numbers import Rotor, WindCell
from takagi.certificates.cross_check.turbine.ranges import residual
from takagi.certificates.cross_check.turbine.running.machine import Machine
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

ZERO, FULL, HALF = fmpq(0), fmpq(1), fmpq(1, 2)
WAYS, PARTS, DECIMALS = 3, 4, 10**7
Sides = dict[str, fmpq]
Gradient = list[NumberRange]


class ScheduledCell:
    """Schedule winds from ``low`` to ``high``.

    Raises
    ------
    Outside : the cell is not above rated wind, or a range leaves a table.
    Refusal : winds that are not between two nodes of the law.
    """

    def __init__(self, rotor: Rotor, machine: Machine, low: fmpq, high: fmpq, box: Sides) -> None:
        self.rotor, self.machine, self.box = rotor, machine, box
        self.ends = low, high
        places = [k for k, (a, b) in enumerate(pairwise(rotor.wind)) if a <= low < high <= b]
        if not places:
            raise Refusal("a cell whose winds are not between two nodes of the law")
        self.k = places[0]
        if rotor.speed[self.k] != rotor.speed[self.k + 1] or rotor.ahead[self.k] != 0:
            raise Outside("winds at which torque does not rest at its rated value")
        self.omega = rotor.speed[self.k]
        # Below, R (omega* - e) over the greatest wind is the least lambda.
        if max(box["speed"], box["measured"]) >= self.omega:
            raise Outside("a speed that may reach zero")
        self.b, self.gamma, self.q = (
            [self.value(name, v) for v in self.ends]
            for name in ("effectiveness", "proportional", "effort")
        )
        if min(self.b) <= 0:
            raise Outside("an effectiveness that is not positive")
        self.gain = NumberRange.of(*(g / b for g, b in zip(self.gamma, self.b, strict=True)))
        self.gain_slope = self._bent("proportional")
        self.pitch_slope = self._bent("effort")
        self.trims = NumberRange.of(*(self.trim(v) for v in self.ends))
        self.rho = box["estimate"] / machine.lag
        self.own_lead = self._lead()

    # The law's tables.

    def value(self, name: str, wind: fmpq, k: int | None = None) -> fmpq:
        """Return a table at a wind, by the line of the cell's interval or of another."""
        k = self.k if k is None else k
        column, nodes = getattr(self.rotor, name), self.rotor.wind
        a, b = nodes[k], nodes[k + 1]
        found: fmpq = (column[k] * (b - wind) + column[k + 1] * (wind - a)) / (b - a)
        return found

    def trim(self, wind: fmpq, k: int | None = None) -> fmpq:
        """Return beta* where the trim's effort is beyond the ramp."""
        effort, b = self.value("effort", wind, k), self.value("effectiveness", wind, k)
        return self.rotor.pitch_min + effort / b

    def _bent(self, name: str) -> NumberRange:
        """Return the range of (f / b)' = (f' b - f b') / b^2."""
        nodes, k = self.rotor.wind, self.k
        f, b = getattr(self.rotor, name), self.rotor.effectiveness
        width = nodes[k + 1] - nodes[k]
        top = ((f[k + 1] - f[k]) * b[k] - f[k] * (b[k + 1] - b[k])) / width
        return NumberRange.of(*(top / one**2 for one in self.b))

    def _lead(self) -> NumberRange:
        away = self.gain_slope.size * self.box["signal"]
        spread = self.pitch_slope + NumberRange(-away, away)
        return outward(spread.times(self.rotor.lead))

    # The torque.

    def _both(
        self, winds: NumberRange, e: fmpq, pitch: NumberRange
    ) -> tuple[Gradient, list[Gradient]]:
        """Return g and H over winds, speeds within e of omega*, and pitches."""
        rotor = self.rotor
        over, R = rotor.surface.over, _number(rotor.radius)
        x = NumberRange(
            rotor.radius * (self.omega - e) / winds.high,
            rotor.radius * (self.omega + e) / winds.low,
        )
        C, Cx, Cy = over(x, pitch), over(x, pitch, 1, 0), over(x, pitch, 0, 1)
        Cxx, Cxy, Cyy = over(x, pitch, 2, 0), over(x, pitch, 1, 1), over(x, pitch, 0, 2)
        v, two = winds, fmpq(2)
        by_v = R * (Cx - x * Cxx), v * (Cy.times(two) - x * Cxy)
        mixed = R * (v * Cxy)
        corner = C.times(two) - (x * Cx).times(two) + x.squared() * Cxx
        g = [R * (v * Cx), v.squared() * Cy, v * (C.times(two) - x * Cx)]
        H = [
            [R.squared() * Cxx, mixed, by_v[0]],
            [mixed, v.squared() * Cyy, by_v[1]],
            [by_v[0], by_v[1], corner],
        ]
        c = rotor.c
        return [one.times(c) for one in g], [[one.times(c) for one in row] for row in H]

    def _at_trim(self) -> Gradient:
        found: Gradient | None = None
        for part in _parts(*self.ends):
            pitch = NumberRange.of(self.trim(part.low), self.trim(part.high))
            found = _joined(found, self._both(part, ZERO, pitch)[0])
        return found or []

    def _curved(self, s: tuple[fmpq, fmpq, fmpq]) -> list[fmpq]:
        """Return sum_j |H_ij| s_j for each i."""
        e, p, d = s
        pitch, H = self.trims + NumberRange(-p, p), [[ZERO] * 3 for _ in range(3)]
        for part in _parts(self.ends[0] - d, self.ends[1] + d):
            here = self._both(part, e, pitch)[1]
            H = [
                [max(most, one.size) for most, one in zip(row, at, strict=True)]
                for row, at in zip(H, here, strict=True)
            ]
        return [sum((h * side for h, side in zip(row, s, strict=True)), ZERO) for row in H]

    def _slopes(self) -> tuple[Gradient, Gradient]:
        """Return the slopes from the trim, and those between the state and the observer's."""
        box, g = self.box, self._at_trim()
        s = box["speed"], box["pitch"], box["wind"]
        away = [ZERO] * 3
        for k in range(1, WAYS + 1):
            part = self._curved((s[0] * k / WAYS, s[1] * k / WAYS, s[2] * k / WAYS))
            # part holds k/n times the sides; the whole sides count.
            weight = fmpq(2 * (WAYS - k) + 1, 2 * WAYS**2) * fmpq(WAYS, k)
            away = [a + weight * b for a, b in zip(away, part, strict=True)]
        wide = max(box["speed"], box["measured"]), box["pitch"], max(box["wind"], box["estimate"])
        whole = self._curved(wide)
        return (
            [one + NumberRange(-a, a) for one, a in zip(g, away, strict=True)],
            [one + NumberRange(-a, a) for one, a in zip(g, whole, strict=True)],
        )

    def _late(self) -> fmpq:
        """Return the largest h."""
        rotor, d = self.rotor, self.box["wind"]
        low, high, most = self.ends[0] - d, self.ends[1] + d, ZERO
        nodes = rotor.wind
        if low < nodes[0] or high > nodes[-1] or low <= 0:
            raise Outside("a wind that may leave the law's tables")
        for k, (a, b) in enumerate(pairwise(nodes)):
            start, stop = max(a, low), min(b, high)
            if start < stop:
                for part in _parts(start, stop):
                    most = max(most, self._late_over(part, k))
        return most

    def _late_over(self, part: NumberRange, k: int) -> fmpq:
        rotor, ends = self.rotor, (part.low, part.high)
        if min(self.value("effort", v, k) for v in ends) < rotor.overlap:
            raise Outside("a trim in the ramp")
        pitch = NumberRange.of(*(self.trim(v, k) for v in ends))
        speeds = [self.value("speed", v, k) for v in ends]
        x = NumberRange(
            rotor.radius * min(speeds) / part.high, rotor.radius * max(speeds) / part.low
        )
        steep = (rotor.surface.over(x, pitch, 0, 1) * part.squared()).times(rotor.c)
        top: fmpq = max(self.value("limit", v, k) for v in ends) + steep.high
        return top

    # What a claim needs.

    @property
    def residual(self) -> fmpq:
        """A bound of the tables' residual over the cell."""
        short: Any = copy(self.rotor)
        for name in ("speed", "effort", "effectiveness", "limit", "proportional"):
            setattr(short, name, [self.value(name, v) for v in self.ends])
        short.wind = [*self.ends]
        short.kappa = short.power = _number(FULL)
        short.speed_signal = short.effort_lag = ZERO
        return residual(WindCell(short, 0))

    def factors(self, lead: NumberRange) -> dict[str, NumberRange]:
        """Return the range of every factor, rounded outward."""
        machine, d = self.machine, self.box["wind"]
        (a, steep, by_wind), (a_seen, _, wind_seen) = self._slopes()
        winds = NumberRange(self.ends[0] - d, self.ends[1] + d)
        found = {
            "stiffness": a,
            "pitch gain": -steep,
            "wind gain": by_wind,
            "late pitch gain": NumberRange(ZERO, self._late()),
            "inertia": machine.kappa,
            "pitch per signal": self.gain,
            "lead": lead,
            "pitch slope": self.pitch_slope,
            "observed stiffness": a_seen,
            "observed wind gain": wind_seen,
            "observer inertia": _number(machine.inertia_ratio),
            "wake rate": winds / machine.length,
        }
        return {name: outward(one) for name, one in found.items()}

    def limits(self, lead: NumberRange) -> list[tuple[str, bool]]:
        """Return the conditions under which limits missing in the equations are not reached."""
        rotor, machine, box, rho = self.rotor, self.machine, self.box, self.rho
        seen = self.ends[0] - box["estimate"], self.ends[1] + box["estimate"]
        asked = self.gain.high * box["signal"] + lead.size * rho
        nu = rotor.integral_rates[self.k]
        turned = (machine.l2 * box["innovation"] + rho) / machine.lag
        sent = (self.pitch_slope.size + self.gain_slope.size * box["signal"]) * rho
        sent += self.gain.high * (box["measured_rate"] + nu * box["measured"])
        sent += lead.size * turned
        trims, p = self.trims, box["pitch"]
        return [
            ("the ramp", min(self.q) - max(self.gamma) * box["signal"] >= rotor.overlap),
            ("the estimate in the tables", rotor.wind[0] <= seen[0] and seen[1] <= rotor.wind[-1]),
            (
                "the observer's wind",
                machine.least_wind < seen[0] and seen[1] < machine.most_wind,
            ),
            (
                "the pitch that is asked for",
                trims.low - asked >= rotor.pitch_min and trims.high + asked <= rotor.pitch_max,
            ),
            (
                "pitch",
                trims.low - p >= rotor.pitch_min and trims.high + p <= rotor.pitch_max,
            ),
            ("the drive's rate", box["drive"] <= rotor.rate_limit * rotor.drive),
            ("the rate of pitch", sent <= rotor.rate_limit),
        ]


def _parts(low: fmpq, high: fmpq) -> list[NumberRange]:
    if low <= 0:
        raise Outside("a wind that may reach zero")
    step = (high - low) / PARTS
    return [NumberRange(low + step * i, low + step * (i + 1)) for i in range(PARTS)]


def _joined(found: Gradient | None, more: Gradient) -> Gradient:
    return more if found is None else [a.hull(b) for a, b in zip(found, more, strict=True)]


def _number(value: fmpq) -> NumberRange:
    return NumberRange(value, value)


def outward(span: NumberRange) -> NumberRange:
    """Return the range with ends of seven decimals."""
    return NumberRange(-_up(-span.low), _up(span.high))


def _up(value: fmpq) -> fmpq:
    return fmpq(-((-int(value.p) * DECIMALS) // int(value.q)), DECIMALS)
