"""The models of partial and of full load.

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
"""

from __future__ import annotations

import math
from typing import Unpack

from takagi.models.equations.derivation_step import Step
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Number, exact
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import BANDS, Bands, exact_inertia, operating_band
from takagi.models.turbine.regional_model import (
    INTEGRAL,
    KINDS,
    PITCH_DEVIATION,
    SPEED_ERROR,
    WIND_DEVIATION,
    RegionalPlant,
    region_model,
    secant_premise,
    telescoping_step,
    torque_symbols,
)
from takagi.models.turbine.trim import rated_wind, reference_speed

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
