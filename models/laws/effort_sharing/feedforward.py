r"""The effort-sharing law's feed-forward of the rate of its schedule wind.

The schedule wind v_s is the output of the law's low-pass, so v_s' = (v_hat - v_s) / tau_f is a
known number at any time.  Two things follow from it:

    torque   a_f = f v_s', held within +-g    [rad/s^2]: the effort that accelerates the rotor while
    the reference speed omega*(v_s) moves; f is the slope of omega*
    pitch    tau_lead v_s' d/dv_s [psi(U) / b] [rad]: a drive with the time constant tau_lead then
    follows the schedule without a lag

f and g are constant between two nodes of the schedule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.schedule import EffortSchedule
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import Turbine

# The share of the trim's torque that is left to the gains (``EffortSettings.torque_share``): both
# together must not ask for negative torque.
DEFAULT_TORQUE_KEPT = 0.62
# The share of the difference between rated torque and the trim's torque that may be fed forward.
DEFAULT_RESERVE_SHARE = 0.5
DEFAULT_INERTIA_SHARE = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Feedforward:
    """Feed-forward of the schedule wind's rate over the intervals of an effort schedule.

    Attributes
    ----------
    inertia : (K - 1,) f [rad/s per m/s], constant on each interval between nodes.
    effort_limit : (K - 1,) g >= 0 [rad/s^2], the largest effort that is fed forward to torque.
    pitch_lead : tau_lead >= 0 [s]; 0 switches the lead off.
    """

    inertia: Floats
    effort_limit: Floats
    pitch_lead: float

    def __post_init__(self) -> None:
        for name in ("inertia", "effort_limit"):
            column = np.array(getattr(self, name), dtype=np.float64)
            if column.ndim != 1 or not np.all(np.isfinite(column)):
                raise ModelError(f"{name} must be a row of finite numbers, one per interval")
            column.flags.writeable = False
            object.__setattr__(self, name, column)
        if self.inertia.shape != self.effort_limit.shape:
            raise ModelError(
                f"{len(self.inertia)} feed-forwards need as many limits, one per interval; "
                f"{len(self.effort_limit)} were given"
            )
        if np.any(self.effort_limit < 0) or not 0 <= self.pitch_lead < np.inf:
            raise ModelError(
                f"effort_limit and pitch_lead ({self.pitch_lead!r} s) must not be negative"
            )

    @property
    def acts(self) -> bool:
        """Whether any feed-forward is not zero."""
        return bool(self.pitch_lead > 0 or np.any(self.inertia * self.effort_limit != 0))


def no_feedforward(schedule: EffortSchedule) -> Feedforward:
    """Return a feed-forward of zero, for a law that does not use its schedule wind's rate."""
    none = np.zeros(len(schedule.wind) - 1)
    return Feedforward(none, none, 0.0)


def known_rate_feedforward(
    turbine: Turbine, schedule: EffortSchedule, *, inertia_share: float = DEFAULT_INERTIA_SHARE
) -> Feedforward:
    """Return f, g and tau_lead, rounded to the decimals that are emitted.

    A share ``DEFAULT_TORQUE_KEPT`` of the trim's torque is left to the gains; g is what remains, at
    the worse of the interval's ends.  It is also at most a share ``DEFAULT_RESERVE_SHARE`` of rated
    torque minus the trim's torque: more would have no effect, because torque stays at or below
    rated.  tau_lead is the pitch time constant of the design model.

    Parameters
    ----------
    inertia_share : f over the slope of omega* [-].

    Raises
    ------
    ModelError : a share outside [0, 1].
    """
    if not 0 <= inertia_share <= 1:
        raise ModelError(
            f"inertia_share = {inertia_share!r} was given; a share from 0 to 1 is needed"
        )
    slope = np.diff(schedule.rotor_speed) / np.diff(schedule.wind)
    full = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    reserve = effort_ramp(-schedule.trim_effort, schedule.overlap)
    torque = full - reserve
    below = np.minimum(torque[:-1], torque[1:]) - DEFAULT_TORQUE_KEPT * np.maximum(
        torque[:-1], torque[1:]
    )
    above = DEFAULT_RESERVE_SHARE * np.minimum(reserve[:-1], reserve[1:])
    least = np.maximum(np.minimum(below, above), 0.0)
    inertia = np.round(inertia_share * slope, 7)
    # The limit is emitted with six decimals. It is rounded down, so that the reserve of torque is
    # not exceeded by the rounding.
    limit = np.where(inertia != 0, np.floor(least * 1e6) / 1e6, 0.0)
    return Feedforward(inertia, limit, turbine.pitch_time_constant)
