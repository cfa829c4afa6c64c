"""Options of the filters on the measured rotor speed, which the gain file of a law contains."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.turbine.data import Turbine

SpeedFilter = Annotated[
    float | None,
    typer.Option(
        metavar="RAD/S",
        help="Turbines: corner of the low-pass on the measured rotor speed [rad/s], which the gain "
        "file contains, 0 for none; 30 unless given, 8 without a torsion filter. Only the claim "
        "running-loop covers it. Effort-sharing law.",
    ),
]
TorsionFilter = Annotated[
    float | None,
    typer.Option(
        metavar="RAD/S",
        help="Turbines: frequency of the band-stop on the measured rotor speed [rad/s], which the "
        "gain file contains, 0 for none; 0.9 of the drivetrain's torsion mode unless given, if "
        "the turbine's file states one. It removes that mode from the loop. Only the claim "
        "running-loop covers it. Effort-sharing law.",
    ),
]

OF_FILTERS = ("speed_filter", "torsion_filter")
# Lower limits in rad/s.  A slower filter would delay the speed at frequencies where the law acts.
SLOWEST_CORNER = 0.5
SLOWEST_STOP = 2.0


def filter_settings(
    turbine: Turbine,
    *,
    speed_filter: float | None = None,
    torsion_filter: float | None = None,
) -> dict[str, Any]:
    """Return the fields of ``DesignSettings`` that were asked for.

    Raises
    ------
    ModelError : a filter that makes no sense; names the option.
    """
    found: dict[str, Any] = {}
    if (corner := speed_filter) is not None:
        _require(
            corner == 0 or SLOWEST_CORNER <= corner < math.inf,
            f"--speed-filter: {corner:g} was given; at least {SLOWEST_CORNER:g} rad/s is needed, "
            "or 0 for none: a slower low-pass hides the speed from the law",
        )
        found["speed_filter"] = corner
    return found | _torsion_filter(turbine, torsion_filter, speed_filter)


def _torsion_filter(
    turbine: Turbine, frequency: float | None, corner: float | None
) -> dict[str, Any]:
    """Return the band-stop that was asked for, and the low-pass that goes with it."""
    from takagi.certificates.design.turbine.scale import speed_filters

    if frequency is None:
        # The band-stop is only built in series with a low-pass.
        return {"torsion_filter": 0.0} if corner == 0 else {}
    _require(
        frequency == 0 or SLOWEST_STOP <= frequency < math.inf,
        f"--torsion-filter: {frequency:g} was given; at least {SLOWEST_STOP:g} rad/s is needed, or "
        "0 for none: a band-stop turns the phase below its frequency",
    )
    _require(
        frequency == 0 or corner != 0,
        f"--torsion-filter: {frequency:g} was given with --speed-filter 0; the band-stop needs a "
        "low-pass behind it: leave --speed-filter out, or give it a corner",
    )
    found: dict[str, Any] = {"torsion_filter": frequency}
    if corner is None:
        found["speed_filter"] = speed_filters(turbine, stopped=frequency > 0)[0]
    return found


def _require(holds: bool, words: str) -> None:
    if not holds:
        raise ModelError(f"option {words}")
