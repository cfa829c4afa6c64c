r"""The coupling filter F(omega, T_g) = sum_m h^a_m F_m that blends torque and pitch control.

Acting on u = (T_g, beta_ref), with T_g the *commanded* torque:

    F = diag(f_2(T_g), f_1(omega)),   F_1..F_4 = diag(f_2 low | high, f_1 low | high)
    h^a_1 = w_11 w_12,  h^a_2 = w_11 w_22,  h^a_3 = w_21 w_12,  h^a_4 = w_21 w_22

w_21 = f_1 is a ramp in omega.  f_2 comes in two variants, because "torque is held at rated from
T_min on, and passes below T_min" is impossible with a slope of T_g f_2 of at most 1:

    sector     f_2 = w_12 + w_22 T_max/T_min.  w_22 rises over [T_min - eps_T, T_min], which
               lets torque pass below, and falls over [T_min, T_max].  Corners 1, T_max/T_min.
               The slope of T_g f_2 reaches about 1 + (T_max - T_min)/eps_T > 1.
    saturated  f_2 = phi(T_g)/T_g with phi = T_g up to T_max - eps_T/2, a parabola, and
               phi = T_max from T_max + eps_T/2 on: slope in [0, 1].  Then f_2 <= 1 throughout,
               so its corners are T_max/T_top (T_top: largest command) and 1.

Beyond the premise's range ([., T_max] or [., T_top]) the weights are held at their ends; the law's
torque limit at T_max then limits the torque.

Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, section "Fuzzy-Blending of
Control Regions"; the variants are readings of it, see docs/laws.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.ramps import Ramp, Shape, rated_speed_ramp
from takagi.models.turbine.data import Turbine

Variant: TypeAlias = Literal["sector", "saturated"]


@dataclass(frozen=True, slots=True)
class CouplingFilter:
    """F(omega, T_g) as a value; see the module for the formulas.

    Attributes
    ----------
    speed_ramp : f_1 = w_21 over rotor speed [rad/s].
    variant : "sector" or "saturated".
    rated_torque : T_max [N m].
    torque_overlap : eps_T [N m].
    minimum_torque : T_min [N m], lower end of the window of ``sector``.
    top_torque : T_top [N m], the largest command that ``saturated`` has corners for.
    shape : shape of the torque ramps of ``sector``.

    Raises
    ------
    ModelError : torques out of order (0 < T_min - eps_T, T_min < T_max, T_max + eps_T/2 <= T_top).
    """

    speed_ramp: Ramp
    variant: Variant
    rated_torque: float
    torque_overlap: float
    minimum_torque: float
    top_torque: float
    shape: Shape = "linear"

    def __post_init__(self) -> None:
        if self.variant not in get_args(Variant):
            raise ModelError(
                f"coupling filter {self.variant!r} was given; it is one of "
                f"{', '.join(get_args(Variant))}{did_you_mean(self.variant, get_args(Variant))}"
            )
        low, high, overlap = self.minimum_torque, self.rated_torque, self.torque_overlap
        if not (math.isfinite(overlap) and 0 < overlap < low < high):
            raise ModelError(
                f"torque overlap {overlap:.6g} N m, minimum {low:.6g} N m and rated torque "
                f"{high:.6g} N m were given; 0 < overlap < minimum < rated is needed: narrow the "
                "overlap or move the window's lower end"
            )
        if self.variant == "saturated" and high + overlap / 2 > self.top_torque:
            raise ModelError(
                f"torque overlap {overlap:.6g} N m rounds the corner at {high:.6g} N m up to "
                f"{high + overlap / 2:.6g} N m, above the largest command {self.top_torque:.6g} "
                "N m; narrow the overlap or raise the largest command"
            )

    @property
    def torque_corners(self) -> tuple[float, float]:
        """(f_2 low, f_2 high): (1, T_max/T_min) or (T_max/T_top, 1)."""
        if self.variant == "sector":
            return 1.0, self.rated_torque / self.minimum_torque
        return self.rated_torque / self.top_torque, 1.0

    @property
    def corners(self) -> Floats:
        """F_1..F_4, (4, 2, 2), acting on (T_g [N m], beta_ref [rad])."""
        low, high = self.torque_corners
        return np.array([np.diag(pair) for pair in ((low, 0), (high, 0), (low, 1), (high, 1))])

    def torque_weights(self, torque: ArrayLike) -> Floats:
        """Return (w_12, w_22) at commanded torques [N m], stacked on the first axis."""
        T = np.asarray(torque, dtype=np.float64)
        if self.variant == "sector":
            rising, falling = self._torque_ramps
            high = rising(T) - falling(T)
        else:
            low = self.torque_corners[0]
            high = np.clip((self._saturated_factor(T) - low) / (1.0 - low), 0.0, 1.0)
        return np.stack((1.0 - high, high))

    def memberships(self, rotor_speed: ArrayLike, torque: ArrayLike) -> Floats:
        """Return h^a_1..h^a_4, (4, ...), for arrays that broadcast; all >= 0, sum 1.

        Parameters
        ----------
        rotor_speed [rad/s], torque : commanded torque [N m].
        """
        speed, command = np.broadcast_arrays(
            np.asarray(rotor_speed, dtype=np.float64), np.asarray(torque, dtype=np.float64)
        )
        by_speed, by_torque = self.speed_ramp.weights(speed), self.torque_weights(command)
        return np.stack([by_speed[i] * by_torque[j] for i in (0, 1) for j in (0, 1)])

    def factors_at(self, rotor_speed: float, torque: float) -> tuple[float, float]:
        """Return (f_2, f_1) at one point: what a control loop calls."""
        low, high = self.torque_corners
        return low + self._high_weight_at(torque) * (high - low), self.speed_ramp.at(rotor_speed)

    @property
    def torque_slope_range(self) -> tuple[float, float]:
        """(smallest, largest) slope of T_g f_2 over T_g up to the end of the corners' range.

        ``saturated``: (0, 1).  ``sector``: the largest exceeds 1, and the smallest is below 0.
        """
        if self.variant == "saturated":
            return 0.0, 1.0
        rising, falling = self._torque_ramps
        gain = self.rated_torque / self.minimum_torque - 1.0
        slopes = [1.0]
        for ramp, sign, offset in ((rising, 1.0, 0.0), (falling, -1.0, 1.0)):
            slopes += _product_slopes(ramp, sign, offset, gain)
        return min(slopes), max(slopes)

    @property
    def _torque_ramps(self) -> tuple[Ramp, Ramp]:
        low, high, overlap = self.minimum_torque, self.rated_torque, self.torque_overlap
        return Ramp(low - overlap, overlap, self.shape), Ramp(low, high - low, self.shape)

    def _saturated_factor(self, T: Floats) -> Floats:
        half, limit = self.torque_overlap / 2, self.rated_torque
        # The parabola is only ever divided by torques near rated, never by zero.
        near_rated = np.maximum(T, limit - half)
        curve = limit - (limit + half - near_rated) ** 2 / (4 * half)
        phi = np.where(near_rated >= limit + half, limit, curve)
        return np.where(limit - half >= T, 1.0, phi / near_rated)

    def _high_weight_at(self, torque: float) -> float:
        low, limit, overlap = self.minimum_torque, self.rated_torque, self.torque_overlap
        if self.variant == "sector":
            rising, falling = self._torque_ramps
            return rising.at(torque) - falling.at(torque)
        half = overlap / 2
        if torque <= limit - half:
            return 1.0
        phi = limit if torque >= limit + half else limit - (limit + half - torque) ** 2 / (4 * half)
        low = limit / self.top_torque
        return max((phi / torque - low) / (1.0 - low), 0.0)


def coupling_filter(
    turbine: Turbine,
    *,
    speed_overlap: float = 0.1,
    torque_overlap: float = 2000.0,
    variant: Variant = "saturated",
    placement: float = 0.5,
    minimum_torque: float | None = None,
    shape: Shape = "smooth",
    torque_shape: Shape = "linear",
    speed_setpoint: float | None = None,
) -> CouplingFilter:
    """Return the coupling filter of a turbine.

    Parameters
    ----------
    speed_overlap : epsilon_omega [rad/s], width of the ramp of f_1.
    torque_overlap : epsilon_T [N m].
    variant : "saturated" or "sector".
    placement : share of the speed overlap that lies above the set-point (``rated_speed_ramp``).
    minimum_torque : T_min of ``sector`` [N m]; None takes rated torque - torque overlap.
    shape : of the ramp in speed.
    torque_shape : of the ramps in torque of ``sector``.  Linear ones keep T_g f_2 >= T_max on the
        window; smooth ones let it dip below by about a tenth of the window just before T_max.
    speed_setpoint : rotor speed of full load [rad/s]; None takes the rated speed.

    Raises
    ------
    ModelError : overlaps that do not fit the turbine's torques.
    """
    setpoint = turbine.rated_rotor_speed if speed_setpoint is None else speed_setpoint
    lowest = turbine.rated_torque - torque_overlap if minimum_torque is None else minimum_torque
    return CouplingFilter(
        rated_speed_ramp(setpoint, overlap=speed_overlap, placement=placement, shape=shape),
        variant,
        turbine.rated_torque,
        torque_overlap,
        lowest,
        turbine.maximum_torque,
        torque_shape,
    )


def _product_slopes(ramp: Ramp, sign: float, offset: float, gain: float) -> list[float]:
    """Return the slopes of T (1 + gain (offset + sign w(T))) at the ramp's ends and extremum.

    For the smooth ramp d(slope)/ds = 6 sign gain (3 s - 4 s^2 + c (1 - 2 s)), c = start/width,
    has one root in (0, 1).
    """
    c = ramp.start / ramp.width
    b = 2 * c - 3
    ramp_points = (0.0, 1.0, (-b + math.sqrt(b * b + 16 * c)) / 8)
    slopes = []
    for s in ramp_points:
        w, by_s = (s, 1.0) if ramp.shape == "linear" else (s * s * (3 - 2 * s), 6 * s * (1 - s))
        slopes.append(1 + gain * (offset + sign * w) + sign * gain * (c + s) * by_s)
    return slopes
