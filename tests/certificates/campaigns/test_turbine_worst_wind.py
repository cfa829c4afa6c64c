"""The search for worst winds: its loop against the other loop in floats, and what it finds."""

from __future__ import annotations

import json
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from tests.certificates.recorded.answers import recorded

motion: Any = import_module("turbine_running")
worst: Any = import_module("turbine_worst_wind")


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return dict(json.loads(next(recorded("running-rate"))[1]))


@pytest.fixture(scope="module")
def loop(document: dict[str, Any]) -> Any:
    return worst.loop_of(document)


def stepped(document: Any, start: float, change: float, seconds: int) -> Any:
    """Return omega - omega*(v) after a step of the wind, by Euler steps of the other loop."""
    cell = {"wind": [start, start + 0.01]}
    plant = motion.Plant(1.0, 60.0, 0.5)
    after = motion.Motion(document, cell, start + change, plant)
    before = motion.Motion(document, cell, start, plant)
    xi = np.zeros(10)
    xi[[0, 4, 5, 8, 9]] = before.speed - after.speed
    xi[[1, 7]] = after.b0 * (before.pitch - after.pitch)
    xi[2] = before.x_rest - after.x_rest
    xi[[3, 6]] = -change
    found = []
    for _ in range(round(seconds / worst.STEP)):
        xi = xi + worst.STEP * after.rate(xi)
        found.append(xi[0])
    return np.array(found)


@pytest.mark.parametrize("start", [8.0, 15.2, 19.2])
def test_the_loop_is_that_of_the_page(document: dict[str, Any], loop: Any, start: float) -> None:
    """A ramp of 0.25 m/s in the first second, then constant wind; both are written from the page.

    The other loop has no moving wind: its answers to 50 small steps are added up.  What differs is
    the surface's grid, when a command is applied, and the second order of the ramp.
    """
    change, seconds = 0.25, 12
    each = round(worst.HOLD / worst.STEP)
    rates = np.zeros(seconds)
    rates[0] = change / worst.HOLD
    mine = worst.motion(loop, start, rates)[:, 1]
    step = stepped(document, start, change / 10, seconds) * 10 / each
    other = np.zeros(len(mine))
    for k in range(each):
        other[k:] += step[: len(other) - k]
    assert np.abs(mine - other).max() < 0.05 * np.abs(other).max()


@pytest.mark.slow
def test_a_wind_that_is_found_does_what_is_said(loop: Any) -> None:
    """At 13 m/s: it moves no faster than the rate, and the rotor passes 12 % with that plant.

    It is of the order of what the linear peak gain allows: 0.21 m/s^2.
    """
    linear, rate, rates, plant = worst.largest_rate(loop, 13.0, 30.0, np.random.default_rng(0))
    assert np.abs(rates).max() <= rate * (1 + 1e-12)
    rows = worst.motion(plant, 13.0, rates)
    assert np.abs(np.diff(rows[:, 0])).max() <= rate * worst.STEP * (1 + 1e-9)
    assert rows[:, 7].max() >= (1 + worst.MOST) * loop.rated_speed
    assert 0.7 * linear < rate < 2 * linear


def test_the_linear_gain_is_the_peak_of_a_small_wind(loop: Any) -> None:
    """The worst signs at a thousandth of the rate bring the gain's share of the peak."""
    gain, signs = worst.linear_gain(loop, 15.2, 80)
    reached = worst.peak(loop, 15.2, 1e-3 * signs, (3.0, 25.0))
    assert reached == pytest.approx(1e-3 * gain, rel=0.02)
