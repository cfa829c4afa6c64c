"""Margins that are asked of the loop that runs, and whether it has them.

    gain 2, phase 30deg, delay 0.1s, disk 0.5, sample 20ms, computing 10ms

Gain is a factor above 1, or dB, that torque and pitch may both grow and fall by; disk is alpha of
both loops at once.  ``sample`` and ``computing`` are no thresholds: they say how the law runs.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from takagi.models.errors import ModelError, did_you_mean
from takagi.reports.margins.running_over_wind import RunningMargins, wind_ranges

_WORD = re.compile(r"\s*([a-z]+)\s*([0-9.]+(?:[eE][-+]?[0-9]+)?)\s*([A-Za-z°]*)\s*")
# Name -> unit as written -> factor to what is compared; "" where no unit is needed.
_TIME = {"s": 1.0, "ms": 1e-3}
_UNITS: Mapping[str, Mapping[str, float]] = {
    "gain": {"": 1.0, "dB": 1.0},
    "phase": {"deg": math.pi / 180, "°": math.pi / 180, "rad": 1.0},
    "delay": _TIME,
    "disk": {"": 1.0},
    "sample": _TIME,
    "computing": _TIME,
}
# What the message on a missed threshold ends with.
RAISED_BY = (
    "margins grow with a smaller --bandwidth or --bandwidth-growth, a slower --wind-filter, a "
    "faster --speed-filter, a band-stop (--torsion-filter) and a larger --pitch-effectiveness-share"
)
EXAMPLE = '"gain 1.5, phase 10deg, delay 15ms"'


@dataclass(frozen=True, slots=True)
class AskedMargins:
    """What is asked: 0 (gain: 1) asks nothing.

    Attributes
    ----------
    gain : factor [-].   phase [rad].   delay [s].   disk : alpha [-].
    sample, computing : of the program [s].
    """

    gain: float = 1.0
    phase: float = 0.0
    delay: float = 0.0
    disk: float = 0.0
    sample: float = 0.02
    computing: float = 0.0


class _Least(NamedTuple):
    value: float
    loop: str
    row: RunningMargins


def asked_margins(written: str) -> AskedMargins:
    """Return what a text asks, such as ``"gain 2, phase 30deg, delay 0.1s"``.

    Raises
    ------
    ModelError : a word, number or unit that says nothing, a word twice, or no threshold.
    """
    found: dict[str, float] = {}
    for part in written.split(","):
        match = _WORD.fullmatch(part)
        if match is None:
            raise ModelError(
                f"margins: {part.strip()!r} was given; a name, a number and its unit are needed, "
                f"such as {EXAMPLE}"
            )
        name, unit = match.group(1), match.group(3)
        if name not in _UNITS:
            raise ModelError(
                f"margins: {name!r} is not known{did_you_mean(name, _UNITS)}; choose from "
                f"{', '.join(_UNITS)}"
            )
        if unit not in _UNITS[name]:
            units = " or ".join(unit or "no unit" for unit in _UNITS[name])
            raise ModelError(f"margins: {part.strip()!r} was given; {name} needs {units}")
        if name in found:
            raise ModelError(f"margins: {name} was given twice")
        found[name] = _value(name, match.group(2), unit, part.strip())
    if not found.keys() - {"sample", "computing"}:
        raise ModelError(f"margins: {written!r} asks for none; give some, such as {EXAMPLE}")
    return AskedMargins(**found)


def failed(rows: Sequence[RunningMargins], asked: AskedMargins) -> tuple[str, ...]:
    """Return a sentence for each threshold that is missed: the least figure, where, how often."""
    found = []
    kinds = {"gain": asked.gain, "phase": asked.phase, "delay": asked.delay, "disk": asked.disk}
    for kind, needed in kinds.items():
        below = [one for one in (_least(row, kind) for row in rows) if one.value < needed]
        if below:
            least = min(below, key=lambda one: one.value)
            winds = wind_ranges([one.row.wind for one in below], [row.wind for row in rows])
            value = _figure(kind, least.value)
            found.append(
                f"at {_where(least.row)} the {kind} margin of {least.loop} is {value}, "
                f"{_figure(kind, needed)} is asked; missed at {winds}"
            )
    return tuple(found)


def measured(rows: Sequence[RunningMargins], asked: AskedMargins, source: str) -> tuple[str, ...]:
    """Return what was measured in words: the least of every kind, and the modes that are met."""
    winds = sorted({row.wind for row in rows})
    figures = []
    for kind in ("gain", "phase", "delay", "disk"):
        least = min((_least(row, kind) for row in rows), key=lambda one: one.value)
        value = _figure(kind, least.value)
        figures.append(f"{kind} {value} ({least.loop}, {least.row.wind:g} m/s)")
    lines = [
        f"{source}: margins of the loop that runs, {winds[0]:g} to {winds[-1]:g} m/s, "
        f"{len({(row.inertia, row.wake) for row in rows})} plants, sampled every "
        f"{asked.sample * 1e3:g} ms, computing {asked.computing * 1e3:g} ms: least "
        f"{', '.join(figures)}; linearised in floating point: measured, not proved"
    ]
    return (*lines, *modes_met(rows))


def modes_met(rows: Sequence[RunningMargins]) -> tuple[str, ...]:
    """Return a sentence for each mode at which a loop's gain reaches 1, with what helps."""
    places: dict[tuple[str, str], list[RunningMargins]] = {}
    frequency = {}
    for row in rows:
        for loop, mode in row.modes_met:
            places.setdefault((loop, mode.name), []).append(row)
            frequency[mode.name] = mode.frequency
    found = []
    for (loop, name), met in places.items():
        winds = wind_ranges([row.wind for row in met], [row.wind for row in rows])
        less_lag = "a band-stop below it (--torsion-filter), less lag (less computing time) or "
        advice = f"{less_lag if name == 'torsion' else ''}a smaller gain helps"
        found.append(
            f"the {name} mode ({frequency[name] / 2 / math.pi:.2f} Hz) lies inside the crossover "
            f"of the {loop} loop at {winds}: {advice}"
        )
    return tuple(found)


def _least(row: RunningMargins, kind: str) -> _Least:
    """Return the row's least margin of a kind, and of which loop."""
    if kind == "disk":
        return _Least(row.both.alpha, "torque and pitch", row)
    return _Least(*min((getattr(m, kind), name) for name, m in row.loops), row)


def _figure(kind: str, value: float) -> str:
    if not math.isfinite(value):
        return "without bound"
    if kind == "phase":
        return f"{math.degrees(value):.3g} deg"
    return f"{value:.3g} s" if kind == "delay" else f"{value:.3g}"


def _where(row: RunningMargins) -> str:
    parts = [f"{row.wind:g} m/s"]
    if not row.nominal:
        parts.append(f"inertia {row.inertia:g} of nominal, {row.wake} wake")
    if row.decay_rate <= 0:
        parts.append("where the loop is unstable")
    return f"{parts[0]} ({', '.join(parts[1:])})" if parts[1:] else parts[0]


def _value(name: str, number: str, unit: str, part: str) -> float:
    try:
        value = float(number) * _UNITS[name][unit]
    except ValueError as error:
        raise ModelError(f"margins: {number!r} is no number") from error
    if unit == "dB":
        value = 10 ** (value / 20)
    least = 1.0 if name == "gain" else 0.0
    if not (math.isfinite(value) and (value > least or (name == "computing" and value >= 0))):
        raise ModelError(f"margins: {part!r} was given; {name} must lie above {least:g}")
    if name == "disk" and value >= 2:
        raise ModelError(f"margins: {part!r} was given; no loop has a disk margin of 2 or more")
    return value
