"""The reference filter of the paper's laws: its response, its rest, its place in the law."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.signal import step

from takagi.models import ModelError
from takagi.models.laws.protocol import Law, Measurement, sampled
from takagi.models.laws.published.law import PublishedLawName
from takagi.models.laws.published.reference_filter import FilteredReferenceLaw, ReferenceFilter
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.turbine_plant import design_plant
from takagi.models.simulation.wind import step_wind
from tests.models.test_paper_law import TURBINE, make_law

Array = NDArray[np.float64]
LAWS: tuple[PublishedLawName, PublishedLawName] = ("paper", "paper-two-integrators")
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


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("filter_", FILTERS)
def test_at_rest_it_is_the_law_itself(name: PublishedLawName, filter_: ReferenceFilter) -> None:
    """G_f(0) = 1: same commands, same integral rates, and the filter does not move."""
    law = make_law(name)
    filtered = FilteredReferenceLaw(law, filter_)
    for wind in (8.0, 18.0):
        measured, own = Measurement(1.2, 0.1, wind), np.full(len(law.state_names), -2.0)
        state = np.concatenate([own, filter_.rest(law.reference_speed(wind))])

        assert filtered.command(state, measured) == law.command(own, measured)
        rate = filtered.state_rate(state, measured)
        assert rate[: len(own)] == pytest.approx(law.state_rate(own, measured), abs=0)
        assert rate[len(own) :] == pytest.approx(0.0, abs=1e-15)
    assert len(state) == len(filtered.state_names)
    assert filtered.name.startswith(name)


def test_the_law_feels_the_filtered_reference() -> None:
    """A lower reference asks for more torque; each integral follows the filtered error."""
    law = make_law()
    filtered = FilteredReferenceLaw(law, ReferenceFilter(2.0))
    measured, wind = Measurement(1.0, 0.0, 8.0), 8.0
    own, reference = law.initial_state(wind), law.reference_speed(wind)
    lower = np.array([*own, reference - 0.05])

    assert filtered.command(lower, measured).torque > law.command(own, measured).torque
    assert filtered.state_rate(lower, measured)[0] == pytest.approx(reference - 0.05 - 1.0)
    assert filtered.state_rate(lower, measured)[1] == pytest.approx(0.05 / 2.0)


def test_in_region_2_it_is_a_filter_on_the_wind() -> None:
    """Where omega_ref = lambda v / R, filtering the reference is filtering the wind estimate.

    That is where the effort-sharing law's filter stands: both references agree to rounding.
    """
    law = make_law()
    filtered: Law = FilteredReferenceLaw(law, ReferenceFilter(5.0))
    state, wind = filtered.initial_state(7.0), 7.0
    for _ in range(100):
        _, state = sampled(filtered, state, Measurement(1.0, 0.0, 8.5), 0.1)
        wind = 8.5 + (wind - 8.5) * np.exp(-0.1 / 5.0)

    assert float(state[-1]) == pytest.approx(law.reference_speed(float(wind)), abs=1e-12)
    assert law.reference_speed(8.5) - float(state[-1]) > 0.01


def test_a_filter_softens_the_step_of_torque() -> None:
    """A wind step in region 2 on the design plant: torque jumps less behind the filter."""
    law, wind = make_law("paper-two-integrators"), step_wind(8.0, 9.0, 20.0, begin=5.0)
    plant = design_plant(TURBINE)
    sharp = simulate(plant, law, wind)
    soft = simulate(plant, FilteredReferenceLaw(law, ReferenceFilter(2.0)), wind)

    jumps = [float(np.abs(np.diff(run.torque_command)).max()) for run in (sharp, soft)]
    assert jumps[1] < 0.2 * jumps[0]
    assert soft.law_states.shape[1] == sharp.law_states.shape[1] + 1


def test_misuse_is_told() -> None:
    """Times, dampings and orders that make no filter."""
    with pytest.raises(ModelError, match="time_constant = 0"):
        ReferenceFilter(0.0)
    with pytest.raises(ModelError, match="damping = -1"):
        ReferenceFilter(1.0, order=2, damping=-1.0)
    with pytest.raises(ModelError, match="order 3"):
        ReferenceFilter(1.0, order=3)
