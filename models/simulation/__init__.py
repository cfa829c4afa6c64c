"""The nonlinear plant, wind, and the closed loop in time.

wind, turbulence        wind series: steps, ramps, gusts; rotor-effective turbulence
turbine_plant           the plants as values
equations, dynamics     what they do in time, compiled; as functions of a plant
speed_filter            what is done to the measured speed before the law reads it
closed_loop, history    a law on a plant in a wind, and what it leaves
time_steps              samples of the law, and the plant's steps within them
baseline                the reference's own controller as a law
metrics, scenario       numbers of a record; one law in one wind, and the paper's winds
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.simulation.baseline import BaselineLaw as BaselineLaw
    from takagi.models.simulation.closed_loop import Diverged as Diverged
    from takagi.models.simulation.closed_loop import simulate as simulate
    from takagi.models.simulation.dynamics import equilibrium_state as equilibrium_state
    from takagi.models.simulation.dynamics import loads as loads
    from takagi.models.simulation.dynamics import plant_derivative as plant_derivative
    from takagi.models.simulation.dynamics import plant_rate as plant_rate
    from takagi.models.simulation.history import History as History
    from takagi.models.simulation.metrics import damage_equivalent_load as damage_equivalent_load
    from takagi.models.simulation.metrics import measure as measure
    from takagi.models.simulation.scenario import Case as Case
    from takagi.models.simulation.scenario import Result as Result
    from takagi.models.simulation.scenario import published_winds as published_winds
    from takagi.models.simulation.scenario import run_case as run_case
    from takagi.models.simulation.speed_filter import SpeedFilter as SpeedFilter
    from takagi.models.simulation.turbine_plant import Flag as Flag
    from takagi.models.simulation.turbine_plant import SimulatedTurbine as SimulatedTurbine
    from takagi.models.simulation.turbine_plant import design_plant as design_plant
    from takagi.models.simulation.turbine_plant import validation_plant as validation_plant
    from takagi.models.simulation.turbulence import same_turbulence as same_turbulence
    from takagi.models.simulation.turbulence import turbulent_wind as turbulent_wind
    from takagi.models.simulation.wind import WindSeries as WindSeries
    from takagi.models.simulation.wind import constant_wind as constant_wind
    from takagi.models.simulation.wind import gust_wind as gust_wind
    from takagi.models.simulation.wind import ramp_wind as ramp_wind
    from takagi.models.simulation.wind import step_wind as step_wind

__getattr__, __dir__ = lazy_names(__name__)
