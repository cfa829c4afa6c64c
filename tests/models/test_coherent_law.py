"""The effort-sharing law as it runs: formulas, limits, continuity, and what the tables say."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Floats, ModelError, Turbine, nrel5mw
from takagi.models.laws.effort_sharing.law import (
    EffortGains,
    EffortSharingLaw,
    SetpointInputs,
)
from takagi.models.laws.effort_sharing.schedule import (
    EffortSchedule,
    effort_schedule,
    frozen_wake_effectiveness,
    speed_effort,
)
from takagi.models.laws.protocol import Measurement
from takagi.models.ramps import effort_ramp
from takagi.models.simulation.closed_loop import History, simulate
from takagi.models.simulation.turbine_plant import design_plant
from takagi.models.turbine.data import rotor_torque
from takagi.models.turbine.trim import reference_speed, trim
from tests.winds import constant_wind

WINDS = st.floats(3, 25)
ERRORS = st.floats(-0.06, 0.06)


def gains(schedule: EffortSchedule) -> EffortGains:
    count = len(schedule.wind)
    return EffortGains(np.linspace(0.1, 0.5, count), np.linspace(0.01, 0.02, count - 1))


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def schedule(turbine: Turbine) -> EffortSchedule:
    return effort_schedule(turbine)


@pytest.fixture(scope="module")
def law(turbine: Turbine, schedule: EffortSchedule) -> EffortSharingLaw:
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


def test_the_integral_is_held_at_its_limit_and_let_go(law: EffortSharingLaw) -> None:
    """At |x| = limit it may move inward alone."""
    limit = law.integral_limit
    slow, fast = Measurement(0.9, 0.0, 12.0), Measurement(1.6, 0.0, 12.0)

    assert law.state_rate([limit, 12.0], slow)[0] == 0.0
    assert law.state_rate([limit, 12.0], fast)[0] < 0.0
    assert law.state_rate([-limit, 12.0], fast)[0] == 0.0
    assert law.state_rate([-limit, 12.0], slow)[0] > 0.0


def test_torque_is_never_negative_nor_pitch_beyond_its_limit(law: EffortSharingLaw) -> None:
    stopped = law.command([0.0, 8.0], Measurement(0.0, 0.0, 8.0))
    racing = law.command([0.0, 25.0], Measurement(9.0, 0.0, 25.0))

    assert stopped.torque == 0.0 and stopped.pitch == law.pitch_min
    assert racing.pitch == law.pitch_max and racing.torque == law.rated_torque


def test_the_schedule_wind_stays_inside_the_table(law: EffortSharingLaw) -> None:
    assert law.initial_state(99.0)[1] == 25.0
    assert law.state_rate([0.0, 25.0], Measurement(1.2, 0.0, 99.0))[1] == 0.0
    assert law.state_rate([0.0, 3.0], Measurement(0.7, 0.0, 0.0))[1] == 0.0
    rate = law.state_rate([0.0, 10.0], Measurement(1.2, 0.0, 11.0))[1]
    assert rate == pytest.approx(1 / law.wind_filter)


def test_without_a_filter_the_estimate_is_the_schedule_wind(
    turbine: Turbine, schedule: EffortSchedule
) -> None:
    """tau_f = 0 passes the estimate through: the state's second entry plays no part."""
    direct = EffortSharingLaw.of(turbine, schedule, gains(schedule), wind_filter=0.0)

    one, two = (direct.command([0.0, s], Measurement(1.2, 0.0, 14.0)) for s in (3.0, 20.0))
    assert one == two
    assert direct.state_rate([0.0, 3.0], Measurement(1.2, 0.0, 14.0))[1] == 0.0


def test_shares(law: EffortSharingLaw) -> None:
    """f1 runs from torque alone to pitch alone."""
    assert law.pitch_share(5.0) == 0.0 and law.pitch_share(20.0) == 1.0


def test_sizes_that_differ_are_misuse(turbine: Turbine, schedule: EffortSchedule) -> None:
    with pytest.raises(ModelError, match="integral rates"):
        EffortGains(np.ones(3), np.ones(3))
    with pytest.raises(ModelError, match="positive"):
        EffortGains(np.array([1.0, 0.0]), np.ones(1))
    with pytest.raises(ModelError, match="wind nodes"):
        EffortSharingLaw.of(turbine, schedule, EffortGains(np.ones(3), np.ones(2)))


def test_nodes_are_trims(turbine: Turbine, schedule: EffortSchedule) -> None:
    """At every node aerodynamic and generator torque balance to 1e-6 of rated torque."""
    for v, omega in zip(schedule.wind, schedule.rotor_speed, strict=True):
        driving = float(rotor_torque(turbine, omega, schedule.pitch(v, turbine), v))
        held = turbine.gear_ratio * schedule.torque(v, turbine)
        assert driving == pytest.approx(held, abs=1e-6 * turbine.gear_ratio * turbine.rated_torque)


def test_far_from_rated_the_trim_is_the_plants(turbine: Turbine, schedule: EffortSchedule) -> None:
    for v in (4.0, 6.0, 8.0, 10.0, 13.0, 15.0, 20.0, 25.0):
        k = int(np.argmin(np.abs(schedule.wind - v)))
        node = float(schedule.wind[k])
        if abs(schedule.trim_effort[k]) < schedule.overlap:
            continue
        point = trim(turbine, node)
        assert schedule.rotor_speed[k] == pytest.approx(point.rotor_speed, abs=1e-8)
        assert schedule.pitch(node, turbine) == pytest.approx(point.pitch, abs=1e-6)
        assert schedule.torque(node, turbine) == pytest.approx(point.torque, rel=1e-5)


def test_columns_are_short_decimals_in_order(turbine: Turbine, schedule: EffortSchedule) -> None:
    assert schedule.wind[0] == turbine.cut_in and schedule.wind[-1] == turbine.cut_out
    assert np.all(np.diff(schedule.wind) > 0)
    for column in (schedule.wind, schedule.rotor_speed, schedule.trim_effort):
        assert np.all(np.round(column, 9) == column)
    assert np.all(np.diff(schedule.trim_effort) > 0)


def test_every_kink_of_the_reference_is_a_node(turbine: Turbine, schedule: EffortSchedule) -> None:
    """Linear interpolation of omega* between nodes is exact to the rounding of the kinks' winds."""
    winds = np.linspace(turbine.cut_in, turbine.cut_out, 400)
    speeds = [reference_speed(turbine, float(v)) for v in winds]

    assert np.interp(winds, schedule.wind, schedule.rotor_speed) == pytest.approx(speeds, abs=2e-5)


def test_frozen_wake_is_the_published_sensitivity(turbine: Turbine) -> None:
    """At the published winds: dP/dbeta over rated speed and inertia; below, with v squared."""
    table = turbine.frozen_wake
    for v, power in zip(table.wind, table.power_sensitivity, strict=True):
        expected = -power / (turbine.rated_rotor_speed * turbine.inertia)
        assert frozen_wake_effectiveness(turbine, v) == pytest.approx(expected)
    first = float(table.wind[0])
    below = frozen_wake_effectiveness(turbine, first / 2)
    assert below == pytest.approx(frozen_wake_effectiveness(turbine, first) / 4)


def test_a_lower_set_point_is_followed(turbine: Turbine) -> None:
    """A de-rated set-point caps omega* and moves rated wind; nodes stay trims."""
    low = effort_schedule(turbine, speed_setpoint=1.15)

    assert low.rotor_speed.max() == pytest.approx(1.15)
    v, omega = float(low.wind[-1]), float(low.rotor_speed[-1])
    driving = float(rotor_torque(turbine, omega, low.pitch(v, turbine), v))
    assert driving == pytest.approx(turbine.gear_ratio * low.torque(v, turbine), rel=1e-6)


@pytest.mark.parametrize("options", [{"overlap": 0.0}, {"effectiveness_share": -1.0}])
def test_bad_settings_are_misuse(turbine: Turbine, options: dict[str, float]) -> None:
    with pytest.raises(ModelError, match="positive"):
        effort_schedule(turbine, **options)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"wind": np.array([2.0, 1.0])}, "increase"),
        ({"trim_effort": np.array([0.0])}, "trim_effort"),
        ({"rotor_speed": np.array([1.0, np.nan])}, "rotor_speed"),
        ({"effectiveness": np.array([1.0, 0.0])}, "positive"),
        ({"overlap": 0.0}, "positive"),
    ],
)
def test_columns_are_checked_at_the_door(change: dict[str, object], words: str) -> None:
    good: dict[str, object] = {
        "wind": np.array([3.0, 4.0]),
        "rotor_speed": np.ones(2),
        "trim_effort": np.zeros(2),
        "effectiveness": np.ones(2),
        "effectiveness_limit": np.ones(2),
        "overlap": 0.01,
    }
    with pytest.raises(ModelError, match=words):
        EffortSchedule(**(good | change))  # type: ignore[arg-type]


@pytest.mark.parametrize(("low", "high"), [(6.0, 25.0), (3.0, 12.0), (11.0, 25.0)])
def test_a_short_range_of_winds_has_no_node_outside(
    turbine: Turbine, low: float, high: float
) -> None:
    """Cut-in above 5 m/s, above the fine nodes, and cut-out just above rated wind."""
    wind = effort_schedule(replace(turbine, cut_in=low, cut_out=high)).wind

    assert (wind[0], wind[-1]) == (low, high)


FAULT = (5.0, 45.0)


@dataclass(frozen=True)
class Stuck:
    """A wind estimate that stands at 20 m/s from 5 to 45 s, and is true else."""

    wind: float

    def initial_state(self, rotor_speed: float, wind: float) -> Floats:
        return np.zeros(1)

    def wind_estimate(self, state: Floats) -> float:
        return 20.0 if FAULT[0] <= state[0] < FAULT[1] else self.wind

    def state_rate(self, state: Floats, rotor_speed: float, pitch: float, torque: float) -> Floats:
        return np.ones(1)


def faulty(turbine: Turbine, limit: float) -> History:
    """Return 90 s at 14 m/s with an estimate that is 6 m/s too high for 40 s."""
    schedule = effort_schedule(turbine)
    count = len(schedule.wind)
    gains = EffortGains(np.full(count, 0.6), np.full(count - 1, 0.15))
    law = replace(EffortSharingLaw.of(turbine, schedule, gains), integral_limit=limit)
    return simulate(design_plant(turbine), law, constant_wind(14.0, 90.0), observer=Stuck(14.0))


@pytest.mark.slow
def test_the_limit_shortens_the_way_back(turbine: Turbine) -> None:
    """Far outside the certified set |x| stops at its limit; overspeed after the fault is halved."""
    held, free = faulty(turbine, 0.1), faulty(turbine, 10.0)
    rated = turbine.rated_rotor_speed
    after = held.time > FAULT[1]

    assert np.abs(held.law_states[:, 0]).max() == pytest.approx(0.1, abs=1e-12)
    assert np.abs(free.law_states[:, 0]).max() > 0.2
    assert held.rotor_speed.min() < 0.95 * rated
    overspeed = [float(run.rotor_speed[after].max() / rated - 1) for run in (held, free)]
    assert overspeed[0] < 0.06 and overspeed[0] < 0.6 * overspeed[1]


@pytest.fixture(scope="module")
def with_setpoints(turbine: Turbine, law: EffortSharingLaw) -> EffortSharingLaw:
    inputs = SetpointInputs(
        1.05,
        0.92 * turbine.rated_torque,
        turbine.generator_efficiency * turbine.gear_ratio,
        speed_effort(turbine, law.schedule, 1.05),
    )
    return replace(law, setpoints=inputs)


@pytest.mark.parametrize(
    ("speed", "power", "speed_share", "torque_share"),
    [
        (2.0, 1.2, 1.0, 1.0),
        (2.0, 0.95, 1.0, 0.95),
        # Below the lowest torque the speed falls, and below the lowest speed nothing does.
        (2.0, 0.85, 0.85 / 0.92, 0.92),
        (2.0, 0.1, 1.05, 0.92),
        # A speed set-point leaves torque at rated, and never above it.
        (1.1, 1.0, 1.1, 1.0),
        (0.5, 1.0, 1.05, 1.0),
    ],
)
def test_set_points_lower_torque_first(
    turbine: Turbine,
    with_setpoints: EffortSharingLaw,
    speed: float,
    power: float,
    speed_share: float,
    torque_share: float,
) -> None:
    """A share of the rated speed below 1 is one, a number above 1 is a speed [rad/s]."""
    rated = turbine.rated_rotor_speed
    operation = with_setpoints.at_setpoints(
        speed=speed, power=power * turbine.rated_power
    ).operation

    assert operation is not None
    expected = speed_share if speed_share > 1 else speed_share * rated
    assert operation.speed == pytest.approx(expected, rel=1e-6)
    assert operation.torque == pytest.approx(torque_share * turbine.rated_torque, rel=1e-6)


@given(wind=WINDS, e=ERRORS, x=ERRORS)
def test_rated_set_points_change_nothing(
    turbine: Turbine,
    law: EffortSharingLaw,
    with_setpoints: EffortSharingLaw,
    wind: float,
    e: float,
    x: float,
) -> None:
    measured = Measurement(demanded(law, wind, e, x)[0], 0.1, wind)
    rated = with_setpoints.at_setpoints(speed=99.0, power=2 * turbine.rated_power)

    assert rated.command([x, wind], measured) == pytest.approx(law.command([x, wind], measured))
    assert rated.state_rate([x, wind], measured) == pytest.approx(
        law.state_rate([x, wind], measured)
    )


@pytest.mark.parametrize("wind", [8.0, 11.0, 14.0, 20.0, 25.0])
def test_speed_effort_is_that_of_the_trim_at_the_lowest_speed(
    turbine: Turbine, with_setpoints: EffortSharingLaw, wind: float
) -> None:
    """Second way: the trim of a turbine that is de-rated to this speed."""
    law = with_setpoints.at_setpoints(speed=1.05, power=9e9)
    point = trim(turbine, wind, speed_setpoint=1.05)

    command = law.command([0.0, wind], Measurement(point.rotor_speed, point.pitch, wind))

    # The tables are lines between their nodes.
    assert command.torque == pytest.approx(point.torque, rel=0.02)
    assert command.pitch == pytest.approx(point.pitch, abs=0.01)
