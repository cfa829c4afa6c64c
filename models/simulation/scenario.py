"""A record in numbers: energy, overspeed, pitch and torque work, fatigue; the paper's winds."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, nan

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.simulation.closed_loop import History
from takagi.models.simulation.wind import PERIOD, WindSeries, same_turbulence
from takagi.models.turbine.data import Turbine

# Wohler exponents of welded steel and of composite blades.
TOWER_EXPONENT = 4.0
BLADE_EXPONENT = 10.0
REFERENCE_FREQUENCY = 1.0
# A change of torque within this time is a bump, not a motion of the loop [s].
CHANGE_TIME = 0.4
# Pitch counts as active this far above fine pitch [rad], torque as low below this share of rated.
# A constant-power law lowers torque a little at overspeed; that is not the loops' quarrel.
PITCH_ACTIVE = np.radians(0.5)
TORQUE_LOW = 0.95


@dataclass(frozen=True, slots=True)
class Metrics:
    """One record in numbers.

    Attributes
    ----------
    duration [s].
    energy [kWh], mean_power [kW] : electrical.
    overspeed : largest rotor speed above rated, negative if it stays below [% of rated].
    speed_deviation : standard deviation of rotor speed [% of rated].
    pitch_travel : sum of |d pitch| [deg];  pitch_rate : the same per second [deg/s].
    both_active : share of time with pitch more than 0.5 deg above fine pitch *and* torque below
        95 % of rated [%].
    torque_rate : root mean square, high-speed shaft [kN m/s].
    tower_del : damage-equivalent fore-aft moment at the base, exponent 4, 1 Hz [MN m].
    blade_del : of the flapwise moment at the blades' root, exponent 10, 1 Hz [MN m]; what all
        blades share alone: no gravity, no shear, no gust that a single blade meets.
    shaft_del : of the torque in the low-speed shaft, exponent 4 [MN m].
    torque_change : largest change of the generator's torque within 0.4 s [kN m].
    peak_power : electrical [% of rated].
    """

    duration: float
    energy: float
    mean_power: float
    overspeed: float
    speed_deviation: float
    pitch_travel: float
    pitch_rate: float
    both_active: float
    torque_rate: float
    tower_del: float
    # Records of designs that were kept by earlier versions lack the rest.
    shaft_del: float = nan
    torque_change: float = nan
    peak_power: float = nan
    blade_del: float = nan


def measure(history: History, turbine: Turbine) -> Metrics:
    """Return the metrics of a record of two samples or more."""
    time, pitch, torque = history.time, history.pitch, history.torque
    duration = float(time[-1] - time[0])
    # Torque holds from sample to sample, so the first of two acts on the mean speed between them.
    generator = history.generator_speed
    work = torque[:-1] * (generator[:-1] + generator[1:]) / 2 * np.diff(time)
    energy = turbine.generator_efficiency * turbine.gear_ratio * float(np.sum(work))
    speed = history.rotor_speed / turbine.rated_rotor_speed
    travel = degrees(float(np.sum(np.abs(np.diff(pitch)))))
    both_actuators = (pitch > turbine.pitch_min + PITCH_ACTIVE) & (
        torque < TORQUE_LOW * turbine.rated_torque
    )
    torque_rate = np.diff(torque) / np.diff(time)
    return Metrics(
        duration=duration,
        energy=energy / 3.6e6,
        mean_power=energy / duration / 1e3,
        overspeed=100 * (float(np.max(speed)) - 1),
        speed_deviation=100 * float(np.std(speed)),
        pitch_travel=travel,
        pitch_rate=travel / duration,
        both_active=100 * float(np.mean(both_actuators)),
        torque_rate=float(np.sqrt(np.mean(torque_rate**2))) / 1e3,
        tower_del=damage_equivalent_load(history.tower_moment, duration) / 1e6,
        shaft_del=damage_equivalent_load(history.shaft_torque, duration) / 1e6,
        torque_change=_largest_change(torque, round(CHANGE_TIME / float(time[1] - time[0]))) / 1e3,
        peak_power=100 * float(np.max(history.electrical_power)) / turbine.rated_power,
        blade_del=damage_equivalent_load(history.blade_moment, duration, exponent=BLADE_EXPONENT)
        / 1e6,
    )


def _largest_change(series: Floats, steps: int) -> float:
    """Return the largest difference of two samples that are at most so many steps apart."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    size = max(steps, 1) + 1
    return float(np.max(maximum_filter1d(series, size) - minimum_filter1d(series, size)))


def damage_equivalent_load(
    series: ArrayLike,
    duration: float,
    *,
    exponent: float = TOWER_EXPONENT,
    frequency: float = REFERENCE_FREQUENCY,
) -> float:
    """Return (sum_i n_i R_i^m / N_eq)^(1/m) with N_eq = duration * frequency; unit of the series.

    R_i are the ranges of the rainflow cycles (peak to peak), n_i is 1 for a closed cycle and 1/2
    for every half cycle of the residual.

    ``series`` : load over time.   duration : [s].   exponent : m.   frequency : [Hz].

    Raises
    ------
    ModelError : duration, exponent or frequency not above 0, or a load that is not finite.

    Source: ASTM E1049-85 (2017), 5.4.4 (rainflow counting, residual as half cycles).
    """
    import rainflow

    load = np.asarray(series, dtype=np.float64)
    if not (duration > 0 and exponent > 0 and frequency > 0):
        raise ModelError(
            f"duration {duration:g} s, exponent {exponent:g} and frequency {frequency:g} Hz were "
            "given; all must be above 0"
        )
    if load.ndim != 1 or not np.all(np.isfinite(load)):
        raise ModelError("a damage-equivalent load needs one row of finite numbers")
    damage = sum(
        count * cycle_range**exponent
        for cycle_range, _, count, _, _ in rainflow.extract_cycles(load.tolist())
    )
    return float((damage / (duration * frequency)) ** (1 / exponent))


PAPER_MEANS = (8.0, 11.5, 14.0)
PAPER_INTENSITY = 0.18
# Chosen because it shows what the scenario is for: the highest wind is above rated for three
# quarters of the time and leaves it once, the middle one crosses rated, the lowest never does.
PAPER_SEED = 59
PAPER_DURATION = 60.0


def published_winds(
    turbine: Turbine, duration: float = PAPER_DURATION, seed: int = PAPER_SEED
) -> tuple[WindSeries, ...]:
    """Return winds with one turbulence and different means, cut from a period of 600 s or more.

    ``duration`` : [s].

    Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, simulation results: the
    highest wind mostly in region 3 with intervals in region 2, the lowest in partial load only.
    The figures' own wind is not published; seed and intensity are our choice.
    """
    return same_turbulence(
        PAPER_MEANS,
        PAPER_INTENSITY,
        duration,
        seed,
        rotor_radius=turbine.rotor_radius,
        hub_height=turbine.hub_height,
        period=max(duration, PERIOD),
    )
