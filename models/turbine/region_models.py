r"""The models of partial and of full load.

The partial-load model: torque control at smallest pitch, premises in rotor speed and wind.

    e'   = a e + d (v - v_0) - (n_g / J) (T - T*)          e = omega - omega*(v_0)
    x_I' = -e                                              x_I = int (omega_ref - omega) dt

with omega_ref = omega*(v_0), v_0 the wind estimate (constant; a moving estimate adds
-omega*'(v_0) v_0' to e'), T*(v_0) = T_r(omega*, beta_min, v_0) / n_g the torque that balances the
table's operating point, and the secants a, d of ``torque_secants``: four rules.

The full-load model: pitch control at constant torque, premises in rotor speed, pitch and wind.

    e'       = a e + b delta_beta + d (v - v_0)            e = omega - omega*
    delta_beta' = (delta_ref - delta_beta) / tau_beta      delta_beta = beta - beta*(v_0)
    x_I'     = -e                                          x_I = int (omega_ref - omega) dt

with omega_ref = omega* (rated, or the de-rated set-point), v_0 the wind estimate (constant; a
moving estimate adds -beta*'(v_0) v_0' to the second line), and the secants a, b, d of
``torque_secants``: eight rules.  The generator torque is the one that balances the table's
operating point; what an emitted table leaves of rated torque is a residual of the loop, not of
this model.

Where the model may begin.  Near rated wind pitch has little authority: on the quasi-steady
surface of the NREL 5-MW turbine dT_r/dbeta / J at the trim is -0.06 at 11.45 m/s and -0.32 at
12 m/s, and at small pitch and lower wind it changes sign.  A vertex with b >= 0 cannot be
stabilised by pitch.  The default range therefore begins at rated wind plus the wind band, so that
every wind of the band is above rated; with the default bands b <= -0.15 1/s^2/rad there.

Telescoping secants of the rotor torque around the trim at the wind estimate.

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

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Unpack

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.equations.derivation_step import Step
from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Range
from takagi.models.intervals.interval import Number, exact
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise, round_outward
from takagi.models.turbine.data import Turbine, rotor_torque, rotor_torque_gradient
from takagi.models.turbine.operating_band import (
    BANDS,
    Bands,
    OperatingBand,
    Slope,
    exact_inertia,
    operating_band,
    slope_range,
)
from takagi.models.turbine.trim import rated_wind, reference_speed

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


LOWEST_WIND_STEP = 0.05  # m/s


def partial_load_model(
    turbine: Turbine,
    *,
    wind_range: tuple[float, float] | None = None,
    tolerance: Number = "0.02",
    **bands: Unpack[Bands],
) -> TSModel:
    """Return e' = a e + d w - (n_g/J) dT, x_I' = -e as four rules, exact over the band.

    States: rotor speed error [rad/s], integral of speed deficit [rad]; input: generator torque
    deviation, high-speed shaft [N m]; disturbance: wind deviation w = v - v_0 [m/s].  Premises a
    (rotor speed, wind) and d (wind); ``model.premise_values(rotor_speed=, wind=, wind_estimate=)``
    evaluates them.

    Parameters
    ----------
    wind_range : wind estimates covered [m/s]; None takes from ``lowest_wind``, where the band
        just fits into the coefficient table, to rated wind.
    tolerance : excess of a bound, as a share of the premise's range.
    bands : see ``Bands``; pitch stays at the trim.

    Raises
    ------
    ModelError : a range or band that is empty, negative or leaves the coefficient table.

    Source: Schulte (2024), section II-B (scheme); the bounds are proved here.
    """
    around: Bands = {**BANDS, **bands, "pitch_band": 0}
    rated = rated_wind(turbine, speed_setpoint=bands.get("speed_setpoint"))
    # Rounded down, so that no node of the table is above rated wind.
    span = wind_range or (lowest_wind(turbine, **around), math.floor(rated * 1e6) / 1e6)
    band = operating_band(turbine, span, **around)
    if any(band.pitch > turbine.pitch_min):
        raise ModelError(
            f"{turbine.name}: the wind range up to {band.wind[-1]:.6g} m/s reaches into full load, "
            f"where pitch is not at its smallest; end it at or below rated wind, {rated:.6g} m/s"
        )
    share = exact(tolerance)
    premises = (
        secant_premise(band, "speed", with_pitch=False, tolerance=share),
        secant_premise(band, "wind", with_pitch=False, tolerance=share),
    )
    return region_model(_partial_load_region(turbine), band, premises, name="partial load")


def lowest_wind(turbine: Turbine, **bands: Unpack[Bands]) -> float:
    """Return the lowest wind, in steps of 0.05 m/s from cut-in, whose band fits into the table.

    The binding end is lambda = (omega* + speed band) R / (v - wind band): at low wind the minimum
    speed keeps lambda high.

    Raises
    ------
    ModelError : at no wind below rated does the band fit.
    """
    e, w = (float(exact(bands[name])) for name in ("speed_band", "wind_band"))
    speed_setpoint = bands.get("speed_setpoint")
    largest = turbine.torque.x_range[1]
    rated = rated_wind(turbine, speed_setpoint=speed_setpoint)
    for step in range(int((rated - turbine.cut_in) / LOWEST_WIND_STEP) + 1):
        v = round(turbine.cut_in + step * LOWEST_WIND_STEP, 9)
        speed = reference_speed(turbine, v, speed_setpoint=speed_setpoint)
        if v > w and (speed + e) * turbine.rotor_radius / (v - w) <= largest:
            return v
    raise ModelError(
        f"{turbine.name}: a speed band of {e:.4g} rad/s with a wind band of {w:.4g} m/s fits into "
        f"the coefficient table (tip-speed ratio up to {largest:.4g}) at no wind below rated; "
        "narrow a band"
    )


def _partial_load_region(turbine: Turbine) -> RegionalPlant:
    """Return the plant and its factored form in symbols, T_r an undefined function."""
    import sympy as sp

    from takagi.models.equations.equations import Equations, Factored

    torque = torque_symbols(with_pitch=False)
    integral, command, trim_torque = sp.symbols(r"x_I \delta_T T^*", real=True)
    gear = sp.Symbol("n_g", positive=True)
    J, e, w = torque.inertia, torque.speed_error, torque.wind_deviation
    balance = {trim_torque: torque.trim / gear}
    acceleration = ((torque.point - gear * (trim_torque + command)) / J).subs(balance)
    plant = Equations(
        f=(acceleration, -e),
        states=(e, integral),
        inputs=(command,),
        disturbances=(w,),
        outputs=(),
        units={},
    )
    matrices = {
        "A": sp.Matrix([[torque.secant("a"), 0], [-1, 0]]),
        "B": sp.Matrix([[-gear / J], [0]]),
        "C": sp.zeros(0, 2),
        "D": sp.zeros(0, 1),
        "E": sp.Matrix([[torque.secant("d")], [0]]),
    }
    constants = {gear: exact(turbine.gear_ratio), J: exact_inertia(turbine)}
    balanced = Step(
        "The torque that balances the trim point; the input is the deviation from it.",
        rf"n_g T^* = {sp.latex(torque.trim)}",
    )
    names = {
        "states": (SPEED_ERROR, INTEGRAL),
        "inputs": ("generator torque deviation [N m]",),
        "outputs": (),
        "disturbances": (WIND_DEVIATION,),
    }
    factored = Factored(matrices, torque.secants, constants)
    return RegionalPlant(plant, factored, names, (balanced, telescoping_step(torque)))


def full_load_model(
    turbine: Turbine,
    *,
    wind_range: tuple[float, float] | None = None,
    tolerance: Number = "0.02",
    **bands: Unpack[Bands],
) -> TSModel:
    """Return the eight-rule model of pitch control above rated wind, exact over the band.

    States: rotor speed error [rad/s], pitch deviation [rad], integral of speed deficit [rad];
    input: pitch reference deviation [rad]; disturbance: wind deviation w = v - v_0 [m/s].
    Premises a (rotor speed, pitch, wind), b (pitch, wind), d (wind);
    ``model.premise_values(rotor_speed=, pitch=, wind=, wind_estimate=)`` evaluates them.

    Parameters
    ----------
    wind_range : wind estimates covered [m/s]; None takes from rated wind plus the wind band to
        cut-out (why: see the module).
    tolerance : excess of a bound, as a share of the premise's range.
    bands : see ``Bands``.

    Raises
    ------
    ModelError : a range or band that is empty, negative or leaves the coefficient table.

    Source: Schulte (2024), section II-C (scheme); the bounds are proved here.
    """
    around: Bands = {**BANDS, **bands}
    if wind_range is None:
        rated = rated_wind(turbine, speed_setpoint=bands.get("speed_setpoint"))
        wind_range = (rated + float(exact(around["wind_band"])), turbine.cut_out)
    band = operating_band(turbine, wind_range, **around)
    premises = tuple(
        secant_premise(band, slope, with_pitch=True, tolerance=exact(tolerance)) for slope in KINDS
    )
    return region_model(_full_load_region(turbine), band, premises, name="full load")


def _full_load_region(turbine: Turbine) -> RegionalPlant:
    """Return the plant and its factored form in symbols, T_r an undefined function."""
    import sympy as sp

    from takagi.models.equations.equations import Equations, Factored

    torque = torque_symbols(with_pitch=True)
    integral, command = sp.symbols(r"x_I \delta_\mathrm{ref}", real=True)
    tau = sp.Symbol(r"\tau_\beta", positive=True)
    e, p, w = torque.speed_error, torque.pitch_deviation, torque.wind_deviation
    plant = Equations(
        f=((torque.point - torque.trim) / torque.inertia, (command - p) / tau, -e),
        states=(e, p, integral),
        inputs=(command,),
        disturbances=(w,),
        outputs=(),
        units={},
    )
    a, b, d = (torque.secant(name) for name in "abd")
    matrices = {
        "A": sp.Matrix([[a, b, 0], [0, -1 / tau, 0], [-1, 0, 0]]),
        "B": sp.Matrix([[0], [1 / tau], [0]]),
        "C": sp.zeros(0, 3),
        "D": sp.zeros(0, 1),
        "E": sp.Matrix([[d], [0], [0]]),
    }
    names = {
        "states": (SPEED_ERROR, PITCH_DEVIATION, INTEGRAL),
        "inputs": ("pitch reference deviation [rad]",),
        "outputs": (),
        "disturbances": (WIND_DEVIATION,),
    }
    constants = {tau: exact(turbine.pitch_time_constant)}
    factored = Factored(matrices, torque.secants, constants)
    return RegionalPlant(plant, factored, names, (telescoping_step(torque),))
