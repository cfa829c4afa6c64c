"""Laws after a disturbance: the vectorised ones against those that run, and outcomes told apart."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import pytest

from takagi.certificates.campaign import certified_loop
from takagi.certificates.claims.turbine import published_law_data
from takagi.certificates.document import turbine_data
from takagi.models import Turbine, full_load_model, nrel5mw, partial_load_model
from takagi.models.laws import Measurement, PublishedLaw, published_law
from takagi.models.laws.published.coupling_filter import coupling_filter
from takagi.models.laws.published.regional_schedule import regional_schedule

laws: Any = import_module("trial_laws")
plant: Any = import_module("trial_plant")
trials: Any = import_module("disturbance_trials")
advance, rotor_of = plant.advance, plant.rotor_of

NAMES = ("paper", "paper-two-integrators")


@pytest.fixture(scope="module")
def schedules() -> tuple[Turbine, Any, Any]:
    """Regions with made-up gains, alike at the two corners of d: no LMI is solved here."""
    turbine, draw, found = nrel5mw(), np.random.default_rng(6), []
    for model, scale in (
        (partial_load_model(turbine), (-4e5, 0.0, -1e4)),
        (full_load_model(turbine), (-0.8, 0.3, -0.1)),
    ):
        by_corner: dict[tuple[int, ...], np.ndarray] = {}
        rows = [
            by_corner.setdefault(tuple(rule[:-1]), np.array(scale) * draw.uniform(0.5, 1.5, 3))
            for rule in model.rules
        ]
        k = np.array(rows)
        found.append(regional_schedule(turbine, model, k_x=k[:, :2], k_I=k[:, 2]))
    return turbine, found[0], found[1]


def law_of(schedules: tuple[Turbine, Any, Any], name: Any) -> PublishedLaw:
    """The published law with a centred ramp of 0.1 rad/s."""
    turbine, partial, full = schedules
    coupling = coupling_filter(turbine, speed_overlap=0.1)
    return published_law(turbine, partial=partial, full=full, coupling=coupling, name=name)


@pytest.mark.parametrize("name", [NAMES[0], pytest.param(NAMES[1], marks=pytest.mark.slow)])
def test_published_laws_are_those_that_run(schedules: Any, name: str) -> None:
    """Torque, pitch and integrals at random states over all winds, saturated ones among them."""
    law, draw, n = law_of(schedules, name), np.random.default_rng(7), 60
    data = published_law_data(law)
    rotor = rotor_of(turbine_data(law.turbine, []))
    ramp = law.coupling.speed_ramp
    trial = laws.published_trial(
        data, rotor, ramp_start=np.full(n, ramp.start), ramp_width=np.full(n, ramp.width)
    )
    wind = draw.uniform(4, 25, n)
    speed = np.minimum(0.12 * wind, 1.267) * draw.uniform(0.93, 1.07, n)
    pitch = draw.uniform(0, 0.42, n)
    own = draw.uniform(-6, 1, (len(law.state_names), n))
    found = trial(speed, pitch, own, wind)
    for i in range(n):
        seen = Measurement(speed[i], pitch[i], wind[i])
        command, rate = law.command(own[:, i], seen), law.state_rate(own[:, i], seen)
        assert found.torque[i] == pytest.approx(command.torque, rel=1e-9)
        assert found.pitch[i] == pytest.approx(command.pitch, abs=1e-10)
        assert found.rate[:, i] == pytest.approx(rate, abs=1e-10)
    assert len(np.unique(found.torque)) > 10
    assert len(np.unique(found.pitch)) > 10


def test_coherent_law_is_the_one_that_runs(built: Any) -> None:
    """With its own filter: both states move as the law says."""
    loop, law, draw, n = certified_loop(built.document), built.law, np.random.default_rng(8), 40
    trial = laws.effort_sharing_trial(loop, law.wind_filter)
    own = np.stack([draw.uniform(-0.02, 0.02, n), draw.uniform(3.1, 24.9, n)])
    wind, pitch = draw.uniform(3, 25, n), draw.uniform(0, 0.4, n)
    speed = np.interp(own[1], loop.wind, loop.tables[0]) + draw.uniform(-0.03, 0.03, n)
    found = trial(speed, pitch, own, wind)
    for i in range(n):
        seen = Measurement(speed[i], pitch[i], wind[i])
        command = law.command(own[:, i], seen)
        assert found.torque[i] == pytest.approx(command.torque, rel=1e-9)
        held = min(max(found.pitch[i], loop.pitch_min), loop.pitch_max)
        assert held == pytest.approx(command.pitch, abs=1e-10)
        assert found.rate[:, i] == pytest.approx(law.state_rate(own[:, i], seen), abs=1e-12)


def test_second_order_drive_rings_as_its_damping_says(built: Any) -> None:
    """Overshoot of a step is exp(-pi z / sqrt(1 - z^2)): 4.6 % at z = 0.7 (any textbook)."""
    rotor = rotor_of(built.document["model"], frequency=2 * np.pi, damping=0.7)
    state = np.array([[1.267], [0.2], [0.0]])
    one = np.ones(1)

    def still(speed: Any, pitch: Any, own: Any, wind: Any) -> Any:
        torque = rotor.acceleration(speed, pitch, wind) / rotor.gear_scale
        return plant.TrialCommand(torque, 0.21 * one, np.zeros((0, 1)))

    highest = 0.0
    for _ in range(200):
        state, _ = advance(rotor, still, state, (15 * one, 15 * one, 15 * one), 0.01)
        highest = max(highest, float(state[1, 0]))
    overshoot = np.exp(-np.pi * 0.7 / np.sqrt(1 - 0.49))
    assert (highest - 0.21) / 0.01 == pytest.approx(overshoot, rel=2e-2)
    assert state[0, 0] == pytest.approx(1.267, abs=1e-9)


@pytest.mark.slow
def test_outcomes_are_told_apart(built: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that holds the trim stays, one that waves pitch cycles, one that lets go is lost."""
    monkeypatch.setattr(trials, "DURATION", 30.0)
    monkeypatch.setattr(trials, "JUDGED", 8.0)
    rotor = rotor_of(built.document["model"])
    wind, speed = np.full(3, 18.0), np.full(3, 1.267)
    rest = np.stack([speed, np.full(3, 0.25), 0 * wind, 0 * wind])

    def law(omega: Any, pitch: Any, own: Any, v: Any) -> Any:
        hold = rotor.acceleration(omega, pitch, v) + 0.5 * (omega - 1.267)
        torque = np.where([True, True, False], hold / rotor.gear_scale, 0.0)
        asked = 0.25 + np.array([0.0, 0.01, 0.0]) * np.sin(own[0])
        return plant.TrialCommand(torque, asked, np.ones((1, 3)))

    found = trials.tried(
        rotor,
        law,
        rest,
        wind,
        [trials.Disturbance("speed", speed=-0.01)] * 3,
        rated_speed=1.267,
    )
    assert found.code.tolist() == [trials.STAYS, trials.CYCLES, trials.LOST]
    assert found.moves[1] == pytest.approx(0.02, rel=0.1)


def test_a_gust_comes_and_goes() -> None:
    """1 - cos: nothing before and after, its height in the middle."""
    gust = trials.Disturbance("gust", gust=3.0, lasts=10.0)
    assert [gust.wind(t) for t in (0.0, 5.0, 10.0, 15.0, 60.0)] == pytest.approx([0, 0, 3, 0, 0])


def test_rotor_is_a_value(built: Any) -> None:
    """The first-order drive is the design model's own unless another is asked for."""
    assert isinstance(rotor := rotor_of(built.document["model"]), plant.TrialRotor)
    assert (rotor.frequency, rotor.lag) == (0.0, 0.2)
