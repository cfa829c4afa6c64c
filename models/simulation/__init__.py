"""The nonlinear plant, wind, and the closed loop in time.

wind, turbulence        wind series: steps, ramps, gusts; rotor-effective turbulence
turbine_plant           the plants as values
equations, dynamics, wake    what they do in time, compiled; as functions of a plant; at rest
speed_filter            what is done to the measured speed before the law reads it
closed_loop, history    a law on a plant in a wind, and what it leaves
time_steps              samples of the law, and the plant's steps within them
baseline                the reference's own controller as a law
metrics, scenario       numbers of a record; laws side by side in the same winds
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.simulation.baseline import BaselineLaw
    from takagi.models.simulation.closed_loop import Diverged, Observer, simulate
    from takagi.models.simulation.dynamics import equilibrium_state, plant_rate
    from takagi.models.simulation.history import History
    from takagi.models.simulation.metrics import Metrics, damage_equivalent_load, measure
    from takagi.models.simulation.scenario import (
        Case,
        Result,
        paper_scenario,
        paper_winds,
        published_scenario,
        published_winds,
        run_cases,
        transition_scenario,
        transition_winds,
    )
    from takagi.models.simulation.speed_filter import SpeedFilter
    from takagi.models.simulation.turbine_plant import (
        Flag,
        Plant,
        SimulatedTurbine,
        design_plant,
        validation_plant,
    )
    from takagi.models.simulation.turbulence import same_turbulence, turbulent_wind
    from takagi.models.simulation.wind import (
        WindSeries,
        constant_wind,
        gust_wind,
        ramp_wind,
        step_wind,
    )

__all__ = [
    "BaselineLaw",
    "Case",
    "Diverged",
    "Flag",
    "History",
    "Metrics",
    "Observer",
    "Plant",
    "Result",
    "SimulatedTurbine",
    "SpeedFilter",
    "WindSeries",
    "constant_wind",
    "damage_equivalent_load",
    "design_plant",
    "equilibrium_state",
    "gust_wind",
    "measure",
    "paper_scenario",
    "paper_winds",
    "plant_rate",
    "published_scenario",
    "published_winds",
    "ramp_wind",
    "run_cases",
    "same_turbulence",
    "simulate",
    "step_wind",
    "transition_scenario",
    "transition_winds",
    "turbulent_wind",
    "validation_plant",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
