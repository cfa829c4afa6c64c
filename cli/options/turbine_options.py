"""Options of a turbine's speed filters, of the search for its gains, and of its uncertainty."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.models.intervals.interval import Interval
    from takagi.models.laws.effort_sharing.loop_cell import LoopUncertainty
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


# Options that only the effort-sharing law has.
OF_SYNTHESIS = ("two_step", "one_step", "objective")

TwoStep = Annotated[
    bool,
    typer.Option(
        "--two-step",
        help="Turbines: find the gains wind by wind and prove them afterwards. This is the default "
        "unless --one-step or --objective is given. Effort-sharing law.",
    ),
]
OneStep = Annotated[
    bool,
    typer.Option(
        "--one-step",
        help="Turbines: change gains and proof together, starting from the two-step gains. This "
        "takes about two minutes more and gives a larger wind class and faster decay; pitch then "
        "travels more. Effort-sharing law.",
    ),
]
ObjectiveName = Annotated[
    str | None,
    typer.Option(
        "--objective",
        metavar="NAME",
        help="Turbines: what the one-step search improves: balanced (wind class, and some decay), "
        "wind-class, decay, calm-pitch or calm-tower; --one-step alone means balanced. With the "
        "first three the wind class is no smaller than that of the two-step gains, on average and "
        "at the weakest wind; with the calm ones by up to 15 %. Effort-sharing law.",
    ),
]


def synthesis_settings(*, two_step: bool, one_step: bool, objective: str | None) -> dict[str, Any]:
    """Return the fields of ``DesignSettings`` that these options set.

    Raises
    ------
    ModelError : an objective that has no such name, or --two-step beside one step.
    """
    from takagi.lmi.turbine.one_step.objective import objective_named

    if two_step:
        if one_step:
            raise ModelError("options --two-step and --one-step: leave one of the two out")
        if objective is not None:
            raise ModelError(
                f"options --two-step and --objective {objective}: an objective steers the search "
                "in one step; leave one of the two out"
            )
        return {"synthesis": "two-step"}
    if objective is None:
        return {"synthesis": "one-step"} if one_step else {}
    try:
        return {"synthesis": "one-step", "objective": objective_named(objective)}
    except ModelError as error:
        raise ModelError(f"option --objective: {error}") from error


# Options that only the effort-sharing law has.
OF_UNCERTAINTY = ("inertia", "power_coefficient", "equilibrium_wake")

Inertia = Annotated[
    tuple[str, str] | None,
    typer.Option(
        metavar="LOW HIGH",
        help="Turbines: true over nominal inertia that gains and certificate must cover; 0.9 1.1 "
        "unless given. Effort-sharing law.",
    ),
]
PowerCoefficient = Annotated[
    tuple[str, str] | None,
    typer.Option(
        metavar="LOW HIGH",
        help="Turbines: true over tabulated power coefficient that the certificate must cover, "
        "such as 0.99 1.01; the table's own unless given. Effort-sharing law.",
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


def uncertainty_asked(
    inertia: tuple[str, str] | None,
    power_coefficient: tuple[str, str] | None,
    equilibrium_wake: bool,
) -> LoopUncertainty:
    """Return the uncertainty that the certificate must cover.

    Raises
    ------
    ModelError : an inertia or a power coefficient that is not an interval around 1.
    """
    from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_UNCERTAINTY
    from takagi.models.laws.effort_sharing.loop_cell import LoopUncertainty

    default = DEFAULT_UNCERTAINTY
    span, power = default.inertia, default.power_coefficient
    if inertia is not None:
        span = _around_one("inertia", inertia)
    if power_coefficient is not None:
        power = _around_one("power-coefficient", power_coefficient)
    return LoopUncertainty(span, frozen_wake=not equilibrium_wake, power_coefficient=power)


def _around_one(option: str, written: tuple[str, str]) -> Interval:
    """Return the interval; its ends are exactly the typed decimals, without a float."""
    from takagi.models.intervals.interval import Interval

    try:
        span = Interval.of(*written)
    except ModelError as error:
        raise ModelError(f"option --{option}: {error}") from error
    if not 0 < span.lower <= 1 <= span.upper:
        raise ModelError(
            f"option --{option}: {written[0]} {written[1]} was given; 0 < LOW <= 1 <= HIGH is "
            "needed, relative to the model's own"
        )
    return span
