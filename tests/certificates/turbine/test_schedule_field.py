"""``schedule-rate`` against the nonlinear loop in absolute states (``schedule_field``).

The checker's linear inclusion contains the loop's rates at drawn states of the box, and no motion
leaves V <= 1 in winds that push it outward.  The certificate is the first line of
``recorded/schedule-rate.jsonl``.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.effort_sharing import inputs as plants
from takagi.certificates.checker.turbine.running_loop import inputs as machines
from takagi.certificates.checker.turbine.scheduled_loop import (
    schedule_cell,
    schedule_inputs,
    schedule_loop,
)
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.schedule_field import SCHEDULE, WIND, Field, Floats

CELLS = range(3)
RATED, LAG, ETA = "rated_rotor_speed", 3, 7


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("schedule-rate"))[1]))


@pytest.fixture(scope="module")
def field(stored: dict[str, Any]) -> Field:
    return Field(stored)


# The inclusion.


def checked(stored: Any, k: int) -> schedule_cell.ScheduleCell:
    """Return one cell as the checker has it."""
    data = read_text(json.dumps(stored), "certificate")
    model, gains, claim = data["model"], data["gains"], data["claims"][0]
    cell = claim["cells"][k]
    low, high = (Fraction(str(v)) for v in stored["claims"][0]["cells"][k]["wind"])
    return schedule_cell.ScheduleCell(
        plants.Plant.read(model),
        plants.Law.read(gains),
        machines.Machine.read(claim, model, gains, "claim"),
        (low, high),
        schedule_inputs.ScheduleSides.read(cell, "cell"),
    )


@dataclass(frozen=True)
class Drawn:
    """A state of the box, its rates, and the factors' signals that are sums of other factors'."""

    xi: Floats
    wind_rate: float
    rates: Floats
    sums: dict[str, float]


def drawn(field: Field, k: int, rng: np.random.Generator) -> Drawn:
    """Return a state of a cell's box with the rates of xi; at a corner of the box half the time."""
    claim = field.claim
    cell, family = claim["cells"][k], claim["uncertainty"]
    side = cell["sides"]
    while True:
        v_s = rng.choice([rng.uniform(*cell["wind"]), cell["wind"][0] + 1e-9])
        size = {
            name: value * rng.choice([rng.uniform(-1, 1), -1, 1]) for name, value in side.items()
        }
        m, e = size["measured"], size["speed"]
        poles = rng.uniform(-1, 1, 2) * side["speed"]
        xi = np.array([e, 0, m - size["signal"], size["wind"], m, m - size["innovation"],
                       size["estimate"], 0, *poles])  # fmt: skip
        y = field.states(xi, v_s)
        sent = field.commands(y)[1]
        xi[1] = sent - field.trim_pitch(v_s) - size["drive"]
        xi[ETA] = rng.uniform(-1, 1) * side["pitch"]
        if abs(xi[1]) <= side["pitch"]:
            break
    y = field.states(xi, v_s)
    inertia, length = rng.choice(family["inertia"]), rng.uniform(*family["wake_length"])
    h = rng.choice([0.0, 1.0]) * field.late(y[WIND])
    wind_rate = rng.choice([-1, 1]) * cell["wind_rate"]
    one = (np.atleast_1d(value) for value in (sent, inertia, h, length, wind_rate))
    own = field.rates(y[:, None], *one)[:, 0]
    moved, step = own[SCHEDULE], 1e-6
    turned = (field.trim_pitch(v_s + step) - field.trim_pitch(v_s)) / step * moved
    rates = own[:SCHEDULE].copy()
    rates[[1, ETA]] -= turned
    rates[[LAG, 6]] -= moved
    seen = rates[5] - claim["observer"]["l1"] * (xi[4] - xi[5])
    return Drawn(xi, wind_rate, rates, {"inertia": rates[0] * inertia, "observer inertia": seen})


TOLERANCE = 1e-8


def contains(cell: schedule_cell.ScheduleCell, span: Any, at: Drawn) -> bool:
    """Return whether some w with w_i^2 <= z_i^2, and some rho, give the rates: a linear program."""
    signals, rates = schedule_loop.schedule_equations(cell, span)
    F = np.array([[float(x) for x in signals.row(rate)] for rate in rates])
    Z = np.array([[float(x) for x in signals.row(one)] for one in signals.outer])
    known = len(at.xi) + 1
    given = np.array([*at.xi, at.wind_rate])
    rows, values = [F[:, known:]], [at.rates - F[:, :known] @ given]
    bounds: list[tuple[float, float]] = [(-1.0, 1.0)]
    for name, row in zip(signals.names, Z, strict=True):
        if np.any(row[known:]):
            # z of a sum of other factors' signals: its value is that of the loop.
            radius = float(span[name][1] - span[name][0]) / 2
            z = radius * at.sums[name]
            rows.append(row[None, known:])
            values.append(np.array([z - row[:known] @ given]))
        else:
            z = float(row[:known] @ given)
        bounds.append((-abs(z) - TOLERANCE, abs(z) + TOLERANCE))
    A, b = np.vstack(rows), np.concatenate(values)
    found = linprog(np.zeros(len(bounds)), A_eq=A, b_eq=b, bounds=bounds)
    return bool(found.status == 0)


@pytest.mark.parametrize("k", CELLS)
def test_the_inclusion_contains_the_loop(stored: Any, field: Field, k: int) -> None:
    rng, cell = np.random.default_rng(k), checked(stored, k)
    span = schedule_loop.schedule_factors(cell, cell.lead)
    assert all(contains(cell, span, drawn(field, k, rng)) for _ in range(100))


NARROWED = (
    ("stiffness", "pitch gain", "wind gain"),
    ("observed stiffness", "observed wind gain"),
    *(("late pitch gain",), ("inertia",), ("pitch per signal", "lead"), ("pitch slope",)),
    ("wake rate",),
)


@pytest.mark.parametrize("names", NARROWED)
def test_narrower_ranges_do_not(stored: Any, field: Field, names: tuple[str, ...]) -> None:
    """Break on purpose: with a twentieth of some ranges, at their middle, rates are missed."""
    rng, cell = np.random.default_rng(5), checked(stored, 1)
    span = dict(schedule_loop.schedule_factors(cell, cell.lead))
    for name in names:
        low, high = span[name]
        middle, radius = (low + high) / 2, (high - low) / 40
        span[name] = middle - radius, middle + radius
    assert not all(contains(cell, span, drawn(field, 1, rng)) for _ in range(100))


# Motions.


@dataclass(frozen=True)
class Seen:
    """The largest V of each motion, and of all motions in percent of rated, rad, m/s and m/s."""

    V: Floats
    v_s: tuple[float, float]
    largest: dict[str, float]


def motions(field: Field, faster: float, count: int, seconds: float, seed: int) -> Seen:
    """Return what motions from V = 1 do, with a wind that pushes V up or changes its sign.

    Inertia is at an end of its range; h and the wake's length are where they push V up, or at an
    end.  The wind rate is ``faster`` times the claimed one, and the wind stays in its range.
    """
    rng, claim, step = np.random.default_rng(seed), field.claim, 0.02
    least, most = claim["winds"][0]
    v_s, xi = _starts(field, rng, count)
    y, (short, long) = field.states(xi, v_s), claim["uncertainty"]["wake_length"]
    inertia = rng.choice(claim["uncertainty"]["inertia"], count)
    h_end, length_end = rng.choice([0.0, 1.0], count), rng.choice([short, long], count)
    greedy, period = rng.random((3, count)) < 0.6, rng.uniform(2, 60, count)
    limit = field.model["pitch_rate_limit"]
    sent, V, v_s_ends = field.commands(y)[1], np.zeros(count), (np.inf, -np.inf)
    largest = dict.fromkeys(("speed", "pitch", "estimate", "wind"), 0.0)
    for i in range(round(seconds / step)):
        xi = field.distances(y)
        slopes = np.einsum("kij,jk->ik", field.P(y[SCHEDULE]), xi)
        V = np.maximum(V, np.sum(xi * slopes, axis=0))
        v_s_ends = min(v_s_ends[0], y[SCHEDULE].min()), max(v_s_ends[1], y[SCHEDULE].max())
        found = 100 * y[0] / field.model[RATED], abs(xi[1]), abs(xi[6]), abs(xi[LAG])
        for name, value in zip(largest, found, strict=True):
            largest[name] = max(largest[name], float(np.max(value)))
        square = np.where(i * step // period % 2 == 0, 1.0, -1.0)
        wind_rate = faster * claim["cells"][0]["wind_rate"]
        wind_rate = wind_rate * np.where(greedy[0], np.sign(slopes[LAG]), square)
        stopped = ((y[WIND] >= most) & (wind_rate > 0)) | ((y[WIND] <= least) & (wind_rate < 0))
        wind_rate = np.where(stopped, 0.0, wind_rate)
        behind = y[1] - y[ETA]
        h = field.late(y[WIND]) * np.where(greedy[1], slopes[0] * behind < 0, h_end)
        longest = np.where(slopes[ETA] * behind > 0, short, long)
        length = np.where(greedy[2], longest, length_end)
        fixed = sent, inertia, h, length, wind_rate
        a = field.rates(y, *fixed)
        b = field.rates(y + step / 2 * a, *fixed)
        c = field.rates(y + step / 2 * b, *fixed)
        d = field.rates(y + step * c, *fixed)
        y = y + step / 6 * (a + 2 * b + 2 * c + d)
        torque, asked, _ = field.commands(y)
        assert faster > 1 or np.all(torque == field.law["rated_torque"])
        sent = np.clip(asked, sent - limit * step, sent + limit * step)
    return Seen(V, v_s_ends, largest)


def _starts(field: Field, rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    """Return schedule winds and points of V = 1 there, with the wind in its range."""
    claim, found = field.claim, list[tuple[float, Floats]]()
    low, high = claim["cells"][0]["wind"][0], claim["cells"][-1]["wind"][1]
    while len(found) < count:
        v_s = rng.uniform(low, high)
        P = field.P(np.array([v_s]))[0]
        # Where one state is largest, or anywhere.
        axis = rng.choice([-1, 1]) * np.eye(10)[rng.integers(10)]
        xi = np.linalg.solve(P, rng.choice([axis, np.linalg.cholesky(P) @ rng.normal(size=10)]))
        xi /= np.sqrt(xi @ P @ xi)
        if claim["winds"][0][0] <= v_s + xi[LAG] <= claim["winds"][0][1]:
            found.append((v_s, xi))
    return np.array([v for v, _ in found]), np.array([xi for _, xi in found]).T


SHOWN = {"speed": 104.88, "pitch": np.radians(2.13), "estimate": 0.96, "wind": 0.617}


def test_no_motion_leaves_the_set_and_what_is_said_holds(field: Field) -> None:
    """Widths as the claim's sentence has them, which some motions come near to."""
    seen = motions(field, 1.0, count=100, seconds=6, seed=0)
    assert 0.99 < np.min(seen.V) and np.max(seen.V) < 1 + 1e-9
    assert 17.034 < seen.v_s[0] and seen.v_s[1] < 18.5276
    for name, most in SHOWN.items():
        assert 0.9 * most < seen.largest[name] <= most


@pytest.mark.slow
def test_no_motion_leaves_the_set_in_a_minute(field: Field) -> None:
    seen = motions(field, 1.0, count=300, seconds=60, seed=1)
    assert np.max(seen.V) < 1 + 1e-9
    assert 17.034 < seen.v_s[0] and seen.v_s[1] < 18.5276
    assert all(seen.largest[name] <= most for name, most in SHOWN.items())


def test_motions_leave_it_in_a_faster_wind(field: Field) -> None:
    """Break on purpose: at three times the rate."""
    seen = motions(field, 3.0, count=60, seconds=6, seed=3)
    assert np.max(seen.V) > 1.02
