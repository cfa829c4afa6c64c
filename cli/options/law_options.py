"""Options of a turbine's law other than its gains: set-points, schedule, ramps."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.options.law_names import typed_name
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.turbine.data import Turbine

TorqueSetpoint = Annotated[
    str | None,
    typer.Option(
        metavar="TORQUE",
        help="Turbines: de-rated generator torque with its unit, 34.5kNm, or a share of the rated "
        "one, 80%; rated torque unless given.",
    ),
]
PitchEffectivenessShare = Annotated[
    float | None,
    typer.Option(
        metavar="SHARE",
        help="Turbines: pitch effectiveness that the law divides by, over the frozen wake's [-]; "
        "1 unless given. Less moves pitch more. Effort-sharing law.",
    ),
]
RampShape = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Turbines: ramp of the coupling filter in speed: smooth (C1) or linear; smooth unless "
        "given. Published laws.",
    ),
]
RampPlacement = Annotated[
    float | None,
    typer.Option(
        metavar="SHARE",
        help="Turbines: share of the speed overlap that lies above the set-point [-], 0 to 1; 0.5 "
        "unless given. Published laws.",
    ),
]
TrackingTime = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Turbines: time constant of the anti-windup [s]; 5 unless given. Law "
        "published-two-integrators.",
    ),
]
WindFilter = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        help="Turbines: low-pass on the wind estimate [s]; 12 unless given. A fast one, 0.05, is "
        "for a wind that is measured, by a lidar say: the wind rate that is proved is then larger, "
        "but with an estimate from rotor speed the loop oscillates. Effort-sharing law.",
    ),
]
# The options that only one kind of law has.
OF_EFFORT_SHARING = ("pitch_effectiveness_share", "wind_filter")
OF_PUBLISHED = ("ramp_shape", "ramp_placement", "tracking_time")
# A slower filter suits no turbine, and the design would search for minutes before failing.
LONGEST_FILTER = 100.0  # s


def law_settings(
    turbine: Turbine,
    *,
    law: str,
    speed_setpoint: float | None,
    torque_setpoint: str | None = None,
    pitch_effectiveness_share: float | None = None,
    ramp_shape: str | None = None,
    ramp_placement: float | None = None,
    tracking_time: float | None = None,
    wind_filter: float | None = None,
) -> dict[str, Any]:
    """Return the fields of ``DesignSettings`` that were asked for.

    Raises
    ------
    ModelError : a value that makes no sense; names the option.
    """
    found: dict[str, Any] = {}
    if torque_setpoint is not None:
        found["torque_setpoint"] = _torque(torque_setpoint, turbine, speed_setpoint)
    if (share := pitch_effectiveness_share) is not None:
        needed = "above 0 and at most 10 is needed, such as 1"
        _require(0 < share <= 10, f"--pitch-effectiveness-share: {share:g} was given; {needed}")
        found["effectiveness_share"] = share
    if ramp_shape is not None:
        known = ramp_shape in ("smooth", "linear")
        _require(known, f"--ramp-shape: {ramp_shape!r} was given; smooth or linear is needed")
        found["ramp_shape"] = ramp_shape
    if (place := ramp_placement) is not None:
        needed = "0 (below the set-point) to 1 (above it) is needed"
        _require(0 <= place <= 1, f"--ramp-placement: {place:g} was given; {needed}")
        found["ramp_placement"] = place
    if (time := tracking_time) is not None:
        _require(
            law == "paper-two-integrators",
            "--tracking-time belongs to the law published-two-integrators, but "
            f"--law {typed_name(law)} was asked for; leave it out or choose that law",
        )
        _require(0 < time < math.inf, f"--tracking-time: {time:g} was given; it must be positive")
        found["tracking_time"] = time
    if (time := wind_filter) is not None:
        _require(
            0 < time <= LONGEST_FILTER,
            f"--wind-filter: {time:g} was given; it must be positive, because the law feeds the "
            f"filtered wind's rate forward, and at most {LONGEST_FILTER:g} s, because a slower "
            "filter does not follow the wind",
        )
        found["wind_filter"] = time
    return found


def _require(holds: bool, words: str) -> None:
    if not holds:
        raise ModelError(f"option {words}")


def _torque(written: str, turbine: Turbine, speed_setpoint: float | None) -> float:
    """Return the torque [N m] of a text such as 34.5kNm, or of a share of rated torque, 80%."""
    from takagi.models.files.units import to_si, typed_figure
    from takagi.models.turbine.derating import derated

    try:
        value, unit = typed_figure(written)
        if not unit:
            raise ModelError("a number with its unit is needed, such as 34.5kNm or 80%")
        if unit == "%":
            torque = round(value / 100 * turbine.rated_torque, 6)
        else:
            torque = to_si(value, unit, "N m")
        derated(turbine, torque, speed_setpoint=speed_setpoint)
    except ModelError as error:
        raise ModelError(f"option --torque-setpoint {written}: {error}") from error
    return torque
