r"""Ranges of the running loop's factors over the box of one cell; symbols of docs/running-loop.md.

    a, a_2   c R v c_Q,lambda          sigma  -c v^2 c_Q,beta / b_0
    d        c v (2 c_Q - lambda c_Q,lambda)
    F, psi   of the efforts q* -+ (side + rho_0), where |U_r - q*| <= rho_0 = r / G

r bounds the tables' residual over the cell, G > 0 is the least of F sigma_U + (1 - F) m over
efforts within the side of q*.
"""

from __future__ import annotations

from copy import copy
from decimal import Decimal
from itertools import pairwise
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
)
from takagi.certificates.cross_check.turbine.numbers import Rotor, WindCell, ramp, ramp_slope
from takagi.certificates.cross_check.turbine.ranges import residual
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

ZERO, FULL = fmpq(0), fmpq(1)
# A part of the ramp for G has at most this much of the share; ranges are rounded to these decimals.
# A multiplier belongs to one range: with another middle the inequality may fail, so the rounding is
# a part of the claim.  Ranges that are as exact as the tables are not rounded.
EXACT = ("speed slope", "held estimate", "feed-forward", "integral rate")
SHARE_STEP, DECIMALS = fmpq(1, 10), 10**7
Sides = dict[str, fmpq]


class RunningCell:
    """Constant winds from ``low`` to ``high``.

    Raises
    ------
    Outside : a range leaves the coefficient table, the estimate may reach its lower limit, or
        there is no rest near the trim.
    Refusal : winds that are not between two nodes of the law.
    """

    def __init__(self, rotor: Rotor, machine: Machine, low: fmpq, high: fmpq, box: Sides) -> None:
        self.rotor, self.machine, self.box = rotor, machine, box
        self.v = NumberRange(low, high)
        nodes = rotor.wind
        if not any(a <= low < high <= b for a, b in pairwise(nodes)):
            raise Refusal("a cell whose winds are not between two nodes of the law")
        if low - box["estimate"] <= machine.least_wind:
            raise Outside("an estimate at its lower limit")
        winds = self.v + NumberRange(-box["schedule"], box["schedule"])
        # The schedule winds, their intervals of the tables and their b.
        self.v_s = NumberRange(max(winds.low, nodes[0]), min(winds.high, nodes[-1]))
        self.intervals = [
            k for k, (a, b) in enumerate(pairwise(nodes)) if a < self.v_s.high and b > self.v_s.low
        ]
        self.b_s = self.table("effectiveness", self.v_s)
        self.b = self.table("effectiveness", self.v)
        self.b0 = _three_decimals((self.b.low + self.b.high) / 2)
        if self.b0 <= 0:
            raise Outside("an effectiveness of next to nothing")
        self.q = self.table("effort", self.v)
        self.rest = self._rest()
        self.x_rest = self.rest / self.table("proportional", self.v).low
        away = box["effort"] + self.rest
        self.efforts = self.q + NumberRange(-away, away)
        self.at_rest = self.q + NumberRange(-self.rest, self.rest)
        self.shed, self.shed_rest = self._psi(self.efforts), self._psi(self.at_rest)
        self.share = self._share(self.efforts)
        self.rho = (box["estimate"] + box["schedule"]) / machine.lag
        self.band = self._band()

    # Tables of the law.

    def value(self, name: str, wind: fmpq) -> fmpq:
        column: list[fmpq] = getattr(self.rotor, name)
        nodes = self.rotor.wind
        for k, (a, b) in enumerate(pairwise(nodes)):
            if wind <= b:
                return (column[k] * (b - wind) + column[k + 1] * (wind - a)) / (b - a)
        raise Refusal("a wind beyond the law's tables")

    def table(self, name: str, over: NumberRange) -> NumberRange:
        """Return a table's range over winds: it is a line between nodes."""
        column = getattr(self.rotor, name)
        inside = [
            y for v, y in zip(self.rotor.wind, column, strict=True) if over.low < v < over.high
        ]
        return NumberRange.of(self.value(name, over.low), self.value(name, over.high), *inside)

    def slope(self, name: str) -> NumberRange:
        """Return the range of a table's slope at the schedule winds."""
        column, nodes = getattr(self.rotor, name), self.rotor.wind
        return NumberRange.of(
            *((column[k + 1] - column[k]) / (nodes[k + 1] - nodes[k]) for k in self.intervals)
        )

    def step(self, column: list[fmpq]) -> NumberRange:
        """Return the range of what is constant between nodes."""
        return NumberRange.of(*(column[k] for k in self.intervals))

    # The ramp.

    def _psi(self, efforts: NumberRange) -> NumberRange:
        eps = self.rotor.overlap
        return NumberRange(ramp(efforts.low, eps), ramp(efforts.high, eps))

    def _share(self, efforts: NumberRange) -> NumberRange:
        eps = self.rotor.overlap
        return NumberRange(ramp_slope(efforts.low, eps), ramp_slope(efforts.high, eps))

    # The surface.

    def ratio(self, error: fmpq, away: fmpq = ZERO) -> NumberRange:
        """Return R (omega*(v) + e) / (v + d), monotone in v, in e and in d."""
        return NumberRange.of(
            *(
                self.rotor.radius * (self.value("speed", v) + e) / (v + d)
                for v in (self.v.low, self.v.high)
                for e in (-error, error)
                for d in (-away, away)
            )
        )

    def _pitch(self, efforts: NumberRange) -> NumberRange:
        return self._psi(efforts) / self.b + _number(self.rotor.pitch_min)

    def _band(self) -> NumberRange:
        away = self.box["pitch"] / self.b0
        asked = self._pitch(self.at_rest)
        return NumberRange(max(asked.low - away, self.rotor.pitch_min), asked.high + away)

    def by_pitch(self, pitch: NumberRange) -> NumberRange:
        """Return -c v^2 c_Q,beta at the reference speed."""
        slope = self.rotor.surface.over(self.ratio(ZERO), pitch, 0, 1)
        return -(self.v.squared() * slope).times(self.rotor.c)

    def by_speed(self, error: fmpq) -> NumberRange:
        slope = self.rotor.surface.over(self.ratio(error), self.band, 1, 0)
        return (self.v * slope).times(self.rotor.c * self.rotor.radius)

    def by_wind(self) -> NumberRange:
        away = self.box["estimate"]
        ratio = self.ratio(self.box["measured"], away)
        steep = self.rotor.surface.over(ratio, self.band, 1, 0)
        inner = self.rotor.surface.over(ratio, self.band).times(fmpq(2)) - ratio * steep
        return (inner * (self.v + NumberRange(-away, away))).times(self.rotor.c)

    # The rest.

    def _rest(self) -> fmpq:
        side = self.box["effort"]
        least = self._least_gain(self.q + NumberRange(-side, side))
        left = residual(_short_cell(self))
        if least <= 0 or left > least * side:
            raise Outside("no rest is known near the trim")
        return _rounded_up(left / least)

    def _least_gain(self, efforts: NumberRange) -> fmpq:
        """Return the least of F sigma_U + (1 - F) m, part by part of the efforts."""
        eps, m = self.rotor.overlap, _number(self.rotor.m)
        cuts = {efforts.low, efforts.high}
        start, stop = max(efforts.low, -eps), min(efforts.high, eps)
        if start < stop:
            moved = (ramp_slope(stop, eps) - ramp_slope(start, eps)) / SHARE_STEP
            parts = -((-int(moved.p)) // int(moved.q))
            cuts |= {start + (stop - start) * i / parts for i in range(parts + 1)}
        found = []
        for a, b in pairwise(sorted(cuts)):
            part = NumberRange(a, b)
            share = self._share(part)
            if share.high == 0:
                found.append(self.rotor.m)
                continue
            sigma = self.by_pitch(self._pitch(part)) / self.b
            # Affine in each of F and sigma: the least is at a corner.
            found.append((m + share * (sigma - m)).low)
        return min(found)

    # The factors.

    def lead(self) -> NumberRange:
        rotor, s = self.rotor, self.box["signal"] + self.x_rest
        moved = self.slope("effort") + NumberRange(-s, s) * self.slope("proportional")
        N = self.share * moved - self.shed * (self.slope("effectiveness") / self.b_s)
        return _outward((N / self.b_s).times(rotor.lead * self.b0).hull(_number(ZERO)))

    def factors(self) -> dict[str, NumberRange]:
        """Return the range of every factor except the share of pitch, rounded outward."""
        rotor, machine, box, x = self.rotor, self.machine, self.box, self.x_rest
        one, b0 = _number(FULL), _number(self.b0)
        turned = self.slope("proportional").size * x
        sigma = self.by_pitch(self.band).times(1 / self.b0)
        late = max(self.table("limit", self.v).high / self.b0 - sigma.low, ZERO)
        nodes = rotor.wind
        free = nodes[0] <= self.v.low - box["estimate"]
        free = free and self.v.high + box["estimate"] <= nodes[-1]
        found = {
            "speed slope": self.slope("speed"),
            "effort slope": self.slope("effort") + NumberRange(-turned, turned),
            "gamma": self.table("proportional", self.v_s),
            "held estimate": one if free else NumberRange(ZERO, FULL),
            "feed-forward": self.step(rotor.ahead).hull(_number(ZERO)),
            "pitch per effort": b0 / self.b_s,
            "pitch by schedule": self.shed_rest
            * self.slope("effectiveness")
            * b0
            / (self.b_s * self.b),
            "lead": self.lead(),
            "integral rate": self.step(rotor.integral_rates),
            "stiffness": self.by_speed(box["speed"]),
            "pitch gain": sigma,
            "late pitch gain": NumberRange(ZERO, late),
            "inertia": machine.kappa,
            "observed stiffness": self.by_speed(max(box["speed"], box["measured"])),
            "wind gain": self.by_wind(),
            "observer inertia": _number(machine.inertia_ratio),
            "wake rate": self.v / machine.length,
            "drive": NumberRange(self.drive(), FULL),
        }
        return {name: at if name in EXACT else _outward(at) for name, at in found.items()}

    def drive(self) -> fmpq:
        """Return h_min: the least of 1 and limit tau over the largest |beta_s - beta|."""
        box, rotor = self.box, self.rotor
        bent = self.shed_rest.high * self.slope("effectiveness").size / self.b.low
        asked = (self.share.high * box["effort"] + bent * box["schedule"]) / self.b_s.low
        away = asked + self.lead().size * self.rho / self.b0 + box["pitch"] / self.b0
        return min(FULL, rotor.rate_limit * rotor.drive / away)

    # Limits.

    def limits(self) -> list[tuple[str, bool]]:
        """Return the conditions under which limits missing in the equations are not reached."""
        rotor, machine, box, rho = self.rotor, self.machine, self.box, self.rho
        away = box["estimate"]
        observed = machine.least_wind < self.v.low - away, self.v.high + away < machine.most_wind
        fed = max(min(abs(rotor.ahead[k]) * rho, rotor.ahead_limit[k]) for k in self.intervals)
        relief = ramp(-self.efforts.low, rotor.overlap) + fed
        led = self.lead().size / self.b0
        asked = rotor.pitch_min + self.shed.high / self.b_s.low + led * rho
        torque, pitch = self.command_rates()
        return [
            ("the observer's wind", all(observed)),
            ("a wind above 0", self.v.low - box["schedule"] > 0),
            ("torque above 0", rotor.per_effort * relief <= rotor.torque),
            ("pitch below its limit", max(asked, self.band.high) <= rotor.pitch_max),
            ("the integral", box["integral"] + self.x_rest <= rotor.integral_limit),
            ("the rate of torque", torque <= machine.torque_rate),
            ("the rate of pitch", pitch <= rotor.rate_limit),
        ]

    def command_rates(self) -> tuple[fmpq, fmpq]:
        """Return bounds of the rates of both commands."""
        rotor, machine, box, rho = self.rotor, self.machine, self.box, self.rho
        w, q, gamma, b = (
            self.slope(name).size for name in ("speed", "effort", "proportional", "effectiveness")
        )
        nu = self.step(rotor.integral_rates).high
        signal = box["measured_rate"] + w * rho + nu * (box["measured"] + w * box["schedule"])
        U = (q + gamma * (box["signal"] + self.x_rest)) * rho
        U += self.table("proportional", self.v_s).high * signal
        bend = (machine.l2 * box["innovation"] + rho) / machine.lag
        reserve = ramp_slope(-self.efforts.low, rotor.overlap)
        torque = rotor.per_effort * (reserve * U + self.step(rotor.ahead).size * bend)
        asked = (self.share.high * U + self.shed.high * b * rho / self.b_s.low) / self.b_s.low
        return torque, asked + self.lead().size / self.b0 * bend


def _short_cell(cell: RunningCell) -> Any:
    """Return the cell of tables whose only nodes are its two winds, for their residual."""
    short: Any = copy(cell.rotor)
    for name in ("speed", "effort", "effectiveness", "limit", "proportional"):
        ends = [cell.value(name, v) for v in (cell.v.low, cell.v.high)]
        setattr(short, name, ends)
    short.wind = [cell.v.low, cell.v.high]
    short.kappa = short.power = _number(FULL)
    short.speed_signal = short.effort_lag = ZERO
    return WindCell(short, 0)


def _number(value: fmpq) -> NumberRange:
    return NumberRange(value, value)


def _three_decimals(value: fmpq) -> fmpq:
    """Return the nearest multiple of a thousandth; of two, the even one."""
    twice = value * 2000
    down = int(twice.p) // int(twice.q)
    whole, half = divmod(down, 2)
    if half and (twice.q != 1 or whole % 2):
        whole += 1
    return fmpq(whole, 1000)


def _outward(span: NumberRange) -> NumberRange:
    """Return the range with ends of seven decimals."""
    return NumberRange(-_rounded_up(-span.low), _rounded_up(span.high))


def _rounded_up(value: fmpq) -> fmpq:
    """Return the number, rounded up to seven decimals."""
    return fmpq(-((-int(value.p) * DECIMALS) // int(value.q)), DECIMALS)


SIDES = (
    "speed",
    "measured",
    "pitch",
    "signal",
    "effort",
    "schedule",
    "estimate",
    "integral",
    "measured_rate",
    "innovation",
)


class Machine:
    """Numbers that are not in the law; ``stop`` is (frequency, share passed), or None."""

    def __init__(self, claim: Any, model: Any, gains: Any) -> None:
        seen, filters = entry(claim, "observer"), entry(claim, "measurement")
        family = entry(claim, "uncertainty")
        self.l1, self.l2 = rational(seen, "l1"), rational(seen, "l2")
        self.least_wind, self.most_wind = rationals(seen, "wind_limits", 2)
        self.corner, self.lag = rational(filters, "speed_filter"), rational(gains, "wind_filter")
        self.stop: tuple[fmpq, fmpq] | None = None
        positive = [self.l1, self.l2, self.least_wind, self.corner, self.lag]
        _no_other_filters(filters)
        if "torsion_filter" in filters:
            self.stop = _band_stop(filters["torsion_filter"])
            positive.append(self.stop[0])
            if self.stop[1] < 0 or self.stop[1] > 1:
                raise Refusal("torsion_filter: a share from 0 to 1 must pass")
        self.torque_rate = rational(model, "torque_rate_limit")
        light, heavy = rationals(family, "inertia", 2)
        short, long = rationals(family, "wake_length", 2)
        positive += [self.torque_rate, light, short]
        in_order = light <= heavy and short <= long and self.least_wind < self.most_wind
        if min(positive) <= 0 or not in_order:
            raise Refusal("a number of observer, filters or family that is not in its range")
        self.kappa, self.length = NumberRange(1 / heavy, 1 / light), NumberRange(short, long)
        self.inertia_ratio = _inertia_ratio(model)

    @property
    def states(self) -> int:
        return 8 if self.stop is None else 10


def box(cell: Any) -> dict[str, fmpq]:
    """Return the sides of a cell's box."""
    sides = {name: rational(entry(cell, "sides"), name) for name in SIDES}
    if min(sides.values()) <= 0:
        raise Refusal("sides: positive numbers are needed")
    return sides


def same_controller(claim: Any, document: Any) -> bool:
    """Return whether observer and filters are those of the file's controller, if there is one."""
    if not isinstance(document, dict) or document.get("controller") is None:
        return True
    own = document["controller"]
    parts = ("observer", "measurement")
    return all(_numbers(claim, part) == _numbers(own, part) for part in parts)


def _numbers(owner: Any, part: str) -> list[fmpq] | None:
    """Return the numbers of one part, or None where it is missing."""
    if not isinstance(owner, dict) or part not in owner:
        return None
    found = owner[part]
    if part == "observer":
        return [rational(found, "l1"), rational(found, "l2"), *rationals(found, "wind_limits", 2)]
    _no_other_filters(found)
    numbers = [rational(found, "speed_filter")]
    if "torsion_filter" in found:
        numbers += _band_stop(found["torsion_filter"])
    return numbers


def _no_other_filters(stated: Any) -> None:
    if not isinstance(stated, dict) or not set(stated) <= {"speed_filter", "torsion_filter"}:
        raise Refusal("measurement: a low-pass and a band-stop, and nothing else")


def _band_stop(stated: Any) -> tuple[fmpq, fmpq]:
    """Return frequency and share passed; refuses what else a filter of another form has."""
    found = rational(stated, "frequency"), rational(stated, "passed")
    if len(stated) > len(found):
        raise Refusal("torsion_filter: frequency and passed, and nothing else")
    return found


def _inertia_ratio(model: Any) -> fmpq:
    """Return J / J_o: the observer divides by the nearest float of J, written in decimals."""
    n = rational(model, "gear_ratio")
    J = rational(model, "rotor_inertia") + n * n * rational(model, "generator_inertia")
    if J <= 0:
        raise Refusal("model: a positive inertia is needed")
    p, q = Decimal(repr(int(J.p) / int(J.q))).as_integer_ratio()
    return J / fmpq(p, q)
