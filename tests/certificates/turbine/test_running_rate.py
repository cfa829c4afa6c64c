"""The claim about the running loop in moving wind: both checkers, forged files, the nonlinear loop.

The certificate is the first line of ``recorded/running-rate.jsonl``: six cells of the default law
of the NREL 5-MW turbine, in three ranges of winds.
"""

from __future__ import annotations

import json
import math
import re
from copy import deepcopy
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, check
from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine import moving_claim
from takagi.cli.main import main
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import Change, entry, sealed, verdicts

motion: Any = import_module("turbine_running")
F = Fraction
CELLS = range(6)


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("running-rate"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


# Both checkers.


def test_both_checkers_prove_it(document: dict[str, Any]) -> None:
    assert verdicts(document) == ("PROVED", "PROVED")


def test_the_sentence_names_ranges_gaps_and_bounds(document: dict[str, Any]) -> None:
    """The wind stays in one of the ranges: V is continuous only within each."""
    claim = check_document(sealed(document)).claims[0]
    assert "but NOT 3 to 10.7509 m/s, 10.8509 to 12.7509 m/s, 12.8509 to 15.0425 m/s" in claim.name
    ranges = "10.7509 to 10.8509 m/s, or 12.7509 to 12.8509 m/s, or 15.0425 to 16.0382 m/s"
    assert f"within ONE of {ranges}" in claim.text
    assert "r is 0.006 to 0.011 m/s^2 (by cell) from 15.0425 to 16.0382 m/s" in claim.text
    for phrase in ("wind rate within", "rigid shaft, tower and blades", "c_P of the table"):
        assert any(phrase in one for one in claim.assumes)
    assert not any("constant wind" in one for one in claim.assumes)


def test_the_sentence_has_the_widths_of_the_sets(document: dict[str, Any]) -> None:
    """Against numpy's inverse; torque moves with the effort alone in the first cell: 438.4 N m.

    There the share of torque is 1 at the box's end, no feed-forward is met, and above rated wind
    torque does not move.
    """
    claim, law = document["claims"][0], document["gains"]
    text = check_document(sealed(document)).claims[0].text
    inverse = [np.linalg.inv(np.array(one["P"])) for one in claim["functions"]]
    widths = {
        name: max(math.sqrt(one[i, i]) for one in inverse)
        for name, i in (("speed", 0), ("pitch", 1), ("estimate", 6), ("schedule", 3))
    }
    torque = claim["cells"][0]["sides"]["effort"] * law["effort_torque"]
    assert 438 < torque < 439 and "torque by 439 N m" in text
    for name, phrase, unit in (
        ("speed", r"the speed by ([\d.]+) rad/s", 1.0),
        ("pitch", r"pitch by ([\d.]+) deg", math.pi / 180),
        ("estimate", r"the wind estimate by ([\d.]+) m/s", 1.0),
        ("schedule", r"the schedule wind by ([\d.]+) m/s", 1.0),
    ):
        found = re.search(phrase, text)
        assert found is not None
        assert 1.0 <= float(found[1]) * unit / widths[name] < 1.01
    over = re.search(r"at or below ([\d.]+) % of its rated speed", text)
    assert over is not None
    rated = document["model"]["rated_rotor_speed"]
    assert 0 <= float(over[1]) - 100 * (1 + widths["speed"] / rated) < 0.01


def scaled(place: int, factor: float) -> Change:
    """Return a change of a whole function, which stays positive definite and symmetric."""

    def change(document: Any) -> None:
        one = document["claims"][0]["functions"][place]
        one["P"] = [[factor * entry for entry in row] for row in one["P"]]

    return change


def jump(document: Any) -> None:
    """Let the set jump at the wind that two cells share: a function for each side."""
    functions = document["claims"][0]["functions"]
    place = next(i for i, one in enumerate(functions) if one["wind"] == 15.5403)
    other = deepcopy(functions[place])
    other["P"] = [[1.01 * entry for entry in row] for row in other["P"]]
    functions.insert(place, other)


CLAIM = ("claims", 0)
CELL = (*CLAIM, "cells", 3)
FORGED = {
    "a faster wind": entry(*CELL, "wind_rate", factor=2),
    "no rate of the wind": entry(*CELL, "wind_rate", value=0.0),
    "a negative rate of the wind": entry(*CELL, "wind_rate", factor=-1),
    "faster decay": entry(*CELL, "decay_rate", factor=5),
    "slower decay": entry(*CELL, "decay_rate", factor=0.2),
    "negative decay": entry(*CELL, "decay_rate", factor=-1),
    "no share of the residual": entry(*CELL, "residual_share", value=0.0),
    "hardly a share of the residual": entry(*CELL, "residual_share", value=1e-5),
    "nothing but the residual": entry(*CELL, "residual_share", value=1.0),
    "a negative share": entry(*CELL, "residual_share", value=-0.1),
    "one entry of P": entry(*CLAIM, "functions", 6, "P", 0, 1, factor=1.000001),
    "a smaller diagonal of P": entry(*CLAIM, "functions", 6, "P", 3, 3, factor=0.1),
    "a larger diagonal of P": entry(*CLAIM, "functions", 6, "P", 3, 3, factor=30),
    "a set that grows too fast with the wind": scaled(6, 0.6),
    "a set that shrinks too fast with the wind": scaled(6, 1.6),
    "a set that jumps": jump,
    "a function too few": lambda d: d["claims"][0]["functions"].pop(6),
    "a function of eight states": entry(*CLAIM, "functions", 6, "P", value=np.eye(8).tolist()),
    "a multiplier of 0": entry(*CELL, "multipliers", 0, "drive", 1, value=0.0),
    "a negative multiplier": entry(*CELL, "multipliers", 0, "gamma", 0, factor=-1),
    "a small multiplier": entry(*CELL, "multipliers", 0, "drive", 0, factor=1e-3),
    "a large multiplier": entry(*CELL, "multipliers", 0, "drive", 1, factor=1e3),
    "a multiplier of nothing": entry(*CELL, "multipliers", 0, "nothing", value=[1.0, 1.0]),
    "one multiplier for both winds": entry(*CELL, "multipliers", 0, "drive", value=1.0),
    "a multiplier too few": lambda d: d["claims"][0]["cells"][3]["multipliers"][0].pop(
        "pitch slope"
    ),
    "a larger box": entry(*CELL, "sides", "effort", factor=6),
    "a smaller box": entry(*CELL, "sides", "schedule", factor=0.5),
    "a box of nothing": entry(*CELL, "sides", "speed", value=0.0),
    "an estimate that reaches zero": entry(*CELL, "sides", "estimate", value=15.0425),
    "a filtered speed that moves faster": entry(*CELL, "sides", "measured_rate", factor=60),
    "other winds of the cell": entry(*CELL, "wind", 0, value=15.3),
    "winds that are left out": entry(*CLAIM, "winds", value=[[10.7509, 16.0382]]),
    "a range too few": lambda d: d["claims"][0]["winds"].pop(),
    "cells in another order": lambda d: d["claims"][0]["cells"].reverse(),
    "a cell that stands twice": lambda d: d["claims"][0]["cells"].append(
        d["claims"][0]["cells"][5]
    ),
    "more inertia": entry(*CLAIM, "uncertainty", "inertia", value=[0.2, 5.0]),
    "a wake that is longer": entry(*CLAIM, "uncertainty", "wake_length", value=[0.4, 8000.0]),
    "another observer than the file's": entry(*CLAIM, "observer", "l1", factor=1.01),
    "another filter than the file's": entry(*CLAIM, "measurement", "speed_filter", value=8.0),
    "no band-stop in the claim": lambda d: d["claims"][0]["measurement"].pop("torsion_filter"),
    "other pitch limits of the law": entry("gains", "pitch_max", value=1.0),
    "a slower wind filter": entry("gains", "wind_filter", value=24.0),
    "a law without a filter": entry("gains", "wind_filter", value=0.0),
    "a faster law": lambda d: d["gains"].update(
        proportional=[4 * v for v in d["gains"]["proportional"]]
    ),
    "a slower drive": entry("model", "pitch_time_constant", factor=30),
    "a torque that may hardly move": entry("model", "torque_rate_limit", value=10.0),
    "another torque surface": entry("model", "torque_constant", factor=1.05),
    "a law whose file has another program": entry("gains", "name", value="paper"),
    "a cell that is entered at its edge": entry(*CELL, "sides", "schedule", value=0.33346),
    "an observer's gain as a text": entry("controller", "observer", "l1", value="1.7942"),
}


@pytest.mark.parametrize("change", FORGED.values(), ids=FORGED.keys())
def test_a_forged_file_is_not_proved(document: dict[str, Any], change: Change) -> None:
    """With hashes that fit again; by neither checker."""
    change(document)
    assert "PROVED" not in verdicts(document)


def test_only_a_cell_that_is_entered_needs_room_for_the_rate_limits(
    document: dict[str, Any],
) -> None:
    """Its set keeps a box that leaves 5 um/s; the pitch that lags from the next cell needs 8.

    By itself the cell is proved: no wind enters it with the commands of another.
    """
    claim = document["claims"][0]
    claim["cells"][3]["sides"]["schedule"] = 0.33346
    assert verdicts(document) == ("UNDECIDED", "UNDECIDED")
    text = check_document(sealed(document)).claims[0].text
    assert "15.2914 to 15.5403 m/s: torque or pitch may lag behind the law" in text
    claim["cells"] = [claim["cells"][3]]
    claim["winds"] = [claim["cells"][0]["wind"]]
    assert verdicts(document) == ("PROVED", "PROVED")


def test_both_checkers_turn_at_the_same_room(document: dict[str, Any]) -> None:
    """The side at which the cell may be entered, from both sides, less than 2e-8 apart."""
    sides = document["claims"][0]["cells"][3]["sides"]
    for side, answer in ((0.333463196, "UNDECIDED"), (0.333463213, "PROVED")):
        sides["schedule"] = side
        assert verdicts(document) == (answer, answer)


def test_a_slower_wind_is_proved_too(document: dict[str, Any]) -> None:
    """Less is claimed: the input's weight grows, and P moves less."""
    for cell in document["claims"][0]["cells"]:
        cell["wind_rate"] *= 0.5
    assert verdicts(document) == ("PROVED", "PROVED")


def test_both_checkers_turn_at_the_same_rate(document: dict[str, Any]) -> None:
    """One cell, all else as it is: the largest rate of the wind, from both sides."""
    claim = document["claims"][0]
    claim["cells"], claim["winds"] = [claim["cells"][1]], [claim["cells"][1]["wind"]]
    stated = claim["cells"][0]["wind_rate"]
    low, high = stated, 2 * stated
    while high - low > 1e-3 * stated:
        claim["cells"][0]["wind_rate"] = (low + high) / 2
        first, second = verdicts(document)
        assert first == second
        low, high = ((low + high) / 2, high) if first == "PROVED" else (low, (low + high) / 2)
    assert stated < low < 1.99 * stated


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
    gains.write_text(json.dumps({"law": document["gains"], **controller}), encoding="utf-8")
    assert check(certificate, gains=gains).verdict.name == "PROVED"
    controller["observer"]["l1"] = 1.8
    gains.write_text(json.dumps({"law": document["gains"], **controller}), encoding="utf-8")
    with pytest.raises(CertificateError, match="observer.l1 is not the gain file's"):
        check(certificate, gains=gains)


# The search, and how it is asked for.


@pytest.mark.slow
def test_the_search_finds_a_claim_that_both_checkers_prove(document: dict[str, Any]) -> None:
    """One interval of the law's tables; the target of 0.5 m/s^2 at 15 m/s is far away."""
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    claims, why = moving_claim(*given, within=(F("15.0425"), F("15.5403")))
    document["claims"] = claims
    assert why == {} and verdicts(document) == ("PROVED", "PROVED")
    assert claims[0]["winds"] == [[15.0425, 15.5403]]
    assert all(0.005 < cell["wind_rate"] < 0.05 for cell in claims[0]["cells"])


def test_a_law_without_a_filter_has_no_such_claim(document: dict[str, Any]) -> None:
    document["gains"]["wind_filter"] = 0.0
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    claims, why = moving_claim(*given)
    assert claims == []
    assert why == {"running-rate": "not claimed: the law has no filter of the wind estimate"}


def test_winds_without_a_cell_have_no_such_claim(document: dict[str, Any]) -> None:
    """No interval of the law's tables lies within."""
    given = document["model"], document["gains"], document["controller"], [0.9, 1.1]
    claims, why = moving_claim(*given, within=(F("3.4"), F("3.45")))
    assert claims == []
    assert "no quadratic function was found in moving wind" in why["running-rate"]


def test_the_option_belongs_to_the_effort_sharing_law(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--law", "paper", "--moving-wind", "--out", str(tmp_path)]
    assert main(["design", "nrel5mw", *options]) == 2
    assert "--moving-wind belongs to the effort-sharing law" in capsys.readouterr().err


# The nonlinear loop.


class Trim:
    """Trim and V at winds of a cell, from the law's tables with numpy."""

    def __init__(self, stored: Any, k: int) -> None:
        self.law, claim = stored["gains"], stored["claims"][0]
        self.cell = claim["cells"][k]
        by_wind = {one["wind"]: np.array(one["P"]) for one in claim["functions"]}
        self.low, self.high = self.cell["wind"]
        self.ends = by_wind[self.low], by_wind[self.high]
        self.slope = (self.ends[1] - self.ends[0]) / (self.high - self.low)

    def P(self, wind: float) -> Any:
        return self.ends[0] + (wind - self.low) * self.slope

    def at(self, wind: float) -> Any:
        """Return the trim as ten states: speeds in rad/s, pitch in rad, winds in m/s."""
        law = self.law
        speed, effort, b = (
            float(np.interp(wind, law["wind"], law[name]))
            for name in ("rotor_speed", "trim_effort", "effectiveness")
        )
        eps = law["overlap"]
        shed = 0.0 if effort <= -eps else effort if effort >= eps else (effort + eps) ** 2 / 4 / eps
        pitch = law["pitch_min"] + shed / b
        return np.array([speed, pitch, 0.0, wind, speed, speed, wind, pitch, speed, speed])

    def moving(self, wind: float) -> Any:
        """Return the trim's slope, by differences inside the cell."""
        step = 1e-6
        return (self.at(wind + step) - self.at(wind - step)) / (2 * step)


@pytest.mark.parametrize("k", CELLS)
def test_no_motion_leaves_the_set(stored: Any, k: int) -> None:
    """V' < 0 at the boundary for v' = -r and r, where the nonlinear loop is as fast as it can be.

    The loop is the one of ``benchmarks/turbine_running.py``, which knows nothing of the enclosures;
    rates come in absolute states, and the trim's motion is subtracted here.
    """
    trim, rng = Trim(stored, k), np.random.default_rng(k)
    cell = trim.cell
    worst = -np.inf
    for wind in np.linspace(trim.low, trim.high, 5)[1:-1]:
        plant = motion.Plant(rng.uniform(0.9, 1.1), rng.uniform(40, 80), rng.uniform(0, 1))
        at, P = motion.Motion(stored, cell, float(wind), plant), trim.P(float(wind))
        units = np.ones(10)
        units[[1, 7]] = 1 / at.b0
        rest = trim.at(float(wind)) * 0
        rest[[1, 7]] = at.pitch - trim.at(float(wind))[1]
        rest[2] = at.x_rest
        moved = trim.moving(float(wind))
        steepest = _steepest(at, P, units, moved)
        for xi in (*motion.boundary(P, 60, seed=k), *steepest):
            # ``xi`` is measured from the trim; the loop's states from its rest, pitch times b0.
            if trim.at(float(wind))[1] + xi[1] < stored["gains"]["pitch_min"]:
                continue
            rates = at.rate((xi - rest) / units) * units
            for sign in (1.0, -1.0):
                v = sign * cell["wind_rate"]
                slope = 2 * xi @ P @ (rates - v * moved) + v * (xi @ trim.slope @ xi)
                worst = max(worst, slope)
    assert worst < 0


def _steepest(at: Any, P: Any, units: Any, moved: Any) -> list[Any]:
    """Return points of V = 1 towards which a moving trim pushes most, by the loop's differences."""
    sizes = 1e-4 / np.sqrt(np.diag(P)) / units
    columns = [
        (at.rate(size * one) - at.rate(-size * one)) / (2 * size)
        for size, one in zip(sizes, np.eye(10), strict=True)
    ]
    A = units[:, None] * np.array(columns).T / units[None, :]
    towards = [np.linalg.solve(A - shift * np.eye(10), moved) for shift in (0.0, 0.01, 0.03)]
    return [sign * one / np.sqrt(one @ P @ one) for one in towards for sign in (1.0, -1.0)]


def test_the_bound_of_the_schedule_wind_is_above_its_lag_in_a_ramp(stored: dict[str, Any]) -> None:
    """A ramp at rate r makes v_s lag by 12 s times r, and each bound is inside the cells' boxes."""
    text = check_document(sealed(stored)).claims[0].text
    cells = stored["claims"][0]["cells"]
    for words, side in (("the schedule wind", "schedule"), ("the wind estimate", "estimate")):
        found = re.search(rf"{words} by (\S+) m/s", text)
        assert found and float(found[1]) < max(cell["sides"][side] for cell in cells)
    found = re.search(r"the schedule wind by (\S+) m/s", text)
    assert found and float(found[1]) > 12 * max(cell["wind_rate"] for cell in cells)
