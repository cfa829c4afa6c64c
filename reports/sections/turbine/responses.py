"""Step, gust and turbulence responses of the nonlinear loop, beside the reference controller."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.laws.protocol import law_words
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.reports.figures.response import response_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.page.text import CaptionedFigure, Section, Table, powers, table, with_decimals
from takagi.reports.simulation.measured_loop import TURBULENT_DURATION, DesignRun, measured_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from takagi.certificates.design.turbine.result import TurbineDesign

# Metric -> its words and unit, and whether a law's value is clearly worse than the reference's.
WORSE: dict[str, tuple[str, str, Callable[[float, float], bool]]] = {
    "overspeed": ("Overspeed", "%", lambda law, reference: law > max(reference, 0.0) + 1.0),
    "tower_del": ("Tower load", "MN m", lambda law, reference: law > 1.05 * reference),
    "pitch_travel": ("Pitch travel", "°", lambda law, reference: law > 1.05 * reference + 1.0),
    "energy": ("Energy", "kWh", lambda law, reference: law < 0.995 * reference),
}


def responses_section(design: TurbineDesign) -> Section:
    """Return the section with the simulated responses."""
    plant, measured = validation_plant(design.turbine), measured_loop(design)
    return Section(
        "responses",
        "Responses",
        {
            "figures": [_figure(design, name, run) for name, run in measured.drawn.items()],
            "table": _table(measured.runs),
            "worse": [words for name in WORSE if (words := _worse(measured.runs, name))],
            "torque_rate": with_decimals(plant.torque_rate_limit / 1e3, 0),
            "pitch_rate": with_decimals(float(np.degrees(plant.pitch_rate_limit)), 0),
            "turbulent": f"{TURBULENT_DURATION:g}",
            "reference": design.turbine.baseline is not None,
        },
    )


def _worse(runs: Sequence[DesignRun], metric: str) -> str:
    """Return where a metric is clearly worse than the reference controller's; "" for nowhere."""
    name, unit, is_worse = WORSE[metric]
    worse = []
    for run in runs:
        if run.reference is not None:
            law, reference = (
                getattr(result.metrics, metric) for result in (run.law, run.reference)
            )
            if is_worse(law, reference):
                worse.append(f"{powers(run.words)} ({law:.4g} against {reference:.4g} {unit})")
    return f"{name}: {', '.join(worse)}." if worse else ""


def response_drawing(design: TurbineDesign, run: DesignRun) -> Figure:
    """Return the run over time, beside the reference controller's where there is one."""
    turbine = design.turbine
    lines = [result.line for result in (run.law, run.reference) if result and result.line]
    speed = design.settings.speed_setpoint or turbine.rated_rotor_speed
    rated = {"rotor_speed": speed, "torque": turbine.rated_torque}
    return response_figure(run.time, lines, rated=rated)


def response_words(run: DesignRun) -> str:
    """Return the caption of a run: the wind, and the overspeed of each law."""
    sentence = f"Overspeed {with_decimals(run.law.metrics.overspeed, 1)} %"
    if run.reference:
        reference = with_decimals(run.reference.metrics.overspeed, 1)
        sentence += f", reference controller {reference} %"
    return f"{powers(run.words).capitalize()}. {sentence}. Dotted: rated."


def _figure(design: TurbineDesign, name: str, run: DesignRun) -> CaptionedFigure:
    return captioned_figure(
        response_drawing(design, run),
        f"response-{name}",
        "response",
        words=response_words(run),
        wind=powers(run.words),
    )


def _table(runs: Sequence[DesignRun]) -> Table:
    rows = []
    for run in runs:
        for result in filter(None, (run.law, run.reference)):
            of_design = result is run.law
            rows.append(
                (
                    run.words,
                    law_words(result.label),
                    with_decimals(result.metrics.energy, 1),
                    with_decimals(result.metrics.overspeed, 1),
                    with_decimals(result.metrics.pitch_travel, 1),
                    with_decimals(result.metrics.tower_del, 1),
                    with_decimals(100 * run.share_inside if of_design else float("nan"), 0),
                )
            )
    return table("runs", rows)
