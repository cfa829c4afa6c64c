"""The options of a turbine's design on the command line, and their translation into settings.

The options are declared once, as annotated types, and used by all verbs that make designs.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.options.filter_options import (
    OF_FILTERS,
    SpeedFilter,
    TorsionFilter,
    filter_settings,
)
from takagi.cli.options.given import Groups, defaults_of, option_of
from takagi.cli.options.law_names import law_in_files, typed_name
from takagi.cli.options.law_options import (
    OF_EFFORT_SHARING,
    OF_PUBLISHED,
    PitchEffectivenessShare,
    RampPlacement,
    RampShape,
    TorqueSetpoint,
    TrackingTime,
    WindFilter,
    law_settings,
)
from takagi.cli.options.synthesis_options import (
    OF_SYNTHESIS,
    ObjectiveName,
    OneStep,
    TwoStep,
    synthesis_settings,
)
from takagi.cli.options.uncertainty_options import (
    OF_UNCERTAINTY,
    EquilibriumWake,
    Inertia,
    PowerCoefficient,
    uncertainty_asked,
)
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.settings import DesignSettings
    from takagi.models.turbine.data import Turbine

EFFORT_SHARING = "coherent"  # the default law of a turbine
Model = Annotated[
    str,
    typer.Argument(
        metavar="MODEL",
        help="A built-in name (see `takagi models`) or the path of a TOML file.",
        show_default=False,
    ),
]
Law = Annotated[
    str | None,
    typer.Option(
        "--law",
        help="Turbines: effort-sharing (one law for all winds, which hands its effort from torque "
        "to pitch), or the published law of regions with filters between them: published (one "
        "integrator) or published-two-integrators (one a region); effort-sharing unless given. "
        "Their names in files, coherent, paper and paper-two-integrators, may be given too.",
        callback=law_in_files,
        metavar="NAME",
    ),
]
Overlap = Annotated[
    float | None,
    typer.Option(
        help="Turbines: half the width of effort over which torque and pitch both act [rad/s^2]; "
        "0.01 unless given. Effort-sharing law."
    ),
]
SpeedOverlap = Annotated[
    float | None,
    typer.Option(
        help="Turbines: overlap of the coupling filter in rotor speed [rad/s]; 0.1 unless given. "
        "Published laws."
    ),
]
TorqueOverlap = Annotated[
    float | None,
    typer.Option(
        help="Turbines: overlap of the coupling filter in torque [N m]; 2000 unless given. "
        "Published laws."
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
        help="Turbines: wanted proportional gain [1/s]; 0.6 unless given. Effort-sharing law."
    ),
]
BandwidthGrowth = Annotated[
    float | None,
    typer.Option(
        metavar="FACTOR",
        help="Turbines: factor on --bandwidth from 1.25 times the wind where pitch begins to act "
        "[-]; 1 unless given, more for a rotor larger than the NREL 5-MW turbine's. "
        "Effort-sharing law.",
    ),
]
AskedMargins = Annotated[
    str | None,
    typer.Option(
        "--margins",
        metavar="TEXT",
        help="Turbines: margins that the loop that runs must have, as `takagi check --margins` "
        'takes them: "gain 1.5, phase 20deg, delay 15ms". Settings that were not given are '
        "changed, as little as possible, until the margins are met. Effort-sharing law.",
    ),
]


def turbine_law(
    *,
    law: Law = None,
    overlap: Overlap = None,
    speed_overlap: SpeedOverlap = None,
    torque_overlap: TorqueOverlap = None,
    speed_setpoint: SpeedSetpoint = None,
    torque_setpoint: TorqueSetpoint = None,
    pitch_effectiveness_share: PitchEffectivenessShare = None,
) -> None:
    """Declare the law, its overlaps and set-points: only the signature is read."""


def turbine_filters(
    *,
    ramp_shape: RampShape = None,
    ramp_placement: RampPlacement = None,
    tracking_time: TrackingTime = None,
    wind_filter: WindFilter = None,
    speed_filter: SpeedFilter = None,
    torsion_filter: TorsionFilter = None,
) -> None:
    """Declare the law's ramp and filters: only the signature is read."""


def turbine_gains(
    *,
    bandwidth: Bandwidth = None,
    bandwidth_growth: BandwidthGrowth = None,
    margins: AskedMargins = None,
) -> None:
    """Declare what the gains aim at: only the signature is read."""


def turbine_claims(
    *,
    inertia: Inertia = None,
    power_coefficient: PowerCoefficient = None,
    equilibrium_wake: EquilibriumWake = False,
) -> None:
    """Declare the plants and winds that claims are about: only the signature is read."""


def turbine_synthesis(
    *,
    two_step: TwoStep = False,
    one_step: OneStep = False,
    objective: ObjectiveName = None,
) -> None:
    """Declare how gains are found: only the signature is read."""


# In the order in which the help lists them.
TURBINE_OPTIONS: Groups = (
    turbine_law,
    turbine_filters,
    turbine_gains,
    turbine_claims,
    turbine_synthesis,
)

_OF_GAINS = ("bandwidth", "bandwidth_growth")
_OF_EFFORT_SHARING = (
    "overlap",
    *_OF_GAINS,
    "margins",
    *OF_UNCERTAINTY,
    *OF_EFFORT_SHARING,
    *OF_FILTERS,
    *OF_SYNTHESIS,
)
_OF_PUBLISHED = ("speed_overlap", "torque_overlap", *OF_PUBLISHED)
_OVERLAPS = ("overlap", "speed_overlap", "torque_overlap")


def design_settings(turbine: Turbine, **options: Any) -> DesignSettings:
    """Return the settings; an option that is not given keeps the turbine's default.

    Parameters
    ----------
    options : values of the options that ``TURBINE_OPTIONS`` declare.

    Raises
    ------
    ModelError : an option that makes no sense for the law or the turbine; names the option.
    """
    from takagi.certificates.design.turbine.scale import default_settings
    from takagi.certificates.design.turbine.settings import check_limits
    from takagi.lmi.turbine.effort import EffortSettings

    given = {**defaults_of(TURBINE_OPTIONS), **options}
    law = EFFORT_SHARING if given["law"] is None else given["law"]
    for name in (*_OVERLAPS, *_OF_GAINS):
        _check_positive(name, given[name])
    speed = given["speed_setpoint"]
    setpoint = None if speed is None else _setpoint(speed, turbine)
    overlaps = {name: given[name] for name in _OVERLAPS if given[name] is not None}
    asked = replace(default_settings(turbine), law=law, speed_setpoint=setpoint, **overlaps)
    _check_law(law, given)
    of_law = {name: given[name] for name in ("torque_setpoint", *OF_EFFORT_SHARING, *OF_PUBLISHED)}
    asked = replace(asked, **law_settings(turbine, law=law, speed_setpoint=setpoint, **of_law))
    asked = replace(asked, **filter_settings(turbine, **{name: given[name] for name in OF_FILTERS}))
    asked = replace(asked, **synthesis_settings(**{name: given[name] for name in OF_SYNTHESIS}))
    effort = asked.effort or EffortSettings()
    effort = replace(effort, **{name: given[name] for name in _OF_GAINS if given[name] is not None})
    covered = uncertainty_asked(**{name: given[name] for name in OF_UNCERTAINTY})
    if given["inertia"] is not None:
        span = covered.inertia
        effort = replace(effort, inertia=(float(span.lower), float(span.upper)))
    asked = replace(
        asked,
        effort=effort,
        uncertainty=covered,
    )
    check_limits(turbine, asked)
    return asked


def _check_law(law: str, given: Mapping[str, object]) -> None:
    """Refuse options that the law does not have; ignoring them would mislead the user."""
    for name in _OF_PUBLISHED if law == EFFORT_SHARING else _OF_EFFORT_SHARING:
        if given[name] is not None and given[name] is not False:
            owner = "the published laws" if law == EFFORT_SHARING else "the effort-sharing law"
            raise ModelError(
                f"option {option_of(name)} belongs to {owner}, but --law {typed_name(law)} "
                "was asked for; leave it out or choose the other law"
            )


def _check_positive(name: str, value: float | None) -> None:
    if value is not None and not (math.isfinite(value) and value > 0):
        raise ModelError(f"option {option_of(name)}: {value:g} was given; it must be positive")


def _setpoint(written: str, turbine: Turbine) -> float:
    """Return the rotor speed [rad/s] of a text such as 11.5rpm."""
    from takagi.models.files.turbine_units import to_si
    from takagi.models.turbine.trim import reference_speed

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
