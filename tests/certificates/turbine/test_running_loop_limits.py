"""The running loop's limits and sides: each from both sides of what its formula gives."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import Interval, point
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.equations import rows
from takagi.certificates.checker.turbine.running_loop.factors import factors
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Sides
from takagi.certificates.checker.turbine.running_loop.limits import command_rates, limit_failure
from takagi.certificates.checker.turbine.running_loop.running_claim import _box_failure
from tests.certificates.recorded.answers import recorded

F = Fraction
HAIR = F(1, 10**12)
CELLS = range(4)


def cell_of(k: int) -> Cell:
    data = read_text(next(recorded("running-loop"))[1], "document")
    claim, stated = data["claims"][0], data["claims"][0]["cells"][k]
    machine = Machine.read(claim, data["model"], data["gains"], "claim")
    low, high = (F(str(end)) for end in stated["wind"])
    sides = Sides.read(stated, "cell")
    return Cell(Plant.read(data["model"]), Law.read(data["gains"]), machine, (low, high), sides)


def largest(column: Any, cell: Cell) -> Fraction:
    """The largest size of a column's slope over the schedule winds of the set."""
    nodes = cell.law.wind
    found: list[Fraction] = [
        abs((column[j + 1] - column[j]) / (nodes[j + 1] - nodes[j])) for j in cell.near
    ]
    return max(found)


@pytest.mark.parametrize("k", CELLS)
def test_rates_of_the_commands_by_their_formula(k: int) -> None:
    """The module's text, written out once more."""
    cell = cell_of(k)
    law, sides, machine = cell.law, cell.sides, cell.machine
    rho = (sides.estimate + sides.schedule) / machine.wind_filter
    twice = (machine.l2 * sides.innovation + rho) / machine.wind_filter
    w, q, b = (largest(c, cell) for c in (law.speed, law.effort, law.effectiveness))
    bend = largest(law.gamma, cell)
    nu = max(law.nu[j] for j in cell.near)
    gamma, least = cell.over(law.gamma, cell.reach)[1], cell.over(law.effectiveness, cell.reach)[0]
    moved = q * rho + bend * rho * (sides.signal + cell.rest_integral)
    moved += gamma * (sides.measured_rate + w * rho + nu * (sides.measured + w * sides.schedule))
    lead = max(abs(end) for end in cell.lead) / cell.b0
    fed = max(abs(law.inertia[j]) for j in cell.near)
    torque = law.effort_torque * (share(-cell.efforts[0], law.overlap) * moved + fed * twice)
    most, part = psi(cell.efforts[1], law.overlap), share(cell.efforts[1], law.overlap)
    pitch = (part * moved + most * b * rho / least) / least + lead * twice

    assert command_rates(cell) == (torque, pitch)


def at(cell: Cell, **parts: Any) -> str:
    """Return the limit that may be reached with other numbers of law, machine, plant and sides."""
    kept = {name: getattr(cell, name) for name in ("law", "machine", "plant", "sides")}
    for place, value in parts.items():
        owner, _, name = place.partition("__")
        setattr(cell, owner, replace(getattr(cell, owner), **{name: value}))
    try:
        return limit_failure(cell)
    finally:
        for name, value in kept.items():
            setattr(cell, name, value)


@pytest.mark.parametrize("k", CELLS)
def test_each_limit_counts_from_its_own_threshold(k: int) -> None:
    """Exactly at a limit nothing is beyond it; a hair less of it is too little."""
    cell = cell_of(k)
    law, sides, rho = cell.law, cell.sides, cell.schedule_rate
    _ = cell.pitches, cell.share, cell.shed, cell.lead  # of the honest numbers, once for all
    assert limit_failure(cell) == ""
    torque, pitch = command_rates(cell)
    taken = max(min(abs(law.inertia[j]) * rho, law.inertia_limit[j]) for j in cell.near)
    rated = law.effort_torque * (psi(-cell.efforts[0], law.overlap) + taken)
    for place, least, words in (
        ("law__rated_torque", rated, "negative torque"),
        ("law__integral_limit", sides.integral + cell.rest_integral, "the integral"),
        ("machine__torque_rate", torque, "torque may reach"),
        ("plant__rate_limit", pitch, "pitch may reach"),
    ):
        assert at(cell, **{place: least}) == "", place
        assert at(cell, **{place: least - HAIR}).startswith(words), place


@pytest.mark.parametrize("k", CELLS)
def test_the_feed_forward_is_cut_at_its_own_limit(k: int) -> None:
    cell = cell_of(k)
    law, rho = cell.law, cell.schedule_rate
    shed, nodes = psi(-cell.efforts[0], law.overlap), len(law.wind)
    for inertia, limit, taken in ((2, 9 * rho, 2 * rho), (-2, 9 * rho, 2 * rho), (9, rho, rho)):
        law_parts: Any = {"law__inertia": [F(inertia)] * nodes, "machine__torque_rate": F(10**15)}
        law_parts["law__inertia_limit"] = [F(limit)] * nodes
        rated = law.effort_torque * (shed + taken)
        assert at(cell, **law_parts, law__rated_torque=rated) == ""
        assert at(cell, **law_parts, law__rated_torque=rated - HAIR).startswith("negative torque")


@pytest.mark.parametrize("k", CELLS)
def test_pitch_keeps_its_upper_limit(k: int) -> None:
    """What the law asks for, and where the pitch itself may be."""
    cell = cell_of(k)
    law, lead = cell.law, max(abs(end) for end in cell.lead)
    least = cell.over(law.effectiveness, cell.reach)[0]
    asked = psi(cell.efforts[1], law.overlap) / least + law.pitch_min
    asked += lead * cell.schedule_rate / cell.b0
    _ = cell.share, cell.shed
    cell.__dict__["pitches"] = Interval(0, 0)
    assert at(cell, law__pitch_max=asked) == ""
    assert at(cell, law__pitch_max=asked - HAIR).startswith("pitch beyond its limit")
    high = point(asked + 1)
    cell.__dict__["pitches"] = Interval(0, high.low)
    assert at(cell, law__pitch_max=asked + 1) == ""
    cell.__dict__["pitches"] = Interval(0, high.low + 1)
    assert at(cell, law__pitch_max=asked + 1).startswith("pitch beyond its limit")


LARGE = F(10**6)


def boxed(cell: Cell, **sides: Fraction) -> str:
    """Return which side the unit ball of all ten states leaves; a side that is not given is far."""
    whole = {name: LARGE for name in Sides.__dataclass_fields__} | {"schedule": F(2)} | sides
    span = factors(cell)
    cell.sides = Sides(**whole)
    unit = [[F(int(i == j)) for j in range(10)] for i in range(10)]
    return _box_failure(cell, span, unit)


@pytest.mark.parametrize("name", ["speed", "measured", "pitch", "schedule", "estimate", "integral"])
def test_a_state_s_side_is_left_where_it_is_reached(name: str) -> None:
    assert boxed(cell_of(3)) == ""
    assert boxed(cell_of(3), **{name: 1 + HAIR}) == ""
    assert boxed(cell_of(3), **{name: F(1)}) == f"the set leaves its box in {name}"


def test_the_sides_of_sums_by_their_formula() -> None:
    """Of factors from a range: the middle's row, and the rest taken from the bound."""
    cell = cell_of(3)
    span = factors(cell)
    half = {name: (high - low) / 2 for name, (low, high) in span.items()}
    mid = {name: (high + low) / 2 for name, (low, high) in span.items()}
    w, q, gamma = ("speed slope", "effort slope", "gamma")
    away = half[w] * 2
    # signal = m - x - w s; effort = q s + gamma signal; both in (x, s, m).
    signal2 = 2 + mid[w] ** 2
    effort2 = 2 * mid[gamma] ** 2 + (mid[q] - mid[gamma] * mid[w]) ** 2
    c, passed = cell.machine.corner, (cell.machine.stop or (F(0), F(1)))[1]
    rate2 = 2 * c**2 + 8 * (1 - passed) ** 2 * c**2
    spread = half[q] * 2 + half[gamma] * LARGE + mid[gamma] * away
    for name, square, less in (
        ("signal", signal2, away),
        ("effort", effort2, spread),
        ("measured_rate", rate2, F(0)),
        ("innovation", F(2), F(0)),
    ):
        root = F(round(float(square) ** 0.5 * 10**9), 10**9)
        words = f"the set leaves its box in {name.replace('_', ' ')}"
        assert boxed(cell_of(3), **{name: root + less + F(1, 10**6)}) == ""
        assert boxed(cell_of(3), **{name: root + less - F(1, 10**6)}) == words
        # A bound below zero is left, however large its square.
        assert boxed(cell_of(3), **{name: less - 3 * root}) == words
    assert rows(cell, span).keys() == set(Sides.__dataclass_fields__)


def test_a_shape_that_is_not_definite_has_no_set() -> None:
    cell = cell_of(3)
    unit = [[F(int(i == j)) for j in range(10)] for i in range(10)]
    unit[9][9] = F(0)
    assert _box_failure(cell, factors(cell), unit) == "P is not symmetric positive definite"
