r"""Default settings of a design, scaled from the NREL 5-MW turbine to a turbine's own size.

One number does not suit all rotors: a speed band of 0.04 rad/s is 3 % of one rotor's rated speed
and 5 % of another's.  The settings are multiplied by the ratio of these measures to those of the
5-MW turbine:

    measure   formula                          settings
    speed     omega_rated  [rad/s]             speed bands and filters, overlap of the coupling
                                               filter in speed
    torque    T_rated  [N m]                   overlap of the coupling filter in torque
    effort    n_g T_rated / J  [rad/s^2]       overlap of the effort ramp
    pitch     b times rate limit  [rad/s^3]    effort lag, the part of the effort that the drive
                                               has not delivered yet
    drive     rate limit times tau  [rad]      pitch errors of a region's gains, at most those at
                                               which its model is exact

b is the frozen-wake effectiveness at the first wind of its column, tau the pitch drive's time
constant.  The speed band must also stay inside the coefficient table at cut-in, where the trim is
at ``TABLE_SHARE`` of the largest tip-speed ratio.

Bandwidths lie between two rates.  The lower one is n_g T_rated / (J omega_rated), at which rated
torque stops the rotor: 0.075 1/s for 5 MW, 0.080 1/s for 15 MW.  The upper one is the pitch drive's
1 / tau: 5 and 2.2 1/s.  The lower one hardly changes, so that the bandwidths are multiplied by the
square root of the ratio of 1 / tau, but never increased.  Wake, blades and tower respond more
slowly on a larger rotor: the bandwidth of pitch is divided by the ratio of the radii, and the wind
filter's time multiplied by it.  They limit it near rated wind alone, where pitch turns thrust more
than torque; from 1.25 times that wind on the bandwidth has grown by the same ratio.  The pitch
effectiveness that the law divides by is lowered by the cube root of the ratio, which gives the loop
of the 15-MW turbine the margins that the 5-MW turbine has in the loop that runs (docs/margins.md).
With 0.4 1/s at all winds and 8 s it is unstable.

The figures are rounded to two digits (one of them to three).  They are starting values without
guarantee: each design made with them must still be proved.
"""

from __future__ import annotations

from dataclasses import replace
from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal
from fractions import Fraction
from math import cbrt, pi, sqrt
from typing import TYPE_CHECKING

from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_BOX
from takagi.certificates.design.turbine.settings import (
    DEFAULT_SPEED_FILTER,
    SPEED_FILTER_ALONE,
    TORSION_SHARE,
    DesignSettings,
)
from takagi.models.laws.effort_sharing.law import LoopBox
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TABLE_SHARE

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortSettings
    from takagi.lmi.turbine.region_request import Requirement

# Measures of the NREL 5-MW turbine, from the figures in models/data/nrel5mw.toml: SPEED in rad/s,
# EFFORT in rad/s^2, TORQUE in N m, RADIUS in m, LAG (pitch time constant) in s, DRIVE in rad,
# PITCH in rad/s^3.
SPEED = 12.1 * pi / 30
EFFORT = 97 * 43093.55 / (38759228.0 + 97**2 * 534.116)
TORQUE, RADIUS = 43093.55, 63.0
LAG = 0.2
DRIVE = 8 * pi / 180 * LAG
# Pitch errors of a region's gains [rad]; its model is exact up to 0.034907, two degrees. A drive
# with a time constant above 2.8 s comes to this limit.
LARGEST_PITCH_ERROR = 0.034
# The widest ramp of Schulte's law, as a share of the speeds between the smallest and the rated one.
RAMP_SHARE = 0.95
PITCH = 8 * pi / 180 * 28.24e6 / (SPEED * (38759228.0 + 97**2 * 534.116))


def default_settings(turbine: Turbine) -> DesignSettings:
    """Return the settings scaled to the turbine; for the NREL 5-MW turbine ``DesignSettings()``."""
    settings = DesignSettings()
    speed = turbine.rated_rotor_speed / SPEED
    # The deceleration of the rotor by rated torque [rad/s^2].
    effort = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    corner, stop = speed_filters(turbine, stopped=turbine.torsion is not None)
    box = scaled_box(turbine)
    # The ramp of Schulte's law ends at the set-point and must begin above the smallest speed.
    widest = RAMP_SHARE * (turbine.rated_rotor_speed - turbine.minimum_rotor_speed)
    return replace(
        settings,
        overlap=_rounded(settings.overlap * effort / EFFORT),
        speed_overlap=_rounded(min(settings.speed_overlap * speed, widest)),
        torque_overlap=_rounded(settings.torque_overlap * turbine.rated_torque / TORQUE),
        wind_filter=_rounded(settings.wind_filter / _pace(turbine)),
        effectiveness_share=_rounded(settings.effectiveness_share * cbrt(_pace(turbine))),
        speed_filter=corner,
        torsion_filter=stop,
        effort=_effort_settings(turbine, float(box.speed_signal)),
        box=box,
    )


def speed_filters(turbine: Turbine, *, stopped: bool) -> tuple[float, float]:
    """Return the low-pass's corner and the band-stop's frequency [rad/s].

    ``stopped`` says whether there is a band-stop. Without a torsion mode its frequency is 0.
    """
    alone = DEFAULT_SPEED_FILTER if stopped else SPEED_FILTER_ALONE
    mode = turbine.torsion if stopped else None
    stop = _rounded(TORSION_SHARE * mode.frequency) if mode else 0.0
    return _rounded(alone * turbine.rated_rotor_speed / SPEED), stop


def _effort_settings(turbine: Turbine, speed_error: float) -> EffortSettings:
    from takagi.lmi.turbine.effort import EffortSettings

    settings = EffortSettings()
    slower = min(1.0, sqrt(LAG / turbine.pitch_time_constant))
    return replace(
        settings,
        bandwidth=_rounded(settings.bandwidth * slower * _pace(turbine)),
        bandwidth_growth=_rounded(1 / _pace(turbine)),
        partial_bandwidth=_rounded(settings.partial_bandwidth * slower),
        speed_error=speed_error,
    )


def region_requirements(turbine: Turbine) -> tuple[Requirement, Requirement]:
    """Return the requirements on the gains of partial load and of full load."""
    from takagi.lmi.turbine.region_request import FULL_LOAD, PARTIAL_LOAD

    speed = float(scaled_box(turbine).speed_error / DEFAULT_BOX.speed_error)
    pitch = turbine.pitch_rate_limit * turbine.pitch_time_constant / DRIVE
    return (
        replace(PARTIAL_LOAD, speed_error=_rounded(PARTIAL_LOAD.speed_error * speed)),
        replace(
            FULL_LOAD,
            speed_error=float(f"{FULL_LOAD.speed_error * speed:.3g}"),
            pitch_error=min(_rounded(FULL_LOAD.pitch_error * pitch), LARGEST_PITCH_ERROR),
        ),
    )


def scaled_box(turbine: Turbine) -> LoopBox:
    """Return the box around the trim on which the effort-sharing loop is proved.

    Its sides are rounded down, since a smaller box stays inside the coefficient table.
    """
    from takagi.models.laws.effort_sharing.schedule import frozen_wake_effectiveness

    box = DEFAULT_BOX
    first = turbine.frozen_wake.wind[0]
    pitch = turbine.pitch_rate_limit * frozen_wake_effectiveness(turbine, first) / PITCH
    scaled_error = float(box.speed_error) * turbine.rated_rotor_speed / SPEED
    # At cut-in the tip-speed ratio may rise from TABLE_SHARE of the table to its end; the wind
    # error takes its share of that room, the speed error gets the rest.
    room = 1 - float(box.wind_share) - TABLE_SHARE
    largest = room * turbine.torque.x_range[1] * turbine.cut_in / turbine.rotor_radius
    error = Fraction(_text(min(scaled_error, largest), ROUND_DOWN))
    signal = float(error * box.speed_signal / box.speed_error)
    return replace(
        box,
        speed_error=error,
        speed_signal=Fraction(_text(signal, ROUND_DOWN)),
        effort_lag=Fraction(_text(float(box.effort_lag) * pitch, ROUND_DOWN)),
    )


def _pace(turbine: Turbine) -> float:
    """Return how fast wake and structure respond relative to 5 MW [-]; at most 1."""
    return min(1.0, RADIUS / turbine.rotor_radius)


def _rounded(value: float) -> float:
    return float(_text(value, ROUND_HALF_EVEN))


def _text(value: float, rounding: str) -> str:
    """Return the value in two digits.

    It is first written in twelve digits: the error of a float must not move 0.04 down to 0.039.
    """
    short = Decimal(f"{value:.12g}")
    return str(short.quantize(Decimal((0, (1,), short.adjusted() - 1)), rounding=rounding))
