"""The published law: its rules, its rest points, and what no placement of the ramp can do."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import step

from takagi.models import ModelError, nrel5mw
from takagi.models.laws.protocol import Law, Measurement, sampled
from takagi.models.laws.published.law import (
    FilteredReferenceLaw,
    PublishedLaw,
    ReferenceFilter,
    equilibrium,
    published_law,
    switched_law,
)
from takagi.models.laws.published.regional_schedule import (
    RegionalSchedule,
    Variant,
    coupling_filter,
    regional_schedule,
)
from takagi.models.ramps import Shape
from takagi.models.turbine.trim import trim
from tests.paper_models import loop_rate, regional_models

TURBINE = nrel5mw()
RATED = TURBINE.rated_rotor_speed
WINDS = (4.5, 7.0, 9.5, 10.6, 11.2, 11.4, 11.6, 12.5, 15.0, 20.0, 25.0)

speeds = st.floats(0.6, 1.5)
pitches = st.floats(0.0, 0.5)
winds = st.floats(3.0, 25.0)
integrals = st.floats(-12.0, 1.0)


@cache
def schedules(uniform: bool = False) -> tuple[RegionalSchedule, RegionalSchedule]:
    """Gains of the size that the regional designs have; ``uniform`` makes all rules alike."""
    partial, full = regional_models()
    spread = np.zeros(4) if uniform else np.linspace(-1, 1, 4)
    k_b, i_b = -77e3 + 8e3 * spread, -8.9e3 - 500 * spread
    wide = np.zeros(8) if uniform else np.linspace(-1, 1, 8)
    k_c = np.column_stack([-0.4 + 0.05 * wide, -0.6 - 0.05 * wide])
    return (
        regional_schedule(TURBINE, partial, k_x=k_b[:, None], k_I=i_b),
        regional_schedule(TURBINE, full, k_x=k_c, k_I=-0.075 + 0.009 * wide),
    )


def make_law(
    *,
    placement: float = 0.5,
    speed_overlap: float = 0.1,
    variant: Variant = "saturated",
    shape: Shape = "smooth",
    uniform: bool = False,
) -> PublishedLaw:
    partial, full = schedules(uniform)
    coupling = coupling_filter(
        TURBINE, placement=placement, speed_overlap=speed_overlap, variant=variant, shape=shape
    )
    return published_law(TURBINE, partial=partial, full=full, coupling=coupling)


@given(speeds, pitches, winds, integrals)
def test_the_switched_law_is_the_limit_of_no_overlap(
    speed: float, pitch: float, wind: float, integral: float
) -> None:
    """Next to the switching point too, where the pitch reference jumps by all of u_2."""
    ramp, law = make_law(speed_overlap=1e-9, placement=0.0), switched_law(make_law())
    narrow = replace(ramp, coupling=replace(ramp.coupling, torque_overlap=1e-6))
    state = np.array([integral])
    for at in (speed, RATED - 2e-9, RATED):
        seen = Measurement(at, pitch, wind)
        assert law.command(state, seen) == pytest.approx(narrow.command(state, seen), rel=1e-9)
        wanted = law.blended(state, seen)
        assert wanted.blended_pitch == (wanted.pitch if at >= RATED else 0.0)


@given(speeds, pitches, winds, integrals)
def test_triple_sum_is_the_blended_law(
    speed: float, pitch: float, wind: float, integral: float
) -> None:
    """sum h^a_m h^b_i h^c_j F_m (-k_x dx + k_I x_I) over all 128 rules is what the law commands."""
    law, state = make_law(), np.array([integral])
    seen = Measurement(speed, pitch, wind)
    deviation = [speed - law.reference_speed(wind), pitch]
    b, c = law.partial, law.full
    h_a = law.coupling.memberships(speed, law.blended(state, seen).torque)
    h_b, h_c = b.memberships_at(*seen), c.memberships_at(*seen)
    weights = np.einsum("m,i,j->mij", h_a, h_b, h_c)
    rules = [
        F @ (k @ [integral, *deviation])
        for F in law.coupling.corners
        for k in (
            np.stack([[b.k_I[i], *-b.k_x[i]], [c.k_I[j], *-c.k_x[j]]])
            for i in range(len(h_b))
            for j in range(len(h_c))
        )
    ]
    total = weights.ravel() @ np.array(rules)
    found = law.blended(state, seen)
    # Above the largest command that the filter has corners for, the torque limit takes over.
    torque = float(total[0])

    assert float(weights.sum()) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(
        [min(max(torque, 0.0), TURBINE.rated_torque), total[1]],
        [law.command(state, seen).torque, found.blended_pitch],
        rtol=1e-9,
        atol=1e-9,
    )


@given(st.floats(-0.1, 0.1), st.floats(-0.034, 0.034), st.floats(12.0, 25.0), integrals)
def test_scheduled_gains_agree_with_the_model(
    error: float, angle: float, wind: float, integral: float
) -> None:
    """The loop's floats and the model's vectorised memberships blend the same pitch command."""
    law = make_law()
    point = trim(TURBINE, wind)
    speed, pitch = point.rotor_speed + error, max(point.pitch + angle, 0.0)
    model = law.full.model
    z = model.premise_values(rotor_speed=speed, pitch=pitch, wind=wind, wind_estimate=wind)
    h = model.memberships(z)
    expected = h @ (law.full.k_I * integral - law.full.k_x @ [error, pitch])
    found = law.blended(np.array([integral]), Measurement(speed, pitch, wind)).pitch

    assert found == pytest.approx(float(expected), abs=1e-6)


@given(st.floats(-0.1, 0.1), st.floats(4.2, 11.4))
def test_fast_premises_agree_with_the_partial_load_model(error: float, wind: float) -> None:
    """Premises on floats equal those of the model, also where the secant becomes a derivative."""
    schedule = schedules()[0]
    speed = make_law().reference_speed(wind) + error
    exact = schedule.model.premise_values(rotor_speed=speed, wind=wind, wind_estimate=wind)

    for evaluate, value in zip(schedule.evaluators, exact, strict=True):
        assert evaluate(speed, 0.0, wind) == pytest.approx(float(value), abs=1e-7)


@given(speeds, pitches, winds, integrals, st.sampled_from(["saturated", "sector"]))
def test_commands_stay_within_the_limits(
    speed: float, pitch: float, wind: float, integral: float, variant: Variant
) -> None:
    """Torque lies in 0..T_rated and pitch in its range, whatever the integrals say."""
    law = make_law(variant=variant)
    command = law.command(np.array([integral]), Measurement(speed, pitch, wind))

    assert 0.0 <= command.torque <= TURBINE.rated_torque
    assert TURBINE.pitch_min <= command.pitch <= TURBINE.pitch_max


@pytest.mark.parametrize("variant", ["saturated", "sector"])
@pytest.mark.parametrize("placement", [0.0, 0.5, 1.0])
def test_equilibria_are_rest_points(placement: float, variant: Variant) -> None:
    law = make_law(placement=placement, variant=variant)
    for point in (equilibrium(law, wind) for wind in WINDS):
        if point.kind != "none":
            z = np.array([point.rotor_speed, point.pitch, point.integral])
            np.testing.assert_allclose(loop_rate(law, point.wind, z, clip=True), 0.0, atol=1e-8)


def test_region_25_spends_pitch_and_power() -> None:
    """With the ramp centred, 11 m/s rests at degrees of pitch and a fraction of the power."""
    point = equilibrium(make_law(placement=0.5), 11.0)

    assert (point.kind, point.trim.region) == ("shifted", "2.5")
    assert point.rotor_speed == pytest.approx(point.trim.rotor_speed)
    assert point.pitch - point.trim.pitch > radians(3) and point.power_ratio < 0.7


def test_full_load_integral_is_the_published_balance() -> None:
    """x_I* = (1 + f_1 k_p) b*/(f_1 k_I), where the torque that it commands exceeds rated."""
    law = make_law(uniform=True, shape="linear")
    point = equilibrium(law, 25.0)
    k_p, k_i = law.full.k_x[0, 1], law.full.k_I[0]

    assert point.kind == "intended"
    assert point.integral == pytest.approx((1 + 0.5 * k_p) * point.trim.pitch / (0.5 * k_i))
    assert law.partial.k_I[0] * point.integral > TURBINE.rated_torque


def test_initial_state_rests_at_the_trim_in_region_2() -> None:
    """At 8 m/s the law starts, and stays, at the turbine's own trim."""
    law, point = make_law(), trim(TURBINE, 8.0)
    state = law.initial_state(8.0)
    seen = Measurement(point.rotor_speed, point.pitch, 8.0)

    assert len(state) == len(law.state_names)
    assert law.command(state, seen).torque == pytest.approx(point.torque)
    np.testing.assert_allclose(law.state_rate(state, seen), 0.0, atol=1e-12)


def test_initial_state_without_equilibrium_gives_the_trim_torque() -> None:
    law = make_law(placement=1.0)

    assert equilibrium(law, 15.0).kind == "none"
    x = law.initial_state(15.0)
    point = trim(TURBINE, 15.0)
    seen = Measurement(point.rotor_speed, point.pitch, 15.0)
    assert law.blended(x, seen).torque == pytest.approx(TURBINE.rated_torque)


@pytest.mark.parametrize(("wind", "end"), [(25.4, 25.0), (2.5, 3.0)])
def test_initial_state_outside_the_range_is_that_of_its_end(wind: float, end: float) -> None:
    """The first wind of a turbulent one about 24 m/s may be above cut-out."""
    law = make_law()

    assert law.initial_state(wind) == pytest.approx(law.initial_state(end))


def test_reference_speed_is_the_trim_speed() -> None:
    """omega_ref of the loop is the trim's, region 1.5 included, and held outside the wind range."""
    law = make_law()
    for wind in (3.0, 3.4, 4.0, 6.0, 9.0, 10.5, 25.0):
        assert law.reference_speed(wind) == pytest.approx(trim(TURBINE, wind).rotor_speed)
    assert law.reference_speed(40.0) == RATED


def test_wrong_sign_of_the_integral_gain_is_refused() -> None:
    """K_I instead of k_I = -K_I would drive the loop away; the message says which rule."""
    partial, full = schedules()
    flipped = RegionalSchedule(full.model, full.k_x, -full.k_I, full.evaluators)
    with pytest.raises(ModelError, match=r"give k_I = -K_I"):
        published_law(TURBINE, partial=partial, full=flipped, coupling=coupling_filter(TURBINE))


def test_misuse_is_explained() -> None:
    partial, _ = schedules()
    with pytest.raises(ModelError, match="one row per rule"):
        regional_schedule(TURBINE, partial.model, k_x=np.zeros((3, 1)), k_I=np.zeros(4))


FILTERS = (ReferenceFilter(2.0), ReferenceFilter(1.5, order=2, damping=0.7))


def transfer(filter_: ReferenceFilter) -> tuple[list[float], list[float]]:
    """Return numerator and denominator of G_f(s) from its formula."""
    tau = filter_.time_constant
    if filter_.order == 1:
        return [1.0], [tau, 1.0]
    return [1.0], [tau**2, 2 * filter_.damping * tau, 1.0]


@pytest.mark.parametrize("filter_", FILTERS)
def test_a_step_answers_as_the_transfer_function(filter_: ReferenceFilter) -> None:
    """Sampled every 0.1 s against scipy's step response, exact to rounding; G_f(0) = 1."""
    times, wanted = step(transfer(filter_), T=np.linspace(0.0, 12.0, 121))
    state, found = filter_.rest(0.0), []
    for _ in times:
        found.append(float(state[0]))
        state = filter_.after(state, 1.0, 0.1)

    assert np.array(found) == pytest.approx(wanted, abs=1e-6)
    assert filter_.after(filter_.rest(0.0), 1.0, 60.0)[0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("filter_", FILTERS)
def test_the_rate_and_the_sample_are_one_filter(filter_: ReferenceFilter) -> None:
    """An ordinary solver on ``rate`` reaches what ``after`` says."""
    begin = filter_.rest(0.9)
    solved = solve_ivp(lambda _, z: filter_.rate(z, 1.2), (0.0, 1.7), begin, rtol=1e-10, atol=1e-12)

    assert filter_.after(begin, 1.2, 1.7) == pytest.approx(solved.y[:, -1], abs=1e-8)


@pytest.mark.parametrize("filter_", FILTERS)
def test_at_rest_it_is_the_law_itself(filter_: ReferenceFilter) -> None:
    """G_f(0) = 1: same commands, same integral rates, and the filter does not move."""
    law = make_law()
    filtered = FilteredReferenceLaw(law, filter_)
    for wind in (8.0, 18.0):
        measured, own = Measurement(1.2, 0.1, wind), np.full(len(law.state_names), -2.0)
        state = np.concatenate([own, filter_.rest(law.reference_speed(wind))])

        assert filtered.command(state, measured) == law.command(own, measured)
        rate = filtered.state_rate(state, measured)
        assert rate[: len(own)] == pytest.approx(law.state_rate(own, measured), abs=0)
        assert rate[len(own) :] == pytest.approx(0.0, abs=1e-15)
    assert len(state) == len(filtered.state_names)
    assert filtered.name.startswith(law.name)


def test_the_law_feels_the_filtered_reference() -> None:
    law = make_law()
    filtered = FilteredReferenceLaw(law, ReferenceFilter(2.0))
    measured, wind = Measurement(1.0, 0.0, 8.0), 8.0
    own, reference = law.initial_state(wind), law.reference_speed(wind)
    lower = np.array([*own, reference - 0.05])

    assert filtered.command(lower, measured).torque > law.command(own, measured).torque
    assert filtered.state_rate(lower, measured)[0] == pytest.approx(reference - 0.05 - 1.0)
    assert filtered.state_rate(lower, measured)[1] == pytest.approx(0.05 / 2.0)


def test_in_region_2_it_is_a_filter_on_the_wind() -> None:
    """Where omega_ref = lambda v / R, filtering the reference is filtering the wind estimate."""
    law = make_law()
    filtered: Law = FilteredReferenceLaw(law, ReferenceFilter(5.0))
    state, wind = filtered.initial_state(7.0), 7.0
    for _ in range(100):
        _, state = sampled(filtered, state, Measurement(1.0, 0.0, 8.5), 0.1)
        wind = 8.5 + (wind - 8.5) * np.exp(-0.1 / 5.0)

    assert float(state[-1]) == pytest.approx(law.reference_speed(float(wind)), abs=1e-12)
    assert law.reference_speed(8.5) - float(state[-1]) > 0.01


def test_misuse_is_told() -> None:
    with pytest.raises(ModelError, match="time_constant = 0"):
        ReferenceFilter(0.0)
    with pytest.raises(ModelError, match="damping = -1"):
        ReferenceFilter(1.0, order=2, damping=-1.0)
    with pytest.raises(ModelError, match="order 3"):
        ReferenceFilter(1.0, order=3)
