"""The effort-sharing law as it runs: formulas, limits, continuity, and what the tables say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from takagi.models import ModelError, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import (
    EffortSchedule,
    Feedforward,
    effort_schedule,
    known_rate_feedforward,
    no_feedforward,
)
from takagi.models.laws.protocol import Measurement
from takagi.models.ramps import effort_ramp

WINDS = st.floats(3, 25)
ERRORS = st.floats(-0.06, 0.06)


def gains(schedule: EffortSchedule) -> EffortGains:
    """Return gains that differ from node to node, so that a wrong node shows."""
    count = len(schedule.wind)
    return EffortGains(np.linspace(0.1, 0.5, count), np.linspace(0.01, 0.02, count - 1))


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def law(turbine: Turbine) -> EffortSharingLaw:
    schedule = effort_schedule(turbine)
    return EffortSharingLaw.of(turbine, schedule, gains(schedule))


def demanded(law: EffortSharingLaw, wind: float, e: float, x: float) -> tuple[float, float, float]:
    """Return (omega, U, b) by numpy's interpolation, not the law's own."""
    table = law.schedule
    omega, q, b, gamma = (
        float(np.interp(wind, table.wind, column))
        for column in (
            table.rotor_speed,
            table.trim_effort,
            table.effectiveness,
            law.gains.proportional,
        )
    )
    return omega + e, q + gamma * (e - x), b


@given(wind=WINDS, e=ERRORS, x=ERRORS)
def test_commands_follow_the_formulas(
    law: EffortSharingLaw, wind: float, e: float, x: float
) -> None:
    """T = T_rated - E psi(-U), beta = beta_min + psi(U) / b, x' = -nu e."""
    omega, U, b = demanded(law, wind, e, x)
    eps = law.schedule.overlap
    measured = Measurement(omega, 0.0, wind)

    command = law.command([x, wind], measured)

    torque = max(law.rated_torque - law.effort_torque * float(effort_ramp(-U, eps)), 0.0)
    assert command.torque == pytest.approx(torque, abs=1e-6 * law.rated_torque)
    assert command.pitch == pytest.approx(law.pitch_min + float(effort_ramp(U, eps)) / b, abs=1e-9)
    nu = law.gains.integral_rate
    k = min(int(np.searchsorted(law.schedule.wind, wind, side="right")) - 1, len(nu) - 1)
    rate, filtered = law.state_rate([x, wind], measured)
    assert rate == pytest.approx(-nu[k] * e, abs=1e-9)
    assert filtered == pytest.approx(0, abs=1e-12)


@given(wind=WINDS, e=ERRORS, x=ERRORS)
def test_both_actuators_together_buy_the_demanded_effort(
    law: EffortSharingLaw, wind: float, e: float, x: float
) -> None:
    """b (beta - beta_min) - (T_rated - T) / E = U: no effort is lost or bought twice."""
    omega, U, b = demanded(law, wind, e, x)
    command = law.command([x, wind], Measurement(omega, 0.0, wind))
    bought = b * (command.pitch - law.pitch_min)
    bought -= (law.rated_torque - command.torque) / law.effort_torque

    assert bought == pytest.approx(U, abs=1e-9) or command.torque == 0.0


@given(wind=WINDS, e=ERRORS)
def test_more_speed_never_asks_for_less(law: EffortSharingLaw, wind: float, e: float) -> None:
    """Torque and pitch both rise with the speed error: no state in which they fight."""
    omega, _, _ = demanded(law, wind, e, 0.0)
    one, two = (
        law.command([0.0, wind], Measurement(omega + step, 0.0, wind)) for step in (0.0, 1e-3)
    )

    assert two.torque >= one.torque - 1e-6 and two.pitch >= one.pitch - 1e-12


def test_commands_are_continuous_across_every_node(law: EffortSharingLaw) -> None:
    """Only the integral's rate may step from cell to cell."""
    for wind in law.schedule.wind[1:-1]:
        left, right = (
            law.command([0.01, w], Measurement(1.2, 0.0, w)) for w in (wind - 1e-9, wind + 1e-9)
        )
        assert left.torque == pytest.approx(right.torque, abs=1e-2)
        assert left.pitch == pytest.approx(right.pitch, abs=1e-7)


def test_the_integral_is_held_at_its_limit_and_let_go(law: EffortSharingLaw) -> None:
    """At |x| = limit it may move inward alone."""
    limit = law.integral_limit
    slow, fast = Measurement(0.9, 0.0, 12.0), Measurement(1.6, 0.0, 12.0)

    assert law.state_rate([limit, 12.0], slow)[0] == 0.0
    assert law.state_rate([limit, 12.0], fast)[0] < 0.0
    assert law.state_rate([-limit, 12.0], fast)[0] == 0.0
    assert law.state_rate([-limit, 12.0], slow)[0] > 0.0


def test_torque_is_never_negative_nor_pitch_beyond_its_limit(law: EffortSharingLaw) -> None:
    """Far outside the certified set the commands stop at the limits."""
    stopped = law.command([0.0, 8.0], Measurement(0.0, 0.0, 8.0))
    racing = law.command([0.0, 25.0], Measurement(9.0, 0.0, 25.0))

    assert stopped.torque == 0.0 and stopped.pitch == law.pitch_min
    assert racing.pitch == law.pitch_max and racing.torque == law.rated_torque


def test_the_schedule_wind_stays_inside_the_table(law: EffortSharingLaw) -> None:
    """A wind estimate outside the table pulls no further than to its end."""
    assert law.initial_state(99.0)[1] == 25.0
    assert law.state_rate([0.0, 25.0], Measurement(1.2, 0.0, 99.0))[1] == 0.0
    assert law.state_rate([0.0, 3.0], Measurement(0.7, 0.0, 0.0))[1] == 0.0
    rate = law.state_rate([0.0, 10.0], Measurement(1.2, 0.0, 11.0))[1]
    assert rate == pytest.approx(1 / law.wind_filter)


def test_without_a_filter_the_estimate_is_the_schedule_wind(turbine: Turbine) -> None:
    """tau_f = 0 passes the estimate through: the state's second entry plays no part."""
    schedule = effort_schedule(turbine)
    direct = EffortSharingLaw.of(turbine, schedule, gains(schedule), wind_filter=0.0)

    one, two = (direct.command([0.0, s], Measurement(1.2, 0.0, 14.0)) for s in (3.0, 20.0))
    assert one == two
    assert direct.state_rate([0.0, 3.0], Measurement(1.2, 0.0, 14.0))[1] == 0.0


@given(wind=st.floats(3.01, 24.99), e=ERRORS, x=ERRORS, ahead=st.floats(-8, 8))
def test_the_feedforward_follows_its_formulas(
    law: EffortSharingLaw, wind: float, e: float, x: float, ahead: float
) -> None:
    """T less by E a_f, a_f = f v' in +-g; pitch more by tau_lead v' times its own slope in v_s."""
    table, fed = law.schedule, law.feedforward
    k = int(np.searchsorted(table.wind, wind, side="right")) - 1
    near = float(np.abs(table.wind - wind).min())
    assume(near > 2e-6)
    seen = float(np.clip(wind + ahead, 3.0, 25.0))
    rate = (seen - wind) / law.wind_filter
    omega, U, b = demanded(law, wind, e, x)

    moved = law.command([x, wind], Measurement(omega, 0.0, seen))

    taken = float(np.clip(fed.inertia[k] * rate, -fed.effort_limit[k], fed.effort_limit[k]))
    reserve = float(effort_ramp(-U, table.overlap)) + taken
    torque = np.clip(law.rated_torque - law.effort_torque * reserve, 0.0, law.rated_torque)
    assert moved.torque == pytest.approx(torque, abs=1e-6 * law.rated_torque)

    def shed(v: float) -> float:
        _, effort, slope = demanded(law, v, e, x)
        return float(effort_ramp(effort, table.overlap)) / slope

    h = 1e-6
    lead = fed.pitch_lead * rate * (shed(wind + h) - shed(wind - h)) / (2 * h)
    pitch = np.clip(law.pitch_min + shed(wind) + lead, law.pitch_min, law.pitch_max)
    assert moved.pitch == pytest.approx(pitch, abs=2e-6)


def test_the_pitch_lead_outruns_the_drive(turbine: Turbine) -> None:
    """On a ramp of 1 m/s^2 the drive lags the schedule by tau times its slope, or not at all."""
    schedule = effort_schedule(turbine)
    lag = {}
    for lead in (0.0, turbine.pitch_time_constant):
        none = np.zeros(len(schedule.wind) - 1)
        fed = Feedforward(none, none, lead)
        # So fast a filter that the estimate on the ramp stays within the table's winds.
        law = EffortSharingLaw.of(
            turbine, schedule, gains(schedule), feedforward=fed, wind_filter=5.0
        )
        wind, pitch, step = 15.0, schedule.pitch(15.0, turbine), 0.002
        for _ in range(1500):
            omega = float(np.interp(wind, schedule.wind, schedule.rotor_speed))
            seen = wind + law.wind_filter
            asked = law.command([0.0, wind], Measurement(omega, pitch, seen)).pitch
            pitch += step * (asked - pitch) / turbine.pitch_time_constant
            wind += step
        lag[lead] = schedule.pitch(wind, turbine) - pitch
    slope = schedule.pitch(18.0, turbine) - schedule.pitch(17.0, turbine)
    assert lag[0.0] == pytest.approx(turbine.pitch_time_constant * slope, rel=0.1)
    assert abs(lag[turbine.pitch_time_constant]) < 0.03 * lag[0.0]


def test_the_feedforward_leaves_torque_between_zero_and_rated(turbine: Turbine) -> None:
    """g fits below the trim's torque and below what it lacks to rated; 0 where omega* rests."""
    schedule = effort_schedule(turbine)
    found = known_rate_feedforward(turbine, schedule)
    reserve = effort_ramp(-schedule.trim_effort, schedule.overlap)
    full = turbine.gear_ratio * turbine.rated_torque / turbine.inertia

    assert np.all(found.effort_limit <= np.minimum(reserve[1:], (full - reserve)[:-1]))
    resting = np.diff(schedule.rotor_speed) == 0
    assert np.all(found.effort_limit[resting] == 0) and np.all(found.inertia[resting] == 0)
    assert found.effort_limit[~resting].max() > 0.01
    assert found.pitch_lead == turbine.pitch_time_constant


def test_a_feedforward_that_cannot_be_is_misuse(turbine: Turbine) -> None:
    """Sizes, signs, shares, and a law without a filter, which does not know the rate."""
    schedule = effort_schedule(turbine)
    none = np.zeros(len(schedule.wind) - 1)
    with pytest.raises(ModelError, match="as many limits"):
        Feedforward(np.ones(3), np.ones(2), 0.0)
    with pytest.raises(ModelError, match="not be negative"):
        Feedforward(none, none - 1, 0.0)
    with pytest.raises(ModelError, match="not be negative"):
        Feedforward(none, none, -0.1)
    with pytest.raises(ModelError, match="inertia_share = 2"):
        known_rate_feedforward(turbine, schedule, inertia_share=2)
    with pytest.raises(ModelError, match="2 feed-forwards for"):
        EffortSharingLaw.of(
            turbine, schedule, gains(schedule), feedforward=Feedforward(none[:2], none[:2], 0.0)
        )
    with pytest.raises(ModelError, match="without a filter"):
        EffortSharingLaw.of(
            turbine,
            schedule,
            gains(schedule),
            feedforward=known_rate_feedforward(turbine, schedule),
            wind_filter=0.0,
        )
    assert not no_feedforward(schedule).acts


def test_shares(law: EffortSharingLaw) -> None:
    """f1 runs from torque alone to pitch alone."""
    assert law.pitch_share(5.0) == 0.0 and law.pitch_share(20.0) == 1.0


def test_sizes_that_differ_are_misuse(turbine: Turbine) -> None:
    """One gain per node and one integral rate per interval, all positive."""
    with pytest.raises(ModelError, match="integral rates"):
        EffortGains(np.ones(3), np.ones(3))
    with pytest.raises(ModelError, match="positive"):
        EffortGains(np.array([1.0, 0.0]), np.ones(1))
    with pytest.raises(ModelError, match="wind nodes"):
        EffortSharingLaw.of(turbine, effort_schedule(turbine), EffortGains(np.ones(3), np.ones(2)))
