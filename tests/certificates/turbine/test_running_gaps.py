"""Gaps in the claim about moving wind: cells beside one another get functions that serve both.

The cells are four in a row from ``recorded/running-rate.jsonl``, 15.04 to 16.04 m/s.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.running_loop import (
    carried,
    equations,
    factors,
    moving,
    stated,
)
from takagi.certificates.checker.turbine.running_loop import (
    cell as one_cell,
)
from takagi.certificates.checker.turbine.running_loop import (
    moving_claim as checked,
)
from takagi.certificates.claims.turbine import moving_claim
from takagi.certificates.claims.turbine.running_loop import (
    bridges,
    candidate,
    cell_chain,
    entered_cells,
    moving_cell,
    moving_program,
    running_loop_claim,
    running_rate_claim,
)
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import verdicts

F = Fraction
Span = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Stored:
    """The certificate, and what its search knows."""

    document: dict[str, Any]
    subject: candidate.Subject
    cells: list[checked.MovingCell]


@pytest.fixture(scope="module")
def stored() -> Stored:
    document = json.loads(next(recorded("running-rate"))[1])
    claim = read_text(json.dumps(document), "certificate")["claims"][0]
    head = {"decay_rate": 0.004, **document["claims"][0]}
    subject = running_loop_claim.loop_subject(document["model"], document["gains"], head)
    functions = stated.stated_functions(claim, 10, "claim")
    cells = [checked.MovingCell.read(cell, functions, "cell") for cell in claim["cells"][2:]]
    return Stored(document, subject, cells)


def certified(document: dict[str, Any], cells: Sequence[checked.MovingCell]) -> tuple[str, str]:
    """Return what both checkers say about a claim of these cells."""
    found, claim = deepcopy(document), running_rate_claim.stated_cells(cells)
    found["claims"][0] |= claim
    return verdicts(found)


def passed(subject: candidate.Subject, cells: Sequence[checked.MovingCell]) -> list[carried.Passed]:
    """Return the cells as the condition between cells takes them."""
    given = subject.plant, subject.law, subject.machine
    kept = [checked.examined(*given, cell) for cell in cells]
    return [one.passed for one in kept if isinstance(one, checked.Kept)]


def test_gaps_are_the_winds_that_no_cell_covers(stored: Stored) -> None:
    first, second, third, last = stored.cells
    everywhere = (first.winds[0], last.winds[1])
    assert bridges.gaps(stored.cells, everywhere) == []
    assert bridges.gaps([first, third], everywhere) == [second.winds, last.winds]
    assert bridges.gaps([second], everywhere)[0] == first.winds


def test_two_cells_get_another_function_between_them(stored: Stored) -> None:
    """The functions at their outer ends stay, as other cells have them; so do the rates."""
    pair = stored.cells[1:3]
    first = {v: P for cell in pair for v, P in zip(cell.winds, cell.ends, strict=True)}
    stay = {v: first[v] for v in (pair[0].winds[0], pair[1].winds[1])}
    asked = [
        cell_chain.Asked(moving_cell.as_fitted(one), float(one.decay), (1.0, 0.97), {})
        for one in pair
    ]
    found = cell_chain.held(stored.subject, asked, first, stay)
    assert found is not None
    cells = [stored.cells[0], *found, stored.cells[3]]
    for one, before in zip(cells, stored.cells, strict=True):
        assert one.wind_rate >= F("0.97") * before.wind_rate
    assert cells[1].ends[0] == pair[0].ends[0] and cells[1].ends[1] != pair[0].ends[1]
    assert certified(stored.document, cells) == ("PROVED", "PROVED")


@pytest.mark.slow
def test_a_gap_is_filled_and_its_neighbours_keep_their_rates(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last cell but one is left out; both checkers prove what is found in its place."""
    first, second, gone, last = stored.cells
    left, own = [first, second, last], [moving_cell.as_fitted(gone)]
    monkeypatch.setattr(bridges, "NEIGHBOURS", (1,))
    found = bridges.bridged(stored.subject, left, own, {one.winds: {} for one in stored.cells})
    assert found is not None
    assert [one.winds for one in found] == [one.winds for one in stored.cells]
    for one, before in zip(found, stored.cells, strict=True):
        assert one.wind_rate >= (F("0.97") if before in left else F("0.6")) * before.wind_rate
    assert found[1].ends[0] == second.ends[0] and found[1].ends[1] != second.ends[1]
    assert certified(stored.document, found) == ("PROVED", "PROVED")


def test_a_cell_gets_the_room_that_entering_it_needs(stored: Stored) -> None:
    """In the narrow box the limits' lag leads out of the cell; the functions stay."""
    narrow = list(stored.cells)
    sides = replace(narrow[1].sides, schedule=F("0.33346"))
    narrow[1] = replace(narrow[1], sides=sides)
    run = passed(stored.subject, narrow)
    failing = [winds for winds, _ in carried.carried_failures(run)]
    assert failing == [narrow[1].winds]
    found = entered_cells.with_room(stored.subject, narrow)
    assert found is not None and found[1].sides.schedule > sides.schedule
    assert [one.ends for one in found] == [one.ends for one in narrow]
    assert certified(stored.document, found) == ("PROVED", "PROVED")


def test_a_box_is_widened_by_the_moves(stored: Stored) -> None:
    """By no more than they need; signal and effort lose to a longer side of the schedule wind."""
    cell, subject = stored.cells[1], stored.subject
    moves = {"schedule": 0.05, "effort": 0.001}
    sides = moving_cell.with_moves(subject, cell.winds, cell.sides, cell.ends, moves)
    at = one_cell.Cell(subject.plant, subject.law, subject.machine, cell.winds, sides)
    sets = [np.linalg.inv(np.array(moving.in_units(at, P), dtype=np.float64)) for P in cell.ends]
    for name, (h, bound) in equations.rows(at, factors.factors(at)).items():
        row = np.array(h, dtype=np.float64)
        left = float(bound) - max(float(np.sqrt(row @ Q @ row)) for Q in sets)
        if name in moves:
            assert moves[name] < left < 1.05 * moves[name]
        else:
            assert left > 0


def test_the_room_is_what_the_checker_asks_for(stored: Stored) -> None:
    """The checker turns where a set is as far from its bound as the moves are long."""
    given = stored.subject.plant, stored.subject.law, stored.subject.machine
    kept = [
        one
        for cell in stored.cells
        if isinstance(one := checked.examined(*given, cell), checked.Kept)
    ]
    run = [one.passed for one in kept]
    moves = entered_cells.moves_to_enter([one.cell for one in run])
    assert moves is not None
    for factor, enough in ((1.001, True), (0.999, False)):
        rooms: list[list[carried.Room]] = [
            [{name: (F(1), 1 + F(factor * move)) for name, move in one.items()}] for one in moves
        ]
        at = [replace(one, rooms=(room, room)) for one, room in zip(run, rooms, strict=True)]
        needing = [
            one.cell.winds for one, move in zip(run, moves, strict=True) if any(move.values())
        ]
        failing = [winds for winds, _ in carried.carried_failures(at)]
        assert needing and failing == ([] if enough else needing)


def test_a_set_has_width_in_pitch_where_nothing_moves_it(stored: Stored) -> None:
    """At 7 m/s the share of pitch is 0, and the least set has none: P could not change to one."""
    winds = stored.subject.law.wind
    low = next(v for v in winds if v > 7)
    at = (low, low + F("0.05"))
    box = candidate.box_of_size(stored.subject, F(1, 10))
    posed, why = moving_cell.pose(stored.subject, at, box, 0.002)
    assert posed is not None, why
    least = moving_program.least_set(posed.loops, posed.rows, *moving_cell.USUAL)
    assert least is not None and np.sqrt(least[equations.P, equations.P]) < 0.01
    given, why = moving_cell.function_at(stored.subject, [moving_cell.Fitted(at, 0.002, box)])
    assert given is not None, why
    found = np.linalg.inv(np.array(given, dtype=np.float64) * np.outer(posed.unit, posed.unit))
    for state in (equations.P, equations.ETA):
        assert np.sqrt(found[state, state]) > 0.99 * moving_cell.THINNEST


@pytest.mark.slow
def test_cells_of_a_gap_are_found_by_themselves(stored: Stored) -> None:
    """The interval is one cell: no narrower one is wanted where the neighbours are no faster."""
    winds = stored.cells[2].winds
    (found,) = bridges.own_cells(stored.subject, winds, 0.003)
    assert found.winds == winds and found.rate > 0.003


@pytest.mark.slow
def test_a_corner_of_the_reference_speed_is_in_a_range(stored: Stored) -> None:
    """It is at 5.9622 m/s; the search's first cells leave a gap around it."""
    document = deepcopy(stored.document)
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    claims, why = moving_claim(*given, within=(F("5.4626"), F("6.8503")))
    document["claims"] = claims
    assert why == {} and verdicts(document) == ("PROVED", "PROVED")
    assert claims[0]["winds"] == [[5.4626, 6.8503]]
