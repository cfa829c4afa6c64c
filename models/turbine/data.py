"""A turbine's figures, and the torque and thrust of its rotor.

Rotor torque, power and thrust from the coefficient surfaces; vectorised over arrays.

    lambda = omega R / v
    T_r = (rho pi R^3 / 2) v^2 c_Q(lambda, beta)            [N m], low-speed side
    P   = omega T_r                                         [W], mechanical
    F   = (rho pi R^2 / 2) v^2 c_T(lambda, beta)            [N]

Outside the table these functions raise ``ModelError``.  ``clip=True`` holds the *coefficient* at
the table's edge instead (lambda and beta are moved there): a simulation that touches the edge then
goes on, with a torque that is continuous and no longer a figure of the rotor.

Source: theory of the ideal actuator disc; Burton et al. (2011), Wind Energy Handbook, ch. 3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError
from takagi.models.splines.spline import Surface


@dataclass(frozen=True, slots=True)
class Figure:
    """One number as the file gives it: value, unit, and where it was read."""

    value: float
    unit: str
    source: str


@dataclass(frozen=True, slots=True)
class BaselineController:
    """The reference's own controller: K w_g^2 torque with linear transitions, scheduled pitch PI.

    Attributes
    ----------
    proportional_gain : pitch per generator speed at pitch 0 [s].
    integral_gain : pitch per generator angle at pitch 0 [-].
    schedule_pitch : the gains are divided by 1 + pitch / schedule_pitch [rad].
    optimal_torque_constant : K in T_g = K w_g^2, high-speed shaft [N m s^2/rad^2].
    region_15_speed, region_2_speed, region_25_speed, region_3_speed : generator speeds at which
        the regions begin [rad/s].
    """

    proportional_gain: float
    integral_gain: float
    schedule_pitch: float
    optimal_torque_constant: float
    region_15_speed: float
    region_2_speed: float
    region_25_speed: float
    region_3_speed: float


@dataclass(frozen=True, slots=True)
class FrozenWake:
    """dP/dpitch with the induction held, at the trim.

    A quasi-steady coefficient table gives the equilibrium-wake sensitivity, which is much smaller
    near rated wind; the truth on a fast pitch step lies between the two.

    Attributes
    ----------
    wind : [m/s], increasing.
    pitch : trim pitch, as published or of the tables [rad].
    power_sensitivity : dP/dpitch at constant speed [W/rad].
    source : where the columns were read.
    """

    wind: tuple[float, ...]
    pitch: tuple[float, ...]
    power_sensitivity: tuple[float, ...]
    source: str


@dataclass(frozen=True, slots=True)
class DiscWake:
    """The wake of the validation plant: w' = (k_a a(c_T) v - w) / t_w.

    Attributes
    ----------
    induction : k_a [-], induced wind where the blades work, over the momentum theory's disc mean.
    time_share : t_w over Oye's first time constant [-].

    The defaults, for a file without ``[wake]``, are those of the NREL 5-MW turbine, rounded: 1 is
    the theory's mean, and understates the first answers by some per cent.
    """

    induction: float = 1.3
    time_share: float = 0.5


@dataclass(frozen=True, slots=True)
class FlapMode:
    """The first collective flap mode of the validation plant.

    Attributes
    ----------
    frequency [rad/s], damping [-] : structural, at rated speed.
    compliance : blade-tip displacement over rotor thrust at rest [m/N].
    velocity_share : velocity that the rotor feels over that of the blade tip [-].
    """

    frequency: float
    damping: float
    compliance: float
    velocity_share: float


@dataclass(frozen=True, slots=True)
class TorsionMode:
    """The first free-free torsion mode: frequency [rad/s] and damping [-]."""

    frequency: float
    damping: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class Turbine(ShortRepr):
    """A variable-speed, pitch-controlled turbine; SI units throughout, angles in rad.

    Attributes
    ----------
    rotor_radius, hub_height [m]; air_density [kg/m^3].
    gear_ratio : n_g [-].
    rotor_inertia, generator_inertia [kg m^2]; the generator's is on the high-speed shaft.
    rated_rotor_speed, minimum_rotor_speed [rad/s].
    rated_torque, maximum_torque [N m], torque_rate_limit [N m/s], all on the high-speed shaft.
    generator_efficiency [-].
    pitch_min, pitch_max [rad], pitch_rate_limit [rad/s].
    pitch_time_constant : first-order drive of the design model [s].
    pitch_drive_frequency [rad/s], pitch_drive_damping [-] : second-order drive of the
        validation plant.
    tower_mass [kg], tower_damping [N s/m], tower_stiffness [N/m] : first fore-aft mode.
    shaft_stiffness [N m/rad], shaft_damping [N m s/rad], low-speed side.
    cut_in, cut_out [m/s].
    speed_filter : corner of the generator-speed filter [rad/s].
    baseline : the reference's own controller; None where the file has none.
    frozen_wake : dP/dpitch over wind, published or computed.
    power, thrust : c_P and c_T over tip-speed ratio [-] and pitch [rad].
    torque : c_Q, the spline of c_P / lambda at the table's points; rotor torque is computed from
        it, so that it is a polynomial on every cell.  It agrees with ``power`` at those points.
    figures : every number of the file by ``"section.key"``, as given, with unit and source.

    Of the validation plant alone, with what holds where the file has no such entry:

    wake : of the disc.   flap : None, no flap mode.
    tower_share : fore-aft velocity of the hub over that of the tower top [-], above 1 where the
        top turns; 1.
    torsion : None, rotor and generator on the shaft's own stiffness and damping.
    torque_lag : first-order lag of the generator [s]; None for none.
    """

    name: str
    rotor_radius: float
    hub_height: float
    air_density: float
    gear_ratio: float
    rotor_inertia: float
    generator_inertia: float
    rated_rotor_speed: float
    minimum_rotor_speed: float
    rated_torque: float
    maximum_torque: float
    torque_rate_limit: float
    generator_efficiency: float
    pitch_min: float
    pitch_max: float
    pitch_rate_limit: float
    pitch_time_constant: float
    pitch_drive_frequency: float
    pitch_drive_damping: float
    tower_mass: float
    tower_damping: float
    tower_stiffness: float
    shaft_stiffness: float
    shaft_damping: float
    cut_in: float
    cut_out: float
    speed_filter: float
    baseline: BaselineController | None
    frozen_wake: FrozenWake
    power: Surface
    thrust: Surface
    torque: Surface
    figures: Mapping[str, Figure]
    wake: DiscWake = DiscWake()
    flap: FlapMode | None = None
    tower_share: float = 1.0
    torsion: TorsionMode | None = None
    torque_lag: float | None = None

    @property
    def inertia(self) -> float:
        """J = J_r + n_g^2 J_g on the low-speed side [kg m^2]."""
        return self.rotor_inertia + self.gear_ratio**2 * self.generator_inertia

    @property
    def reference_controller(self) -> BaselineController:
        """``baseline``; ModelError where the turbine has none."""
        if self.baseline is None:
            raise ModelError(
                f"{self.name}: its file has no section [baseline], the figures of the reference's "
                "own controller; add them as models/data/nrel5mw.toml has them, or leave the law "
                "baseline out"
            )
        return self.baseline

    @property
    def torque_constant(self) -> float:
        """rho pi R^3 / 2 [kg m]; times v^2 c_Q it is the rotor torque."""
        return 0.5 * self.air_density * pi * self.rotor_radius**3

    @property
    def rated_power(self) -> float:
        """Electrical power at rated speed and torque [W]."""
        mechanical = self.rated_torque * self.gear_ratio * self.rated_rotor_speed
        return self.generator_efficiency * mechanical


def tip_speed_ratio(turbine: Turbine, rotor_speed: ArrayLike, wind: ArrayLike) -> Floats:
    """Return lambda = omega R / v [-]; ModelError where the wind is not above 0."""
    v = np.asarray(wind, dtype=np.float64)
    if not np.all(v > 0):
        raise ModelError(f"wind {np.min(v):.9g} m/s was given; a wind above 0 is needed")
    omega = np.asarray(rotor_speed, dtype=np.float64)
    return np.asarray(omega * turbine.rotor_radius / v, dtype=np.float64)


def rotor_torque(
    turbine: Turbine,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    wind: ArrayLike,
    *,
    clip: bool = False,
) -> Floats:
    """Return T_r = (rho pi R^3 / 2) v^2 c_Q(lambda, beta) [N m], low-speed side.

    Parameters
    ----------
    rotor_speed [rad/s], pitch [rad], wind [m/s] : numbers or arrays that broadcast.
    clip : hold the coefficient at the table's edge instead of raising.

    Raises
    ------
    ModelError : a point outside the table (with clip=False), or wind <= 0.
    """
    v = np.asarray(wind, dtype=np.float64)
    lam = tip_speed_ratio(turbine, rotor_speed, v)
    c_q = turbine.torque(lam, pitch, clip=clip)
    return np.asarray(turbine.torque_constant * v**2 * c_q, dtype=np.float64)


def rotor_torque_gradient(
    turbine: Turbine,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    wind: ArrayLike,
    *,
    clip: bool = False,
) -> tuple[Floats, Floats, Floats]:
    """Return (dT_r/d omega, dT_r/d beta, dT_r/d v), exact derivatives of the spline.

    With k = rho pi R^3 / 2:  k R v c_Q,lambda  [N m s/rad];  k v^2 c_Q,beta  [N m/rad];
    k v (2 c_Q - lambda c_Q,lambda)  [N s].

    Parameters and errors as for ``rotor_torque``.  With clip=True the derivatives are those at
    the table's edge, not of the held coefficient.
    """
    v = np.asarray(wind, dtype=np.float64)
    lam = tip_speed_ratio(turbine, rotor_speed, v)
    if clip:
        lam = np.clip(lam, *turbine.torque.x_range)
    k = turbine.torque_constant
    c_q = turbine.torque(lam, pitch, clip=clip)
    by_lambda = turbine.torque(lam, pitch, dx=1, clip=clip)
    by_pitch = turbine.torque(lam, pitch, dy=1, clip=clip)
    return (
        np.asarray(k * turbine.rotor_radius * v * by_lambda, dtype=np.float64),
        np.asarray(k * v**2 * by_pitch, dtype=np.float64),
        np.asarray(k * v * (2 * c_q - lam * by_lambda), dtype=np.float64),
    )


def rotor_thrust(
    turbine: Turbine,
    rotor_speed: ArrayLike,
    pitch: ArrayLike,
    wind: ArrayLike,
    *,
    clip: bool = False,
) -> Floats:
    """Return F = (rho pi R^2 / 2) v^2 c_T(lambda, beta) [N].

    Parameters and errors as for ``rotor_torque``.
    """
    v = np.asarray(wind, dtype=np.float64)
    lam = tip_speed_ratio(turbine, rotor_speed, v)
    c_t = turbine.thrust(lam, pitch, clip=clip)
    factor = turbine.torque_constant / turbine.rotor_radius
    return np.asarray(factor * v**2 * c_t, dtype=np.float64)
