"""Units in the form of FMI: exponents of the base units."""

from __future__ import annotations

import re

from takagi.models.errors import ModelError
from takagi.models.files.units import BASE, parse_unit


def base_units(unit: str) -> dict[str, int] | None:
    """Return the exponents of kg, m, s, A, K, mol, cd and rad that are not 0.

    None for a text that is no SI unit; signals of a gain file are in SI.
    """
    try:
        found = parse_unit(unit)
    except ModelError:
        return None
    powers = found.dimension.exponents
    if not found.is_si or any(power.denominator != 1 for power in powers):
        return None
    exponents = {name: int(power) for name, power in zip(BASE, powers, strict=True)}
    exponents["rad"] = _radians(unit)
    return {name: power for name, power in exponents.items() if power}


def _radians(unit: str) -> int:
    """Return the exponent of rad, which is a pure number in SI and a base unit in FMI."""
    above, _, below = unit.partition("/")

    def count(text: str) -> int:
        return sum(int(power or 1) for power in re.findall(r"\brad\b(?:\^(-?\d+))?", text))

    return count(above) - count(below)
