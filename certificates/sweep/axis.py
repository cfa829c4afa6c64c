"""An axis of a sweep: a quantity, its unit and its values, and how one is written."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import UNITS, to_si

# Values between the ends are short decimals, because they identify the point in journal and
# tables.
_DIGITS = 9
_MOST = 100_000
_NUMBER = re.compile(r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*")


@dataclass(frozen=True, slots=True)
class AxisKind:
    """A quantity that may be swept.

    Attributes
    ----------
    name : as in ``--over``;  unit : SI unit of its values;  words : its description.
    above : every value must be larger;  highest : no value may be larger.
    closed : whether ``above`` itself is allowed.
    """

    name: str
    unit: str
    words: str
    above: float = 0.0
    highest: float = math.inf
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Axis:
    """A quantity with the values it takes, in its SI unit, increasing.

    Raises
    ------
    ModelError : no value, or values that do not increase.
    """

    name: str
    unit: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.values:
            raise ModelError(f"axis {self.name}: no values were given; at least one is needed")
        for low, high in zip(self.values, self.values[1:], strict=False):
            if not low < high:
                raise ModelError(
                    f"axis {self.name}: {low:g} is followed by {high:g} {self.unit}; values must "
                    "increase"
                )


def parse_axes(written: Sequence[str], kinds: Sequence[AxisKind]) -> tuple[Axis, ...]:
    """Return the axes that texts like ``speed-overlap=0.02:0.2:20`` ask for, in their order.

    A text is NAME=LOW:HIGH:COUNT (evenly spaced, both ends included) or NAME=VALUE,VALUE,...; a
    number may have a unit behind it (``torque-overlap=0.5kN m:5kN m:10``), else it is in SI.

    Raises
    ------
    ModelError : a name that is not known (the known ones are listed) or is given twice, a text of
        another form, a unit of another quantity, a range that does not increase, a value beyond
        what the quantity allows, more than 100 000 points.
    """
    known = {kind.name: kind for kind in kinds}
    found: dict[str, Axis] = {}
    for text in written:
        name, equals, values = text.partition("=")
        name = name.strip()
        if name not in known:
            raise ModelError(
                f"--over {text}: {name!r} cannot be swept{did_you_mean(name, known)}; known here: "
                + ", ".join(f"{kind.name} [{kind.unit}]" for kind in kinds)
            )
        if name in found:
            raise ModelError(f"--over {text}: {name} was given before; give each axis once")
        if not equals:
            raise ModelError(
                f"--over {text}: values are missing; write {name}=LOW:HIGH:COUNT or "
                f"{name}=VALUE,VALUE,..."
            )
        found[name] = _axis(text, known[name], values)
    points = math.prod(len(axis.values) for axis in found.values())
    if points > _MOST:
        raise ModelError(f"{points} points were asked for; at most {_MOST} are made in one sweep")
    return tuple(found.values())


def _axis(text: str, kind: AxisKind, values: str) -> Axis:
    parts = values.split(":")
    if len(parts) == 1:
        numbers = [_number(text, kind, part) for part in values.split(",")]
    elif len(parts) == 3:
        numbers = _spaced(text, kind, parts)
    else:
        raise ModelError(
            f"--over {text}: write {kind.name}=LOW:HIGH:COUNT or {kind.name}=VALUE,VALUE,..."
        )
    for value in numbers:
        least = kind.closed and value == kind.above
        if not (least or kind.above < value <= kind.highest):
            limit = f"{'at least' if kind.closed else 'above'} {kind.above:g}"
            limit += f" and at most {kind.highest:g}" if kind.highest < math.inf else ""
            raise ModelError(
                f"--over {text}: {value:g} {kind.unit} was given; {kind.name} must be {limit} "
                f"{kind.unit}"
            )
    try:
        return Axis(kind.name, kind.unit, tuple(numbers))
    except ModelError as error:
        raise ModelError(f"--over {text}: {error}") from error


def _spaced(text: str, kind: AxisKind, parts: Sequence[str]) -> list[float]:
    low, high = (_number(text, kind, part) for part in parts[:2])
    if not re.fullmatch(r"\s*[0-9]{1,6}\s*", parts[2]) or int(parts[2]) < 2:
        raise ModelError(
            f"--over {text}: {parts[2]!r} was given as the number of values; a whole number from 2 "
            f"to {_MOST} is needed"
        )
    if not low < high:
        raise ModelError(
            f"--over {text}: the range {low:g} to {high:g} {kind.unit} does not increase; give the "
            "smaller end first"
        )
    count = int(parts[2])
    if count > _MOST:
        raise ModelError(f"--over {text}: {count} values were asked for; at most {_MOST} are made")
    steps = [low + (high - low) * i / (count - 1) for i in range(count)]
    return [low, *(float(f"{value:.{_DIGITS}g}") for value in steps[1:-1]), high]


def _number(text: str, kind: AxisKind, part: str) -> float:
    found = _NUMBER.fullmatch(part)
    if found is None:
        raise ModelError(f"--over {text}: {part!r} is not a number; write it like 0.05 or 1e-3")
    value = float(found.group(1))
    if not math.isfinite(value):
        raise ModelError(f"--over {text}: {part!r} is too large for a number")
    if not found.group(2):
        return value
    try:
        # The unit's factor must not add further digits to a decimal that was typed.
        return float(f"{to_si(value, _spelled(found.group(2)), kind.unit):.12g}")
    except ModelError as error:
        raise ModelError(f"--over {text}: {error}") from error


def _spelled(unit: str) -> str:
    """Return the unit as the table spells it: "kNm" is read as "kN m"."""
    spellings: Mapping[str, str] = {known.replace(" ", ""): known for known in UNITS}
    return spellings.get(unit.replace(" ", ""), unit)
