"""Condition 4 with pieces of the schedule wind: both checkers compute the same, piece by piece.

The certificates are the first and the last of ``recorded/running-rate.jsonl``, the last with three
pieces in each cell.  Some numbers of the law are changed, so that cells differ in feed-forward.
"""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq

from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing import inputs as turbine
from takagi.certificates.checker.turbine.running_loop import (
    carried,
    factors,
    limits,
    moving,
    moving_claim,
)
from takagi.certificates.checker.turbine.running_loop import stated as stated_parts
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.inputs import Machine
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers as other_numbers
from takagi.certificates.cross_check.turbine import surface as other_surface
from takagi.certificates.cross_check.turbine.running import cell as other_cell
from takagi.certificates.cross_check.turbine.running import (
    entering,
    machine,
    moving_form,
    moving_loop,
)
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import verdicts

F = Fraction
# Intervals of the tables: one that only the former two cells' schedule winds meet, and one for the
# later two.
FIRST, LAST = 14.5446, 16.0382


@pytest.fixture(scope="module")
def pieces() -> Any:
    """Two cells with three pieces each."""
    return json.loads([text for _, text in recorded("running-rate")][-1])


@pytest.fixture
def document(pieces: Any) -> Any:
    return deepcopy(pieces)


@pytest.fixture
def row() -> Any:
    """Four cells in a row, two of them with pieces; of the later two a feed-forward is met.

    The multipliers are not for these: only what is asked beside the inequality is compared.
    """
    found = json.loads(next(recorded("running-rate"))[1])
    cells = found["claims"][0]["cells"] = found["claims"][0]["cells"][2:]
    for cell in cells:
        every = {"feed-forward": [1.0, 1.0]} | cell["multipliers"][0]
        cell["multipliers"] = [every]
    for cell in cells[1:3]:
        cell |= {"schedule_cuts": [-0.1, 0.15], "multipliers": cell["multipliers"] * 3}
    law = found["gains"]
    law["inertia_feedforward"] = [0.08 * (at == LAST) for at in law["wind"][:-1]]
    law["feedforward_limit"] = [1e-3] * len(law["feedforward_limit"])
    return found


def number(value: Any) -> Fraction:
    return F(int(value.p), int(value.q))


def first(document: Any) -> list[carried.Passed]:
    """Return the cells between their neighbours, by the first checker."""
    data = read_text(json.dumps(document), "certificate")
    claim, model, gains = data["claims"][0], data["model"], data["gains"]
    plant, law = turbine.Plant.read(model), turbine.Law.read(gains)
    own = Machine.read(claim, model, gains, "claim")
    functions = stated_parts.stated_functions(claim, 10, "claim")
    found = []
    for one in claim["cells"]:
        stated = moving_claim.MovingCell.read(one, functions, "cell")
        cell = Cell(plant, law, own, stated.winds, stated.sides)
        parts = [cell if lag is None else cell.piece(lag) for lag in stated.lags]
        rooms: tuple[list[carried.Room], list[carried.Room]] = ([], [])
        for at_end, end in zip(rooms, stated.ends, strict=True):
            for part in parts:
                P = moving.in_units(cell, end)
                room = moving_claim._room(part, moving.moving_factors(part), P)
                assert not isinstance(room, str), room
                at_end.append(room)
        found.append(carried.Passed(cell, rooms))
    return found


def second(document: Any) -> list[entering.Entered]:
    """Return the same by the second checker; its conditions are not decided here."""
    data = loads(json.dumps(document))
    claim, model, gains = data["claims"][0], data["model"], data["gains"]
    rotor, own = other_numbers.Rotor(model, gains), machine.Machine(claim, model, gains)
    functions = moving_form.functions_by_wind(claim, own.states)
    found: list[entering.Entered] = []
    for k, cell in enumerate(claim["cells"]):
        for _ in moving_loop._cell(rotor, own, cell, functions, f"cell {k}", found):
            pass
    return found


def compared(document: Any) -> list[int]:
    """Return the cells that may not be entered; the same by both checkers."""
    return late_in(first(document), second(document))


def late_in(mine: list[carried.Passed], yours: list[entering.Entered]) -> list[int]:
    """Return the places of the cells that fail, of the same cells by each checker."""
    winds = [one.cell.winds for one in mine]
    found = [winds.index(at) for at, _ in carried.carried_failures(mine)]
    left = {one.label.split(":")[0] for one in entering.entering(yours) if not one.holds}
    assert left == {f"cell {k}" for k in found}
    return found


def test_the_numbers_of_the_condition_are_the_same(row: Any) -> None:
    """F, the rates, the bounds of the rows, and what the sets reach in each piece."""
    mine, yours = first(row), second(row)
    for a, b in zip(mine, yours, strict=True):
        spans = [tuple(number(end) for end in (at.low, at.high)) for at in (b.fed(), b.led())]
        assert list(a.ranges) == spans
        moved = limits.motion(a.cell)
        assert {name: number(value) for name, value in b.cell.speeds().items()} == vars(moved)
        sizes = b.fed().size, b.led().size
        rates = limits.command_rates(a.cell, *map(number, sizes))
        assert rates == tuple(map(number, b.cell.command_rates(*sizes)))
        bounds = [{n: bound for n, (_, bound) in room.items()} for room in a.rooms[0]]
        stated = [(n, number(bound)) for n, _, bound in b.sides]
        each = len(stated) // len(bounds)
        assert each == 10
        assert bounds == [dict(stated[i : i + each]) for i in range(0, len(stated), each)]
    assert [len(one.rooms[1]) for one in mine] == [1, 3, 3, 1]
    assert [one.ranges[0][1] for one in mine] == [0, 0, F("0.08"), F("0.08")]


@pytest.mark.parametrize(
    ("spare", "late"), [("5", []), ("4", [0, 1]), ("1e-7", [0, 1]), ("-1e-7", [0, 1])]
)
def test_torque_that_comes_back_late(row: Any, spare: str, late: list[int]) -> None:
    """The gain file's limit less the largest rate of the torque, as a share of that rate.

    Cells without a feed-forward of their own are entered with that of the later two.
    """
    size = F("0.08")
    rates = [limits.command_rates(one.cell, fed=size)[0] for one in first(row)]
    row["model"]["torque_rate_limit"] = float(max(rates) * (1 + F(spare)))
    assert compared(row) == late


def test_both_turn_at_the_same_limit_of_torque(row: Any) -> None:
    """The cells without a feed-forward are the later two, with the smaller |v_s'| of their own."""
    law = row["gains"]
    law["inertia_feedforward"] = [0.08 * (at == FIRST) for at in law["wind"][:-1]]
    mine, yours = first(row), second(row)
    rates = [one.cell.schedule_rate for one in mine]
    assert max(rates[2:]) < max(rates)
    moved = max(limits.command_rates(one.cell, fed=F("0.08"))[0] for one in mine)
    low, high = 2 * moved, 20 * moved
    while high - low > F(1, 500) * low:
        limit = F(round((low + high) / 2))
        for one in mine:
            one.cell.machine = replace(one.cell.machine, torque_rate=limit)
        yours[0].cell.machine.torque_rate = fmpq(limit.numerator)
        low, high = (limit, high) if late_in(mine, yours) else (low, limit)
    assert 2 * moved < low < high < 20 * moved


def test_pitch_that_comes_back_late(row: Any) -> None:
    """The limit of pitch just above the largest rate of its command: only the most lead is kept."""
    cells = first(row)
    size = max(one.ranges[1][1] for one in cells)
    most = [k for k, one in enumerate(cells) if one.ranges[1][1] == size]
    rates = [limits.command_rates(one.cell, led=size)[1] for one in cells]
    assert compared(row) == []
    row["model"]["pitch_rate_limit"] = float(max(rates) * F("1.0000001"))
    assert compared(row) == [k for k in range(4) if k not in most]


# Whole files.


@pytest.mark.parametrize(
    ("k", "outside", "inside"),
    [(0, 0.0165209, 0.016521), (1, 0.0169028, 0.0169029)],
)
def test_the_piece_with_the_least_room_decides(
    document: Any, k: int, outside: float, inside: float
) -> None:
    """The side `effort`: of cell 0 the third piece is left, of cell 1 the second is entered late.

    With the first piece alone both would be proved.
    """
    sides = document["claims"][0]["cells"][k]["sides"]
    sides["effort"] = inside
    assert verdicts(document) == ("PROVED", "PROVED")
    sides["effort"] = outside
    assert verdicts(document) == ("UNDECIDED", "UNDECIDED")


@pytest.mark.parametrize(
    ("order", "answer"), [((0, 0, 1, 1, 2, 2), "PROVED"), ((0, 1, 2, 0, 1, 2), "UNDECIDED")]
)
def test_rows_of_multipliers_stand_piece_by_piece(
    document: Any, order: tuple[int, ...], answer: str
) -> None:
    """Two pieces of the share of pitch for each of three pieces of the schedule wind."""
    cell = document["claims"][0]["cells"][0]
    cell["multipliers"] = [cell["multipliers"][i] for i in order]
    assert verdicts(document) == (answer, answer)


def test_cuts_at_the_ends_of_the_side_are_refused(document: Any) -> None:
    cell = document["claims"][0]["cells"][0]
    side = cell["sides"]["schedule"]
    for cuts in ([-side, 0.2], [-0.2, side]):
        cell["schedule_cuts"] = cuts
        assert verdicts(document) == ("refused", "refused")


def test_cells_in_another_order_are_refused(document: Any) -> None:
    """So cells that share a wind are neighbours in the list, as one checker takes for granted."""
    document["claims"][0]["cells"].reverse()
    assert verdicts(document) == ("refused", "refused")


def test_a_piece_beyond_the_tables_is_not_proved(document: Any) -> None:
    """The tables end at 25 m/s: of lags from 0.1 m/s on a wind of 24.9 m/s has none below it."""
    mine, yours = first(document)[0].cell, second(document)[0].cell
    assert mine.law.wind[-1] == 25
    cell = Cell(mine.plant, mine.law, mine.machine, (F("24.9"), F(25)), mine.sides)
    other = other_cell.RunningCell(yours.rotor, yours.machine, fmpq(249, 10), fmpq(25), yours.box)
    with pytest.raises(Refused, match="no schedule wind"):
        cell.piece((F("0.1"), F("0.4")))
    with pytest.raises(other_surface.Outside, match="no schedule wind"):
        other.part(fmpq(1, 10), fmpq(2, 5))
    part = other.part(fmpq(9, 100), fmpq(2, 5)).factors()
    found = factors.factors(cell.piece((F("0.09"), F("0.4"))))
    assert found == {name: (number(at.low), number(at.high)) for name, at in part.items()}
