r"""Settings of a design in a turbine's own scale, from those that serve the NREL 5-MW turbine.

A band of 0.04 rad/s is 3 % of one rotor's speed and 5 % of another's.  Three measures carry the
settings from one turbine to the next; on the 5-MW turbine each ratio is 1:

    speed            omega_rated                              speed bands, the filter's overlap
    effort           n_g T_rated / J      [rad/s^2]           overlap of the effort ramp
    pitch            b rate limit         [rad/s^3]           effort lag, by which the drive is late

    drive            rate limit times time constant  [rad]    pitch errors of a region's gains

with b the frozen-wake effectiveness at the first wind of its column.  The speed band is also kept
inside the coefficient table at cut-in, where the trim is ``TABLE_SHARE`` of the largest tip-speed
ratio.  Bandwidths lie between two rates: that at which rated torque stops the rotor,
n_g T_rated / (J omega_rated), which is 0.075 1/s for 5 MW and 0.080 1/s for 15 MW, and the pitch
drive's 1 / tau, which is 5 and 2.2 1/s.  They go with the square root of the latter, and no drive
raises them.  Wake, blades and tower of a larger rotor are slower as its radius is larger: the
bandwidth of pitch goes down with it and the wind filter's time up.  At 0.4 1/s and 5 s the 15-MW
loop swings at and above rated wind with a wake that needs its time.  Every figure is rounded to two
digits.

These are starting values without guarantee: each design made with them must still be proved.
"""

from __future__ import annotations

from dataclasses import replace
from decimal import ROUND_DOWN, ROUND_HALF_EVEN, Decimal
from fractions import Fraction
from math import pi, sqrt
from typing import TYPE_CHECKING

from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_BOX
from takagi.certificates.design.turbine.settings import (
    DEFAULT_SPEED_FILTER,
    SPEED_FILTER_ALONE,
    TORSION_SHARE,
    DesignSettings,
)
from takagi.models.loops.effort_sharing.loop_cell import LoopBox
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import TABLE_SHARE

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortSettings
    from takagi.lmi.turbine.region_request import Requirement

# The NREL 5-MW turbine, as models/data/nrel5mw.toml has it.
SPEED = 12.1 * pi / 30
EFFORT = 97 * 43093.55 / (38759228.0 + 97**2 * 534.116)
TORQUE, RADIUS = 43093.55, 63.0
LAG = 0.2
DRIVE = 8 * pi / 180 * LAG
PITCH = 8 * pi / 180 * 28.24e6 / (SPEED * (38759228.0 + 97**2 * 534.116))


def default_settings(turbine: Turbine) -> DesignSettings:
    """Return the settings of a design that suit the turbine's size; those of 5 MW for 5 MW."""
    asked = DesignSettings()
    speed = turbine.rated_rotor_speed / SPEED
    corner, stop = speed_filters(turbine, stopped=turbine.torsion is not None)
    box = scaled_box(turbine)
    return replace(
        asked,
        overlap=_rounded(asked.overlap * _effort(turbine) / EFFORT),
        speed_overlap=_rounded(asked.speed_overlap * speed),
        torque_overlap=_rounded(asked.torque_overlap * turbine.rated_torque / TORQUE),
        wind_filter=_rounded(asked.wind_filter / _pace(turbine)),
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

    asked = EffortSettings()
    slower = min(1.0, sqrt(LAG / turbine.pitch_time_constant))
    return replace(
        asked,
        bandwidth=_rounded(asked.bandwidth * slower * _pace(turbine)),
        partial_bandwidth=_rounded(asked.partial_bandwidth * slower),
        speed_error=speed_error,
    )


def region_requirements(turbine: Turbine) -> tuple[Requirement, Requirement]:
    """Return what is asked of the regions' gains, partial load and full load."""
    from takagi.lmi.turbine.region_request import FULL_LOAD, PARTIAL_LOAD

    speed = float(scaled_box(turbine).speed_error / DEFAULT_BOX.speed_error)
    pitch = turbine.pitch_rate_limit * turbine.pitch_time_constant / DRIVE
    return (
        replace(PARTIAL_LOAD, speed_error=_rounded(PARTIAL_LOAD.speed_error * speed)),
        replace(
            FULL_LOAD,
            speed_error=float(f"{FULL_LOAD.speed_error * speed:.3g}"),
            pitch_error=_rounded(FULL_LOAD.pitch_error * pitch),
        ),
    )


def scaled_box(turbine: Turbine) -> LoopBox:
    """Return the region around the trim that a certificate of the coherent loop encloses."""
    from takagi.models.laws.effort_sharing.schedule import frozen_wake_effectiveness

    box = DEFAULT_BOX
    first = turbine.frozen_wake.wind[0]
    pitch = turbine.pitch_rate_limit * frozen_wake_effectiveness(turbine, first) / PITCH
    wanted = float(box.speed_error) * turbine.rated_rotor_speed / SPEED
    room = 1 - float(box.wind_share) - TABLE_SHARE
    largest = room * turbine.torque.x_range[1] * turbine.cut_in / turbine.rotor_radius
    error = Fraction(_text(min(wanted, largest), ROUND_DOWN))
    signal = float(error * box.speed_signal / box.speed_error)
    return replace(
        box,
        speed_error=error,
        speed_signal=Fraction(_text(signal, ROUND_DOWN)),
        effort_lag=Fraction(_text(float(box.effort_lag) * pitch, ROUND_DOWN)),
    )


def _pace(turbine: Turbine) -> float:
    """Return how fast wake and structure answer, over those of 5 MW [-]; no small rotor counts."""
    return min(1.0, RADIUS / turbine.rotor_radius)


def _effort(turbine: Turbine) -> float:
    """Return n_g T_rated / J, the deceleration that rated torque makes [rad/s^2]."""
    return turbine.gear_ratio * turbine.rated_torque / turbine.inertia


def _rounded(value: float) -> float:
    return float(_text(value, ROUND_HALF_EVEN))


def _text(value: float, rounding: str) -> str:
    """Return the value in two digits; a hair of rounding error is taken off first."""
    short = Decimal(f"{value:.12g}")
    return str(short.quantize(Decimal((0, (1,), short.adjusted() - 1)), rounding=rounding))
