"""Where the schedule of the law gets its wind, and what moves energy near rated wind.

    python benchmarks/schedule_source.py                 wind from observer, lidar, own effort
    python benchmarks/schedule_source.py --settings      settings that move energy near rated wind
    python benchmarks/schedule_source.py --means 11 18 --seeds 1 2

Each law runs 660 s of class B turbulence on the validation plant with flap, tower, torsion, wake,
ripple and sampling; the last 600 s count.  Mean power is also told with the rotor's kinetic energy
at both ends counted, since a rotor that ends faster has stored what another has sent.

*lidar*: the rotor-effective wind itself, some seconds before it arrives: the best that any can be.
*own effort*: the law's effort U is what it asks of torque and pitch together.  The wind whose trim
effort is U, the root of q*(v) = U, stands in the place of the estimate; no observer is needed.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from numpy.typing import ArrayLike  # noqa: E402

from takagi.lmi.turbine.effort import EffortSettings, effort_gains  # noqa: E402
from takagi.models.arrays import Floats  # noqa: E402
from takagi.models.laws.effort_sharing.law import EffortSharingLaw  # noqa: E402
from takagi.models.laws.effort_sharing.schedule import effort_schedule  # noqa: E402
from takagi.models.laws.protocol import Command, Measurement  # noqa: E402
from takagi.models.laws.sampled import SampledLaw  # noqa: E402
from takagi.models.simulation.closed_loop import Observer, simulate  # noqa: E402
from takagi.models.simulation.metrics import measure  # noqa: E402
from takagi.models.simulation.speed_filter import SpeedFilter  # noqa: E402
from takagi.models.simulation.turbine_plant import validation_plant  # noqa: E402
from takagi.models.simulation.turbulence import turbulent_wind  # noqa: E402
from takagi.models.simulation.wind import WindSeries  # noqa: E402
from takagi.models.turbine.loader import nrel5mw  # noqa: E402
from takagi.models.turbine.wind_observer import WindObserver  # noqa: E402

TURBINE = nrel5mw()
FILTER = SpeedFilter(30.0, 9.3)  # low-pass and band-stop of the default law
OBSERVER = (1.7942, 48.8767)  # (l_1, l_2) of the design, about 1 rad/s
DURATION, SKIP, SAMPLE = 660.0, 60.0, 0.0125
RIPPLE = 0.005  # three swings a turn, over the wind: what OpenFAST's records of the rotor have


@dataclass(frozen=True)
class Settings:
    """What is moved; the default law's values."""

    wind_filter: float = 12.0
    overlap: float = 0.01
    share: float = 1.0
    bandwidth: float = 0.6
    partial_bandwidth: float = 0.3
    integral_share: float = 0.15
    partial_integral_share: float = 0.3


class OwnEffort(EffortSharingLaw):
    """The law with the wind at which the trim effort is its own effort in place of the estimate."""

    def seen(self, state: ArrayLike, measurement: Measurement) -> Measurement:
        integral, wind = np.asarray(state, dtype=np.float64)
        nodes = self.schedule.wind
        trim, speed, gain = (
            float(np.interp(wind, nodes, column))
            for column in (
                self.schedule.trim_effort,
                self.schedule.rotor_speed,
                self.gains.proportional,
            )
        )
        effort = trim + gain * (measurement.rotor_speed - speed - integral)
        found = float(np.interp(effort, self.schedule.trim_effort, nodes))
        return measurement._replace(wind_estimate=found)

    def command(self, state: ArrayLike, measurement: Measurement) -> Command:
        return super().command(state, self.seen(state, measurement))

    def state_rate(self, state: ArrayLike, measurement: Measurement) -> Floats:
        return super().state_rate(state, self.seen(state, measurement))

    def sample(
        self, state: ArrayLike, measurement: Measurement, time: float
    ) -> tuple[Command, Floats]:
        return super().sample(state, self.seen(state, measurement), time)


@dataclass(frozen=True)
class Lidar:
    """Gives the wind ``ahead`` seconds before it arrives; its state is the time."""

    series: WindSeries
    ahead: float

    def initial_state(self, rotor_speed: float, wind: float) -> Floats:
        return np.array([float(self.series.time[0])])

    def wind_estimate(self, state: Floats) -> float:
        time = min(float(state[0]) + self.ahead, float(self.series.time[-1]))
        return float(self.series.at(np.array([time]))[0])

    def state_rate(self, state: Floats, rotor_speed: float, pitch: float, torque: float) -> Floats:
        return np.ones(1)


def law(at: Settings, kind: type[EffortSharingLaw] = EffortSharingLaw) -> EffortSharingLaw:
    """Return the law with gains found wind by wind."""
    schedule = effort_schedule(TURBINE, overlap=at.overlap, effectiveness_share=at.share)
    asked = EffortSettings(
        bandwidth=at.bandwidth,
        partial_bandwidth=at.partial_bandwidth,
        integral_share=at.integral_share,
        partial_integral_share=at.partial_integral_share,
    )
    gains = effort_gains(TURBINE, schedule, asked).gains
    return kind.of(TURBINE, schedule, gains, wind_filter=at.wind_filter)


def numbers(
    control: EffortSharingLaw, mean: float, seed: int, source: Callable[[WindSeries], Observer]
) -> dict[str, float]:
    """Return what one run gives; power in kW, travel in deg, DEL in MN m, shares in %."""
    wind = turbulent_wind(mean, 0.14 * (0.75 + 5.6 / mean), DURATION, seed)
    plant = validation_plant(TURBINE, speed_filter=FILTER, ripple=RIPPLE)
    history = simulate(plant, SampledLaw(control, SAMPLE), wind, observer=source(wind))
    found = measure(history, TURBINE, skip=SKIP)
    late = history.time >= SKIP
    speed = history.rotor_speed[late]
    stored = 0.5 * TURBINE.inertia * (speed[-1] ** 2 - speed[0] ** 2) / (DURATION - SKIP)
    above = history.pitch[late] > TURBINE.pitch_min + np.radians(0.1)
    return {
        "power": found.mean_power,
        "with stored": found.mean_power + stored * TURBINE.generator_efficiency / 1e3,
        "off stop": 100 * float(above.mean()),
        "travel": found.pitch_travel,
        "tower DEL": found.tower_del,
        "overspeed": found.overspeed,
    }


def observed(wind: WindSeries) -> Observer:
    """Return the observer of the design."""
    return WindObserver(TURBINE, *OBSERVER)


def ahead(time: float) -> Callable[[WindSeries], Observer]:
    """Return what makes a lidar of ``time`` [s] for a wind."""
    return lambda wind: Lidar(wind, time)


def sources() -> dict[str, tuple[EffortSharingLaw, Callable[[WindSeries], Observer]]]:
    """Return laws by where their wind is from; (s) is the filter on that wind."""
    found: dict[str, tuple[EffortSharingLaw, Callable[[WindSeries], Observer]]] = {
        f"observer, {filtering:g} s": (law(Settings(wind_filter=filtering)), observed)
        for filtering in (12.0, 30.0)
    }
    for filtering, time in ((12.0, 0.0), (12.0, 12.0), (5.0, 5.0), (2.0, 2.0), (1.0, 0.0)):
        slow = law(Settings(wind_filter=filtering))
        found[f"lidar {time:g} s ahead, {filtering:g} s"] = (slow, ahead(time))
    for filtering in (12.0, 5.0, 30.0):
        own = law(Settings(wind_filter=filtering), OwnEffort)
        # The observer runs, but what it says is not read.
        found[f"own effort, {filtering:g} s"] = (own, observed)
    return found


def settings() -> dict[str, tuple[EffortSharingLaw, Callable[[WindSeries], Observer]]]:
    """Return laws with one or more settings moved."""
    moved: tuple[dict[str, float], ...] = (
        {},
        {"overlap": 0.005},
        {"overlap": 0.003},
        {"wind_filter": 5.0},
        {"wind_filter": 3.0},
        {"share": 1.5},
        {"bandwidth": 0.4},
        {"bandwidth": 1.0},
        {"partial_bandwidth": 0.15},
        {"partial_bandwidth": 0.6},
        {"partial_integral_share": 0.1},
        {"partial_integral_share": 0.03},
        {"wind_filter": 3.0, "overlap": 0.005},
        {"wind_filter": 3.0, "overlap": 0.005, "share": 1.3},
        {"wind_filter": 6.0, "partial_integral_share": 0.1},
        {"partial_bandwidth": 0.6, "partial_integral_share": 0.1},
        {"partial_bandwidth": 0.6, "partial_integral_share": 0.05},
    )
    known = {field.name for field in fields(Settings)}
    found: dict[str, tuple[EffortSharingLaw, Callable[[WindSeries], Observer]]] = {}
    for change in moved:
        assert known.issuperset(change)
        words = ", ".join(f"{name} {value:g}" for name, value in change.items())
        found[words or "default"] = (law(replace(Settings(), **change)), observed)
    return found


def main() -> None:
    """Run the laws at each mean and print a line for each, averaged over the seeds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--settings", action="store_true", help="move settings, not the source")
    parser.add_argument("--means", type=float, nargs="+", default=[11.0, 13.0, 18.0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    given = parser.parse_args()
    for name, (control, source) in (settings() if given.settings else sources()).items():
        for mean in given.means:
            runs = [numbers(control, mean, seed, source) for seed in given.seeds]
            worst = max(run["overspeed"] for run in runs)
            row = {key: float(np.mean([run[key] for run in runs])) for key in runs[0]}
            row["overspeed"] = worst
            told = ", ".join(f"{key} {value:.2f}" for key, value in row.items())
            print(f"{mean:g} m/s, {name}: {told}", flush=True)


if __name__ == "__main__":
    main()
