r"""The full-load model: pitch control at constant torque, premises in rotor speed, pitch and wind.

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

from takagi.models.equations.equations import Equations, Factored
from takagi.models.intervals.interval import Number, exact
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.operating_band import operating_band
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
from takagi.models.turbine.trim import rated_wind


def full_load_model(
    turbine: Turbine,
    *,
    wind_range: tuple[float, float] | None = None,
    speed_band: Number = "0.1",
    pitch_band: Number = "0.034907",
    wind_band: Number = "0.5",
    wind_step: float = 0.25,
    speed_setpoint: float | None = None,
    tolerance: Number = "0.02",
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
    speed_band : half width in rotor speed [rad/s].
    pitch_band : half width in pitch [rad], default 2 deg; angles below the smallest pitch are not
        part of the band.
    wind_band : half width of v around its estimate [m/s].
    wind_step : distance of the trim table's nodes [m/s].
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated one.
    tolerance : excess of a bound, as a share of the premise's range.

    Raises
    ------
    ModelError : a range or band that is empty, negative or leaves the coefficient table.

    Source: Schulte (2024), section II-C (scheme); the bounds are proved here.
    """
    if wind_range is None:
        rated = rated_wind(turbine, speed_setpoint=speed_setpoint)
        wind_range = (rated + float(exact(wind_band)), turbine.cut_out)
    band = operating_band(
        turbine,
        wind_range,
        speed_band=speed_band,
        pitch_band=pitch_band,
        wind_band=wind_band,
        wind_step=wind_step,
        speed_setpoint=speed_setpoint,
    )
    premises = tuple(
        secant_premise(band, slope, with_pitch=True, tolerance=exact(tolerance)) for slope in KINDS
    )
    return region_model(_region(turbine), band, premises, name=f"{turbine.name} full load")


def _region(turbine: Turbine) -> RegionalPlant:
    """Return the plant and its factored form in symbols, T_r an undefined function."""
    import sympy as sp

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
