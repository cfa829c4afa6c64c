"""The claim about the loop around the trim at the schedule wind: both checkers, forged files, V'.

The certificate is the first line of ``recorded/schedule-rate.jsonl``: three cells of the default
law of the NREL 5-MW turbine, with schedule winds from 17.034 to 18.5276 m/s.
"""

from __future__ import annotations

import json
import math
import re
from copy import deepcopy
from fractions import Fraction
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, check
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.turbine.effort_sharing import inputs as plants
from takagi.certificates.checker.turbine.running_loop import inputs as machines
from takagi.certificates.checker.turbine.scheduled_loop import (
    schedule_cell,
    schedule_inputs,
    schedule_limits,
    schedule_loop,
)
from takagi.certificates.claims.turbine import schedule_claim
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry, sealed, verdicts

motion: Any = import_module("turbine_running")
F = Fraction
CELLS = range(3)
LAG, ESTIMATE = 3, 6


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("schedule-rate"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


# Both checkers.


def test_both_checkers_prove_it(document: dict[str, Any]) -> None:
    assert verdicts(document) == ("PROVED", "PROVED")


def test_the_sentence_has_the_ranges_and_the_widths_of_the_sets(document: dict[str, Any]) -> None:
    """Widths against numpy's inverse."""
    claim = document["claims"][0]
    said = check_document(sealed(document)).claims[0]
    low, high = claim["winds"][0]
    assert f"stays within {low:g} to {high:g} m/s and moves by at most 0.03 m/s^2" in said.text
    assert "a schedule wind within 17.034 to 18.5276 m/s keeps both" in said.text
    inverse = [np.linalg.inv(np.array(one["P"])) for one in claim["functions"]]
    for i, phrase, unit in (
        (0, r"the speed by ([\d.]+) rad/s", 1.0),
        (1, r"pitch by ([\d.]+) deg", math.pi / 180),
        (ESTIMATE, r"the wind estimate by ([\d.]+) m/s", 1.0),
        (LAG, r"the wind itself by ([\d.]+) m/s", 1.0),
    ):
        found = re.search(phrase, said.text)
        assert found is not None
        width = max(math.sqrt(one[i, i]) for one in inverse)
        assert 1.0 <= float(found[1]) * unit / width < 1.01
    for phrase in ("wind rate within", "rigid shaft, tower and blades", "c_P of the table"):
        assert any(phrase in one for one in said.assumes)


def scaled(place: int, factor: float) -> Change:
    """Return a change of a whole function, which stays positive definite and symmetric."""

    def change(document: Any) -> None:
        one = document["claims"][0]["functions"][place]
        one["P"] = [[factor * entry for entry in row] for row in one["P"]]

    return change


def jump(document: Any) -> None:
    """Let the set jump at a schedule wind that two cells share: a function for each side."""
    functions = document["claims"][0]["functions"]
    other = deepcopy(functions[1])
    other["P"] = [[1.01 * entry for entry in row] for row in other["P"]]
    functions.insert(1, other)


def below_rated(document: Any) -> None:
    """Move the first cell and its function to winds with a feed-forward of the torque."""
    claim = document["claims"][0]
    claim["functions"][0]["wind"] = claim["cells"][0]["wind"][0] = 9.2
    claim["functions"][1]["wind"] = claim["cells"][0]["wind"][1] = 9.4
    claim["cells"] = claim["cells"][:1]
    claim["winds"] = [[9.25, 9.35]]


CLAIM = ("claims", 0)
CELL = (*CLAIM, "cells", 1)
FORGED = {
    "a faster wind": entry(*CELL, "wind_rate", factor=1.5),
    "no rate of the wind": entry(*CELL, "wind_rate", value=0.0),
    "a negative rate of the wind": entry(*CELL, "wind_rate", factor=-1),
    "faster decay": entry(*CELL, "decay_rate", factor=3),
    "slower decay": entry(*CELL, "decay_rate", factor=0.3),
    "negative decay": entry(*CELL, "decay_rate", factor=-1),
    "no share of the residual": entry(*CELL, "residual_share", value=0.0),
    "nothing but the residual": entry(*CELL, "residual_share", value=1.0),
    "a negative share": entry(*CELL, "residual_share", value=-0.1),
    "one entry of P": entry(*CLAIM, "functions", 1, "P", 0, 1, factor=1.000001),
    "a smaller diagonal of P": entry(*CLAIM, "functions", 1, "P", 3, 3, factor=0.1),
    "a larger diagonal of P": entry(*CLAIM, "functions", 1, "P", 3, 3, factor=30),
    "a set that grows too fast with the wind": scaled(1, 0.5),
    "a set that shrinks too fast with the wind": scaled(1, 2.0),
    "a set that jumps": jump,
    "a function too few": lambda d: d["claims"][0]["functions"].pop(1),
    "a function of eight states": entry(*CLAIM, "functions", 1, "P", value=np.eye(8).tolist()),
    "a multiplier of 0": entry(*CELL, "multipliers", "inertia", 1, value=0.0),
    "a negative multiplier": entry(*CELL, "multipliers", "lead", 0, factor=-1),
    "a small multiplier": entry(*CELL, "multipliers", "inertia", 0, factor=1e-3),
    "a large multiplier": entry(*CELL, "multipliers", "stiffness", 1, factor=1e4),
    "a multiplier of nothing": entry(*CELL, "multipliers", "nothing", value=[1.0, 1.0]),
    "one multiplier for both winds": entry(*CELL, "multipliers", "lead", value=1.0),
    "a multiplier too few": lambda d: d["claims"][0]["cells"][1]["multipliers"].pop("pitch slope"),
    "a larger box": entry(*CELL, "sides", "wind", factor=3),
    "a smaller box": entry(*CELL, "sides", "wind", factor=0.8),
    "a box of nothing": entry(*CELL, "sides", "speed", value=0.0),
    "an estimate that reaches zero": entry(*CELL, "sides", "estimate", value=17.5),
    "an estimate beyond the tables": entry(*CELL, "sides", "estimate", value=7.4),
    "a signal that lets torque act": entry(*CELL, "sides", "signal", value=0.9),
    "a filtered speed that moves faster": entry(*CELL, "sides", "measured_rate", factor=2),
    "a drive that reaches its limit": entry(*CELL, "sides", "drive", value=0.05),
    "a side too few": lambda d: d["claims"][0]["cells"][1]["sides"].pop("innovation"),
    "other winds of the cell": entry(*CELL, "wind", 0, value=17.6),
    "a wind that takes v_s out below": entry(*CLAIM, "winds", 0, 0, value=17.3),
    "a wind that takes v_s out above": entry(*CLAIM, "winds", 0, 1, value=18.4),
    "a wind outside the cells": entry(*CLAIM, "winds", 0, value=[16.0, 19.0]),
    "winds that do not increase": entry(*CLAIM, "winds", 0, value=[17.9, 17.7]),
    "a range too many": lambda d: d["claims"][0]["winds"].append([20.0, 20.1]),
    "no range": entry(*CLAIM, "winds", value=[]),
    "cells in another order": lambda d: d["claims"][0]["cells"].reverse(),
    "a cell too few": lambda d: d["claims"][0]["cells"].pop(1),
    "a cell that stands twice": lambda d: d["claims"][0]["cells"].append(
        d["claims"][0]["cells"][2]
    ),
    "winds below rated wind": below_rated,
    "more inertia": entry(*CLAIM, "uncertainty", "inertia", value=[0.2, 5.0]),
    "a wake that is longer": entry(*CLAIM, "uncertainty", "wake_length", value=[0.4, 8000.0]),
    "another observer than the file's": entry(*CLAIM, "observer", "l1", factor=1.01),
    "another filter than the file's": entry(*CLAIM, "measurement", "speed_filter", value=8.0),
    "no band-stop in the claim": lambda d: d["claims"][0]["measurement"].pop("torsion_filter"),
    "other pitch limits of the law": entry("gains", "pitch_max", value=1.0),
    "a slower wind filter": entry("gains", "wind_filter", value=24.0),
    "a law without a filter": entry("gains", "wind_filter", value=0.0),
    "an integral with a lower limit": entry("gains", "integral_limit", value=0.03),
    "a faster law": lambda d: d["gains"].update(
        proportional=[4 * v for v in d["gains"]["proportional"]]
    ),
    "more effect of pitch before the wake": lambda d: d["gains"].update(
        effectiveness_limit=[4 * v for v in d["gains"]["effectiveness_limit"]]
    ),
    "a slower drive": entry("model", "pitch_time_constant", factor=3),
    "a drive that may hardly move": entry("model", "pitch_rate_limit", value=0.02),
    "another torque surface": entry("model", "torque_constant", factor=1.05),
    "a law whose file has another program": entry("gains", "name", value="paper"),
    "an observer's gain as a text": entry("controller", "observer", "l1", value="1.7942"),
}


@pytest.mark.parametrize("change", FORGED.values(), ids=FORGED.keys())
def test_a_forged_file_is_not_proved(document: dict[str, Any], change: Change) -> None:
    """With hashes that fit again; by neither checker."""
    change(document)
    assert "PROVED" not in verdicts(document)


def test_a_slower_wind_is_proved_too(document: dict[str, Any]) -> None:
    """Less is claimed: the input's weight grows."""
    for cell in document["claims"][0]["cells"]:
        cell["wind_rate"] *= 0.5
    assert verdicts(document) == ("PROVED", "PROVED")


def test_both_checkers_turn_at_the_same_wind(document: dict[str, Any]) -> None:
    """The wind may come as near to the cells' end as v - v_s may go there, by numpy, no nearer."""
    claim = document["claims"][0]
    width = math.sqrt(np.linalg.inv(np.array(claim["functions"][0]["P"]))[LAG, LAG])
    end = claim["cells"][0]["wind"][0]
    for away, answer in ((1e-6, "PROVED"), (-1e-6, "UNDECIDED")):
        claim["winds"][0][0] = end + width + away
        assert verdicts(document) == (answer, answer)


@pytest.mark.parametrize("side", ["estimate", "integral"])
def test_both_checkers_turn_at_the_same_side(document: dict[str, Any], side: str) -> None:
    """The set's own width, as numpy has it, decides whether it fits."""
    claim, law = document["claims"][0], document["gains"]
    place = {"estimate": ESTIMATE, "integral": 2}[side]
    width = max(
        math.sqrt(np.linalg.inv(np.array(one["P"]))[place, place]) for one in claim["functions"]
    )
    for factor, answer in ((1.0001, "PROVED"), (0.9999, "UNDECIDED")):
        if side == "integral":
            law["integral_limit"] = width * factor
        else:
            # Of the widest cell alone: the other boxes hold their sets.
            for cell in claim["cells"]:
                cell["sides"]["estimate"] = min(cell["sides"]["estimate"], width * factor)
        assert verdicts(document) == (answer, answer)


def test_a_file_without_a_controller_is_about_its_own_observer(document: dict[str, Any]) -> None:
    del document["controller"]
    assert verdicts(document) == ("PROVED", "PROVED")


def test_a_gain_file_with_another_observer_is_refused(
    document: dict[str, Any], tmp_path: Path
) -> None:
    """Also where the certificate has no ``controller`` to compare the file with."""
    controller = document.pop("controller")
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(json.dumps(sealed(document)), encoding="utf-8")
    controller["observer"]["l1"] = 1.8
    gains.write_text(json.dumps({"law": document["gains"], **controller}), encoding="utf-8")
    with pytest.raises(CertificateError, match="observer.l1 is not the gain file's"):
        check(certificate, gains=gains)


# The search.


def test_the_search_refuses_what_it_cannot_claim(document: dict[str, Any]) -> None:
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    for within, reason in (
        ((F(18), F("18.1")), "no interval of the law's tables lies in the range"),
        ((F("8.7"), F("9.2")), "the reference speed changes with the wind"),
    ):
        claims, why = schedule_claim(*given, within=within, rate=0.03)
        assert claims == [] and reason in why["schedule-rate"]
    document["gains"]["wind_filter"] = 0.0
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    claims, why = schedule_claim(*given, within=(F(17), F(19)), rate=0.03)
    assert why == {"schedule-rate": "not claimed: the law has no filter of the wind estimate"}


@pytest.mark.slow
def test_the_search_finds_a_claim_that_both_checkers_prove(document: dict[str, Any]) -> None:
    """One interval of the tables at a low rate, so that the lag is shorter than the range."""
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    within = (F("18.0297"), F("18.5276"))
    document["claims"], why = schedule_claim(*given, within=within, rate=0.01)
    assert why == {} and verdicts(document) == ("PROVED", "PROVED")


# The nonlinear loop.


class AtSchedule:
    """The set of one cell at a schedule wind, and the nonlinear loop there, by numpy."""

    def __init__(self, stored: Any, k: int, wind: float) -> None:
        self.stored, self.v_s = stored, wind
        claim = stored["claims"][0]
        self.cell = claim["cells"][k]
        by_wind = {one["wind"]: np.array(one["P"]) for one in claim["functions"]}
        low, high = self.cell["wind"]
        self.slope = (by_wind[high] - by_wind[low]) / (high - low)
        self.P = by_wind[low] + (wind - low) * self.slope

    def pitch(self, wind: float) -> float:
        law = self.stored["gains"]
        effort, b = (
            float(np.interp(wind, law["wind"], law[name]))
            for name in ("trim_effort", "effectiveness")
        )
        return float(law["pitch_min"] + effort / b)

    def rates(self, xi: Any, plant: Any, wind_rate: float) -> tuple[Any, float]:
        """Return xi' of the loop of ``benchmarks/turbine_running.py``, and v_s'."""
        wind = self.v_s + xi[LAG]
        at = motion.Motion(self.stored, {"wind": [wind - 1e-3, wind + 1e-3]}, wind, plant)
        own = xi.copy()
        for i in (1, 7):
            own[i] = (self.pitch(self.v_s) + xi[i] - at.pitch) * at.b0
        own[2] -= at.x_rest
        own[LAG], own[ESTIMATE] = -xi[LAG], xi[ESTIMATE] - xi[LAG]
        found = at.rate(own)
        moved, step = float(found[LAG]), 1e-6
        steep = (self.pitch(self.v_s + step) - self.pitch(self.v_s - step)) / (2 * step)
        for i in (1, 7):
            found[i] = found[i] / at.b0 - steep * moved
        found[LAG], found[ESTIMATE] = wind_rate - moved, found[ESTIMATE] - moved
        return found, moved


@pytest.mark.parametrize("k", CELLS)
def test_no_motion_leaves_the_set(stored: Any, k: int) -> None:
    """V' < 0 on V = 1 for v' = -r and r, in the nonlinear loop, which has no enclosures.

    Points are drawn, and taken where the loop without uncertainty is pushed most.
    """
    rng, cell = np.random.default_rng(k), stored["claims"][0]["cells"][k]
    worst = -np.inf
    for wind in np.linspace(cell["wind"][0], cell["wind"][1], 4)[1:-1]:
        at = AtSchedule(stored, k, float(wind))
        points = [*motion.boundary(at.P, 40, seed=k), *_steepest(at)]
        for xi, inertia, late in zip(
            points, rng.choice([0.9, 1.1], 99), rng.choice([0.0, 1.0], 99), strict=False
        ):
            plant = motion.Plant(inertia, rng.choice([40.0, 80.0]), late)
            for sign in (1.0, -1.0):
                rates, moved = at.rates(xi, plant, sign * cell["wind_rate"])
                worst = max(worst, 2 * xi @ at.P @ rates + moved * (xi @ at.slope @ xi))
    assert -0.06 < worst < 0


def _steepest(at: AtSchedule) -> list[Any]:
    """Return points of V = 1 towards which a moving wind pushes most."""
    plant, sizes = motion.Plant(), 1e-4 / np.sqrt(np.diag(at.P))
    columns = [
        (at.rates(size * one, plant, 0.0)[0] - at.rates(-size * one, plant, 0.0)[0]) / (2 * size)
        for size, one in zip(sizes, np.eye(10), strict=True)
    ]
    A, into = np.array(columns).T, np.eye(10)[LAG]
    towards = [np.linalg.solve(A - shift * np.eye(10), into) for shift in (0.0, 0.01, 0.03, 0.1)]
    return [sign * one / np.sqrt(one @ at.P @ one) for one in towards for sign in (1.0, -1.0)]


def test_a_faster_wind_does_leave_some_set(stored: Any) -> None:
    """Break on purpose: at ten times the rate V' > 0 at points that the wind pushes to."""
    at = AtSchedule(stored, 1, float(np.mean(stored["claims"][0]["cells"][1]["wind"])))
    found = []
    for xi, sign in product(_steepest(at), (1.0, -1.0)):
        rates, moved = at.rates(xi, motion.Plant(), sign * 10 * at.cell["wind_rate"])
        found.append(2 * xi @ at.P @ rates + moved * (xi @ at.slope @ xi))
    assert max(found) > 0


# Enclosures.


def _checked(stored: Any, k: int) -> schedule_cell.ScheduleCell:
    data = read_text(json.dumps(stored), "certificate")
    model, gains, claim = data["model"], data["gains"], data["claims"][0]
    stated = claim["cells"][k]
    winds = F(str(stated["wind"][0])), F(str(stated["wind"][1]))
    return schedule_cell.ScheduleCell(
        plants.Plant.read(model),
        plants.Law.read(gains),
        machines.Machine.read(claim, model, gains, "claim"),
        winds,
        schedule_inputs.ScheduleSides.read(stated, "cell"),
    )


@pytest.mark.parametrize("k", [0, 2])
def test_secants_lie_in_their_ranges(stored: Any, k: int) -> None:
    """Mean slopes on the way to corners of the box, by scipy's spline; the ranges are not loose.

    The mean is over 40 points by the midpoint rule; the largest lies within a third of the range
    from its ends.
    """
    cell = _checked(stored, k)
    ranges = schedule_loop.schedule_factors(cell, cell.lead)
    box = [float(getattr(cell.sides, name)) for name in ("speed", "pitch", "wind")]
    low, high = (float(v) for v in cell.winds)
    plant = motion.Motion(stored, {"wind": [low, high]}, (low + high) / 2, motion.Plant())
    radius = stored["model"]["rotor_radius"]
    seen: list[list[float]] = [[], [], []]
    for wind, *signs in product((low, (low + high) / 2, high), (-1, 0, 1), (-1, 0, 1), (-1, 0, 1)):
        law = stored["gains"]
        effort, b = (
            float(np.interp(wind, law["wind"], law[name]))
            for name in ("trim_effort", "effectiveness")
        )
        slopes = np.zeros(3)
        for t in (np.arange(40) + 0.5) / 40:
            e, p, d = (t * sign * side for sign, side in zip(signs, box, strict=True))
            speed, pitch, v = float(cell.speed) + e, effort / b + p, wind + d
            steep = plant.torque(speed, pitch, v, dx=1)
            slopes[0] += steep * radius / v / 40
            slopes[1] -= plant.torque(speed, pitch, v, dy=1) / 40
            slopes[2] += (
                2 * plant.torque(speed, pitch, v) / v - steep * radius * speed / v**2
            ) / 40
        for found, value in zip(seen, slopes, strict=True):
            found.append(float(value))
    for found, name in zip(seen, ("stiffness", "pitch gain", "wind gain"), strict=True):
        least, most = map(float, ranges[name])
        assert least <= min(found) and max(found) <= most
        assert max(found) - min(found) > (most - least) / 3


def test_the_rate_of_what_is_sent_is_within_its_bound(stored: Any) -> None:
    """The command of the nonlinear loop along its own motion from drawn states, by differences."""
    k, step = 1, 1e-5
    cell = _checked(stored, k)
    most = float(schedule_limits.sent_rate(cell, cell.lead))
    wind = float(np.mean(stored["claims"][0]["cells"][k]["wind"]))
    at, largest = AtSchedule(stored, k, wind), 0.0
    for xi in motion.boundary(at.P, 60, seed=1):
        rates, moved = at.rates(xi, motion.Plant(), 0.03)
        asked = []
        for t in (-step, step):
            there = AtSchedule(stored, k, wind + t * moved)
            state = xi + t * rates
            v = there.v_s + state[LAG]
            loop = motion.Motion(stored, {"wind": [v - 1e-3, v + 1e-3]}, v, motion.Plant())
            own = state.copy()
            own[2] -= loop.x_rest
            own[LAG], own[ESTIMATE] = -state[LAG], state[ESTIMATE] - state[LAG]
            asked.append(loop.commands(own)[1])
        largest = max(largest, abs(asked[1] - asked[0]) / (2 * step))
    assert 0.05 * most < largest < most < stored["model"]["pitch_rate_limit"]
