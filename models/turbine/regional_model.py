r"""Telescoping secants of the rotor torque around the trim at the wind estimate.

    T_r(omega, beta, v) - T_r(omega*, beta*, v_0)
        = S_omega (omega - omega*) + S_beta (beta - beta*) + S_v (v - v_0)

    S_omega = [T_r(omega, beta, v)   - T_r(omega*, beta, v)]  / (omega - omega*)
    S_beta  = [T_r(omega*, beta, v)  - T_r(omega*, beta*, v)] / (beta - beta*)
    S_v     = [T_r(omega*, beta*, v) - T_r(omega*, beta*, v_0)] / (v - v_0)

an identity, with the partial derivative where a difference vanishes.  By the mean value theorem
each secant is a value of the partial derivative between its two points, hence inside the
derivative's range over the tube.  The pitch secant is taken at omega*, so the wrong sign of
dT_r/dbeta at overspeed and small pitch enters S_omega, not S_beta.

The premises are a = S_omega / J, b = S_beta / J, d = S_v / J: entries of the matrices.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.equations.derivation_step import Step
from takagi.models.intervals.box_search import Range
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise, round_outward
from takagi.models.turbine.data import Turbine, rotor_torque, rotor_torque_gradient
from takagi.models.turbine.operating_band import OperatingBand, Slope, slope_range

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.equations.equations import Equations, Factored

# Below this difference (rad/s, rad, m/s) a quotient of floats loses digits and the derivative in
# the middle is better: it errs by the third derivative times the square of this, below 1e-12.
MEETING_DISTANCE = 1e-6


@dataclass(frozen=True, slots=True)
class Kind:
    """What belongs to one secant: symbol, unit, which variable, what else is off the trim."""

    name: str
    unit: str
    words: str
    slope: Slope
    index: int


KINDS: dict[Slope, Kind] = {
    "speed": Kind("a", "1/s", "dT_r/domega / J", "speed", 0),
    "pitch": Kind("b", "1/s^2/rad", "dT_r/dbeta / J", "pitch", 1),
    "wind": Kind("d", "1/s/m", "dT_r/dv / J", "wind", 2),
}


@dataclass(frozen=True, slots=True, eq=False)
class TorqueSymbols:
    """Symbols of the derivation, T_r at the point and at trim, and the secants per inertia."""

    speed_error: sp.Symbol
    pitch_deviation: sp.Symbol
    wind_deviation: sp.Symbol
    inertia: sp.Symbol
    point: sp.Expr
    trim: sp.Expr
    secants: dict[sp.Symbol, sp.Expr]

    def secant(self, name: str) -> sp.Symbol:
        """Return the symbol a, b or d."""
        return next(symbol for symbol in self.secants if symbol.name == name)


def torque_symbols(*, with_pitch: bool) -> TorqueSymbols:
    """Return the telescope with T_r an undefined function; pitch at trim if not with_pitch."""
    import sympy as sp

    T = sp.Function("T_r")
    omega, beta, v0, J = sp.symbols(r"\omega^* \beta^* v_0 J", positive=True)
    e, p, w, a, b, d = sp.symbols(r"e \delta_\beta w a b d", real=True)
    pitch = beta + p if with_pitch else beta
    corners = (
        T(omega + e, pitch, v0 + w),
        T(omega, pitch, v0 + w),
        T(omega, beta, v0 + w),
        T(omega, beta, v0),
    )
    rises = [(first - last) / J for first, last in zip(corners, corners[1:], strict=False)]
    secants = {a: rises[0] / e, b: rises[1] / p, d: rises[2] / w}
    if not with_pitch:
        del secants[b]
    return TorqueSymbols(e, p, w, J, corners[0], corners[3], secants)


def telescoping_step(torque: TorqueSymbols) -> Step:
    """Return the decomposition of the torque difference as a step of the derivation."""
    import sympy as sp

    steps = {"a": torque.speed_error, "b": torque.pitch_deviation, "d": torque.wind_deviation}
    products = [rf"{symbol.name}\,{sp.latex(steps[symbol.name])}" for symbol in torque.secants]
    left_side = f"{sp.latex(torque.point)} - {sp.latex(torque.trim)}"
    return Step(
        "Telescoping secants of the rotor torque around the trim at the wind estimate; each is "
        "a value of the partial derivative between its two points (mean value theorem).",
        rf"{left_side} = {sp.latex(torque.inertia)} \left( {' + '.join(products)} \right)",
    )


def secant_premise(
    band: OperatingBand, slope: Slope, *, with_pitch: bool, tolerance: Fraction
) -> Premise:
    """Return the premise a, b or d with its proved range over the tube.

    ``evaluate(rotor_speed=, pitch=, wind=, wind_estimate=, clip=False)`` takes numbers or arrays;
    without pitch deviation ``pitch`` may be left out and is not used.
    """
    kind = KINDS[slope]
    moving = [name for name in KINDS if with_pitch or name != "pitch"]
    # The telescope leaves the trim wind first, then the pitch, then the speed.
    off_trim = {"wind": ("wind",), "pitch": ("pitch", "wind"), "speed": tuple(moving)}[slope]
    proved_range = slope_range(band, slope, off_trim=off_trim, tolerance=tolerance)
    return proved_premise(kind, proved_range, _evaluator(band, kind, with_pitch))


def proved_premise(kind: Kind, proved: Range, evaluate: Callable[..., float]) -> Premise:
    """Return the premise of a secant with its proved range, rounded outward."""
    bounds = round_outward(proved.outer, digits=6)
    return Premise(
        kind.name,
        bounds.lower,
        bounds.upper,
        unit=kind.unit,
        evidence=(
            f"range of {kind.words} over the tube: Bernstein hulls in exact arithmetic, "
            f"{proved.boxes} boxes, rounded outward"
        ),
        evaluate=evaluate,
    )


def _evaluator(band: OperatingBand, kind: Kind, with_pitch: bool) -> Callable[..., float]:
    def evaluate(
        *,
        rotor_speed: ArrayLike,
        wind: ArrayLike,
        wind_estimate: ArrayLike,
        pitch: ArrayLike | None = None,
        clip: bool = False,
    ) -> Floats:
        trim_speed, trim_pitch = band.at(wind_estimate, clip=clip)
        angle = trim_pitch if pitch is None or not with_pitch else pitch
        values = np.broadcast_arrays(
            rotor_speed, angle, wind, trim_speed, trim_pitch, wind_estimate
        )
        point, trim = [np.asarray(v, dtype=np.float64) for v in values[:3]], values[3:]
        # Variables after this one in (omega, beta, v) stay at the point, those before at trim.
        point_at = [trim[i] if i < kind.index else point[i] for i in range(3)]
        trim_value = np.asarray(trim[kind.index], dtype=np.float64)
        turbine = band.turbine
        return torque_secant(turbine, kind.index, point_at, trim_value, clip=clip) / turbine.inertia

    return evaluate  # type: ignore[return-value]


def torque_secant(
    turbine: Turbine, index: int, end: Sequence[Floats], near_value: Floats, *, clip: bool = False
) -> Floats:
    """Return [T_r(far) - T_r(near)] / (far_i - near_i) [N m per unit], derivative where they meet.

    ``end`` is far: rotor speed, pitch and wind, equal shapes; near differs from it in variable
    ``index``, which has ``near_value`` there.
    """
    start = [*end[:index], near_value, *end[index + 1 :]]
    middle = [(first + last) / 2 for first, last in zip(end, start, strict=True)]
    step = end[index] - near_value
    meeting = np.abs(step) <= MEETING_DISTANCE
    rise = rotor_torque(turbine, *end, clip=clip) - rotor_torque(turbine, *start, clip=clip)
    slope = rotor_torque_gradient(turbine, *middle, clip=clip)[index]
    return np.asarray(np.where(meeting, slope, rise / np.where(meeting, 1.0, step)))


SPEED_ERROR = "rotor speed error [rad/s]"
INTEGRAL = "integral of speed deficit [rad]"
PITCH_DEVIATION = "pitch deviation [rad]"
WIND_DEVIATION = "wind deviation [m/s]"
WIND_ESTIMATE = "wind estimate [m/s]"
SOURCE = (
    "sector nonlinearity: Tanaka and Wang (2001), section 2.2; regional schemes: Schulte (2024), "
    "Coherent Design of Wind Turbine Controllers, section II"
)


@dataclass(frozen=True, slots=True, eq=False)
class RegionalPlant:
    """A regional plant in symbols, its factored form, and the names with units."""

    plant: Equations
    factored: Factored
    names: Mapping[str, tuple[str, ...]]
    steps: tuple[Step, ...]


def region_model(
    region: RegionalPlant,
    band: OperatingBand,
    premises: tuple[Premise, ...],
    *,
    name: str,
    source: str = SOURCE,
) -> TSModel:
    """Return the TSModel of a region over its band, after the symbolic check of exactness."""
    from takagi.models.sector.assembly import assemble

    return assemble(
        region.plant,
        region.factored,
        premises,
        steps=region.steps,
        names=region.names,
        box=_band_box(band),
        name=f"{band.turbine.name} {name}",
        source=f"{band.turbine.name}; {source}",
    )


def _band_box(band: OperatingBand) -> dict[str, tuple[Fraction, Fraction]]:
    """Return the tube as a box in the deviations from the trim and in the wind estimate."""
    box = {SPEED_ERROR: (-band.speed_band, band.speed_band)}
    if band.pitch_band:
        box[PITCH_DEVIATION] = (-band.pitch_band, band.pitch_band)
    box[WIND_DEVIATION] = (-band.wind_band, band.wind_band)
    box[WIND_ESTIMATE] = (band.wind_range.lower, band.wind_range.upper)
    return box
