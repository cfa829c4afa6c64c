"""The units that a turbine file may use, and their factors to SI."""

from __future__ import annotations

from math import pi

from takagi.models.errors import ModelError, did_you_mean

UNITS: dict[str, tuple[str, float]] = {
    "-": ("-", 1.0),
    "m": ("m", 1.0),
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "kg": ("kg", 1.0),
    "t": ("kg", 1e3),
    "kg m^2": ("kg m^2", 1.0),
    "kg/m^3": ("kg/m^3", 1.0),
    "m/s": ("m/s", 1.0),
    "rad": ("rad", 1.0),
    "deg": ("rad", pi / 180),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", pi / 180),
    "rpm": ("rad/s", pi / 30),
    "Hz": ("rad/s", 2 * pi),
    "N": ("N", 1.0),
    "kN": ("N", 1e3),
    "N m": ("N m", 1.0),
    "kN m": ("N m", 1e3),
    "N m/s": ("N m/s", 1.0),
    "kN m/s": ("N m/s", 1e3),
    "N/m": ("N/m", 1.0),
    "m/N": ("m/N", 1.0),
    "N s/m": ("N s/m", 1.0),
    "N m/rad": ("N m/rad", 1.0),
    "N m s/rad": ("N m s/rad", 1.0),
    "N m s^2/rad^2": ("N m s^2/rad^2", 1.0),
    "W": ("W", 1.0),
    "kW": ("W", 1e3),
    "MW": ("W", 1e6),
    "W/rad": ("W/rad", 1.0),
    "MW/rad": ("W/rad", 1e6),
}
"""Unit as written -> (SI unit, factor)."""


def accepted_units(si_unit: str) -> list[str]:
    """Return the spellings that convert to an SI unit."""
    return [unit for unit, (target, _) in UNITS.items() if target == si_unit]


def to_si(value: float, unit: str, si_unit: str) -> float:
    """Return the value in the SI unit.

    Raises
    ------
    ModelError : the unit is not known, or measures something else.
    """
    accepted = ", ".join(repr(name) for name in accepted_units(si_unit))
    if unit not in UNITS:
        raise ModelError(
            f"unit {unit!r} is not known{did_you_mean(unit, UNITS)}; this field accepts {accepted}"
        )
    target, factor = UNITS[unit]
    if target != si_unit:
        raise ModelError(f"unit {unit!r} does not fit; this field accepts {accepted}")
    return value * factor
