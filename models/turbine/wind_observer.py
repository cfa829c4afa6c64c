r"""The Takagi-Sugeno wind observer: its error system for design, and the observer to run.

    omega' = (T_r(omega, beta, v) - n_g T) / J,     v' unknown but bounded
    observer   omegahat' = (T_r(omega, beta, vhat) - n_g T) / J + l_1 (omega - omegahat)
               vhat'     = l_2 (omega - omegahat)

With T_r(omega, beta, v) - T_r(omega, beta, vhat) = J d (v - vhat), d a secant, the errors
omega~ = omega - omegahat, v~ = v - vhat obey exactly

    omega~' = d v~ - l_1 omega~,      v~' = v' - l_2 omega~,

a Takagi-Sugeno system in the *unmeasured* premise d in [d_lower, d_upper]: two rules, no
small-gain guess.  Gains that work at both vertices work for every d in between.

Source: Gauterin, Kammerer, Kuehn, Schulte (2015), "Effective wind speed estimation: comparison
between Kalman filter and Takagi-Sugeno observer techniques", ISA Transactions (the scheme); the
error system in the secant is derived here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.equations.derivation_step import Step
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Number, exact
from takagi.models.splines.spline import scalar_surface
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import round_outward
from takagi.models.turbine.data import Turbine, rotor_torque_gradient
from takagi.models.turbine.operating_band import (
    BANDS,
    Bands,
    OperatingBand,
    operating_band,
    slope_range,
)
from takagi.models.turbine.region_models import (
    KINDS,
    RegionalPlant,
    lowest_wind,
    proved_premise,
    region_model,
    torque_secant,
)
from takagi.models.turbine.trim import trim

STATES = ("rotor speed estimation error [rad/s]", "wind estimation error [m/s]")


def wind_observer_model(
    turbine: Turbine,
    *,
    wind_range: tuple[float, float] | None = None,
    tolerance: Number = "0.05",
    **bands: Unpack[Bands],
) -> TSModel:
    """Return omega~' = d v~, v~' = w with output omega~: two vertices in the premise d.

    The gains of the observer enter as x' = (A - L C) x + E w, L = (l_1, l_2); w = v' [m/s^2].
    Exact while v and vhat are both within the wind band of one wind v_0 of the range around
    whose trim rotor speed and pitch are within their bands.
    ``model.premise_values(rotor_speed=, pitch=, wind=, wind_estimate=)`` evaluates d.

    Parameters
    ----------
    wind_range : [m/s]; None takes from ``lowest_wind`` of these bands to cut-out.
    tolerance : excess of a bound, as a share of the premise's range.
    bands : see ``Bands``.

    Raises
    ------
    ModelError : bands that leave the coefficient table, or over which more wind does not always
        give more torque (d <= 0): there wind cannot be observed from speed.
    """
    around: Bands = {**BANDS, **bands}
    span = wind_range or (lowest_wind(turbine, **around), turbine.cut_out)
    band = operating_band(turbine, span, **around)
    proved_range = slope_range(
        band, "wind", off_trim=("speed", "pitch", "wind"), tolerance=exact(tolerance)
    )
    premise = proved_premise(KINDS["wind"], proved_range, _secant_between_winds(turbine))
    if premise.lower <= 0:
        weakest = _weakest_wind(band, bands.get("speed_setpoint"))
        bounds = round_outward(proved_range.outer, digits=6)
        raise ModelError(
            f"{turbine.name}: dT_r/dv / J is only known to lie in {bounds} over winds "
            f"{band.wind_range} with these bands; it must be positive for the wind to be observed "
            f"from the rotor speed; at the trims it is least at {weakest:.4g} m/s: "
            "correct the power coefficients there, or leave these winds out by cut_in and cut_out"
        )
    return region_model(
        _error_system(),
        band,
        (premise,),
        name="wind observer error",
        source=(
            "scheme: Gauterin, Kammerer, Kuehn, Schulte (2015), effective wind speed estimation, "
            "ISA Transactions"
        ),
    )


@dataclass(frozen=True, slots=True)
class WindObserver:
    """The observer to run, with state (omegahat [rad/s], vhat [m/s]).

    Attributes
    ----------
    l1 : gain on omegahat' [1/s];  l2 : gain on vhat' [m/s^2 per rad/s].
    wind_limits : vhat is held inside [m/s]; None takes half of cut-in to 1.5 times cut-out.
        At a limit, and where the coefficient table ends, the error system above is not exact.

    Raises
    ------
    ModelError : gains that are not positive and finite, or limits that are not 0 < low < high.
    """

    turbine: Turbine
    l1: float
    l2: float
    wind_limits: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name in ("l1", "l2"):
            gain = getattr(self, name)
            if not (math.isfinite(gain) and gain > 0):
                raise ModelError(
                    f"observer gain {name} = {gain!r} was given; both error equations need a "
                    "positive finite gain"
                )
        low, high = self.limits
        if not 0 < low < high:
            raise ModelError(f"wind limits {low!r}, {high!r} m/s: 0 < low < high is needed")

    @property
    def limits(self) -> tuple[float, float]:
        """The wind limits in use [m/s]."""
        return self.wind_limits or (0.5 * self.turbine.cut_in, 1.5 * self.turbine.cut_out)

    @property
    def state_names(self) -> tuple[str, str]:
        """Names of the state's entries with units."""
        return ("estimated rotor speed [rad/s]", "estimated wind [m/s]")

    def initial_state(self, rotor_speed: float, wind: float) -> Floats:
        """Return (omegahat, vhat) for a measured speed and a first guess of the wind."""
        low, high = self.limits
        return np.array([rotor_speed, min(max(wind, low), high)])

    def wind_estimate(self, state: Floats) -> float:
        """Return vhat [m/s], held inside the limits."""
        low, high = self.limits
        return min(max(float(state[1]), low), high)

    def state_rate(self, state: Floats, rotor_speed: float, pitch: float, torque: float) -> Floats:
        """Return (omegahat', vhat') for measured speed [rad/s], pitch [rad] and torque [N m].

        torque is the generator's, on the high-speed shaft.  vhat' is zero where it would push
        vhat further past a limit.  A reading that is not a finite number moves nothing.  Outside
        the coefficient table its edge is taken: there the rate is not that of the error system.
        """
        if not math.isfinite(rotor_speed + pitch + torque):
            return np.zeros(2)
        turbine, wind = self.turbine, self.wind_estimate(state)
        # One point at a time: the vectorised torque costs thirty times as much in a time loop.
        # The table's edge is held, as with clip=True.
        c_q = scalar_surface(turbine.torque)(rotor_speed * turbine.rotor_radius / wind, pitch)
        aerodynamic = turbine.torque_constant * wind * wind * c_q
        error = rotor_speed - float(state[0])
        balance = aerodynamic - turbine.gear_ratio * torque
        wind_rate = self.l2 * error
        low, high = self.limits
        if (state[1] <= low and wind_rate < 0) or (state[1] >= high and wind_rate > 0):
            wind_rate = 0.0
        return np.array([balance / turbine.inertia + self.l1 * error, wind_rate])


def _weakest_wind(band: OperatingBand, speed_setpoint: float | None) -> float:
    """Return the wind at whose trim one more m/s gives least torque [m/s]."""
    winds = np.linspace(float(band.wind_range.lower), float(band.wind_range.upper), 201)

    def slope(wind: float) -> float:
        at = trim(band.turbine, wind, speed_setpoint=speed_setpoint)
        point = (at.rotor_speed, at.pitch, wind)
        return float(rotor_torque_gradient(band.turbine, *point, clip=True)[2])

    return float(min(winds, key=lambda wind: slope(float(wind))))


def _secant_between_winds(turbine: Turbine) -> Callable[..., float]:
    def evaluate(
        *,
        rotor_speed: ArrayLike,
        pitch: ArrayLike,
        wind: ArrayLike,
        wind_estimate: ArrayLike,
        clip: bool = False,
    ) -> Floats:
        values = np.broadcast_arrays(rotor_speed, pitch, wind, wind_estimate)
        omega, beta, v, vhat = (np.asarray(value, dtype=np.float64) for value in values)
        return torque_secant(turbine, 2, [omega, beta, v], vhat, clip=clip) / turbine.inertia

    return evaluate  # type: ignore[return-value]


def _error_system() -> RegionalPlant:
    """Return the error system without gains."""
    import sympy as sp

    from takagi.models.equations.equations import Equations, Factored

    T = sp.Function("T_r")
    omega, beta, estimate, inertia = sp.symbols(r"\omega \beta \hat{v} J", positive=True)
    speed_error, wind_error, rate, d = sp.symbols(r"\tilde{\omega} \tilde{v} w d", real=True)
    rise = T(omega, beta, estimate + wind_error) - T(omega, beta, estimate)
    plant = Equations(
        f=(rise / inertia, rate),
        states=(speed_error, wind_error),
        inputs=(),
        disturbances=(rate,),
        outputs=(speed_error,),
        units={},
    )
    matrices = {
        "A": sp.Matrix([[0, d], [0, 0]]),
        "B": sp.zeros(2, 0),
        "C": sp.Matrix([[1, 0]]),
        "D": sp.zeros(1, 0),
        "E": sp.Matrix([[0], [1]]),
    }
    names = {
        "states": STATES,
        "inputs": (),
        "outputs": (STATES[0],),
        "disturbances": ("wind rate [m/s^2]",),
    }
    gains = Step(
        "With the observer's gains, omitted in the vertices.",
        r"\dot{\tilde{\omega}} = d\,\tilde{v} - l_1 \tilde{\omega}, \qquad "
        r"\dot{\tilde{v}} = \dot{v} - l_2 \tilde{\omega}",
    )
    factored = Factored(matrices, {d: rise / (inertia * wind_error)})
    return RegionalPlant(plant, factored, names, (gains,))
