"""The campaign's loop, written from the formulas, against the law and the plant as they run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates.campaign import CertifiedLoop, certified_loop
from takagi.certificates.campaign.motion import (
    At,
    Drive,
    at_wind,
    demanded,
    error_state,
    rates,
    step,
)
from takagi.certificates.campaign.plants import drawn_starts, quadratic, wake_fits
from takagi.certificates.campaign.winds import Seen, error_rate
from takagi.models.laws import Measurement
from takagi.models.turbine import rotor_torque, rotor_torque_gradient

Scene = tuple[CertifiedLoop, np.ndarray, At, Drive]
COUNT = 200


@pytest.fixture(scope="module")
def scene(built: Any) -> Scene:
    """Random states, winds, plants of the class, all cells."""
    loop, draw = certified_loop(built.document), np.random.default_rng(3)
    state, cell, at = drawn_starts(loop, COUNT, draw)
    rate = draw.uniform(-1, 1, COUNT) * loop.wind_rate[cell]
    error = draw.uniform(-1, 1, COUNT) * loop.wind_error[cell]
    kappa, wake = 1 / draw.uniform(0.9, 1.1, COUNT), draw.uniform(0, 1, COUNT)
    return loop, state, at, Drive(cell, error, rate, kappa, wake, np.ones(COUNT))


def test_commands_are_those_of_the_law(built: Any, scene: Scene) -> None:
    """Torque and pitch reference of ``EffortSharingLaw``, which reads another object."""
    loop, state, at, drive = scene
    law, demand = built.law, demanded(loop, state, at, drive)
    inside = (at.wind + law.wind_filter * drive.rate > 3) & (
        at.wind + law.wind_filter * drive.rate < 25
    )
    # On a node the law takes the cell on its right, and a run may still be in the one on its left.
    inside &= ~np.isin(at.wind, loop.wind)
    assert inside.sum() > 100
    for n in np.flatnonzero(inside):
        seen = at.wind[n] + law.wind_filter * drive.rate[n]
        command = law.command(
            [state[2, n], at.wind[n]], Measurement(state[0, n], state[1, n], seen)
        )
        torque = min(max(demand.torque[n], 0), loop.rated_torque)
        pitch = min(max(demand.pitch[n], loop.pitch_min), loop.pitch_max)
        assert (command.torque, command.pitch) == pytest.approx((torque, pitch), abs=1e-8)


def test_rotor_is_the_turbine_s(built: Any, scene: Scene) -> None:
    """omega' from the turbine's own torque; the wake's by quadrature of its stated slope."""
    loop, state, at, drive = scene
    turbine, (speed, pitch, _) = built.turbine, state
    found, demand = rates(loop, state, at, drive)
    torque = np.clip(demand.torque, 0, loop.rated_torque)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    half = (pitch - at.trim_pitch) / 2
    along = at.trim_pitch + half * (1 + nodes[:, None])
    own = -rotor_torque_gradient(turbine, at.speed, along, at.wind)[1] / turbine.inertia
    added = -drive.wake * half * (weights @ np.maximum(at.limit - own, 0))
    driving = rotor_torque(turbine, speed, pitch, at.wind + drive.error) / turbine.inertia + added
    wanted = drive.kappa * (driving - turbine.gear_ratio / turbine.inertia * torque)

    assert wake_fits(loop).all()
    assert found[0] == pytest.approx(wanted, abs=1e-6)


def test_c_p_multiplies_the_rotor_and_the_wake_keeps_to_its_limit(scene: Scene) -> None:
    """With the whole wake the slope over pitch is the frozen wake's, for every c_P."""
    loop, state, at, drive = scene
    h, slopes = 1e-6, []
    at_trim = np.stack([at.speed, state[1], 0 * at.wind])
    for power in (0.97, 1.0, 1.03):
        full = drive._replace(error=0 * at.wind, wake=0 * at.wind + 1, power=0 * at.wind + power)
        up, down = (rates(loop, at_trim + [[0], [s * h], [0]], at, full)[0][0] for s in (1, -1))
        slopes.append((up - down) / (2 * h * drive.kappa))
    for slope in slopes:
        assert slope == pytest.approx(-at.limit, abs=1e-5)


def test_error_rates_are_the_errors_derivative(scene: Scene) -> None:
    """(e', zeta', x') of the adversaries against a difference along a short step."""
    loop, state, at, drive = scene
    moved, demand = rates(loop, state, at, drive)
    none = np.zeros(COUNT)
    seen = Seen(none, none, state, at, drive)
    found = error_rate(loop, seen, drive, moved, demand)
    h = 1e-7
    later = at_wind(loop, drive.cell, at.wind + h * drive.rate)
    after = state + h * moved
    xi = [
        error_state(loop, s, a, demanded(loop, s, a, drive))
        for s, a in ((state, at), (after, later))
    ]
    inside = (at.wind + 2 * h * drive.rate < loop.wind[drive.cell + 1]) & (
        at.wind + 2 * h * drive.rate > loop.wind[drive.cell]
    )
    difference = (xi[1] - xi[0]) / h
    assert found[:, inside] == pytest.approx(difference[:, inside], abs=2e-6)


def test_steps_are_of_fourth_order_where_nothing_bends(built: Any) -> None:
    """Halved steps err by a sixteenth in full load, away from limits (Kutta 1901)."""
    loop = certified_loop(built.document)
    cell = np.full(1, len(loop.wind) - 4)
    wind = loop.wind[cell] * 0.5 + loop.wind[cell + 1] * 0.5
    at, one = at_wind(loop, cell, wind), np.ones(1)
    drive = Drive(cell, 0 * one, 0 * one, one, 0 * one, one)
    start = np.stack([at.speed + 0.01, at.trim_pitch + 0.002, 0.002 * one])

    def after(count: int) -> np.ndarray:
        state = start
        for _ in range(count):
            state, _ = step(loop, state, at, at, drive, one * 2.0 / count)
        return state

    exact = after(640)
    coarse, fine = (np.abs(after(count) - exact).max() for count in (20, 40))
    assert 12 < coarse / fine < 20


def test_starts_fill_the_set_and_its_corners(built: Any) -> None:
    """V reaches 1, every peak is met from inside, and pitch is never below its limit."""
    loop = certified_loop(built.document)
    state, cell, at = drawn_starts(loop, 3000, np.random.default_rng(4))
    none, one = np.zeros(3000), np.ones(3000)
    xi = error_state(
        loop, state, at, demanded(loop, state, at, Drive(cell, none, none, one, none, one))
    )
    value = quadratic(loop.P, xi)

    assert 0.999999 < value.max() <= 1
    assert state[1].min() >= loop.pitch_min
    assert set(cell) == set(range(len(loop.wind) - 1))
    largest = np.abs(np.stack([xi[0], xi[1], xi[0] - xi[2], xi[2]])).max(axis=1)
    assert np.all(largest <= loop.peaks)
    assert np.all(largest > 0.9999 * loop.peaks)
