"""The wind observer: exact error system, proved premise range, and convergence when it runs."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError, TSModel, WindObserver, nrel5mw, wind_observer_model
from takagi.models.turbine.data import rotor_torque, rotor_torque_gradient
from takagi.models.turbine.operating_band import operating_band
from takagi.models.turbine.trim import trim

UNIT = st.floats(-1, 1)
PITCH_BAND = 0.034907


@lru_cache
def model() -> TSModel:
    return wind_observer_model(nrel5mw())


def observer() -> WindObserver:
    return WindObserver(nrel5mw(), 0.8, 10.0)


@given(st.floats(4.1, 25), UNIT, UNIT, UNIT, UNIT)
def test_error_system_is_exact(v0: float, e: float, p: float, w: float, west: float) -> None:
    turbine, at = nrel5mw(), trim(nrel5mw(), min(v0, 25.0))
    low, high = nrel5mw().pitch_min, at.pitch + 0.9 * PITCH_BAND
    omega, beta = at.rotor_speed + 0.09 * e, min(max(at.pitch + PITCH_BAND * p, low), high)
    v, estimate, torque = v0 + 0.45 * w, v0 + 0.45 * west, 30e3
    state = np.array([omega - 0.01, estimate])
    plant = (float(rotor_torque(turbine, omega, beta, v)) - 97 * torque) / turbine.inertia

    rate = observer().state_rate(state, omega, beta, torque)
    z = model().premise_values(rotor_speed=omega, pitch=beta, wind=v, wind_estimate=estimate)
    error = np.array([0.01, v - estimate])
    blended = (model().blend(z, clip=True).A - np.outer([0.8, 10.0], [1, 0])) @ error
    np.testing.assert_allclose([plant, 0] - rate, blended, rtol=1e-9, atol=1e-12)


def test_bounds_contain_sampled_slopes() -> None:
    """dT_r/dv / J sampled over the whole tube stays inside, within 8 % of the range."""
    turbine, rng = nrel5mw(), np.random.default_rng(11)
    band = operating_band(
        turbine, (4.1, 25.0), speed_band="0.1", pitch_band=PITCH_BAND, wind_band="0.5"
    )
    v0 = np.concatenate([rng.uniform(4.1, 25, 60_000), np.repeat((4.1, 25.0), 2_000)])
    omega, beta = band.at(v0)
    e, p, w = rng.choice([-1, -0.5, 0, 0.5, 1], (3, v0.size))
    off = np.maximum(beta + PITCH_BAND * p, turbine.pitch_min)
    values = rotor_torque_gradient(turbine, omega + 0.1 * e, off, v0 + 0.5 * w)[2] / turbine.inertia
    low, high = (float(end) for end in (model().premises[0].lower, model().premises[0].upper))

    assert 0 < low <= values.min() <= low + 0.08 * (high - low)
    assert high - 0.08 * (high - low) <= values.max() <= high


def test_error_system_structure() -> None:
    """A = [[0, d], [0, 0]], C = [1, 0], E = [0, 1]': two vertices, observable since d > 0."""
    found = model()

    assert found.A.shape == (2, 2, 2)
    assert np.all(found.A[:, 0, 1] > 0)
    np.testing.assert_array_equal(found.A[:, :, 0], 0)
    np.testing.assert_array_equal(found.C[0], [[1, 0]])
    np.testing.assert_array_equal(found.E[0], [[0], [1]])
    assert found.disturbances == ("wind rate [m/s^2]",)
    assert r"l_1 \tilde{\omega}" in getattr(found.derivation, "latex", "")


@pytest.mark.parametrize("wind", [8.0, 11.0, 16.0, 24.0])
def test_estimate_converges_in_steady_wind(wind: float) -> None:
    """From a guess 2 m/s off, vhat reaches a constant wind in steady operation within 0.01 m/s."""
    turbine, watch = nrel5mw(), observer()
    at = trim(turbine, wind)
    torque = float(rotor_torque(turbine, at.rotor_speed, at.pitch, wind)) / turbine.gear_ratio
    state = watch.initial_state(at.rotor_speed, wind - 2)

    for _ in range(1200):
        state = state + 0.05 * watch.state_rate(state, at.rotor_speed, at.pitch, torque)

    assert watch.wind_estimate(state) == pytest.approx(wind, abs=0.01)


def test_estimate_is_held_at_its_limits() -> None:
    watch = WindObserver(nrel5mw(), 0.8, 10.0, wind_limits=(3.0, 20.0))

    assert watch.initial_state(1.2, 40.0)[1] == 20.0
    assert watch.state_rate(np.array([1.0, 20.0]), 1.2, 0.3, 43e3)[1] == 0.0
    assert watch.state_rate(np.array([1.4, 20.0]), 1.2, 0.3, 43e3)[1] < 0


@pytest.mark.parametrize(
    ("speed", "pitch", "torque"),
    [
        (1.2, -3.0, 40e3),
        (1.2, 3.0, 40e3),
        (0.0, 0.0, 0.0),
        (0.4, 0.0, 43e3),
        (5.0, 0.0, 0.0),
        (1.2, 0.2, 0.0),
        (math.nan, 0.0, 40e3),
        (1.2, math.nan, 40e3),
        (1.2, 0.0, math.inf),
    ],
)
def test_estimate_stays_finite_on_bad_readings(speed: float, pitch: float, torque: float) -> None:
    turbine, watch, at = nrel5mw(), observer(), trim(nrel5mw(), 12.0)
    held = float(rotor_torque(turbine, at.rotor_speed, at.pitch, 12.0)) / turbine.gear_ratio
    state = watch.initial_state(at.rotor_speed, 12.0)
    for _ in range(2400):
        state = state + 0.05 * watch.state_rate(state, speed, pitch, torque)
        assert np.all(np.isfinite(state))
    for _ in range(4800):
        state = state + 0.05 * watch.state_rate(state, at.rotor_speed, at.pitch, held)

    assert watch.wind_estimate(state) == pytest.approx(12.0, abs=0.05)


def test_bands_without_a_positive_slope_are_refused() -> None:
    """Deep in stall more wind does not give more torque: the wind is not observable there."""
    with pytest.raises(ModelError, match="must be positive for the wind to be observed"):
        wind_observer_model(nrel5mw(), wind_range=(11, 12), speed_band="0.6", tolerance="0.5")


@pytest.mark.parametrize(
    ("l1", "l2", "limits", "message"),
    [
        (0.0, 1.0, None, "l1 = 0.0"),
        (1.0, float("nan"), None, "l2 = nan"),
        (1.0, 1.0, (5.0, 4.0), "0 < low < high"),
    ],
)
def test_misuse_is_explained(
    l1: float, l2: float, limits: tuple[float, float] | None, message: str
) -> None:
    with pytest.raises(ModelError, match=message):
        WindObserver(nrel5mw(), l1, l2, wind_limits=limits)
