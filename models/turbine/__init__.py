"""Wind turbines: figures with their sources, aerodynamics, trim, regional models, observer.

loader, file_figures, frozen_wake    turbine files and their parts
data, derating       a turbine as a value; the same one at a lower torque set-point
aerodynamics, trim   rotor torque, power, thrust; steady operation over wind
partial_load, full_load, regional_model    the regional models, and what they share
operating_band, torque_secants, torque_slope    where they hold; secants and slopes of the torque
wind_observer        the wind observer: for design, and to run
wind_estimators      a Kalman filter and an immersion-and-invariance estimator, beside it
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.turbine.aerodynamics import (
        rotor_power,
        rotor_thrust,
        rotor_torque,
        rotor_torque_gradient,
        tip_speed_ratio,
    )
    from takagi.models.turbine.data import Baseline, BaselineController, Figure, FrozenWake, Turbine
    from takagi.models.turbine.derating import derated
    from takagi.models.turbine.loader import load_turbine, model_files, nrel5mw
    from takagi.models.turbine.operating_band import OperatingBand
    from takagi.models.turbine.trim import (
        TrimPoint,
        optimal_tip_speed_ratio,
        optimal_torque_constant,
        rated_wind,
        reference_speed,
    )

__all__ = [
    "Baseline",
    "BaselineController",
    "Figure",
    "FrozenWake",
    "OperatingBand",
    "TrimPoint",
    "Turbine",
    "derated",
    "load_turbine",
    "model_files",
    "nrel5mw",
    "optimal_tip_speed_ratio",
    "optimal_torque_constant",
    "rated_wind",
    "reference_speed",
    "rotor_power",
    "rotor_thrust",
    "rotor_torque",
    "rotor_torque_gradient",
    "tip_speed_ratio",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
