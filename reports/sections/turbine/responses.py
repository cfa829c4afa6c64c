"""Step and gust responses of the nonlinear loop across rated wind, compared with the baseline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.turbine.result import claim_summary
from takagi.models.laws.protocol import Law, law_words
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.scenario import Case, Result, run_case
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import WindSeries, gust_wind, ramp_wind, step_wind
from takagi.models.turbine.trim import rated_wind
from takagi.reports.figures.response import ResponseLine, response_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.page.text import (
    CaptionedFigure,
    Section,
    Table,
    powers,
    significant,
    with_decimals,
)

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

STEP = 1.5
DURATION, BEGIN = 90.0, 15.0
NAMES = ("step-up", "step-down", "gust", "ramp")


def responses_section(design: TurbineDesign) -> Section:
    """Return the section with the simulated responses."""
    turbine = design.turbine
    laws: dict[str, Law] = {design.law.name: design.law}
    if turbine.baseline is not None:
        laws["baseline"] = BaselineLaw(turbine)
    winds = _winds(design)
    plant, observer = validation_plant(turbine), design.observer.observer
    own = replace(plant, speed_filter=design.speed_filter)
    plants = {design.law.name: own, "baseline": plant}
    cases = [
        Case(name, plants[name], law, wind, observer)
        for wind in winds
        for name, law in laws.items()
    ]
    results = [run_case(case) for case in cases]
    groups = [results[k : k + len(laws)] for k in range(0, len(results), len(laws))]
    return Section(
        "responses",
        "Responses across rated wind",
        {
            "figures": [
                _figure(design, name, group) for name, group in zip(NAMES, groups, strict=True)
            ],
            "table": _table(design, results),
            "torque_rate": with_decimals(plant.torque_rate_limit / 1e3, 0),
            "pitch_rate": with_decimals(float(np.degrees(plant.pitch_rate_limit)), 0),
            "baseline": turbine.baseline is not None,
            "class_known": claim_summary(design) is not None,
        },
    )


def _winds(design: TurbineDesign) -> tuple[WindSeries, ...]:
    setpoint = design.settings.speed_setpoint
    rated = round(rated_wind(design.turbine, speed_setpoint=setpoint), 2)
    low, high = round(rated - STEP, 2), round(rated + STEP, 2)
    radius = design.turbine.rotor_radius
    return (
        step_wind(low, high, DURATION, begin=BEGIN),
        step_wind(high, low, DURATION, begin=BEGIN),
        gust_wind(rated, DURATION, rotor_radius=radius, begin=BEGIN),
        ramp_wind(low - 2, high + 2, DURATION, rate=0.2, begin=BEGIN),
    )


def _figure(design: TurbineDesign, name: str, results: Sequence[Result]) -> CaptionedFigure:
    turbine = design.turbine
    lines = [ResponseLine.of(law_words(result.label), result.history) for result in results]
    speed = design.settings.speed_setpoint or turbine.rated_rotor_speed
    rated = {"rotor_speed": speed, "torque": turbine.rated_torque}
    wind = powers(results[0].wind_name).capitalize()
    return captioned_figure(
        response_figure(results[0].history.time, lines, rated=rated),
        f"response-{name}",
        caption=f"{wind}: {' and '.join(line.label for line in lines)} on the validation "
        "plant, wind observer in the loop. Dotted: rated.",
        alternative=f"Time responses of wind, pitch, torque, rotor speed and power: {wind}",
    )


def _table(design: TurbineDesign, results: Sequence[Result]) -> Table:
    return Table(
        "The same runs in numbers",
        (
            ("wind", ""),
            ("law", ""),
            ("energy", "kWh"),
            ("largest overspeed", "%"),
            ("pitch travel", "°"),
            ("both active", "% of time"),
            ("tower DEL", "MN m"),
            ("|v − v<sub>s</sub>| reached", "m/s"),
            ("|v<sub>s</sub>'| reached", "m/s²"),
            ("time inside the class", "%"),
        ),
        tuple(
            (
                result.wind_name,
                law_words(result.label),
                with_decimals(result.metrics.energy, 2),
                with_decimals(result.metrics.overspeed, 2),
                with_decimals(result.metrics.pitch_travel, 1),
                with_decimals(result.metrics.both_active, 1),
                with_decimals(result.metrics.tower_del, 2),
                *_class_use(design, result),
            )
            for result in results
        ),
        note="Both active: pitch above fine pitch while torque is below rated. The last three "
        "columns compare with the certified wind class; outside it the run is a simulation only.",
    )


def _class_use(design: TurbineDesign, result: Result) -> tuple[str, str, str]:
    """Return the largest |v - v_s| and |v_s'|, and the share of time in the certified class."""
    summary, law = claim_summary(design), design.effort_sharing_law
    if summary is None or law is None or result.label != law.name:
        return "–", "–", "–"
    history = result.history
    schedule = history.law_states[:, 1] if law.wind_filter > 0 else history.wind_estimate
    error = np.abs(history.wind - schedule)
    rate = np.abs(np.gradient(schedule, history.time))
    cell = np.clip(np.searchsorted(summary.edges, schedule) - 1, 0, len(summary.winds) - 1)
    fine = np.array(summary.proved)[cell]
    inside = fine & (error <= np.array(summary.wind_error)[cell])
    inside &= rate <= np.array(summary.wind_rate)[cell]
    return (
        significant(error.max()),
        significant(rate.max()),
        with_decimals(100 * float(inside.mean()), 0),
    )
