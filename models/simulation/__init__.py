"""The nonlinear plant, wind, and the closed loop in time.

wind, turbulence        wind series: steps, ramps, gusts; rotor-effective turbulence
turbine_plant, dynamics, wake    the plants as values, and their right-hand sides
closed_loop, history    a law on a plant in a wind, and what it leaves
time_steps              samples of the law, and the plant's steps within them
baseline                the reference's own controller as a law
metrics, scenario       numbers of a record; laws side by side in the same winds
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.simulation.baseline import BaselineLaw
    from takagi.models.simulation.closed_loop import Diverged, Observer, simulate
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
    "WindSeries",
    "constant_wind",
    "damage_equivalent_load",
    "design_plant",
    "gust_wind",
    "measure",
    "paper_scenario",
    "paper_winds",
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

_HOME = {
    "BaselineLaw": "baseline",
    "Case": "scenario",
    "Diverged": "closed_loop",
    "Flag": "turbine_plant",
    "History": "history",
    "Metrics": "metrics",
    "Observer": "closed_loop",
    "Plant": "turbine_plant",
    "Result": "scenario",
    "SimulatedTurbine": "turbine_plant",
    "WindSeries": "wind",
    "constant_wind": "wind",
    "damage_equivalent_load": "metrics",
    "design_plant": "turbine_plant",
    "gust_wind": "wind",
    "measure": "metrics",
    "paper_scenario": "scenario",
    "paper_winds": "scenario",
    "published_scenario": "scenario",
    "published_winds": "scenario",
    "ramp_wind": "wind",
    "run_cases": "scenario",
    "same_turbulence": "turbulence",
    "simulate": "closed_loop",
    "step_wind": "wind",
    "transition_scenario": "scenario",
    "transition_winds": "scenario",
    "turbulent_wind": "turbulence",
    "validation_plant": "turbine_plant",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.models.simulation.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
