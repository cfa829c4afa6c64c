"""Wind turbines: figures with their sources, aerodynamics, trim, regional models, observer.

loader, file_figures, frozen_wake    turbine files and their parts
data, derating       a turbine as a value; the same one at a lower torque set-point
aerodynamics, trim   rotor torque, power, thrust; steady operation over wind
partial_load, full_load, regional_model    the regional models, and what they share
operating_band, torque_secants, torque_slope    where they hold; secants and slopes of the torque
wind_observer        the wind observer: for design, and to run
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.turbine.aerodynamics import rotor_thrust as rotor_thrust
    from takagi.models.turbine.aerodynamics import rotor_torque as rotor_torque
    from takagi.models.turbine.aerodynamics import rotor_torque_gradient as rotor_torque_gradient
    from takagi.models.turbine.aerodynamics import tip_speed_ratio as tip_speed_ratio
    from takagi.models.turbine.data import Turbine as Turbine
    from takagi.models.turbine.derating import derated as derated
    from takagi.models.turbine.loader import load_turbine as load_turbine
    from takagi.models.turbine.loader import model_files as model_files
    from takagi.models.turbine.loader import nrel5mw as nrel5mw
    from takagi.models.turbine.operating_band import OperatingBand as OperatingBand
    from takagi.models.turbine.trim import TrimPoint as TrimPoint
    from takagi.models.turbine.trim import optimal_tip_speed_ratio as optimal_tip_speed_ratio
    from takagi.models.turbine.trim import optimal_torque_constant as optimal_torque_constant
    from takagi.models.turbine.trim import rated_wind as rated_wind
    from takagi.models.turbine.trim import reference_speed as reference_speed

__getattr__, __dir__ = lazy_names(__name__)
