"""A turbine's design in steps, gusts and turbulence, beside the reference controller.

Simulated on the validation plant with the wind observer in the loop: nothing here is proved.  Each
run says when it is inside the proved wind limits, since its bounds hold there alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.design.turbine.result import claim_summary
from takagi.models.arrays import Floats
from takagi.models.laws.protocol import Law
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import History
from takagi.models.simulation.scenario import Case, Result, run_case
from takagi.models.simulation.turbine_plant import SimulatedTurbine, validation_plant
from takagi.models.simulation.wind import (
    REFERENCE_INTENSITY,
    WindSeries,
    gust_wind,
    ramp_wind,
    same_turbulence,
    step_wind,
)
from takagi.models.turbine.trim import rated_wind

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

STEP = 1.5
DURATION, BEGIN = 90.0, 15.0
# Further gusts, by their distance from rated wind [m/s]; they last this long [s].
GUSTS = (-2.5, 2.5, 4.5, 8.5)
GUST_DURATION, GUST_BEGIN = 40.0, 5.0
# Means of class-B turbulence [m/s], simulated for this long [s], with one seed.
TURBULENT = (5.0, 8.0, 11.0, 14.0, 19.0)
TURBULENT_DURATION, SEED = 200.0, 1


@dataclass(frozen=True, slots=True, eq=False)
class DesignRun:
    """One wind: the design's law, and the reference controller where the turbine has one.

    Attributes
    ----------
    wind : the wind over time.
    law, reference : the simulated loops.
    schedule : of the design's law, its schedule wind v_s (n,) [m/s]; else the wind estimate.
    inside : whether the law's loop is within the proved wind limits, (n,); None without them.
    """

    wind: WindSeries
    law: Result
    reference: Result | None
    schedule: Floats
    inside: NDArray[np.bool_] | None

    @property
    def words(self) -> str:
        """The wind in words, e.g. ``"gust at 11.45 m/s"``."""
        return self.wind.name.partition(",")[0].replace("turbulent", "turbulence of")

    @property
    def share_inside(self) -> float:
        """Share of time within the proved wind limits [-]; nan without them."""
        return float("nan") if self.inside is None else float(self.inside.mean())


@lru_cache(maxsize=2)
def step_and_gust_runs(design: TurbineDesign) -> dict[str, DesignRun]:
    """Return step-up, step-down, gust and ramp across rated wind."""
    rated, radius = _rated(design), design.turbine.rotor_radius
    low, high = round(rated - STEP, 2), round(rated + STEP, 2)
    winds = {
        "step-up": step_wind(low, high, DURATION, begin=BEGIN),
        "step-down": step_wind(high, low, DURATION, begin=BEGIN),
        "gust": gust_wind(rated, DURATION, rotor_radius=radius, begin=BEGIN),
        "ramp": ramp_wind(low - 2, high + 2, DURATION, rate=0.2, begin=BEGIN),
    }
    return dict(zip(winds, _runs(design, winds.values()), strict=True))


@lru_cache(maxsize=2)
def gust_runs(design: TurbineDesign) -> dict[float, DesignRun]:
    """Return mean wind [m/s] -> the extreme operating gust there, rated wind among them."""
    turbine, rated = design.turbine, _rated(design)
    means = [round(rated + distance, 2) for distance in GUSTS]
    means = [mean for mean in means if turbine.cut_in < mean < turbine.cut_out]
    radius = turbine.rotor_radius
    winds = [gust_wind(v, GUST_DURATION, rotor_radius=radius, begin=GUST_BEGIN) for v in means]
    found = dict(zip(means, _runs(design, winds), strict=True))
    return dict(sorted({rated: step_and_gust_runs(design)["gust"], **found}.items()))


@lru_cache(maxsize=2)
def turbulent_runs(design: TurbineDesign) -> dict[float, DesignRun]:
    """Return mean wind [m/s] -> turbulence of class B, sigma_1 = 0.14 (0.75 V + 5.6 m/s)."""
    turbine = design.turbine
    means = [mean for mean in TURBULENT if turbine.cut_in < mean < turbine.cut_out]
    winds = [
        same_turbulence(
            [mean],
            REFERENCE_INTENSITY * (0.75 + 5.6 / mean),
            TURBULENT_DURATION,
            SEED,
            rotor_radius=turbine.rotor_radius,
            hub_height=turbine.hub_height,
            period=600.0,
        )[0]
        for mean in means
    ]
    return dict(zip(means, _runs(design, winds), strict=True))


def every_run(design: TurbineDesign) -> list[DesignRun]:
    """Return all runs of a design, each wind once."""
    parts = (step_and_gust_runs(design), gust_runs(design), turbulent_runs(design))
    return list(dict.fromkeys(run for part in parts for run in part.values()))


def _rated(design: TurbineDesign) -> float:
    return round(rated_wind(design.turbine, speed_setpoint=design.settings.speed_setpoint), 2)


def _runs(design: TurbineDesign, winds: Iterable[WindSeries]) -> list[DesignRun]:
    plant = validation_plant(design.turbine)
    filtered = replace(plant, speed_filter=design.speed_filter)
    found = []
    for wind in winds:
        law = _run(design, filtered, design.law, wind)
        reference = None
        if design.turbine.baseline is not None:
            reference = _run(design, plant, BaselineLaw(design.turbine), wind)
        found.append(DesignRun(wind, law, reference, *_class_use(design, law.history)))
    return found


def _run(design: TurbineDesign, plant: SimulatedTurbine, law: Law, wind: WindSeries) -> Result:
    return run_case(Case(law.name, plant, law, wind, design.observer.observer))


def _class_use(design: TurbineDesign, history: History) -> tuple[Floats, NDArray[np.bool_] | None]:
    """Return v_s, and whether |v - v_s| and |v_s'| are within the bounds of the wind cell."""
    law, summary = design.effort_sharing_law, claim_summary(design)
    schedule = history.wind_estimate
    if law is not None and law.wind_filter > 0:
        schedule = history.law_states[:, 1]
    if summary is None or law is None:
        return schedule, None
    cell = np.clip(np.searchsorted(summary.edges, schedule) - 1, 0, len(summary.winds) - 1)
    inside = np.array(summary.proved)[cell]
    rate = np.abs(np.gradient(schedule, history.time))
    inside &= np.abs(history.wind - schedule) <= np.array(summary.wind_error)[cell]
    inside &= rate <= np.array(summary.wind_rate)[cell]
    return schedule, inside
