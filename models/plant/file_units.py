"""Figures in SI -> the units that the plant's file is written in, for words alone.

Nothing that is proved passes through here: certificates and gain files are in SI.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.files.units import parse_unit

if TYPE_CHECKING:
    from takagi.models.plant.plant import Plant
    from takagi.models.plant.variables import Variable

_NAME = re.compile(r"[A-Za-z%]+")
SECOND = parse_unit("s")


def file_unit(variable: Variable) -> tuple[float, str]:
    """Return (size of the unit in SI, its name) of a variable: as its file has it, else SI."""
    return _size(variable.written), variable.written or variable.unit


def time_in_file_units(plant: Plant, seconds: float) -> tuple[float, str]:
    """Return (number, unit) of a time [s].

    The unit is the largest in which the number is at least 1, of s and the units of time that
    occur in the file's units, such as min in ``L/min``; else the smallest of them.
    """
    sizes = sorted((_size(unit), unit) for unit in _times(plant))
    size, unit = max(
        (time_unit for time_unit in sizes if seconds >= time_unit[0]), default=sizes[0]
    )
    return seconds / size, unit


def rate_in_file_units(plant: Plant, rate: float) -> tuple[float, str]:
    """Return (number, unit) of a rate [1/s], in the unit of time that suits its time constant."""
    if not rate > 0:
        return rate, "1/s"
    unit = time_in_file_units(plant, 1 / rate)[1]
    return rate * _size(unit), f"1/{unit}"


def _times(plant: Plant) -> set[str]:
    """Return s, and the units of time that occur in what the file's figures are written in."""
    units_written = [v.written for v in (*plant.states, *plant.inputs, *plant.disturbances)]
    units_written += [parameter.written for parameter in plant.parameters]
    names = {name for unit in units_written for name in _NAME.findall(unit)}
    return {"s"} | {name for name in names if _is_time(name)}


def _is_time(name: str) -> bool:
    try:
        return parse_unit(name).dimension == SECOND.dimension
    except ModelError:
        return False


def _size(unit: str) -> float:
    unit_read = parse_unit(unit or "-")
    return float(unit_read.factor) * math.pi**unit_read.pi_power
