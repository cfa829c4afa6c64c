r"""The published multi-region law, read literally, and its nearest working reading.

With e = omega - omega_ref(v_hat), the blended gains of the two regions, and x_b, x_c integrals:

    u_1 = -k^b_w e            + k^b_I x_b        torque
    u_2 = -k^c_w e - k^c_p b  + k^c_I x_c        pitch (absolute: b, not its deviation)
    (T, beta_ref) = F(omega, u_1) (u_1, u_2),    held to 0..T_rated and the pitch range

``paper``                   one integrator: x_b = x_c = x_I, x_I' = -e.
``paper-two-integrators``   one per region, each tracking the command that its channel delivers:
                            x_b' = -e + (T - u_1)/(tau k^b_I),
                            x_c' = -e + (beta_ref - u_2)/(tau k^c_I).

The aggregated equation of the paper has k_I inside the bracket with a minus, the two regional laws
with a plus; the regional sign is taken.  The triple sum over rules is the same law (a test).

Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, section "Fuzzy-Blending of
Control Regions"; readings in docs/laws.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.laws.published.equilibrium import equilibrium
from takagi.models.laws.published.regional_schedule import (
    CouplingFilter,
    RegionalGainValues,
    RegionalSchedule,
    premise_band,
    premise_evaluators,
)
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import OperatingBand
from takagi.models.turbine.trim import TABLE_SHARE, optimal_tip_speed_ratio

PublishedLawName: TypeAlias = Literal["paper", "paper-two-integrators"]


class BlendedCommands(NamedTuple):
    """Intermediate values of the law: regional commands, gains, and F times the commands."""

    torque: float
    pitch: float
    partial: RegionalGainValues
    full: RegionalGainValues
    blended_torque: float
    blended_pitch: float
    error: float


@dataclass(frozen=True, slots=True, eq=False)
class PublishedLaw:
    """The law as a value; see the module for the formulas and ``published_law`` for making one.

    Attributes
    ----------
    name : "paper" or "paper-two-integrators".
    turbine : figures, limits and torque surface.
    coupling : the filter F.
    partial, full : the regional gains and their schedules.
    tracking_time : tau [s] of the anti-windup; None with the shared integrator.
    speed_setpoint : rotor speed of full load [rad/s].
    """

    name: PublishedLawName
    turbine: Turbine
    coupling: CouplingFilter
    partial: RegionalSchedule
    full: RegionalSchedule
    tracking_time: float | None
    speed_setpoint: float

    def __post_init__(self) -> None:
        if self.name not in get_args(PublishedLawName):
            raise ModelError(
                f"law {self.name!r} was given; it is one of {', '.join(get_args(PublishedLawName))}"
                f"{did_you_mean(self.name, get_args(PublishedLawName))}"
            )
        if (self.tracking_time is None) != (self.name == "paper"):
            raise ModelError(
                f"law {self.name!r} with tracking time {self.tracking_time!r}: the shared "
                "integrator has none (None), the two integrators need one in seconds"
            )
        if self.tracking_time is not None and not self.tracking_time > 0:
            raise ModelError(f"tracking time {self.tracking_time!r} s was given; it must exceed 0")
        for region in (self.partial, self.full):
            if np.any(region.k_I >= 0):
                raise ModelError(
                    f"{region.model.name}: integral gains k_I must be negative (a speed below its "
                    f"reference lowers torque and pitch); rule {int(np.argmax(region.k_I)) + 1} "
                    f"has {float(region.k_I.max()):.6g}: give k_I = -K_I of u = -K x"
                )

    @property
    def state_names(self) -> tuple[str, ...]:
        """One integral, or one for torque and one for pitch."""
        if self.name == "paper":
            return ("integral of speed deficit [rad]",)
        return ("integral of speed deficit, torque [rad]", "integral of speed deficit, pitch [rad]")

    def reference_speed(self, wind: float) -> float:
        """Return omega_ref(v_hat) [rad/s]; an estimate outside cut-in to cut-out is held there."""
        v = min(max(wind, self.turbine.cut_in), self.turbine.cut_out)
        per_ratio = v / self.turbine.rotor_radius
        ceiling = TABLE_SHARE * self.turbine.torque.x_range[1] * per_ratio
        minimum = min(self.turbine.minimum_rotor_speed, ceiling)
        optimal = optimal_tip_speed_ratio(self.turbine) * per_ratio
        return min(max(optimal, minimum), self.speed_setpoint)

    def initial_state(self, wind: float) -> Floats:
        """Return the integrals at the law's own equilibrium, or nearest to the trim without one.

        See ``equilibrium``: that equilibrium need not be the turbine's trim.
        """
        return np.array(equilibrium(self, wind).integrals)

    def blended(
        self, state: ArrayLike, measurement: Measurement, *, reference: float | None = None
    ) -> BlendedCommands:
        """Return the regional and the blended commands before the limits.

        ``reference`` [rad/s] stands in for omega_ref(v_hat); None takes that.
        """
        speed, pitch, wind = measurement
        x = np.asarray(state, dtype=np.float64)
        x_b, x_c = float(x[0]), float(x[-1])
        error = speed - (self.reference_speed(wind) if reference is None else reference)
        b, c = self.partial.gains_at(speed, pitch, wind), self.full.gains_at(speed, pitch, wind)
        torque = -b.speed * error - b.pitch * pitch + b.integral * x_b
        angle = -c.speed * error - c.pitch * pitch + c.integral * x_c
        f_2, f_1 = self.coupling.factors_at(speed, torque)
        return BlendedCommands(torque, angle, b, c, f_2 * torque, f_1 * angle, error)

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        """Return torque [N m, high-speed shaft] and pitch reference [rad], within the limits."""
        return self.limited(self.blended(state, measurement))

    def limited(self, blended: BlendedCommands) -> Command:
        """Return the blended command held to 0..T_rated and to the pitch range."""
        low, high = self.turbine.pitch_min, self.turbine.pitch_max
        torque = min(max(blended.blended_torque, 0.0), self.turbine.rated_torque)
        return Command(torque, min(max(blended.blended_pitch, low), high))

    def state_rate(
        self, state: ArrayLike, measurement: Measurement, *, reference: float | None = None
    ) -> Floats:
        """Return the derivative of the integrals [rad/s]; ``reference`` as in ``blended``."""
        if reference is None:
            reference = self.reference_speed(measurement.wind_estimate)
        if self.tracking_time is None:
            return np.array([reference - measurement.rotor_speed])
        blended = self.blended(state, measurement, reference=reference)
        return self.tracking_rate(blended, self.limited(blended))

    def tracking_rate(self, blended: BlendedCommands, command: Command) -> Floats:
        """Return (x_b', x_c') of the two integrators when ``command`` is what is carried out."""
        tau = self.tracking_time
        if tau is None:
            raise ModelError(f"law {self.name!r} has one integrator and tracks nothing")
        torque_gap, pitch_gap = command.torque - blended.torque, command.pitch - blended.pitch
        return np.array(
            [
                -blended.error + torque_gap / (tau * blended.partial.integral),
                -blended.error + pitch_gap / (tau * blended.full.integral),
            ]
        )


def published_law(
    turbine: Turbine,
    *,
    partial: RegionalSchedule,
    full: RegionalSchedule,
    coupling: CouplingFilter,
    name: PublishedLawName = "paper",
    tracking_time: float = 5.0,
    speed_setpoint: float | None = None,
) -> PublishedLaw:
    """Return the published law of a turbine.

    Parameters
    ----------
    partial, full : gains with their schedules (``regional_schedule``).
    coupling : the filter (``coupling_filter``).
    name : "paper", or "paper-two-integrators".
    tracking_time : tau of the anti-windup [s]; used by the two integrators alone.
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated one.

    Raises
    ------
    ModelError : an unknown name, a tracking time that is not positive, k_I of the wrong sign.
    """
    setpoint = turbine.rated_rotor_speed if speed_setpoint is None else speed_setpoint
    tracking = None if name == "paper" else tracking_time
    return PublishedLaw(name, turbine, coupling, partial, full, tracking, setpoint)


# Largest accepted difference between a premise by the table here and as the law computes it.
SAME = 1e-9


def schedule_band(law: PublishedLaw, schedule: RegionalSchedule) -> OperatingBand:
    """Return the trim table that a schedule's premises refer to.

    Raises
    ------
    ModelError : the schedule was made with another table.
    """
    rated = law.speed_setpoint == law.turbine.rated_rotor_speed
    band = premise_band(law.turbine, schedule.model, None if rated else law.speed_setpoint)
    low, high = float(band.wind[0]), float(band.wind[-1])
    names = [p.name for p in schedule.model.premises]
    mine = premise_evaluators(band, with_pitch="b" in names)
    for first, last in pairwise(np.linspace(low, high, 9)):
        at = (law.reference_speed(first) + 0.01, 0.1, (first + last) / 2)
        for name, theirs in zip(names, schedule.evaluators, strict=True):
            if abs(mine[name](*at) - theirs(*at)) > SAME:
                raise ModelError(
                    f"{schedule.model.name}: premise {name} of the schedule refers to another "
                    "trim table; make the schedule by regional_schedule"
                )
    return band
