"""Campaigns: none of the certified bounds is exceeded inside, and a wrong one is found."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.campaign.motion import (
    BOUNDS,
    CertifiedLoop,
    State,
    _start,
    certified_loop,
    command,
    errors,
    rates,
    schedule,
    step,
)
from takagi.certificates.campaign.runs import INSIDE, Campaign, beyond_of, run_campaigns
from takagi.models import ModelError
from takagi.models.laws.protocol import Measurement
from takagi.models.turbine.data import rotor_torque, rotor_torque_gradient

Run = Callable[..., Campaign]


@pytest.fixture
def campaign(built: Any, tmp_path: Path) -> Run:
    def run(change: Any = None, beyond: str | None = None, **numbers: Any) -> Campaign:
        document = deepcopy(built.document)
        if change is not None:
            change(document["claims"][0])
        path = tmp_path / "certificate.json"
        path.write_text(json.dumps(document), encoding="utf-8")
        classes = [INSIDE if beyond is None else beyond_of(beyond)]
        numbers = {"runs": 200, "duration": 1.0, "seed": 2, **numbers}
        return run_campaigns(path, tmp_path / "results", classes, workers=1, **numbers)[0]

    return run


def test_no_run_exceeds_a_certified_bound(campaign: Run) -> None:
    """Every bound; peaks are attained by starts; decays where the wind is constant."""
    made = campaign(runs=250, duration=4.0, seed=1)
    largest = np.nanmax(made.share, axis=1)

    assert made.violations == 0
    assert largest[0] > 0.999999
    assert np.all(largest[1:5] > 0.9999)
    assert np.all(largest <= 1)
    assert 0.3 < largest[BOUNDS.index("decay")] <= 1
    assert np.isnan(made.share[-1]).sum() == 250 * 21 // 25
    assert made.events["end_value"].max() < 1


def test_a_run_is_the_same_whatever_is_beside_it(campaign: Run) -> None:
    """With more runs than in one task, and alone; another seed gives others."""
    numbers = ((260, 5), (30, 5), (30, 6))
    many, few, other = (campaign(runs=n, duration=0.2, seed=seed) for n, seed in numbers)

    assert np.array_equal(many.share[:, :30], few.share, equal_nan=True)
    assert not np.array_equal(few.share[0], other.share[0])


def smaller(peak: str, share: float = 0.95) -> Any:
    def change(claim: dict[str, Any]) -> None:
        claim["peaks"][peak] *= share

    return change


@pytest.mark.parametrize(
    ("bound", "change"),
    [
        ("speed error", smaller("speed_error")),
        ("effort lag", smaller("effort_lag")),
        ("speed signal", smaller("speed_signal")),
        ("integral", smaller("integral")),
        ("rotor speed", smaller("speed_error", 0.85)),
        ("common decay", lambda claim: claim["settling"].update(decay_rate=0.2)),
        ("decay", lambda claim: [cell.update(decay_rate=1.0) for cell in claim["cells"]]),
    ],
)
def test_a_bound_made_too_small_is_found_exceeded(campaign: Run, bound: str, change: Any) -> None:
    """A few percent off a peak, a decay that no loop of the family has."""
    made = campaign(change)

    assert made.violations > 0
    assert made.broken[BOUNDS.index(bound)].any()
    assert (made.events["first"] == BOUNDS.index(bound)).any() or bound == "rotor speed"


def test_a_set_that_is_not_invariant_is_left(campaign: Run) -> None:
    """P with its coupling of speed and integral turned round: still an ellipsoid, not kept."""

    def turned(claim: dict[str, Any]) -> None:
        P = np.array(claim["P"])
        P[0, 2], P[2, 0] = -P[0, 2], -P[2, 0]
        claim["P"] = P.tolist()
        claim["peaks"] = dict.fromkeys(claim["peaks"], 1.0)

    assert campaign(turned).broken[0].mean() > 0.1


def test_beyond_the_class_the_set_is_left_and_starts_come_back(campaign: Run) -> None:
    """Ten times the wind class breaks bounds; from V up to 4 most runs return within seconds."""
    wide = campaign(beyond="10", duration=2.0)
    far = campaign(beyond="start=4", duration=8.0, runs=100)

    assert wide.broken[0].mean() > 0.2
    assert 3.9 < far.share[0].max()
    assert far.broken[0].mean() > 0.7
    # Shown by the inertia that a campaign draws.
    assert campaign(beyond="inertia=0.2:5", duration=4.0).violations > 0
    assert np.mean(far.events["end_value"] <= 1) > 0.4


@pytest.mark.parametrize(
    "text", ["0", "wind=x", "inertia=2", "inertia=2:1", "torque=3", "start=1:2", "start=1", "1e9"]
)
def test_what_lies_beyond_is_asked_for_in_words(text: str) -> None:
    """Anything else is refused, with what is possible."""
    with pytest.raises(ModelError, match=f"--beyond {text}"):
        beyond_of(text)


@pytest.mark.slow
def test_ten_thousand_runs_exceed_nothing(campaign: Run, reduced: bool) -> None:
    """A minute each (reduced: 1000 for 20 s)."""
    runs, duration = (1000, 20.0) if reduced else (10_000, 60.0)

    assert campaign(runs=runs, duration=duration, seed=4).violations == 0


COUNT = 150


@dataclass
class Scene:
    k: int
    wind: float
    u: tuple[float, float, float, float]
    kappa: float
    state: State


@pytest.fixture(scope="module")
def loop(built: Any) -> CertifiedLoop:
    return certified_loop(built.document)


@pytest.fixture(scope="module")
def scenes(loop: CertifiedLoop) -> list[Scene]:
    """Random states of the set, winds and plants of the class, in all parts of the tables."""
    draw, found = np.random.default_rng(3), []
    p = loop
    for k in draw.integers(len(loop.wind) - 1, size=COUNT):
        wind = float(loop.wind[k] + draw.uniform(0.05, 0.95) * (loop.wind[k + 1] - loop.wind[k]))
        xi = loop.root @ draw.uniform(-0.5, 0.5, 3)
        speed, effort, b, gain, _ = schedule(p, k, wind)
        state = (speed + xi[0], p.pitch_min + max(effort + gain * xi[0], 0.0) / b, xi[2])
        error, rate = draw.uniform(-1, 1, 2) * (loop.wind_error[k], loop.wind_rate[k])
        u = (float(error), float(rate), float(draw.uniform(0, 1)), 1.0)
        found.append(Scene(k, wind, u, 1 / draw.uniform(0.9, 1.1), state))
    return found


def test_commands_are_those_of_the_law(
    built: Any, loop: CertifiedLoop, scenes: list[Scene]
) -> None:
    """Torque and pitch reference of ``EffortSharingLaw``, which reads another object."""
    law, p, compared = built.law, loop, 0
    for s in scenes:
        seen = s.wind + law.wind_filter * s.u[1]
        if not 3 < seen < 25:
            continue
        compared += 1
        wanted = law.command([s.state[2], s.wind], Measurement(s.state[0], s.state[1], seen))
        torque, pitch, _ = command(p, s.k, s.wind, s.state)
        torque = min(max(torque, 0), p.rated_torque)
        pitch = min(max(pitch, p.pitch_min), p.pitch_max)
        assert (torque, pitch) == pytest.approx((wanted.torque, wanted.pitch), abs=1e-8)
    assert compared > 50


def test_rotor_is_the_turbine_s(built: Any, loop: CertifiedLoop, scenes: list[Scene]) -> None:
    """omega' from the turbine's own torque; the wake's by quadrature of its stated slope."""
    turbine, p = built.turbine, loop
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for s in scenes:
        speed, effort, b, _, limit = schedule(p, s.k, s.wind)
        bent = np.clip(effort + p.overlap, 0, 2 * p.overlap)
        trim = p.pitch_min + (bent**2 / (4 * p.overlap) + max(effort - p.overlap, 0)) / b
        half = (s.state[1] - trim) / 2
        pitches = trim + half * (1 + nodes)
        own = -rotor_torque_gradient(turbine, speed, pitches, s.wind)[1] / turbine.inertia
        added = -s.u[2] * half * float(weights @ np.maximum(limit - own, 0))
        torque = min(max(command(p, s.k, s.wind, s.state)[0], 0), p.rated_torque)
        driving = rotor_torque(turbine, s.state[0], s.state[1], s.wind + s.u[0]) / turbine.inertia
        wanted = s.kappa * (driving + added - turbine.gear_ratio / turbine.inertia * torque)
        found = rates(p, s.k, s.wind, s.u, s.kappa, s.state)
        assert found[0] == pytest.approx(wanted, abs=1e-6)
        assert abs(found[1]) <= p.pitch_rate_limit
    assert loop.wake.all()


def test_c_p_multiplies_the_rotor_and_the_wake_keeps_to_its_limit(
    loop: CertifiedLoop, scenes: list[Scene]
) -> None:
    """With the whole wake the slope over pitch is the frozen wake's, for every c_P."""
    p, h = loop, 1e-6
    for s in scenes[:30]:
        speed, *_, limit = schedule(p, s.k, s.wind)
        for power in (0.97, 1.03):
            ends = [
                rates(p, s.k, s.wind, (0.0, s.u[1], 1.0, power), 1.0, (speed, s.state[1] + d, 0.0))
                for d in (h, -h)
            ]
            assert (ends[0][0] - ends[1][0]) / (2 * h) == pytest.approx(-limit, abs=1e-5)


def test_errors_vanish_at_the_trim_and_are_linear_in_the_state(loop: CertifiedLoop) -> None:
    """(e, zeta, x): zeta is the effort that pitch lags behind, in full load q* + gamma (e - x)."""
    p, k = loop, len(loop.wind) - 4
    wind = (loop.wind[k] + loop.wind[k + 1]) / 2
    speed, effort, b, gain, _ = schedule(p, k, wind)
    trim = p.pitch_min + effort / b
    assert errors(p, k, wind, (speed, trim, 0.0)) == pytest.approx((0, 0, 0), abs=1e-12)
    moved = errors(p, k, wind, (speed + 0.01, trim + 0.002, 0.004))
    assert moved == pytest.approx((0.01, gain * 0.006 - b * 0.002, 0.004), abs=1e-12)


def test_starts_lie_in_the_set_in_all_cells_and_often_on_its_boundary(loop: CertifiedLoop) -> None:
    draw, p = np.random.default_rng(1), loop
    starts = [_start(loop, draw, 1.0) for _ in range(400)]
    xi = np.array([errors(p, *start) for start in starts])
    values = np.einsum("ni,ij,nj->n", xi, loop.P, xi)

    assert values.max() <= 1
    assert 0.5 < np.mean(values > 1 - 1e-9) < 0.8
    assert {k for k, _, _ in starts} == set(range(len(p.cells)))


def test_steps_are_of_fourth_order_where_nothing_bends(loop: CertifiedLoop) -> None:
    """Halved steps err by a sixteenth in full load, away from limits (Kutta 1901)."""
    p, k = loop, len(loop.wind) - 4
    wind = (loop.wind[k] + loop.wind[k + 1]) / 2
    speed, effort, b, *_ = schedule(p, k, wind)

    def after(count: int) -> Any:
        state = (speed + 0.01, p.pitch_min + effort / b + 0.002, 0.002)
        for _ in range(count):
            state = step(p, k, wind, (0.0, 0.0, 0.0, 1.0), 1.0, state, 2.0 / count)
        return np.array(state)

    exact = after(640)
    coarse, fine = (np.abs(after(count) - exact).max() for count in (20, 40))
    assert 12 < coarse / fine < 20


def test_another_certificate_is_refused(built: Any) -> None:
    """Without a claim about the loop, or with a part missing or too short: in words."""
    gains = built.document["gains"]
    for changed, words in (
        ({"claims": [{"kind": "decay"}]}, "claims of kind decay.*coherent-loop"),
        ({"gains": {k: v for k, v in gains.items() if k != "trim_effort"}}, "trim_effort"),
        ({"gains": {**gains, "overlap": "wide"}}, "cannot be simulated"),
        ({"gains": {**gains, "wind": gains["wind"][1:]}}, "cannot be simulated"),
    ):
        with pytest.raises(ModelError, match=words):
            certified_loop({**built.document, **changed})
