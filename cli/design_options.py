"""What may be asked of a design on the command line, and its translation into settings.

The options are declared once, as annotated types, and shared by the verbs that design.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from takagi.certificates.turbine_design import DesignSettings
    from takagi.models.embedding.coherent import Uncertainty
    from takagi.models.enclosure.interval import Interval
    from takagi.models.turbine.data import Turbine

__all__ = [
    "Bandwidth",
    "EquilibriumWake",
    "Inertia",
    "Law",
    "Model",
    "Overlap",
    "SpeedOverlap",
    "SpeedSetpoint",
    "TorqueOverlap",
    "design_settings",
    "turbine_options",
    "uncertainty_asked",
]

Model = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A built-in name (see `takagi models`) or the path of a TOML file.",
        show_default=False,
    ),
]
Law = Annotated[
    str,
    typer.Option(
        "--law", help="Turbines: coherent, paper or paper-two-integrators.", metavar="NAME"
    ),
]
Overlap = Annotated[
    float | None,
    typer.Option(
        help="Turbines: half the width of effort over which torque and pitch both act [rad/s^2]; "
        "0.01 unless given. Law coherent."
    ),
]
SpeedOverlap = Annotated[
    float | None,
    typer.Option(
        help="Turbines: overlap of the coupling filter in rotor speed [rad/s]; 0.05 unless given. "
        "Laws of the paper."
    ),
]
TorqueOverlap = Annotated[
    float | None,
    typer.Option(
        help="Turbines: overlap of the coupling filter in torque [N m]; 2000 unless given. Laws of "
        "the paper."
    ),
]
SpeedSetpoint = Annotated[
    str | None,
    typer.Option(
        metavar="SPEED",
        help="Turbines: de-rated rotor speed with its unit, 11.5rpm or 1.2rad/s; rated speed "
        "unless given.",
    ),
]
Bandwidth = Annotated[
    float | None,
    typer.Option(
        help="Turbines: proportional action aimed at [1/s]; 0.6 unless given. Law coherent."
    ),
]
Inertia = Annotated[
    tuple[str, str] | None,
    typer.Option(
        metavar="LOW HIGH",
        help="Turbines: true over nominal inertia that gains and certificate must cover; 0.9 1.1 "
        "unless given. Law coherent.",
    ),
]
EquilibriumWake = Annotated[
    bool,
    typer.Option(
        "--equilibrium-wake",
        help="Turbines: leave the frozen wake out of the pitch effectiveness that the certificate "
        "covers: a larger wind class, for a smaller family of plants.",
    ),
]


def turbine_options(
    law: Law = "coherent",
    overlap: Overlap = None,
    speed_overlap: SpeedOverlap = None,
    torque_overlap: TorqueOverlap = None,
    speed_setpoint: SpeedSetpoint = None,
    bandwidth: Bandwidth = None,
    inertia: Inertia = None,
    equilibrium_wake: EquilibriumWake = False,
) -> None:
    """Declare what a design for a wind turbine may be asked for."""


_OF_COHERENT = ("overlap", "bandwidth", "inertia", "equilibrium_wake")
_OF_PAPER = ("speed_overlap", "torque_overlap")


def design_settings(
    turbine: Turbine,
    *,
    law: str = "coherent",
    overlap: float | None = None,
    speed_overlap: float | None = None,
    torque_overlap: float | None = None,
    speed_setpoint: str | None = None,
    bandwidth: float | None = None,
    inertia: tuple[str, str] | None = None,
    equilibrium_wake: bool = False,
) -> DesignSettings:
    """Return what is asked for; an option that is not given keeps the library's default.

    Raises
    ------
    ModelError : an option that makes no sense for the law or the turbine; names the option.
    """
    from takagi.certificates.turbine_scale import default_settings
    from takagi.lmi.turbine.effort import EffortSettings

    given = {
        "overlap": overlap,
        "speed_overlap": speed_overlap,
        "torque_overlap": torque_overlap,
        "bandwidth": bandwidth,
        "inertia": inertia,
        "equilibrium_wake": equilibrium_wake or None,
    }
    numbers = {
        name: _positive(name, value)
        for name, value in given.items()
        if isinstance(value, float | int) and not isinstance(value, bool)
    }
    setpoint = None if speed_setpoint is None else _setpoint(speed_setpoint, turbine)
    asked = replace(
        default_settings(turbine),
        law=law,
        speed_setpoint=setpoint,
        **{name: value for name, value in numbers.items() if name != "bandwidth"},  # type: ignore[arg-type]
    )
    _check_law(law, given)
    effort = asked.effort or EffortSettings()
    if bandwidth is not None:
        effort = replace(effort, bandwidth=bandwidth)
    covered = uncertainty_asked(inertia, equilibrium_wake)
    if inertia is not None:
        span = covered.inertia
        effort = replace(effort, inertia=(float(span.lower), float(span.upper)))
    return replace(asked, effort=effort, uncertainty=covered)


def uncertainty_asked(inertia: tuple[str, str] | None, equilibrium_wake: bool) -> Uncertainty:
    """Return what the certificate shall cover.

    Raises
    ------
    ModelError : an inertia that is no interval around 1.
    """
    from takagi.certificates.coherent import DEFAULT_UNCERTAINTY
    from takagi.models.embedding.coherent import Uncertainty

    span = DEFAULT_UNCERTAINTY.inertia if inertia is None else _inertia(inertia)
    return Uncertainty(span, frozen_wake=not equilibrium_wake)


def _check_law(law: str, given: Mapping[str, object]) -> None:
    """Refuse options that the law does not have: silently ignored, they would mislead."""
    from takagi.models.errors import ModelError

    foreign = _OF_PAPER if law == "coherent" else _OF_COHERENT
    for name in foreign:
        if given[name] is not None:
            owner = "the laws of the paper" if law == "coherent" else "the law coherent"
            raise ModelError(
                f"option {_option(name)} belongs to {owner}, but --law {law} was asked for; leave "
                "it out or choose the other law"
            )


def _positive(name: str, value: float) -> float:
    from takagi.models.errors import ModelError

    if not (math.isfinite(value) and value > 0):
        raise ModelError(f"option {_option(name)}: {value:g} was given; it must be positive")
    return float(value)


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def _setpoint(written: str, turbine: Turbine) -> float:
    """Return the rotor speed [rad/s] that a number with its unit stands for."""
    from takagi.models.errors import ModelError
    from takagi.models.turbine.trim import reference_speed
    from takagi.models.turbine.units import to_si

    found = re.fullmatch(r"\s*([-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*", written)
    if found is None or not found.group(2):
        raise ModelError(
            f"option --speed-setpoint: {written!r} was given; a number with its unit is needed, "
            "such as 11.5rpm or 1.2rad/s"
        )
    try:
        speed = to_si(float(found.group(1)), found.group(2), "rad/s")
        reference_speed(turbine, turbine.cut_in, speed_setpoint=speed)
    except ModelError as error:
        raise ModelError(f"option --speed-setpoint {written}: {error}") from error
    return speed


def _inertia(written: tuple[str, str]) -> Interval:
    """Return the interval; its ends are the decimals that were written."""
    from takagi.models.enclosure.interval import Interval
    from takagi.models.errors import ModelError

    try:
        span = Interval.of(*written)
    except ModelError as error:
        raise ModelError(f"option --inertia: {error}") from error
    if not 0 < span.lower <= 1 <= span.upper:
        raise ModelError(
            f"option --inertia: {written[0]} {written[1]} was given; 0 < LOW <= 1 <= HIGH is "
            "needed, relative to the model's inertia"
        )
    return span
