"""An axis of a sweep: a quantity, its unit and its values, and how a user writes one."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import UNITS, to_si

# Values between the ends are short decimals, because they identify the point.
_DIGITS = 9
_COUNT = 100_000
_NUMBER = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*")


@dataclass(frozen=True, slots=True)
class AxisKind:
    """A quantity that may be swept, as ``--over`` names it, with the SI unit of its values.

    Its values lie above 0 (or on it, if ``closed``), and not beyond ``highest``.
    """

    name: str
    unit: str
    highest: float = math.inf
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Axis:
    """A quantity with the values it takes, in its SI unit, increasing."""

    name: str
    unit: str
    values: tuple[float, ...]

    @property
    def label(self) -> str:
        """Name and unit, as at the head of a column."""
        return f"{self.name} [{self.unit}]"


def parse_axes(written: Sequence[str], kinds: Sequence[AxisKind]) -> tuple[Axis, ...]:
    """Return the axes that texts like ``speed-overlap=0.02:0.2:20`` ask for, in their order.

    A text is NAME=LOW:HIGH:COUNT (evenly spaced, both ends included) or NAME=VALUE,VALUE,...; a
    number may have a unit behind it (``torque-overlap=0.5kN m:5kN m:10``), else it is in SI.

    Raises
    ------
    ModelError : a name that is not known (the known ones are listed) or is given twice, a text of
        another form, a unit of another quantity, values that do not increase, a value beyond what
        the quantity allows, more than 100 000 points.
    """
    named, axes = {kind.name: kind for kind in kinds}, dict[str, Axis]()
    for text in written:
        name, _, values = text.partition("=")
        name = name.strip()
        if name not in named:
            raise ModelError(
                f"--over {text}: {name!r} cannot be swept{did_you_mean(name, named)}; known here: "
                + ", ".join(f"{kind.name} [{kind.unit}]" for kind in kinds)
            )
        if name in axes:
            raise ModelError(f"--over {text}: {name} was given before; give each axis once")
        try:
            axes[name] = _axis(named[name], values)
        except ModelError as error:
            raise ModelError(f"--over {text}: {error}") from error
    points = math.prod(len(axis.values) for axis in axes.values())
    if points > _COUNT:
        raise ModelError(f"{points} points were asked for; at most {_COUNT} are made in one sweep")
    return tuple(axes.values())


def _axis(kind: AxisKind, text: str) -> Axis:
    ends = text.split(":")
    if len(ends) not in (1, 3) or not text.strip():
        raise ModelError(f"write {kind.name}=LOW:HIGH:COUNT or {kind.name}=VALUE,VALUE,...")
    if len(ends) == 3:
        values = _spaced(_number(kind, ends[0]), _number(kind, ends[1]), ends[2])
    else:
        values = [_number(kind, number) for number in text.split(",")]
    for value in values:
        if not (0 < value or kind.closed and value == 0) or value > kind.highest:
            limit = f"{'at least' if kind.closed else 'above'} 0"
            limit += f" and at most {kind.highest:g}" if kind.highest < math.inf else ""
            raise ModelError(
                f"{value:g} {kind.unit} was given; {kind.name} must be {limit} {kind.unit}"
            )
    for low, high in zip(values, values[1:], strict=False):
        if not low < high:
            raise ModelError(f"{low:g} is followed by {high:g} {kind.unit}; values must increase")
    return Axis(kind.name, kind.unit, tuple(values))


def _spaced(low: float, high: float, count: str) -> list[float]:
    if not re.fullmatch(r"\s*[0-9]{1,6}\s*", count) or not 2 <= int(count) <= _COUNT:
        raise ModelError(
            f"{count!r} was given as the number of values; a whole number from 2 to {_COUNT} is "
            "needed"
        )
    n = int(count) - 1
    steps = [low + (high - low) * i / n for i in range(1, n)]
    return [low, *(float(f"{value:.{_DIGITS}g}") for value in steps), high]


def _number(kind: AxisKind, text: str) -> float:
    match = _NUMBER.fullmatch(text)
    if match is None or not math.isfinite(float(match.group(1))):
        raise ModelError(f"{text!r} is not a number; write it like 0.05 or 1e-3")
    value, unit = float(match.group(1)), match.group(2)
    if not unit:
        return value
    # "kNm" is read as "kN m".
    spellings = {spelled.replace(" ", ""): spelled for spelled in UNITS}
    unit = spellings.get(unit.replace(" ", ""), unit)
    # The unit's factor must not add further digits to a decimal that was typed.
    return float(f"{to_si(value, unit, kind.unit):.12g}")
