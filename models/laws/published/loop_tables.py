"""The data of the vector field with a published law: trim tables, scheduled gains, figures."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import prod

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Dual, Range, span
from takagi.models.laws.published.law import PublishedLaw
from takagi.models.laws.published.regional_schedule import (
    RegionalSchedule,
    premise_band,
    premise_evaluators,
)
from takagi.models.ramps import Ramp
from takagi.models.splines.scalar_surface import PatchRanges, patch_ranges
from takagi.models.turbine.operating_band import OperatingBand
from takagi.models.turbine.trim import TABLE_SHARE, optimal_tip_speed_ratio

# Largest accepted difference between a premise as computed here and as the law computes it.
SAME = 1e-9
PREMISES = {"a": 0, "b": 1, "d": 2}


@dataclass(frozen=True, slots=True)
class TrimTable:
    """omega*(v), beta*(v), linear between nodes and held beyond them."""

    wind: tuple[float, ...]
    rotor_speed: tuple[float, ...]
    pitch_angle: tuple[float, ...]

    @property
    def range(self) -> Range:
        return self.wind[0], self.wind[-1]

    def speed(self, wind: Dual) -> Dual:
        return self._at(self.rotor_speed, wind)

    def pitch(self, wind: Dual) -> Dual:
        return self._at(self.pitch_angle, wind)

    def speed_at(self, wind: float) -> float:
        return self._value(self.rotor_speed, wind)

    def _value(self, column: Sequence[float], wind: float) -> float:
        v = min(max(wind, self.wind[0]), self.wind[-1])
        k = min(max(bisect_right(self.wind, v) - 1, 0), len(self.wind) - 2)
        share = (v - self.wind[k]) / (self.wind[k + 1] - self.wind[k])
        return column[k] + share * (column[k + 1] - column[k])

    def _at(self, column: Sequence[float], wind: Dual) -> Dual:
        low, high = wind.value
        first, last = bisect_right(self.wind, low), bisect_left(self.wind, high)
        ends = [self._value(column, low), self._value(column, high)]
        slopes = [0.0] if low < self.wind[0] or high > self.wind[-1] else []
        for k in range(max(first - 1, 0), min(max(last, first), len(self.wind) - 1)):
            slopes.append((column[k + 1] - column[k]) / (self.wind[k + 1] - self.wind[k]))
        return wind.through(span(*ends, *column[first:last]), span(*(slopes or [0.0])))


@dataclass(frozen=True, slots=True)
class GainTable:
    """One region's gains over the corners of its premises that matter, and its trim table.

    Attributes
    ----------
    trim : the table the premises refer to.
    bounds : (lower, upper) of a, and of b in full load.
    gains : per kind (speed, pitch, integral), corner of the premises -> gain, published sign.
    """

    trim: TrimTable
    bounds: tuple[Range, ...]
    gains: tuple[dict[tuple[int, ...], float], ...]

    def weight(self, index: int, premise: Dual) -> Dual:
        """Return (z - lower)/(upper - lower) held to [0, 1]."""
        low, high = self.bounds[index]
        return premise.plus(-low).scaled(1 / (high - low)).held(0.0, 1.0)

    def blended(self, kind: int, weights: Sequence[Dual]) -> Dual:
        """Return the gain, affine in each weight: corners give its range and its partials'."""
        table, ends = self.gains[kind], [w.value for w in weights]
        value = span(*(_multilinear(table, w) for w in product(*ends)))
        slopes: list[Range] = [(0.0, 0.0)] * len(weights[0].slopes)
        for i, weight in enumerate(weights):
            other_ends = [(0.0, 1.0) if j == i else end for j, end in enumerate(ends)]
            partial = _partial(table, i, other_ends)
            inner = weight.through(weight.value, partial).slopes
            slopes = [(a[0] + b[0], a[1] + b[1]) for a, b in zip(slopes, inner, strict=True)]
        return Dual(value, tuple(slopes))


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopFigures:
    """Every number of the closed loop, SI units, angles in rad; see ``loop_figures``."""

    surface: PatchRanges
    torque_per_inertia: float
    gear_per_inertia: float
    radius: float
    pitch_time: float
    pitch_rate_limit: float
    pitch_limits: Range
    rated_torque: float
    torque_overlap: float
    speed_ramp: Ramp
    partial: GainTable
    full: GainTable
    tracking_time: float | None
    optimal_ratio: float
    largest_ratio: float
    minimum_speed: float
    speed_setpoint: float
    cut_in: float
    cut_out: float

    def passed(self, command: float) -> float:
        """Return phi(u_1) held at 0 [N m]."""
        half, limit = self.torque_overlap / 2, self.rated_torque
        if command <= limit - half:
            return max(command, 0.0)
        return (
            limit if command >= limit + half else limit - (limit + half - command) ** 2 / (4 * half)
        )

    def passed_slope(self, command: float) -> float:
        """Return phi'(u_1) for u_1 >= 0; it falls from 1 to 0."""
        half = self.torque_overlap / 2
        return min(max((self.rated_torque + half - command) / (2 * half), 0.0), 1.0)

    def ramp_slope(self, low: float, high: float) -> Range:
        """Return the range of f_1' over [low, high]; one-sided slopes at a kink."""
        width = self.speed_ramp.width
        a, b = ((x - self.speed_ramp.start) / width for x in (low, high))
        if b <= 0 or a >= 1:
            return 0.0, 0.0
        if self.speed_ramp.shape == "linear":
            return (1 / width if a >= 0 and b <= 1 else 0.0), 1 / width
        ends = [6 * s * (1 - s) for s in (min(max(a, 0.0), 1.0), min(max(b, 0.0), 1.0))]
        if a < 0.5 < b:
            ends.append(1.5)
        return min(ends) / width, max(ends) / width


def loop_figures(law: PublishedLaw) -> LoopFigures:
    """Return the numbers of the closed loop with a published law.

    Raises
    ------
    ModelError : a filter or gains that the enclosure does not cover; the message says what to take.
    """
    turbine, coupling = law.turbine, law.coupling
    if coupling.variant != "saturated":
        raise ModelError(
            f"coupling filter {coupling.variant!r}: claims cover the variant 'saturated' alone"
        )
    if coupling.rated_torque != turbine.rated_torque:
        raise ModelError(
            f"the filter holds torque at {coupling.rated_torque:.6g} N m, the turbine's limit is "
            f"{turbine.rated_torque:.6g} N m; a claim needs them equal"
        )
    return LoopFigures(
        surface=patch_ranges(turbine.torque),
        torque_per_inertia=turbine.torque_constant / turbine.inertia,
        gear_per_inertia=turbine.gear_ratio / turbine.inertia,
        radius=turbine.rotor_radius,
        pitch_time=turbine.pitch_time_constant,
        pitch_rate_limit=turbine.pitch_rate_limit,
        pitch_limits=(turbine.pitch_min, turbine.pitch_max),
        rated_torque=coupling.rated_torque,
        torque_overlap=coupling.torque_overlap,
        speed_ramp=coupling.speed_ramp,
        partial=_gain_table(law, law.partial, 1),
        full=_gain_table(law, law.full, 2),
        tracking_time=law.tracking_time,
        optimal_ratio=optimal_tip_speed_ratio(turbine),
        largest_ratio=TABLE_SHARE * turbine.torque.x_range[1],
        minimum_speed=turbine.minimum_rotor_speed,
        speed_setpoint=law.speed_setpoint,
        cut_in=turbine.cut_in,
        cut_out=turbine.cut_out,
    )


def schedule_band(law: PublishedLaw, schedule: RegionalSchedule) -> OperatingBand:
    """Return the trim table that a schedule's premises refer to.

    Raises
    ------
    ModelError : the schedule was made with another table.
    """
    rated = law.speed_setpoint == law.turbine.rated_rotor_speed
    band = premise_band(law.turbine, schedule.model, None if rated else law.speed_setpoint)
    low, high = float(band.wind[0]), float(band.wind[-1])
    names = [p.name for p in schedule.model.premises]
    mine = premise_evaluators(band, with_pitch="b" in names)
    for first, last in pairwise(np.linspace(low, high, 9)):
        at = (law.reference_speed(first) + 0.01, 0.1, (first + last) / 2)
        for name, theirs in zip(names, schedule.evaluators, strict=True):
            if abs(mine[name](*at) - theirs(*at)) > SAME:
                raise ModelError(
                    f"{schedule.model.name}: premise {name} of the schedule refers to another "
                    "trim table; make the schedule by regional_schedule"
                )
    return band


def _gain_table(law: PublishedLaw, schedule: RegionalSchedule, count: int) -> GainTable:
    band, premises = schedule_band(law, schedule), schedule.model.premises
    gains: tuple[dict[tuple[int, ...], float], ...] = ({}, {}, {})
    for rule, row in zip(
        schedule.model.rules, np.column_stack([schedule.k_x, schedule.k_I]).tolist(), strict=True
    ):
        for table, gain in zip(gains, row, strict=True):
            if table.setdefault(rule[:count], gain) != gain:
                raise ModelError(
                    f"{schedule.model.name}: gains differ between the corners of the premise d; "
                    "a claim needs them equal (no actuator answers to the wind alone)"
                )
    if [PREMISES[p.name] for p in premises] != [*range(count), 2]:
        raise ModelError(f"{schedule.model.name}: premises a, {'b, ' * (count - 1)}d are needed")
    if count == 1 and any(gains[1].values()):
        raise ModelError(f"{schedule.model.name}: partial load has no gain on pitch")
    bounds = tuple((float(p.lower), float(p.upper)) for p in premises[:count])
    columns = (band.wind, band.rotor_speed, band.pitch)
    return GainTable(TrimTable(*(tuple(c.tolist()) for c in columns)), bounds, gains)


def _multilinear(table: dict[tuple[int, ...], float], weights: Sequence[float]) -> float:
    return sum(
        gain * prod(w if up else 1 - w for up, w in zip(corner, weights, strict=True))
        for corner, gain in table.items()
    )


def _partial(table: dict[tuple[int, ...], float], i: int, ends: Sequence[Range]) -> Range:
    """Return the range of the derivative with respect to weight i over the box of the others."""
    slopes = []
    for weights in product(*ends):
        if weights[i] == 1.0:
            lower = [0.0 if j == i else w for j, w in enumerate(weights)]
            slopes.append(_multilinear(table, weights) - _multilinear(table, lower))
    return span(*slopes)
