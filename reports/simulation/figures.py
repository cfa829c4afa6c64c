"""Figures of a simulation: the paper's six panels, and per wind the laws over one another."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine
from takagi.reports.figures.response import (
    ResponseLine,
    ScenarioRun,
    response_figure,
    scenario_figure,
)
from takagi.reports.simulation.runs import Run, Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Enough for oscillations of a second in records of a minute; the file stays below 1 MB.
POINTS = 40_000


def simulation_figures(simulation: Simulation) -> dict[str, Figure]:
    """Return the figures by a name fit for files; runs that diverged are left out.

    ``scenario`` shows all winds of one turbulence, one column a law; the others one wind each.
    """
    figures: dict[str, Figure] = {}
    finished = [run for run in simulation.runs if run.history is not None]
    if simulation.scenario == "paper" and finished:
        title = f"{simulation.turbine.name}: one turbulence, different mean winds"
        figures["scenario"] = scenario_figure(
            [_scenario_run(run, simulation.turbine) for run in finished],
            title=title,
            total_points=POINTS,
        )
    for wind in simulation.winds:
        runs = [run for run in finished if run.wind == wind.name]
        if runs:
            figures[slug(wind.name)] = _response(runs, wind, simulation.turbine)
    return figures


def slug(text: str) -> str:
    """Return the text as a file name: small letters, digits and single hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower().replace("m/s", "mps")).strip("-")


def _scenario_run(run: Run, turbine: Turbine) -> ScenarioRun:
    history = run.history
    assert history is not None
    scaled = history.per_unit(turbine)
    return ScenarioRun(
        law=run.law,
        wind_label=run.wind.split(",")[0],
        time=history.time,
        wind=history.wind,
        pitch=history.pitch,
        torque=scaled["torque"],
        rotor_speed=scaled["rotor_speed"],
        power=scaled["electrical_power"],
        tower=scaled["tower_displacement"],
    )


def _response(runs: list[Run], wind: WindSeries, turbine: Turbine) -> Figure:
    found = [(run.law, run.history) for run in runs if run.history is not None]
    lines = [ResponseLine.of(law, history) for law, history in found]
    title = f"{turbine.name}: {wind.name}"
    rated = {
        "torque": turbine.rated_torque,
        "rotor_speed": turbine.rated_rotor_speed,
        "power": turbine.rated_power,
    }
    return response_figure(found[-1][1].time, lines, title=title, rated=rated)
