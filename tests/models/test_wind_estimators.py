"""Kalman filter and immersion-and-invariance estimator of the wind, and readings that are bad."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from takagi.models import ModelError, WindObserver, nrel5mw
from takagi.models.simulation import Observer
from takagi.models.turbine import (
    ImmersionInvarianceEstimator,
    KalmanWindFilter,
    rotor_torque,
    rotor_torque_gradient,
)
from takagi.models.turbine.trim import trim

WATCHES: dict[str, Observer] = {
    "observer": WindObserver(nrel5mw(), 0.8, 10.0),
    "kalman": KalmanWindFilter(nrel5mw(), 0.1),
    "immersion": ImmersionInvarianceEstimator(nrel5mw(), 50.0),
}


def steady(watch: Observer, wind: float, guess: float, seconds: float) -> list[float]:
    """Return the estimates at a constant wind in steady operation, from a guess of the wind."""
    turbine = nrel5mw()
    at = trim(turbine, wind)
    torque = float(rotor_torque(turbine, at.rotor_speed, at.pitch, wind)) / turbine.gear_ratio
    state, found = watch.initial_state(at.rotor_speed, guess), []
    for _ in range(round(seconds / 0.05)):
        found.append(watch.wind_estimate(state))
        state = state + 0.05 * watch.state_rate(state, at.rotor_speed, at.pitch, torque)
    return found


@pytest.mark.parametrize("name", ["kalman", "immersion"])
@pytest.mark.parametrize("wind", [6.0, 8.0, 11.0, 16.0, 24.0])
def test_estimate_converges_in_steady_wind(name: str, wind: float) -> None:
    """From a guess 2 m/s off, the estimate reaches a constant wind within 0.01 m/s."""
    assert steady(WATCHES[name], wind, wind - 2, 60)[-1] == pytest.approx(wind, abs=0.01)


@pytest.mark.parametrize("wind", [6.0, 8.0, 11.0, 16.0, 24.0])
@pytest.mark.parametrize("off", [-1.0, 1.0])
def test_immersion_error_shrinks_where_torque_rises(wind: float, off: float) -> None:
    """dT_r/dv > 0 between guess and wind: the error never grows and keeps its sign."""
    turbine, at = nrel5mw(), trim(nrel5mw(), wind)
    between = np.linspace(wind, wind + off, 50)
    slopes = rotor_torque_gradient(turbine, at.rotor_speed, at.pitch, between)[2]
    errors = [off * (v - wind) for v in steady(WATCHES["immersion"], wind, wind + off, 20)]

    assert np.all(slopes > 0)
    assert all(0 <= after <= before + 1e-12 for before, after in pairwise(errors))


def test_immersion_error_grows_where_the_rotor_stalls() -> None:
    """At a slow rotor in 14 m/s torque falls with the wind: the error grows there."""
    turbine, watch = nrel5mw(), ImmersionInvarianceEstimator(nrel5mw(), 50.0)
    speeds = np.linspace(0.3, 1.2, 50)
    slopes = rotor_torque_gradient(turbine, speeds, 0.0, 14.0, clip=True)[2]
    speed = float(speeds[slopes.argmin()])
    torque = float(rotor_torque(turbine, speed, 0.0, 14.0, clip=True)) / turbine.gear_ratio

    assert slopes.min() < 0
    assert watch.state_rate(watch.initial_state(speed, 14.2), speed, 0.0, torque)[0] > 0


@pytest.mark.parametrize("name", list(WATCHES))
@pytest.mark.parametrize(
    ("speed", "pitch", "torque"),
    [
        (1.2, nrel5mw().pitch_min - 1e-6, 40e3),
        (1.2, -3.0, 40e3),
        (1.2, 3.0, 40e3),
        (0.0, 0.0, 0.0),
        (-0.5, 0.0, 0.0),
        (0.4, 0.0, 43e3),
        (5.0, 0.0, 0.0),
        (1.2, 0.2, 0.0),
        (math.nan, 0.0, 40e3),
        (1.2, math.nan, 40e3),
        (1.2, 0.0, math.inf),
    ],
)
def test_estimate_stays_finite_on_bad_readings(
    name: str, speed: float, pitch: float, torque: float
) -> None:
    """Two minutes of a bad reading leave a finite state, from which the estimate comes back."""
    turbine, watch, at = nrel5mw(), WATCHES[name], trim(nrel5mw(), 12.0)
    held = float(rotor_torque(turbine, at.rotor_speed, at.pitch, 12.0)) / turbine.gear_ratio
    state = watch.initial_state(at.rotor_speed, 12.0)
    for _ in range(2400):
        state = state + 0.05 * watch.state_rate(state, speed, pitch, torque)
        assert np.all(np.isfinite(state))
    for _ in range(4800):
        state = state + 0.05 * watch.state_rate(state, at.rotor_speed, at.pitch, held)

    assert watch.wind_estimate(state) == pytest.approx(12.0, abs=0.05)


@pytest.mark.parametrize(
    ("wind", "speed", "pitch", "torque", "words"),
    [
        (12.0, 1.2, math.nan, 40e3, "no finite number"),
        (12.0, 1.2, -1.0, 40e3, "pitch is outside its table: -1"),
        (12.0, 0.0, 0.0, 0.0, "tip-speed ratio is outside its table: 0"),
        (8.0, 1.0, nrel5mw().pitch_min - 1e-6, 20e3, "pitch is outside its limits: -1e-06"),
        (37.5, 1.2, 0.3, 40e3, "held at its limit, 37.5 m/s"),
        (14.0, 0.6, 0.0, 40e3, "the rotor stalls"),
    ],
)
def test_observer_says_why_its_estimate_is_in_doubt(
    wind: float, speed: float, pitch: float, torque: float, words: str
) -> None:
    """Each reason is named, and none in steady operation."""
    watch, at = WATCHES["observer"], trim(nrel5mw(), 8.0)
    assert isinstance(watch, WindObserver)

    said = watch.doubts(watch.initial_state(speed, wind), speed, pitch, torque)
    calm = watch.initial_state(at.rotor_speed, 8.0)

    assert words in "; ".join(said)
    assert watch.doubts(calm, at.rotor_speed, at.pitch, 20e3) == ()


def test_misuse_is_explained() -> None:
    """Noise and gains that make no estimator are named."""
    with pytest.raises(ModelError, match=r"wind_noise = 0\.0"):
        KalmanWindFilter(nrel5mw(), 0.0)
    with pytest.raises(ModelError, match="gain = nan"):
        ImmersionInvarianceEstimator(nrel5mw(), math.nan)
