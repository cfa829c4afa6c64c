"""The settings of a turbine's design, and the checks of them before the long work begins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_BOX, DEFAULT_UNCERTAINTY
from takagi.lmi.turbine.one_step.design import OBJECTIVES, Objective
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import DEFAULT_WIND_FILTER, LoopBox, LoopUncertainty
from takagi.models.laws.effort_sharing.schedule import DEFAULT_EFFECTIVENESS_SHARE
from takagi.models.turbine.data import Turbine, rotor_torque, rotor_torque_gradient
from takagi.models.turbine.trim import TrimPoint, rated_wind, trim

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortSettings
    from takagi.models.ramps import Shape

# The band-stop's frequency relative to the drivetrain's torsion mode, which is at 10.3 rad/s for
# 5 MW. At the mode a band-stop below it adds phase lead, a band-stop above it adds phase lag
# (docs/laws.md); hence a little below.
TORSION_SHARE = 0.9
DEFAULT_TORSION_FILTER = 9.3
# Corners in rad/s. With the band-stop the low-pass only has to remove noise. Without the band-stop
# (a turbine without a torsion mode) a corner of 8 rad/s for 5 MW saves pitch travel.
DEFAULT_SPEED_FILTER = 30.0
SPEED_FILTER_ALONE = 8.0
Synthesis = Literal["one-step", "two-step"]
SYNTHESES: tuple[Synthesis, ...] = ("one-step", "two-step")
LAWS = ("coherent", "paper")


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignSettings:
    """The settings of a design; the defaults suit the NREL 5-MW turbine.

    ``takagi.certificates.design.turbine.scale.default_settings`` scales them to another turbine.

    Attributes
    ----------
    law : "coherent" or "paper".
    overlap : eps of the effort ramp [rad/s^2] (coherent).
    speed_overlap : eps_omega of the coupling filter [rad/s] (published laws).
    torque_overlap : eps_T of the coupling filter [N m] (published laws).
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.
    torque_setpoint : de-rated torque [N m, high-speed shaft]; None takes the rated torque.
    lowest_speed_setpoint, lowest_torque_setpoint : where one is given, the law takes set-points at
        run time, from these [rad/s], [N m, high-speed shaft] to the rated ones; the other is then
        the rated one (coherent).
    wind_filter : tau_f, of the effort-sharing law's low-pass on the wind estimate [s].
    effectiveness_share : b of the effort-sharing law divided by the frozen wake's pitch
        effectiveness [-].
    speed_filter : corner of the low-pass on the measured speed, which the gain file of the
        effort-sharing law contains [rad/s]; 0 for none.
    torsion_filter : frequency of the band-stop before that low-pass [rad/s]; 0 for none.
    ramp_shape, ramp_placement : shape and place of the coupling filter's ramp in speed, see
        ``coupling_filter`` (published laws).
    effort : requirements on the effort-sharing gains; None takes the defaults.
    synthesis : "two-step" finds the gains wind by wind, and the loop's quadratic functions
        afterwards; "one-step" changes the gains together with the functions, for a larger claim.
    objective : the quantity that the one-step synthesis improves.
    box, uncertainty : what the effort-sharing certificate covers.
    """

    law: str = "coherent"
    overlap: float = 0.01
    speed_overlap: float = 0.5
    torque_overlap: float = 4000.0
    speed_setpoint: float | None = None
    torque_setpoint: float | None = None
    lowest_speed_setpoint: float | None = None
    lowest_torque_setpoint: float | None = None
    wind_filter: float = DEFAULT_WIND_FILTER
    effectiveness_share: float = DEFAULT_EFFECTIVENESS_SHARE
    speed_filter: float = DEFAULT_SPEED_FILTER
    torsion_filter: float = DEFAULT_TORSION_FILTER
    ramp_shape: Shape = "smooth"
    ramp_placement: float = 0.0
    effort: EffortSettings | None = None
    synthesis: Synthesis = "two-step"
    objective: Objective = OBJECTIVES["balanced"]
    box: LoopBox = DEFAULT_BOX
    uncertainty: LoopUncertainty = DEFAULT_UNCERTAINTY

    def __post_init__(self) -> None:
        if self.law == "switched":
            raise ModelError(
                "law 'switched' was given; it can be simulated and not proved, because its command "
                "is not continuous: the pitch reference jumps where the rotor passes the speed "
                "set-point. Give the law that blends the same gains, 'schulte'"
            )
        if self.law not in LAWS:
            raise ModelError(f"law {self.law!r} was given; choose one of {', '.join(LAWS)}")
        if self.synthesis not in SYNTHESES:
            raise ModelError(
                f"synthesis {self.synthesis!r} was given; choose one of {', '.join(SYNTHESES)}"
            )
        overlaps = ("overlap", "speed_overlap", "torque_overlap")
        for name in (*overlaps, "wind_filter", "effectiveness_share"):
            if not getattr(self, name) > 0:
                raise ModelError(f"{name} = {getattr(self, name)!r} was given; it must be positive")
        if not 0 <= self.speed_filter < math.inf:
            raise ModelError(
                f"speed_filter = {self.speed_filter!r} rad/s was given; a corner above 0 is "
                "needed, or 0 for none"
            )
        if not 0 <= self.torsion_filter < math.inf:
            raise ModelError(
                f"torsion_filter = {self.torsion_filter!r} rad/s was given; a frequency above 0 is "
                "needed, or 0 for none"
            )
        if self.torsion_filter and not self.speed_filter:
            raise ModelError(
                "speed_filter = 0 was given with a torsion_filter of "
                f"{self.torsion_filter:g} rad/s, which needs a low-pass behind it; give one, such "
                "as 30 rad/s, or torsion_filter = 0"
            )


# A command limited at rated torque must not be rounded off below half of rated torque.
LARGEST_SHARE = 0.5
WIND_STEPS = 201
# Least d ln T_r / d ln v at a trim [-].  It is 2 where c_Q is constant, and 0 where c_Q grows with
# the square of the tip-speed ratio.
LEAST_EXPONENT = 0.05
WIND_STEP = 0.5  # m/s, between the winds at which the trim is checked


def check_limits(turbine: Turbine, settings: DesignSettings) -> None:
    """Refuse overlaps and a bandwidth for which the law cannot work.

    both        a steady state at every wind from cut-in to cut-out, at which more wind gives more
                torque, or it cannot be observed
                and at the lowest speed set-point, where set-points are taken at run time
    coherent    overlap < n_g T_rated / J, the effort that torque can hold in reserve, and
                bandwidth, grown too, <= 1 / tau, the rate of the pitch drive
    published   torque overlap below half of rated torque, its rounded corner below the largest
                torque; the ramp of f_1 above the smallest speed; and f_1 > 0 at the
                set-point, or nothing acts above rated wind

    Raises
    ------
    ModelError : one of them fails; says what was given, what is needed, at which winds, and a
        number that works.
    """
    _check_rated_torque(turbine, settings.speed_setpoint)
    _check_trims(turbine, settings.speed_setpoint)
    if settings.lowest_speed_setpoint is not None:
        _check_trims(turbine, settings.lowest_speed_setpoint)
    if settings.law == "coherent":
        _check_overlap(turbine, settings.overlap)
        if settings.effort is not None:
            _check_bandwidth(turbine, settings.effort.bandwidth, settings.effort.bandwidth_growth)
        return
    _check_torque_overlap(turbine, settings.torque_overlap)
    _check_speed_ramp(turbine, settings)


def _check_rated_torque(turbine: Turbine, setpoint: float | None) -> None:
    """Refuse a rated torque that is not reached at smallest pitch at any wind inside the table."""
    speed = setpoint or turbine.rated_rotor_speed
    first_wind = speed * turbine.rotor_radius / turbine.torque.x_range[1]
    last = speed * turbine.rotor_radius / turbine.torque.x_range[0] * (1 - 1e-9)
    # Just inside the table's ends, where rounding could leave it.
    first = max(first_wind * (1 + 1e-9), turbine.cut_in)
    winds = np.linspace(first, min(last, turbine.cut_out), WIND_STEPS)
    torques = rotor_torque(turbine, speed, turbine.pitch_min, winds) / turbine.gear_ratio
    low, high = float(torques[0]), float(torques.max())
    if not low < turbine.rated_torque <= high:
        raise ModelError(
            f"{turbine.name}: rated torque {turbine.rated_torque:.6g} N m was given; at "
            f"{speed:.4g} rad/s and smallest pitch the rotor gives {low:.6g} N m at "
            f"{winds[0]:.4g} m/s, where the table begins, and at most {high:.6g} N m, at "
            f"{float(winds[int(torques.argmax())]):.4g} m/s; rated torque must lie between these "
            "two"
        )


def _check_trims(turbine: Turbine, setpoint: float | None) -> None:
    """Refuse a turbine without a steady state somewhere between cut-in and cut-out."""
    winds: list[float] = []
    for v in np.arange(turbine.cut_in, turbine.cut_out + WIND_STEP / 2, WIND_STEP):
        wind = min(float(v), turbine.cut_out)
        try:
            point = trim(turbine, wind, speed_setpoint=setpoint)
        except ModelError as error:
            existence = "none exists"
            if winds:
                existence = f"it exists from {winds[0]:.4g} to {winds[-1]:.4g} m/s"
            raise ModelError(
                f"{error}. A steady state is needed from cut-in {turbine.cut_in:.4g} to cut-out "
                f"{turbine.cut_out:.4g} m/s; {existence}, looked at in steps of {WIND_STEP:g} m/s: "
                "give such winds as cut_in and cut_out, or change the torque and pitch limits"
            ) from error
        _check_observed(turbine, point)
        winds.append(wind)


def _check_observed(turbine: Turbine, point: TrimPoint) -> None:
    """Refuse a trim at which the wind hardly changes the torque: a = d ln T_r / d ln v."""
    slope = float(
        rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, point.wind, clip=True)[2]
    )
    torque = turbine.gear_ratio * point.torque
    if slope * point.wind < LEAST_EXPONENT * torque:
        ratio = point.rotor_speed * turbine.rotor_radius / point.wind
        raise ModelError(
            f"{turbine.name}: at {point.wind:.4g} m/s 1 % more wind gives only "
            f"{slope * point.wind / torque:.3g} % more torque (tip-speed ratio {ratio:.4g}, pitch "
            f"{math.degrees(point.pitch):.4g} deg), and at least {LEAST_EXPONENT:g} % is needed: "
            "the observer cannot see the wind there; correct the power coefficients around this "
            "place, or leave this wind out by cut_in and cut_out"
        )


def _check_overlap(turbine: Turbine, overlap: float) -> None:
    reserve = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    if not 0 < overlap < reserve:
        raise ModelError(
            f"overlap {overlap:.4g} rad/s^2 was given; above 0 and below {reserve:.4g} rad/s^2 is "
            "needed, the whole effort of rated torque: a wider ramp gives pitch a share of it at "
            f"every wind from cut-in, {turbine.cut_in:.4g} m/s, on; try {_short(reserve / 10)}"
        )


def _check_bandwidth(turbine: Turbine, bandwidth: float, growth: float) -> None:
    drive = 1 / turbine.pitch_time_constant
    if 0 < bandwidth <= drive < bandwidth * growth:
        raise ModelError(
            f"bandwidth growth {growth:.4g} was given with a bandwidth of {bandwidth:.4g} 1/s; at "
            f"most {drive:.4g} 1/s is needed, the rate of the pitch drive, at all winds: try "
            f"{_short(drive / bandwidth / 2)}"
        )
    if not 0 < bandwidth <= drive:
        raise ModelError(
            f"bandwidth {bandwidth:.4g} 1/s was given; above 0 and at most {drive:.4g} 1/s is "
            "needed, the rate of the pitch drive, which acts at all winds above rated, "
            f"{rated_wind(turbine):.4g} m/s; try {_short(drive / 8)}"
        )


def _check_torque_overlap(turbine: Turbine, overlap: float) -> None:
    rated, largest = turbine.rated_torque, turbine.maximum_torque
    largest_overlap = min(LARGEST_SHARE * rated, 2 * (largest - rated))
    if not 0 < overlap <= largest_overlap:
        raise ModelError(
            f"torque overlap {overlap:.6g} N m was given; above 0 and at most "
            f"{largest_overlap:.6g} N m is needed: it rounds the corner at rated torque, "
            f"{rated:.6g} N m, up to half of it higher, and the largest torque is {largest:.6g} "
            f"N m; at rated wind, "
            f"{rated_wind(turbine):.4g} m/s, a wider one leaves no torque that is held; try "
            f"{_short(largest_overlap / 4)}"
        )


def _check_speed_ramp(turbine: Turbine, settings: DesignSettings) -> None:
    setpoint = settings.speed_setpoint or turbine.rated_rotor_speed
    placement, overlap = settings.ramp_placement, settings.speed_overlap
    room = setpoint - turbine.minimum_rotor_speed
    below = (1 - placement) * overlap
    if below >= room:
        raise ModelError(
            f"speed overlap {overlap:.4g} rad/s was given, {below:.4g} rad/s of it below the "
            f"set-point; less than {room:.4g} rad/s is needed there: the ramp would begin below "
            f"the smallest speed, {turbine.minimum_rotor_speed:.4g} rad/s, and pitch would act at "
            f"every wind from {turbine.cut_in:.4g} m/s on; try {_short(setpoint / 12)}"
        )
    if placement * overlap > room:
        raise ModelError(
            f"speed overlap {overlap:.4g} rad/s was given, {placement * overlap:.4g} rad/s of it "
            f"above the set-point; at most {room:.4g} rad/s is needed there, or pitch acts fully "
            f"at no speed that the rotor should reach; try {_short(setpoint / 12)}"
        )
    if placement >= 1:
        rated = rated_wind(turbine, speed_setpoint=settings.speed_setpoint)
        raise ModelError(
            f"ramp placement {placement:.4g} was given; below 1 is needed for Schulte's "
            "law: at the set-point torque is held at rated and f_1 is 0, so that no actuator "
            f"acts; the loop has no equilibrium at {rated:.4g} to {turbine.cut_out:.4g} m/s; "
            "try 0"
        )


def _short(value: float) -> str:
    return f"{value:.2g}" if value < 100 else f"{float(f'{value:.2g}'):.0f}"
