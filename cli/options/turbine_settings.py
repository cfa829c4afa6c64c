"""What the options of a turbine's design ask for, as settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from takagi.cli.options.given import defaults_of, option_of
from takagi.cli.options.turbine_options import TURBINE_OPTIONS, typed_name
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.settings import DesignSettings
    from takagi.models.intervals.interval import Interval
    from takagi.models.laws.effort_sharing.law import LoopUncertainty
    from takagi.models.turbine.data import Turbine

EFFORT_SHARING = "coherent"  # the default law of a turbine
_OVERLAPS = ("overlap", "speed_overlap", "torque_overlap")
_OF_GAINS = ("bandwidth", "bandwidth_growth")
# The options that only one kind of law has.
_OF_EFFORT_SHARING = (
    "overlap",
    *_OF_GAINS,
    "inertia",
    "power_coefficient",
    "equilibrium_wake",
    "pitch_effectiveness_share",
    "lowest_speed_setpoint",
    "lowest_torque_setpoint",
    "wind_filter",
    "two_step",
    "one_step",
    "objective",
)
_OF_PUBLISHED = ("speed_overlap", "torque_overlap", "ramp_shape", "ramp_placement")
# A slower filter suits no turbine, and the design would search for minutes before failing.
LONGEST_FILTER = 100.0  # s
# Lower limits in rad/s.  A slower filter would delay the speed at frequencies where the law acts.
SLOWEST_CORNER = 0.5
SLOWEST_STOP = 2.0


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
        value = given[name]
        if value is not None and not (math.isfinite(value) and value > 0):
            raise ModelError(f"option {option_of(name)}: {value:g} was given; it must be positive")
    speed = given["speed_setpoint"]
    setpoint = None if speed is None else _setpoint("speed_setpoint", speed, turbine)
    overlaps = {name: given[name] for name in _OVERLAPS if given[name] is not None}
    settings = replace(default_settings(turbine), law=law, speed_setpoint=setpoint, **overlaps)
    _check_law(law, given)
    fields = _law_fields(turbine, law, setpoint, given)
    fields |= _filter_fields(turbine, given["speed_filter"], given["torsion_filter"])
    fields |= _synthesis_fields(given["two_step"], given["one_step"], given["objective"])
    settings = replace(settings, **fields)
    effort = settings.effort or EffortSettings()
    effort = replace(effort, **{name: given[name] for name in _OF_GAINS if given[name] is not None})
    covered = uncertainty_asked(given)
    if given["inertia"] is not None:
        span = covered.inertia
        effort = replace(effort, inertia=(float(span.lower), float(span.upper)))
    settings = replace(settings, effort=effort, uncertainty=covered)
    check_limits(turbine, settings)
    return settings


def _check_law(law: str, given: Mapping[str, object]) -> None:
    """Refuse options that the law does not have; ignoring them would mislead the user."""
    for name in _OF_PUBLISHED if law == EFFORT_SHARING else _OF_EFFORT_SHARING:
        if given[name] is not None and given[name] is not False:
            owner = "Schulte's law" if law == EFFORT_SHARING else "the effort-sharing law"
            raise ModelError(
                f"option {option_of(name)} belongs to {owner}, but --law {typed_name(law)} "
                "was asked for; leave it out or choose the other law"
            )


def _law_fields(
    turbine: Turbine, law: str, speed_setpoint: float | None, given: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what was asked of the law, as fields of ``DesignSettings``."""
    fields: dict[str, Any] = {}
    for name in ("torque_setpoint", "lowest_torque_setpoint"):
        if (torque := given[name]) is not None:
            fields[name] = _torque(name, torque, turbine, speed_setpoint)
    if (speed := given["lowest_speed_setpoint"]) is not None:
        fields["lowest_speed_setpoint"] = _setpoint("lowest_speed_setpoint", speed, turbine)
    if (share := given["pitch_effectiveness_share"]) is not None:
        needed = "above 0 and at most 10 is needed, such as 1"
        _require(0 < share <= 10, f"--pitch-effectiveness-share: {share:g} was given; {needed}")
        fields["effectiveness_share"] = share
    if (shape := given["ramp_shape"]) is not None:
        known = shape in ("smooth", "linear")
        _require(known, f"--ramp-shape: {shape!r} was given; smooth or linear is needed")
        fields["ramp_shape"] = shape
    if (place := given["ramp_placement"]) is not None:
        needed = "0 (below the set-point) to 1 (above it) is needed"
        _require(0 <= place <= 1, f"--ramp-placement: {place:g} was given; {needed}")
        fields["ramp_placement"] = place
    if (time := given["wind_filter"]) is not None:
        _require(
            0 < time <= LONGEST_FILTER,
            f"--wind-filter: {time:g} was given; it must be positive, because an estimate that "
            f"jumps would make the commands jump, and at most {LONGEST_FILTER:g} s, because a "
            "slower filter does not follow the wind",
        )
        fields["wind_filter"] = time
    return fields


def _require(holds: bool, words: str) -> None:
    if not holds:
        raise ModelError(f"option {words}")


def typed_size(
    option: str,
    written: str,
    unit: str,
    example: str,
    *,
    whole: float | None = None,
    check: Callable[[float], object] = float,
) -> float:
    """Return the size in an SI unit of a text such as 11.5rpm, or of a share of ``whole``, 80%.

    Parameters
    ----------
    option : what stands before the text;  example : for a number without unit.
    check : called with the size; raises ModelError for one that the turbine does not have.

    Raises
    ------
    ModelError : names the option.
    """
    from takagi.models.files.units import to_si, typed_figure

    try:
        value, typed_unit = typed_figure(written)
        if not typed_unit:
            raise ModelError(f"a number with its unit is needed, such as {example}")
        in_share = typed_unit == "%" and whole is not None
        size = round(value / 100 * (whole or 0), 6) if in_share else to_si(value, typed_unit, unit)
        check(size)
    except ModelError as error:
        raise ModelError(f"option {option}{written}: {error}") from error
    return size


def _setpoint(name: str, written: str, turbine: Turbine) -> float:
    """Return the rotor speed [rad/s] of a text such as 11.5rpm."""
    from takagi.models.turbine.trim import reference_speed

    return typed_size(
        f"{option_of(name)} ", written, "rad/s", "11.5rpm or 1.2rad/s",
        check=lambda speed: reference_speed(turbine, turbine.cut_in, speed_setpoint=speed),
    )  # fmt: skip


def _torque(name: str, written: str, turbine: Turbine, speed_setpoint: float | None) -> float:
    """Return the torque [N m] of a text such as 34.5kNm, or of a share of rated torque, 80%."""
    from takagi.models.turbine.trim import derated

    return typed_size(
        f"{option_of(name)} ", written, "N m", "34.5kNm or 80%", whole=turbine.rated_torque,
        check=lambda torque: derated(turbine, torque, speed_setpoint=speed_setpoint),
    )  # fmt: skip


def _filter_fields(
    turbine: Turbine, corner: float | None, frequency: float | None
) -> dict[str, Any]:
    """Return what was asked of low-pass and band-stop, as fields of ``DesignSettings``."""
    fields: dict[str, Any] = {}
    if corner is not None:
        _require(
            corner == 0 or SLOWEST_CORNER <= corner < math.inf,
            f"--speed-filter: {corner:g} was given; at least {SLOWEST_CORNER:g} rad/s is needed, "
            "or 0 for none: a slower low-pass hides the speed from the law",
        )
        fields["speed_filter"] = corner
    from takagi.certificates.design.turbine.scale import speed_filters

    if frequency is None:
        # The band-stop is only built in series with a low-pass.
        return fields | ({"torsion_filter": 0.0} if corner == 0 else {})
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
    fields["torsion_filter"] = frequency
    if corner is None:
        fields["speed_filter"] = speed_filters(turbine, stopped=frequency > 0)[0]
    return fields


def _synthesis_fields(two_step: bool, one_step: bool, objective: str | None) -> dict[str, Any]:
    """Return how gains are to be found, as fields of ``DesignSettings``."""
    from takagi.lmi.turbine.one_step.design_point import objective_named

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


def uncertainty_asked(given: Mapping[str, Any]) -> LoopUncertainty:
    """Return the uncertainty that the certificate must cover.

    Raises
    ------
    ModelError : an inertia or a power coefficient that is not an interval around 1.
    """
    from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_UNCERTAINTY
    from takagi.models.laws.effort_sharing.law import LoopUncertainty

    spans = {
        name: getattr(DEFAULT_UNCERTAINTY, name)
        if given[name] is None
        else _around_one(name.replace("_", "-"), given[name])
        for name in ("inertia", "power_coefficient")
    }
    return LoopUncertainty(**spans, frozen_wake=not given["equilibrium_wake"])


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
