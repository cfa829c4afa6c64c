"""Pieces of the schedule wind in the claim about moving wind: factors, both checkers, forged files.

The certificate is the last line of ``recorded/running-rate.jsonl``: two cells of the default law of
the NREL 5-MW turbine, from 15.0425 to 15.5403 m/s, with three pieces each.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from flint import fmpq

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.effort_sharing import inputs as turbine
from takagi.certificates.checker.turbine.running_loop import cell as own_cell
from takagi.certificates.checker.turbine.running_loop import inputs, moving
from takagi.certificates.claims.turbine import moving_claim
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers as other_numbers
from takagi.certificates.cross_check.turbine.running import cell as other_cell
from takagi.certificates.cross_check.turbine.running import machine as other_machine
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine import test_running_rate as without_pieces
from tests.certificates.turbine.running_documents import verdicts

F = Fraction
SIDES = {
    "speed": "0.02", "measured": "0.02", "pitch": "0.02", "signal": "0.03", "effort": "0.015",
    "schedule": "0.8", "estimate": "0.2", "integral": "0.03", "measured_rate": "0.05",
    "innovation": "0.01",
}  # fmt: skip
# A cell by a node of the tables, with lags over one to three intervals, or within one.
WINDS = {"10.1": ("10.1", "10.2"), "15.0": ("15.0425", "15.2914"), "19.1": ("19.0255", "19.1")}
LAGS = [("-0.8", "-0.3"), ("-0.3", "0.2"), ("0.2", "0.8"), ("0", "0.8"), ("-0.05", "0")]


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads([text for _, text in recorded("running-rate")][-1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


@pytest.fixture(scope="module")
def cells(stored: dict[str, Any]) -> dict[str, tuple[own_cell.Cell, other_cell.RunningCell]]:
    """The same boxes for both checkers."""
    data = read_text(json.dumps(stored), "document")
    claim, model, gains = data["claims"][0], data["model"], data["gains"]
    read = loads(json.dumps(stored))
    other = other_machine.Machine(read["claims"][0], read["model"], read["gains"])
    machine = inputs.Machine.read(claim, model, gains, "claim")
    plant, law, rotor = (
        turbine.Plant.read(model),
        turbine.Law.read(gains),
        other_numbers.Rotor(read["model"], read["gains"]),
    )
    sides = inputs.Sides(**{name: F(value) for name, value in SIDES.items()})
    numbers = {name: exact(value) for name, value in SIDES.items()}
    return {
        key: (
            own_cell.Cell(plant, law, machine, (F(low), F(high)), sides),
            other_cell.RunningCell(rotor, other, exact(low), exact(high), numbers),
        )
        for key, (low, high) in WINDS.items()
    }


def exact(value: str) -> fmpq:
    """Return a decimal for the second checker."""
    return fmpq(*F(value).as_integer_ratio())


def as_numbers(values: Any) -> tuple[Fraction, ...]:
    return tuple(F(int(value.p), int(value.q)) for value in values)


# Factors of a piece.


@pytest.mark.parametrize("lag", LAGS)
@pytest.mark.parametrize("key", WINDS)
def test_both_checkers_enclose_alike(
    cells: dict[str, tuple[own_cell.Cell, other_cell.RunningCell]], key: str, lag: tuple[str, str]
) -> None:
    """To the last digit: a multiplier belongs to one range."""
    first, second = cells[key]
    mine = moving.moving_factors(first.piece((F(lag[0]), F(lag[1]))))
    part = second.part(*(exact(s) for s in lag))
    yours = part.factors() | {"pitch slope": part.trim_slope()}
    assert mine == {name: as_numbers((at.low, at.high)) for name, at in yours.items()}


@pytest.mark.parametrize("lag", LAGS)
@pytest.mark.parametrize("key", WINDS)
@pytest.mark.parametrize("column", ["speed", "effort", "gamma", "effectiveness"])
def test_secants_of_a_piece_are_all_inside_and_reach_its_ends(
    cells: dict[str, tuple[own_cell.Cell, other_cell.RunningCell]],
    key: str,
    lag: tuple[str, str],
    column: str,
) -> None:
    """By numpy's interpolation over 41 winds and lags, which include the ends and the nodes."""
    cell, _ = cells[key]
    nodes = np.array(cell.law.wind, dtype=np.float64)
    values = np.array(getattr(cell.law, column), dtype=np.float64)
    low, high = (float(F(s)) for s in lag)
    found = []
    first, last = (float(F(one)) for one in WINDS[key])
    for v in np.linspace(first, last, 41):
        inside = [w - v for w in nodes if low < w - v < high]
        s = np.array([*np.linspace(low, high, 41), *inside])
        s = s[np.abs(s) > 1e-6]
        found += list((np.interp(v + s, nodes, values) - np.interp(v, nodes, values)) / s)
    range_of = [
        float(end) for end in cell.piece((F(lag[0]), F(lag[1]))).secants(getattr(cell.law, column))
    ]
    assert range_of[0] <= min(found) + 1e-12 and max(found) - 1e-12 <= range_of[1]
    # 41 steps miss a corner between them by little.
    assert np.allclose(range_of, [min(found), max(found)], atol=2e-3)


def test_feed_forward_and_lead_of_a_piece_are_those_of_the_whole_side(
    cells: dict[str, tuple[own_cell.Cell, other_cell.RunningCell]],
) -> None:
    """The feed-forward jumps to 0 at 10.4446 m/s, and torque may follow the jump late.

    So also the piece above that node has the factor from below it, in both checkers.
    """
    first, second = cells["10.1"]
    above = F("0.4"), F("0.8")
    part = second.part(fmpq(2, 5), fmpq(4, 5))
    for name in ("feed-forward", "lead"):
        whole = moving.moving_factors(first)[name]
        assert moving.moving_factors(first.piece(above))[name] == whole
        at = part.factors()[name]
        assert as_numbers((at.low, at.high)) == whole
    fed = dict(zip(first.law.wind[:-1], first.law.inertia, strict=True))
    assert fed[F("10.4446")] == 0 < moving.moving_factors(first)["feed-forward"][1]


def test_pieces_are_narrower_than_the_whole(
    cells: dict[str, tuple[own_cell.Cell, other_cell.RunningCell]],
) -> None:
    """Their hull covers what a secant can be, and each factor's range is inside the whole's."""
    cell, _ = cells["15.0"]
    whole = moving.moving_factors(cell)
    for lag in pairwise([F("-0.8"), F("-0.3"), F("0.3"), F("0.8")]):
        for name, (low, high) in moving.moving_factors(cell.piece(lag)).items():
            # A secant is rounded outward once more than the slopes of the whole.
            assert whole[name][0] - F(1, 10**6) <= low <= high <= whole[name][1] + F(1, 10**6), name


# Both checkers, and forged files.


def test_both_checkers_prove_it(document: dict[str, Any]) -> None:
    assert all("schedule_cuts" in cell for cell in document["claims"][0]["cells"])
    assert verdicts(document) == ("PROVED", "PROVED")


def test_without_the_pieces_it_is_not_proved(document: dict[str, Any]) -> None:
    """The rates of these cells need them: with any row of the multipliers for the whole side."""
    for row in range(3):
        whole = deepcopy(document)
        for cell in whole["claims"][0]["cells"]:
            del cell["schedule_cuts"]
            cell["multipliers"] = [cell["multipliers"][row]]
        assert "PROVED" not in verdicts(whole)


Change = Callable[[Any], None]


def cuts(*values: float) -> Change:
    def change(cell: Any) -> None:
        cell["schedule_cuts"] = list(values)

    return change


FORGED: dict[str, Change] = {
    "no cut": cuts(),
    "cuts that do not increase": cuts(0.1, -0.1),
    "a cut that stands twice": cuts(0.0, 0.0),
    "a cut beyond the box": cuts(0.0, 50.0),
    "a cut too few": cuts(0.0),
    "a cut too many": cuts(-0.1, 0.0, 0.1),
    "other cuts": lambda cell: cell.update(schedule_cuts=[0.99 * -cell["sides"]["schedule"], 0.0]),
    "sixteen cuts": lambda cell: cell.update(
        schedule_cuts=[0.01 * k for k in range(16)], multipliers=cell["multipliers"][:1] * 17
    ),
    "a row too few": lambda cell: cell["multipliers"].pop(),
    "rows of another piece": lambda cell: cell["multipliers"].reverse(),
    "one row for all": lambda cell: cell.update(multipliers=cell["multipliers"][:1] * 3),
    "a row's multiplier of 0": lambda cell: cell["multipliers"][2].update(gamma=[0.0, 0.0]),
    "a row's small multiplier": lambda cell: cell["multipliers"][2].update(gamma=[1e-9, 1e-9]),
    "a faster wind": lambda cell: cell.update(wind_rate=2 * cell["wind_rate"]),
    "a smaller box": lambda cell: cell["sides"].update(schedule=cell["sides"]["schedule"] / 2),
    "a wider box": lambda cell: cell["sides"].update(schedule=3 * cell["sides"]["schedule"]),
    "words in the place of cuts": lambda cell: cell.update(schedule_cuts="none"),
}


@pytest.mark.parametrize("change", FORGED.values(), ids=FORGED.keys())
def test_a_forged_file_is_not_proved(document: dict[str, Any], change: Change) -> None:
    """With hashes that fit again; by neither checker."""
    change(document["claims"][0]["cells"][0])
    assert "PROVED" not in verdicts(document)


def test_a_slower_wind_is_proved_too(document: dict[str, Any]) -> None:
    for cell in document["claims"][0]["cells"]:
        cell["wind_rate"] *= 0.5
    assert verdicts(document) == ("PROVED", "PROVED")


@pytest.mark.parametrize("k", [0, 1])
def test_no_motion_leaves_the_set(stored: dict[str, Any], k: int) -> None:
    """The nonlinear loop of the benchmarks, which knows no pieces, as for cells without them."""
    without_pieces.test_no_motion_leaves_the_set(stored, k)


@pytest.mark.slow
def test_the_search_finds_pieces_that_bear_a_faster_wind(document: dict[str, Any]) -> None:
    """One interval of the law's tables; without pieces no cell there has 0.012 m/s^2."""
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    within = F("15.0425"), F("15.5403")
    rates = {}
    for cuts in ((), (-0.5, 0.5)):
        claims, why = moving_claim(*given, within=within, cuts=cuts)
        document["claims"] = claims
        assert why == {} and verdicts(document) == ("PROVED", "PROVED")
        assert claims[0]["winds"] == [[15.0425, 15.5403]]
        rates[cuts] = [cell["wind_rate"] for cell in claims[0]["cells"]]
        assert all(("schedule_cuts" in cell) == bool(cuts) for cell in claims[0]["cells"])
    assert min(rates[(-0.5, 0.5)]) > max(rates[()])
