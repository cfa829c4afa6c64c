"""A simulation as files: tables, Markdown, CSV, JSON, series of runs, and figures."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.models.laws.protocol import law_words
from takagi.models.simulation.closed_loop import History
from takagi.models.simulation.turbine_plant import Flag
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine
from takagi.reports.figures.response import ResponseLine, response_figure, scenario_figure
from takagi.reports.figures.style import figure_to_png, figure_to_svg
from takagi.reports.output import csv_text, markdown_page
from takagi.reports.simulation.compiled_law import setpoints_now
from takagi.reports.simulation.laws import LAW_NAMES
from takagi.reports.simulation.runs import Run, Simulation, simulation_plant
from takagi.reports.simulation.winds import winds_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Metric -> (title, unit, decimals), in the table's order.
COLUMNS: dict[str, tuple[str, str, int]] = {
    "energy": ("energy", "kWh", 2),
    "mean_power": ("mean power", "kW", 0),
    "overspeed": ("largest overspeed", "%", 2),
    "speed_deviation": ("speed deviation", "% of rated", 2),
    "pitch_travel": ("pitch travel", "deg", 1),
    "torque_rate": ("torque rate, rms", "kN m/s", 2),
    "tower_del": ("tower DEL", "MN m", 2),
    "blade_del": ("blade DEL", "MN m", 2),
    "shaft_del": ("shaft DEL", "MN m", 3),
    "torque_change": ("largest torque change in 0.4 s", "kN m", 2),
    "peak_power": ("peak power", "% of rated", 1),
    "both_active": ("actuators fight", "% of time", 1),
}
WAKE_WORDS = {
    "equilibrium": "a wake that follows at once (coefficient tables)",
    "dynamic": "a wake that needs time, so that torque and thrust first answer by more",
}
# State that a part brings with it, and the part in words.
PART_WORDS = {
    "tower": "tower fore-aft mode",
    "blade-tip": "first collective flap mode",
    "generator speed": "drivetrain torsion",
    "generator torque": "a lag of the generator torque",
    "azimuth": "a ripple of the wind three times a turn",
    "filtered": "a low-pass on the measured speed",
}
# Sample distance of the written series [s]; finer samples add nothing about the loop.
SERIES_STEP = 0.1


def table_rows(simulation: Simulation) -> list[dict[str, Any]]:
    """Return one row per run: law, wind, the metrics by field (None if diverged), remarks, flags.

    Rows are grouped by wind, so that the laws stand under one another.
    """
    rows = []
    for wind in simulation.winds:
        rows += [_row(run) for run in simulation.runs if run.wind == wind.name]
    return rows


def notes(simulation: Simulation) -> list[str]:
    """Return what must be known to read the table: a line per law, then per remarkable run."""
    lines = [f"{law_words(name)}: {LAW_NAMES.get(name, '')}." for name in simulation.chosen.laws]
    for name, law in simulation.chosen.laws.items():
        if asked := setpoints_now(law):
            speed, power = asked["speed_setpoint"], asked["power_setpoint"]
            lines.append(f"{law_words(name)}: at most {speed:.5g} rad/s and {power / 1e3:.5g} kW.")
    for run in simulation.runs:
        if run.remarks():
            lines.append(f"{law_words(run.law)} in {run.wind}: {'; '.join(run.remarks())}.")
    return lines


def as_markdown(simulation: Simulation, *, figures: Sequence[str] = ()) -> str:
    """Return the table with its explanations; ``figures`` are file names that it shows."""
    about = winds_words(simulation.asked)
    return markdown_page(
        "simulation",
        "summary",
        simulation=simulation,
        about=about[0].upper() + about[1:],
        plant=_plant_words(simulation),
        titles=[f"{title} [{unit}]" for title, unit, _ in COLUMNS.values()],
        rows=[
            [row["wind"], law_words(row["law"]), *(rounded_text(row, name) for name in COLUMNS)]
            for row in table_rows(simulation)
        ],
        notes=notes(simulation),
        figures=figures,
    )


def _plant_words(simulation: Simulation) -> str:
    plant = simulation_plant(simulation.turbine, simulation.parts)
    parts = [words for state, words in PART_WORDS.items() if plant.index(state) is not None]
    return ", ".join([WAKE_WORDS[simulation.parts.wake], *parts])


def rounded_text(row: dict[str, Any], name: str) -> str:
    """Return one metric of a row as the table shows it; a dash where the loop diverged."""
    value = row[name]
    return "–" if value is None else f"{value:.{COLUMNS[name][2]}f}"


def as_csv(simulation: Simulation) -> str:
    """Return the rows with all digits; units in the header, remarks in the last column."""
    titles = [f"{title} [{unit}]" for title, unit, _ in COLUMNS.values()]
    rows = (
        (
            *(row["wind"], row["law"]),
            *("" if row[name] is None else repr(row[name]) for name in COLUMNS),
            "; ".join(row["remarks"]),
        )
        for row in table_rows(simulation)
    )
    return csv_text(["wind", "law", *titles, "remarks"], rows)


def as_json(simulation: Simulation, *, files: Sequence[str] = ()) -> str:
    """Return winds, units and rows for machines; the same simulation gives the same text."""
    content = {
        "turbine": simulation.turbine.name,
        "asked": list(simulation.asked),
        "wake": simulation.parts.wake,
        "without": list(simulation.parts.without),
        "speed_filter": simulation.parts.speed_filter,
        "ripple": simulation.parts.ripple,
        "sample_time": simulation.sample_time,
        "computation_time": simulation.computation_time,
        "winds": [
            {"name": wind.name, "duration": wind.duration, "mean": float(np.mean(wind.speed))}
            for wind in simulation.winds
        ],
        "laws": {name: LAW_NAMES.get(name, "") for name in simulation.chosen.laws},
        "setpoints": {name: setpoints_now(law) for name, law in simulation.chosen.laws.items()},
        "units": {
            "speed_setpoint": "rad/s",
            "power_setpoint": "W",
            "duration": "s",
            "speed_filter": "rad/s",
            "ripple": "-",
            "sample_time": "s",
            "computation_time": "s",
            **{name: unit for name, (_, unit, _) in COLUMNS.items()},
        },
        "rows": table_rows(simulation),
        "files": list(files),
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def series_csv(history: History) -> str:
    """Return the record over time in SI units (no degrees): wind, speed, pitch, torque, ..."""
    step = float(history.time[1] - history.time[0])
    stride = max(1, round(SERIES_STEP / step))
    columns = {
        "time [s]": history.time,
        "wind [m/s]": history.wind,
        "wind estimate [m/s]": history.wind_estimate,
        "rotor speed [rad/s]": history.rotor_speed,
        "pitch [rad]": history.pitch,
        "pitch reference [rad]": history.pitch_reference,
        "generator torque [N m]": history.torque,
        "electrical power [W]": history.electrical_power,
        "thrust [N]": history.thrust,
        "tower-top displacement [m]": history.tower_displacement,
        "tower-base moment [N m]": history.tower_moment,
    }
    table = np.column_stack(list(columns.values()))[::stride]
    return csv_text(columns, ([f"{value:.7g}" for value in row] for row in table.tolist()))


def _row(run: Run) -> dict[str, Any]:
    row: dict[str, Any] = {"wind": run.wind, "law": run.law, "diverged": run.diverged}
    row |= {name: None for name in COLUMNS}
    if run.metrics is not None:
        row |= asdict(run.metrics)
        row["flags"] = {flag.name.lower(): run.flags[flag] for flag in Flag if flag.name}
    row["remarks"] = list(run.remarks())
    return row


# Enough for oscillations of a second in records of a minute; the file stays below 1 MB.
POINTS = 40_000


def simulation_figures(simulation: Simulation) -> dict[str, Figure]:
    """Return the figures by a name fit for files; runs that diverged are left out.

    ``scenario`` shows all winds of one seed, one column a law; the others one wind each.
    """
    figures: dict[str, Figure] = {}
    finished = [(run, run.history) for run in simulation.runs if run.history is not None]
    seeds = {wind.name.partition(", seed ")[2] for wind in simulation.winds}
    if finished and len(simulation.winds) > 1 and len(seeds) == 1 and "" not in seeds:
        title = f"{simulation.turbine.name}: one turbulence, different mean winds"
        figures["scenario"] = scenario_figure(
            [(law_words(run.law), run.wind.split(",")[0], history) for run, history in finished],
            simulation.turbine,
            title=title,
            total_points=POINTS,
        )
    for wind in simulation.winds:
        runs = [(run.law, history) for run, history in finished if run.wind == wind.name]
        if runs:
            figures[slug(wind.name)] = _response(runs, wind, simulation.turbine)
    return figures


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Return each name of a wind up to its first comma, or all of it if two are then the same."""
    starts = {name: name.partition(",")[0] for name in names}
    shared = list(starts.values())
    return {name: start if shared.count(start) == 1 else name for name, start in starts.items()}


def slug(text: str) -> str:
    """Return the text as a file name: small letters, digits and single hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower().replace("m/s", "mps")).strip("-")


def _response(runs: list[tuple[str, History]], wind: WindSeries, turbine: Turbine) -> Figure:
    lines = [ResponseLine.of(law_words(law), history) for law, history in runs]
    title = f"{turbine.name}: {wind.name}"
    rated = {
        "torque": turbine.rated_torque,
        "rotor_speed": turbine.rated_rotor_speed,
        "power": turbine.rated_power,
    }
    return response_figure(runs[-1][1].time, lines, title=title, rated=rated)


def simulation_files(simulation: Simulation) -> dict[str, bytes | str]:
    """Return file name -> content: summary, tables, figures as SVG and PNG, series.

    summary.md, simulation.csv, simulation.json; figures/NAME.svg and .png; series/LAW-WIND.csv.
    The same simulation gives the same bytes.
    """
    figures: dict[str, bytes | str] = {}
    for name, figure in simulation_figures(simulation).items():
        described = f"{simulation.turbine.name}: {name}"
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
