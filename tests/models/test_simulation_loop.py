"""The closed loop in time: conservation, convergence, limits, flags, observer, misuse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.models import Floats, ModelError, WindObserver
from takagi.models.laws.protocol import Command, Measurement, SampledLaw
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import History, simulate
from takagi.models.simulation.turbine_plant import (
    Flag,
    SimulatedTurbine,
    design_plant,
    validation_plant,
)
from takagi.models.simulation.turbine_plant import plant_rate as turbine_rate
from takagi.models.simulation.wind import ramp_wind, same_turbulence, step_wind
from takagi.models.turbine.loader import nrel5mw
from tests.winds import constant_wind


@dataclass(frozen=True)
class Held:
    torque: float
    pitch: float
    name: str = "held"
    state_names: tuple[str, ...] = ()

    def initial_state(self, wind: float) -> Floats:
        return np.zeros(0)

    def command(self, state: Floats, measurement: Measurement) -> Command:
        return Command(self.torque, self.pitch)

    def state_rate(self, state: Floats, measurement: Measurement) -> Floats:
        return np.zeros(0)


def baseline_run(
    plant: SimulatedTurbine, *, time_step: float = 0.02, sample: float = 0.04
) -> History:
    wind = same_turbulence((12.0,), 0.15, 60.0, 2)[0]
    law = SampledLaw(BaselineLaw(plant.turbine), sample)
    return simulate(plant, law, wind, time_step=time_step)


def test_loop_equals_an_adaptive_solver() -> None:
    """Constant commands from trim: scipy's DOP853 on ``plant_rate``, no limit being met."""
    plant = validation_plant(nrel5mw(), torsion=True, wake=True)
    start, point = plant.initial_state(14.0)
    history = simulate(
        plant,
        Held(point.torque, point.pitch + 0.02),
        constant_wind(14.0, 20.0),
    )

    def rate(_: float, state: Floats) -> Floats:
        return turbine_rate(plant)(state, point.torque, point.pitch + 0.02, 14.0)

    solved = solve_ivp(rate, (0.0, 20.0), start, method="DOP853", rtol=1e-9, atol=1e-11)

    assert history.flags.max() == 0
    assert history.plant_states[-1] == pytest.approx(solved.y[:, -1], abs=2e-6)


def test_pitch_rate_and_position_limits_hold() -> None:
    """A command of 30 deg: 8 deg/s and no more; one of -5 deg: fine pitch and no less."""
    turbine = nrel5mw()
    up = simulate(validation_plant(turbine), Held(4e4, np.radians(30.0)), constant_wind(14.0, 8.0))
    down = simulate(validation_plant(turbine), Held(4e4, -0.1), constant_wind(14.0, 8.0))

    assert np.abs(np.diff(up.pitch)).max() <= turbine.pitch_rate_limit * 0.02 * (1 + 1e-9)
    assert up.pitch_rate.max() == pytest.approx(turbine.pitch_rate_limit)
    assert up.share_flagged(Flag.PITCH_RATE_LIMITED) > 0.1
    assert down.pitch.min() == turbine.pitch_min
    assert down.share_flagged(Flag.PITCH_POSITION_LIMITED) == 1.0


def test_torque_follows_within_its_rate_and_range() -> None:
    """From trim at 8 m/s to 60 kN m: 300 N m per 0.02 s, up to 110 % of rated."""
    turbine = nrel5mw()
    history = simulate(validation_plant(turbine), Held(6e4, 0.0), constant_wind(11.0, 5.0))
    free = simulate(design_plant(turbine), Held(4e4, 0.0), constant_wind(11.0, 1.0))

    assert np.diff(history.torque).max() == pytest.approx(300.0)
    assert history.torque[-1] == turbine.maximum_torque
    assert history.flags[0] & Flag.TORQUE_RATE_LIMITED.value
    assert history.share_flagged(Flag.TORQUE_LIMITED) == 1.0
    assert free.torque[0] == 4e4


def test_outside_the_table_is_flagged() -> None:
    law = BaselineLaw(nrel5mw())
    history = simulate(validation_plant(nrel5mw()), law, step_wind(10.0, 3.0, 20.0, begin=5.0))
    clipped = (history.flags & Flag.TIP_SPEED_RATIO_CLIPPED.value) != 0

    assert not clipped[history.time < 4.9].any()
    assert clipped[history.time > 5.1].any()
    assert np.all(np.isfinite(history.plant_states))


def test_observer_in_the_loop_follows_the_wind() -> None:
    """The law sees the estimate; on a slow ramp it lags the wind by less than 0.4 m/s."""
    turbine, shares = nrel5mw(), list[float]()
    history = simulate(
        design_plant(turbine),
        BaselineLaw(turbine),
        ramp_wind(9.0, 14.0, 90.0, rate=0.1, begin=10.0),
        observer=WindObserver(turbine, 2.0, 40.0),
        progress=shares.append,
    )

    assert np.abs(history.wind_estimate - history.wind).max() < 0.4
    assert history.wind_estimate[-1] == pytest.approx(14.0, abs=0.02)
    assert np.abs(history.wind_estimate - history.wind).max() > 1e-3
    assert shares[-1] == pytest.approx(1.0)


def test_measured_speed_is_the_generators_or_the_filtered_one() -> None:
    turbine = nrel5mw()
    plain, stiff, filtered = (
        baseline_run(plant).rotor_speed
        for plant in (
            validation_plant(turbine),
            validation_plant(turbine, torsion=False),
            validation_plant(turbine, speed_filter=turbine.speed_filter),
        )
    )

    assert 0 < np.abs(stiff - plain).max() < 0.01
    assert 1e-4 < np.abs(filtered - plain).max() < 0.05


def test_per_unit_of_rated_operation_is_one() -> None:
    """In steady 11.45 m/s speed, torque, power, tower and wind are all near 1, pitch near 0."""
    turbine = nrel5mw()
    history = simulate(
        validation_plant(turbine), Held(turbine.rated_torque, 0.0), constant_wind(11.45, 0.5)
    )
    scaled = history.per_unit(turbine)

    for name in ("wind", "rotor_speed", "torque", "electrical_power", "tower_displacement"):
        assert scaled[name][0] == pytest.approx(1.0, abs=2e-3), name
    assert scaled["tower_moment"][0] == pytest.approx(1.0, abs=2e-3)
    assert scaled["pitch"][0] == pytest.approx(0.0, abs=0.02)


def test_a_record_cannot_be_changed() -> None:
    history = simulate(design_plant(nrel5mw()), Held(4e4, 0.0), constant_wind(11.0, 1.0))

    assert len(history.time) == len(history.plant_states) == len(history.flags) == 51
    with pytest.raises(ValueError, match="read-only"):
        history.rotor_speed[0] = 0.0


def test_misuse_is_told() -> None:
    plant, law = design_plant(nrel5mw()), Held(4e4, 0.0)
    with pytest.raises(ModelError, match="whole multiple"):
        simulate(plant, SampledLaw(law, 0.05), constant_wind(9.0, 5.0), time_step=0.03)
    with pytest.raises(ModelError, match="must be above 0"):
        simulate(plant, law, constant_wind(9.0, 5.0), time_step=0.0)
    with pytest.raises(ModelError, match="less than one step"):
        simulate(plant, law, constant_wind(9.0, 0.01))
    with pytest.raises(ModelError, match="law 'held'.* before 0.02 s"):
        simulate(plant, Held(float("nan"), 0.0), constant_wind(9.0, 5.0))
