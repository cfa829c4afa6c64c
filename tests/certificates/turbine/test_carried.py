"""What the rate limits carry into a cell: each number of the condition, on both sides of its edge.

The cells are four in a row from ``recorded/running-rate.jsonl``, 15.04 to 16.04 m/s.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop import carried, limits, moving_claim, stated
from takagi.certificates.checker.turbine.running_loop.carried import Passed, carried_failures
from takagi.certificates.checker.turbine.running_loop.inputs import Machine
from tests.certificates.recorded.answers import recorded

F = Fraction
Span = tuple[Fraction, Fraction]
NOTHING: Span = (F(0), F(0))
# A set that reaches nowhere, in a box without an end.
WIDE = {name: (F(0), F(10**6)) for name in ("schedule", "effort", "signal")}


@dataclass(frozen=True)
class Given(Passed):
    """A cell with ranges of feed-forward and lead that the test chooses."""

    given: tuple[Span, Span] = (NOTHING, NOTHING)

    @property
    def ranges(self) -> tuple[Span, Span]:
        return self.given


@pytest.fixture(scope="module")
def run() -> list[Passed]:
    data = read_text(json.dumps(json.loads(next(recorded("running-rate"))[1])), "certificate")
    claim = data["claims"][0]
    plant, law = Plant.read(data["model"]), Law.read(data["gains"])
    machine = Machine.read(claim, data["model"], data["gains"], "claim")
    functions = stated.stated_functions(claim, 10, "claim")
    found = []
    for cell in claim["cells"][2:]:
        kept = moving_claim.examined(
            plant, law, machine, moving_claim.MovingCell.read(cell, functions, "cell")
        )
        assert not isinstance(kept, str)
        found.append(kept.passed)
    return found


def with_ranges(run: Sequence[Passed], *given: tuple[Span, Span]) -> list[Passed]:
    """Return cells with these ranges, whose sets have all the room that there is."""
    return [Given(one.cell, ([WIDE], [WIDE]), own) for one, own in zip(run, given, strict=True)]


def winds(found: Any) -> list[Span]:
    return [ends for ends, _ in found]


def test_the_recorded_cells_are_entered_in_time(run: list[Passed]) -> None:
    assert carried_failures(run) == []
    assert all(fed == NOTHING and led[0] == 0 < led[1] for fed, led in (o.ranges for o in run))


def test_cells_with_the_same_ranges_need_no_room(run: list[Passed]) -> None:
    """Also where a command may move as fast as its limit."""
    same = ((F(-1), F(3)), (F(-2), F(1)))
    cells = with_ranges(run, same, same, same, same)
    tight = [replace(one, rooms=([{n: (F(1), F(1)) for n in WIDE}],) * 2) for one in cells]
    assert carried_failures(tight) == []


# Cell, end, which end is shared: the first cell's lower end and the last one's upper end are not.
SHARED = [(0, 0, False), (0, 1, True), (1, 0, True), (2, 1, True), (3, 0, True), (3, 1, False)]


@pytest.mark.parametrize(("k", "end", "shared"), SHARED)
def test_room_is_asked_for_at_shared_winds(
    run: list[Passed], k: int, end: int, shared: bool
) -> None:
    """Each cell has less lead than its neighbour has, and may lag."""
    leads = [F(n, 1000) for n in (1, 2, 3, 4)]
    leads[k] = F(0)
    cells = with_ranges(run, *((NOTHING, (F(0), lead)) for lead in leads))
    assert carried_failures(cells) == []
    rooms = [WIDE, WIDE]
    rooms[end] = {**WIDE, "signal": (F(1), F(1))}
    cells[k] = replace(cells[k], rooms=([rooms[0]], [rooms[1]]))
    assert winds(carried_failures(cells)) == [cells[k].cell.winds] * shared
    # In each piece of v_s - v, not in the first alone.
    cells[k] = replace(cells[k], rooms=([WIDE, rooms[0]], [WIDE, rooms[1]]))
    assert winds(carried_failures(cells)) == [cells[k].cell.winds] * shared


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("which", "name"),
    [(0, "schedule"), (1, "schedule"), (1, "effort"), (1, "signal")],
)
def test_the_room_is_the_lag_times_the_rate(
    run: list[Passed], which: int, name: str, sign: int
) -> None:
    """D h_r exactly, from the docs' formula: at it the cell is not entered, just below it is."""
    size = F(1, 20)
    other: list[Span] = [NOTHING, NOTHING]
    other[which] = (F(0), size) if sign > 0 else (-size, F(0))
    cells = with_ranges(run, *((NOTHING, NOTHING),) * 3, (other[0], other[1]))
    moved = [limits.motion(one.cell) for one in cells]
    rho, law, plant = max(m.schedule for m in moved), cells[0].cell.law, cells[0].cell.plant
    sizes = (size, F(0)) if which == 0 else (F(0), size)
    fastest = max(limits.command_rates(one.cell, *sizes)[which] for one in cells)
    spare = (cells[0].cell.machine.torque_rate, plant.rate_limit)[which] - fastest
    lag = rho * size / spare * (law.effort_torque if which == 0 else 1)
    way = lag * max(getattr(m, name) for m in moved)
    half = F(1, 3)
    for bound, entered in ((half + way, False), (half + way * F(100001, 100000), True)):
        room = {**WIDE, name: (half**2, bound)}
        cells[1] = replace(cells[1], rooms=([WIDE], [room]))
        assert winds(carried_failures(cells)) == [cells[1].cell.winds] * (not entered)
    # A box that is passed within the lag, however small the set.
    cells[1] = replace(cells[1], rooms=([WIDE], [{**WIDE, name: (F(0), way)}]))
    assert winds(carried_failures(cells)) == [cells[1].cell.winds]


def test_torque_needs_no_room_in_effort_and_signal(run: list[Passed]) -> None:
    """The feed-forward depends on the schedule wind alone."""
    cells = with_ranges(run, *((NOTHING, NOTHING),) * 3, ((F(0), F(1, 5)), NOTHING))
    room = {**WIDE, "effort": (F(1), F(1)), "signal": (F(1), F(1))}
    cells[2] = replace(cells[2], rooms=([room], [room]))
    assert carried_failures(cells) == []


@pytest.mark.parametrize("which", [0, 1])
def test_a_command_as_fast_as_its_limit_never_comes_back(run: list[Passed], which: int) -> None:
    sizes = [F(10**6), F(0)] if which == 0 else [F(0), F(10**6)]
    fast = ((F(0), sizes[0]), (F(0), sizes[1]))
    cells = with_ranges(run, *((NOTHING, NOTHING),) * 3, fast)
    assert winds(carried_failures(cells)) == [one.cell.winds for one in cells[:3]]


def test_a_command_just_as_fast_as_its_limit_does_not_either() -> None:
    rates = {"schedule": F(0)}
    assert not carried._caught_up(F(1), F(0), [WIDE], rates)
    assert carried._caught_up(F(0), F(0), [WIDE], rates)
    assert carried._caught_up(F(1), F(1, 10**9), [WIDE], rates)


def test_ranges_have_zero_in_them(run: list[Passed]) -> None:
    """Also of a feed-forward that is above zero at all schedule winds of the cell, or below."""
    law = run[0].cell.law
    for f, wanted in ((F(1, 4), (F(0), F(1, 4))), (F(-1, 4), (F(-1, 4), F(0)))):
        cell = run[0].cell
        kept, cell.law = cell.law, replace(law, inertia=[f] * len(law.inertia))
        try:
            assert Passed(cell, run[0].rooms).ranges[0] == wanted
        finally:
            cell.law = kept


def test_the_lead_is_in_units_of_pitch(run: list[Passed]) -> None:
    cell = run[1].cell
    assert run[1].ranges[1] == (cell.lead[0] / cell.b0, cell.lead[1] / cell.b0)


def test_how_far_a_range_goes_beyond_another() -> None:
    assert carried._beyond((F(-3), F(5)), (F(-1), F(4))) == 2
    assert carried._beyond((F(-3), F(9)), (F(-1), F(4))) == 5
    assert carried._hull([(F(1), F(2)), (F(-4), F(1)), (F(0), F(3))]) == (F(-4), F(3))
