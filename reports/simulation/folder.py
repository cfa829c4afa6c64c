"""All files of a simulation, by file name."""

from __future__ import annotations

from takagi.reports.figures.style import figure_to_png, figure_to_svg
from takagi.reports.simulation.figures import simulation_figures, slug
from takagi.reports.simulation.runs import Simulation
from takagi.reports.simulation.tables import as_csv, as_json, as_markdown, series_csv


def simulation_files(simulation: Simulation) -> dict[str, bytes | str]:
    """Return file name -> content: summary, tables, figures as SVG and PNG, series.

    summary.md, simulation.csv, simulation.json; figures/NAME.svg and .png; series/LAW-WIND.csv.
    The same simulation gives the same bytes.
    """
    figures: dict[str, bytes | str] = {}
    for name, figure in simulation_figures(simulation).items():
        described = f"{simulation.turbine.name}, scenario {simulation.scenario}: {name}"
        # The first writing settles the layout for the second.
        svg = figure_to_svg(figure, name=f"figure-{name}", description=described)
        figures[f"figures/{name}.svg"] = svg + "\n"
        figures[f"figures/{name}.png"] = figure_to_png(figure, dpi=144)
    series = {
        f"series/{slug(run.law)}-{slug(run.wind)}.csv": series_csv(run.history)
        for run in simulation.runs
        if run.history is not None
    }
    shown = [name for name in figures if name.endswith(".svg")]
    names = ["summary.md", "simulation.csv", "simulation.json", *figures, *series]
    return {
        "summary.md": as_markdown(simulation, figures=shown),
        "simulation.csv": as_csv(simulation),
        "simulation.json": as_json(simulation, files=names),
        **figures,
        **series,
    }
