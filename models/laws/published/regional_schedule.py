r"""One region's scheduled gains: memberships h(z) of its model, and the gains that they blend.

At run time the wind is known by its estimate alone, so the premises of a regional model are taken
at v = v_hat, and outside the model's box each premise is held at its nearer bound:

    z^b = (omega, v_hat)         a, d       partial load
    z^c = (omega, beta, v_hat)   a, b, d    full load

The secants are evaluated on Python floats (a few microseconds), where the model's own evaluator is
vectorised; both give the same numbers.  Gains carry the published signs: u = -k_x dx + k_I x_I
with x_I = int (omega_ref - omega) dt, so K_I = -k_I in u = -K x.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.splines.scalar_surface import scalar_surface
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import OperatingBand, operating_band
from takagi.models.turbine.regional_model import WIND_ESTIMATE

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
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.shape != shape or not np.all(np.isfinite(array)):
                raise ModelError(
                    f"{self.model.name}: {name} has shape {array.shape}; finite numbers of shape "
                    f"{shape} are needed, one row per rule of the model"
                )
            array.flags.writeable = False
            object.__setattr__(self, name, array)
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
    band = premise_band(turbine, model, speed_setpoint)
    with_pitch = any(p.name == "b" for p in model.premises)
    by_name = premise_evaluators(band, with_pitch=with_pitch)
    evaluators = tuple(by_name[p.name] for p in model.premises)
    return RegionalSchedule(model, on_states, np.asarray(k_I, dtype=np.float64), evaluators)


def premise_band(turbine: Turbine, model: TSModel, speed_setpoint: float | None) -> OperatingBand:
    """Return the trim table, without bands around it, over the wind range of a regional model."""
    low, high = (float(end) for end in model.box[WIND_ESTIMATE])
    return operating_band(
        turbine,
        (low, high),
        speed_band=0,
        pitch_band=0,
        wind_band=0,
        speed_setpoint=speed_setpoint,
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
