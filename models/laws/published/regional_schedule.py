"""The regions of a published law: gains, memberships, and the filter between them.

The coupling filter F(omega, T_g) = sum_m h^a_m F_m that blends torque and pitch control.

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

One region's scheduled gains: memberships h(z) of its model, and the gains that they blend.

At run time the wind is known by its estimate alone, so the premises of a regional model are taken
at v = v_hat, and outside the model's box each premise is held at its nearer bound:

    z^b = (omega, v_hat)         a, d       partial load
    z^c = (omega, beta, v_hat)   a, b, d    full load

The secants are evaluated on Python floats (a few microseconds), where the model's own evaluator is
vectorised; both give the same numbers.  Gains carry the published signs: u = -k_x dx + k_I x_I
with x_I = int (omega_ref - omega) dt, so K_I = -k_I in u = -K x.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats, frozen
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.ramps import Ramp, Shape, rated_speed_ramp
from takagi.models.splines.spline import scalar_surface
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import OperatingBand, operating_band
from takagi.models.turbine.region_models import WIND_ESTIMATE

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
    ModelError : torques out of order (0 <= eps_T < T_min < T_max, T_max + eps_T/2 <= T_top).
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
        if not (math.isfinite(overlap) and 0 <= overlap < low < high):
            raise ModelError(
                f"torque overlap {overlap:.6g} N m, minimum {low:.6g} N m and rated torque "
                f"{high:.6g} N m were given; 0 <= overlap < minimum < rated is needed: narrow the "
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
        high = np.vectorize(self._high_weight_at, otypes=[float])(torque)
        return np.stack((1.0 - high, high))

    def memberships(self, rotor_speed: ArrayLike, torque: ArrayLike) -> Floats:
        """Return h^a_1..h^a_4, (4, ...), for arrays that broadcast; all >= 0, sum 1.

        ``rotor_speed [rad/s]``, ``torque`` : commanded torque [N m].
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
    shape: Shape = "smooth",
    torque_shape: Shape = "linear",
    speed_setpoint: float | None = None,
) -> CouplingFilter:
    """Return the coupling filter of a turbine.

    Parameters
    ----------
    speed_overlap : epsilon_omega [rad/s], width of the ramp of f_1.
    torque_overlap : epsilon_T [N m]; T_min of ``sector`` is rated torque less it.
    variant : "saturated" or "sector".
    placement : share of the speed overlap that lies above the set-point (``rated_speed_ramp``).
    shape : of the ramp in speed.
    torque_shape : of the ramps in torque of ``sector``.  Linear ones keep T_g f_2 >= T_max on the
        window; smooth ones let it dip below by about a tenth of the window just before T_max.
    speed_setpoint : rotor speed of full load [rad/s]; None takes the rated speed.

    Raises
    ------
    ModelError : overlaps that do not fit the turbine's torques.
    """
    setpoint = turbine.rated_rotor_speed if speed_setpoint is None else speed_setpoint
    return CouplingFilter(
        rated_speed_ramp(setpoint, overlap=speed_overlap, placement=placement, shape=shape),
        variant,
        turbine.rated_torque,
        torque_overlap,
        turbine.rated_torque - torque_overlap,
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


Evaluator: TypeAlias = Callable[[float, float, float], float]

# Steps [rad/s, rad, m/s] below which a secant is taken as a central difference of this width
# around the middle: rounding then stays near 1e-9 of the slope, truncation below it.
STEPS = (1e-4, 1e-4, 1e-3)
INDEX = {"a": 0, "b": 1, "d": 2}


class RegionalGainValues(NamedTuple):
    """Blended gains: on speed error, on pitch, on the integral, with the published signs."""

    speed: float
    pitch: float
    integral: float


@dataclass(frozen=True, slots=True, eq=False)
class RegionalSchedule:
    """h_i(z) and the gains of each rule i.

    Attributes
    ----------
    model : the regional model whose premises schedule the gains.
    k_x : (r, 2), on (omega - omega_ref [rad/s], beta [rad]); the second column of partial load
        is 0.
    k_I : (r,), on x_I [rad].
    evaluators : one f(rotor_speed, pitch, wind_estimate) per premise of the model.

    Raises
    ------
    ModelError : gains that do not fit the model's rules, or are not finite.
    """

    model: TSModel
    k_x: Floats
    k_I: Floats
    evaluators: tuple[Evaluator, ...]
    _bounds: tuple[tuple[float, float], ...] = field(init=False, repr=False)
    _rows: tuple[tuple[float, float, float], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        count = len(self.model.rules)
        for name, shape in (("k_x", (count, 2)), ("k_I", (count,))):
            array = frozen(self, name)
            if array.shape != shape or not np.all(np.isfinite(array)):
                raise ModelError(
                    f"{self.model.name}: {name} has shape {array.shape}; finite numbers of shape "
                    f"{shape} are needed, one row per rule of the model"
                )
        if len(self.evaluators) != len(self.model.premises):
            raise ModelError(
                f"{self.model.name}: {len(self.evaluators)} evaluators for "
                f"{len(self.model.premises)} premises; one each is needed"
            )
        bounds = tuple((float(p.lower), float(p.upper)) for p in self.model.premises)
        rows = tuple((*x, i) for x, i in zip(self.k_x.tolist(), self.k_I.tolist(), strict=True))
        object.__setattr__(self, "_bounds", bounds)
        object.__setattr__(self, "_rows", rows)

    def memberships_at(self, rotor_speed: float, pitch: float, wind: float) -> list[float]:
        """Return h_i in rule order at rotor speed [rad/s], pitch [rad], wind estimate [m/s]."""
        pairs = []
        for evaluate, (low, high) in zip(self.evaluators, self._bounds, strict=True):
            z = evaluate(rotor_speed, pitch, wind)
            upper = 0.0 if high == low else min(max((z - low) / (high - low), 0.0), 1.0)
            pairs.append((1.0 - upper, upper))
        memberships = []
        for rule in self.model.rules:
            h = 1.0
            for pair, corner in zip(pairs, rule, strict=True):
                h *= pair[corner]
            memberships.append(h)
        return memberships

    def gains_at(self, rotor_speed: float, pitch: float, wind: float) -> RegionalGainValues:
        """Return sum_i h_i (k_x_i, k_I_i)."""
        speed = angle = integral = 0.0
        weights = self.memberships_at(rotor_speed, pitch, wind)
        for h, (first, second, third) in zip(weights, self._rows, strict=True):
            speed += h * first
            angle += h * second
            integral += h * third
        return RegionalGainValues(speed, angle, integral)


def regional_schedule(
    turbine: Turbine,
    model: TSModel,
    *,
    k_x: ArrayLike,
    k_I: ArrayLike,
    speed_setpoint: float | None = None,
) -> RegionalSchedule:
    """Return the schedule of a model made by ``partial_load_model`` or ``full_load_model``.

    Parameters
    ----------
    model : its box gives the wind range.
    k_x : (r, 2), or (r, 1) for partial load, where the gain on pitch is 0.
    k_I : (r,), published sign.
    speed_setpoint : that which the model was made with.

    Raises
    ------
    ModelError : gains that do not fit, or a model with other premises than a, b, d.
    """
    on_states = np.asarray(k_x, dtype=np.float64)
    if on_states.ndim == 2 and on_states.shape[1] == 1:
        on_states = np.hstack([on_states, np.zeros_like(on_states)])
    unknown = [p.name for p in model.premises if p.name not in INDEX]
    if unknown or WIND_ESTIMATE not in model.box:
        raise ModelError(
            f"model {model.name!r} has premises {', '.join(p.name for p in model.premises)}; a "
            "regional model of a turbine, with premises among a, b, d, is needed"
        )
    evaluators = model_evaluators(turbine, model, speed_setpoint)
    return RegionalSchedule(model, on_states, np.asarray(k_I, dtype=np.float64), evaluators)


def model_evaluators(
    turbine: Turbine, model: TSModel, speed_setpoint: float | None
) -> tuple[Evaluator, ...]:
    """Return one function of speed, pitch and wind estimate per premise of a regional model."""
    band = premise_band(turbine, model, speed_setpoint)
    with_pitch = any(p.name == "b" for p in model.premises)
    by_name = premise_evaluators(band, with_pitch=with_pitch)
    return tuple(by_name[p.name] for p in model.premises)


def premise_band(turbine: Turbine, model: TSModel, speed_setpoint: float | None) -> OperatingBand:
    """Return the trim table, without bands around it, over the wind range of a regional model."""
    low, high = (float(end) for end in model.box[WIND_ESTIMATE])
    return operating_band(
        turbine, (low, high), speed_band=0, pitch_band=0, wind_band=0, speed_setpoint=speed_setpoint
    )


def premise_evaluators(band: OperatingBand, *, with_pitch: bool) -> dict[str, Evaluator]:
    """Return a, b, d as functions of rotor speed [rad/s], pitch [rad], wind estimate [m/s].

    The estimate is held to the band's wind range.  Without pitch the angle is the trim's.
    """
    table = scalar_surface(band.turbine.torque)
    radius = band.turbine.rotor_radius
    scale = band.turbine.torque_constant / band.turbine.inertia
    winds, columns = band.wind.tolist(), (band.rotor_speed.tolist(), band.pitch.tolist())
    last = len(winds) - 2

    def trim_at(wind: float) -> tuple[float, float, float]:
        v = min(max(wind, winds[0]), winds[-1])
        k = min(max(bisect_right(winds, v) - 1, 0), last)
        share = (v - winds[k]) / (winds[k + 1] - winds[k])
        speed, angle = (c[k] + share * (c[k + 1] - c[k]) for c in columns)
        return speed, angle, v

    def acceleration(omega: float, beta: float, v: float) -> float:
        return scale * v * v * table(omega * radius / v, beta)

    def secant(index: int, speed: float, pitch: float, wind: float) -> float:
        trim = trim_at(wind)
        point = (speed, pitch if with_pitch else trim[1], trim[2])
        lower, upper = [*trim[: index + 1], *point[index + 1 :]], [*trim[:index], *point[index:]]
        if abs(upper[index] - lower[index]) < STEPS[index]:
            middle = (upper[index] + lower[index]) / 2
            lower[index], upper[index] = middle - STEPS[index] / 2, middle + STEPS[index] / 2
        return (acceleration(*upper) - acceleration(*lower)) / (upper[index] - lower[index])

    def bound(index: int) -> Evaluator:
        return lambda speed, pitch, wind: secant(index, speed, pitch, wind)

    return {name: bound(index) for name, index in INDEX.items()}
