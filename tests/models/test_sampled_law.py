"""A law as the program of a controller: its discretisation, its delay, its limits, its misuse."""

from __future__ import annotations

from dataclasses import replace
from math import exp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.laws.protocol import Command, Measurement, SampledLaw, sampled
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import History, fitting_step, simulate
from takagi.models.simulation.turbine_plant import design_plant, validation_plant
from takagi.models.simulation.wind import same_turbulence, step_wind
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw
from tests.winds import constant_wind

REST = Command(4e4, 0.1)


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def law(turbine: Turbine) -> EffortSharingLaw:
    schedule = effort_schedule(turbine, effectiveness_share=0.6)
    count = len(schedule.wind)
    gains = EffortGains(np.full(count, 0.6), np.full(count - 1, 0.15))
    return EffortSharingLaw.of(turbine, schedule, gains)


@given(
    wind=st.floats(3, 25),
    seen=st.floats(0, 30),
    x=st.floats(-0.1, 0.1),
    speed=st.floats(0.6, 1.6),
    time=st.floats(1e-3, 2.0),
)
def test_the_filter_is_discretised_exactly(
    law: EffortSharingLaw, wind: float, seen: float, x: float, speed: float, time: float
) -> None:
    """v_f goes to the held estimate by exp(-t/tau), in one step or two; |x| stays at its limit."""
    measured = Measurement(speed, 0.0, seen)

    once = law.advance([x, wind], measured, time)
    half = law.advance([x, wind], measured, time / 2)
    twice = law.advance(half, measured, time / 2)

    held = min(max(seen, 3.0), 25.0)
    assert once[1] == pytest.approx(held + (wind - held) * exp(-time / law.wind_filter))
    assert once[1] == pytest.approx(twice[1], abs=1e-9)
    assert abs(once[0]) <= law.integral_limit
    free = x + time * law.state_rate([x, wind], measured)[0]
    assert once[0] == pytest.approx(np.clip(free, -law.integral_limit, law.integral_limit))


def test_a_filter_faster_than_the_samples_is_stable(law: EffortSharingLaw) -> None:
    """With tau_f = 5 ms and samples of 20 ms an Euler step would grow by -3 each time."""
    quick, measured = replace(law, wind_filter=0.005), Measurement(1.2, 0.0, 14.0)
    state = euler = np.array([0.0, 10.0])
    for _ in range(8):
        state = quick.advance(state, measured, 0.02)
        euler = euler + 0.02 * quick.state_rate(euler, measured)

    assert state[1] == pytest.approx(14.0, abs=1e-9)
    assert abs(euler[1] - 14.0) > 1e4


def test_a_law_without_its_own_step_takes_eulers(turbine: Turbine) -> None:
    """The reference's controller has no ``sample``."""
    law, measured = BaselineLaw(turbine), Measurement(1.3, 0.1, 14.0)
    state = law.initial_state(14.0)

    command, later = sampled(law, state, measured, 0.02)

    assert command == law.command(state, measured)
    assert later == pytest.approx(state + 0.02 * law.state_rate(state, measured), abs=0)


def test_a_program_is_the_law_between_samples(law: EffortSharingLaw) -> None:
    program = SampledLaw(law, 0.02)
    begin = program.start(14.0, REST)
    measured = Measurement(1.25, 0.1, 15.0)

    sent, after = program.step(begin, measured)

    assert sent == law.sample(begin.law_state, measured, 0.02)[0]
    assert np.array_equal(after.law_state, law.advance(begin.law_state, measured, 0.02))
    assert after.sent == sent and begin.sent == REST


def test_what_is_sent_moves_no_faster_than_its_limits(law: EffortSharingLaw) -> None:
    program = SampledLaw(law, 0.02, torque_rate_limit=15e3, pitch_rate_limit=0.1)
    measured = Measurement(1.40, 0.1, 14.0)
    state = program.start(14.0, Command(30e3, 0.0))
    sent = [Command(30e3, 0.0)]
    for _ in range(120):
        command, state = program.step(state, measured)
        sent.append(command)
    torque, pitch = np.array(sent).T

    assert np.diff(torque)[:10] == pytest.approx(300.0)
    assert np.diff(pitch)[:10] == pytest.approx(0.002)
    assert np.abs(np.diff(torque)).max() <= 300.0 * (1 + 1e-9)
    assert np.abs(np.diff(pitch)).max() <= 0.002 * (1 + 1e-9)
    assert torque[-1] == law.command(state.law_state, measured).torque


def run(law: EffortSharingLaw | SampledLaw, turbine: Turbine) -> History:
    wind = same_turbulence((12.0,), 0.15, 30.0, 2)[0]
    return simulate(validation_plant(turbine), law, wind)


def test_a_plain_law_is_one_that_is_sampled_every_20_ms(
    law: EffortSharingLaw, turbine: Turbine
) -> None:
    plain, sampled = run(law, turbine), run(SampledLaw(law, 0.02), turbine)
    rare = run(SampledLaw(law, 0.1), turbine)

    assert np.array_equal(plain.plant_states, sampled.plant_states)
    assert len(rare.time) == 301 and rare.time[-1] == pytest.approx(30.0)
    assert 1e-4 < np.abs(rare.rotor_speed - plain.rotor_speed[::5]).max() < 0.01


def test_a_computation_time_is_a_later_command(law: EffortSharingLaw, turbine: Turbine) -> None:
    """Torque that was computed at t acts from t + T_c: a whole sample late is the old command."""
    plant, wind = design_plant(turbine), step_wind(13.0, 14.0, 2.0, begin=0.1)
    history = simulate(plant, SampledLaw(law, 0.1, 0.1), wind)
    prompt = simulate(plant, SampledLaw(law, 0.1), wind)
    pitch, reference = history.pitch, history.pitch_reference
    decay = exp(-0.1 / turbine.pitch_time_constant)

    late = reference[:-2] + (pitch[1:-1] - reference[:-2]) * decay
    assert pitch[2:] == pytest.approx(late, abs=1e-6)
    now = prompt.pitch_reference[:-1]
    assert prompt.pitch[1:] == pytest.approx(now + (prompt.pitch[:-1] - now) * decay, abs=1e-6)
    assert np.abs(pitch[2:] - (reference[1:-1] + (pitch[1:-1] - reference[1:-1]) * decay)).max() > (
        1e-5
    )


def test_a_program_has_the_name_and_the_states_of_its_law() -> None:
    program = SampledLaw(BaselineLaw(nrel5mw()), 0.02, 0.01)

    assert (program.name, len(program.state_names)) == ("baseline", 2)


@pytest.mark.parametrize(
    ("times", "step"),
    [((0.02, 0.0), 0.02), ((0.01, 0.0), 0.01), ((0.1, 0.05), 0.1 / 6), ((0.05, 0.01), 0.01)],
)
def test_the_plant_s_step_fits_both_times(times: tuple[float, float], step: float) -> None:
    """The largest one up to 20 ms of which sample and computation time are multiples."""
    assert fitting_step(*times) == pytest.approx(step)


def test_misuse_is_told(law: EffortSharingLaw, turbine: Turbine) -> None:
    with pytest.raises(ModelError, match="sample time 0"):
        SampledLaw(law, 0.0)
    with pytest.raises(ModelError, match="computation time 0.03 s"):
        SampledLaw(law, 0.02, 0.03)
    with pytest.raises(ModelError, match="torque_rate_limit"):
        SampledLaw(law, 0.02, torque_rate_limit=0.0)
    with pytest.raises(ModelError, match="pitch_rate_limit"):
        SampledLaw(law, 0.02, pitch_rate_limit=float("nan"))
    with pytest.raises(ModelError, match="simple fraction"):
        fitting_step(0.1, 0.0317731)
    with pytest.raises(ModelError, match="computation time 0.05 s was given with time step 0.02"):
        simulate(
            design_plant(turbine), SampledLaw(law, 0.1, 0.05), constant_wind(14.0, 1.0),
            time_step=0.02,
        )  # fmt: skip
