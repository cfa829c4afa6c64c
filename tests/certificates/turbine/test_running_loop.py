"""The claim about the running loop: the checker, forged files, and the nonlinear loop itself.

The certificate is the first line of ``recorded/running-loop.jsonl``: four cells of the default law
of the NREL 5-MW turbine.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, check
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.controller import turbine_content
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import OtherGains, Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell, factors
from takagi.certificates.checker.turbine.running_loop.equations import (
    Signals,
    combined,
    decay_form,
    equations,
    rounded_form,
)
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Sides
from takagi.certificates.checker.turbine.running_loop.limits import command_rates
from takagi.certificates.checker.turbine.turbine_claim import gaps
from takagi.certificates.checker.words.ellipsoid_size import squared_reaches
from takagi.certificates.claims.turbine.running_loop_claim import (
    loop_subject,
    running_candidate,
    running_loop_claim,
)
from takagi.certificates.controller import content
from takagi.certificates.design.given.turbine_law import read_observer
from takagi.reports.sections.turbine.summary import summary_rows
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdict
from tests.undrawn import unmeasured

motion: Any = import_module("turbine_running")
F = Fraction
UNDECIDED = Verdict.UNDECIDED
CELLS = range(4)


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("running-loop"))[1]))


@pytest.fixture
def document(stored: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(stored)


# The checker.


def test_it_is_proved(document: dict[str, Any]) -> None:
    assert verdict(document) == "PROVED"


def test_the_sentence_names_every_gap(document: dict[str, Any]) -> None:
    """From 3 m/s, where the law's tables begin, to 25, where they end."""
    claim = check_document(sealed(document)).claims[0]
    left = "3 to 8.238 m/s, 8.7006 to 11.4759 m/s, 11.5009 to 12.0509 m/s, 12.1509 to 15.0425 m/s, "
    for text in (claim.name, claim.text):
        assert "NOT" in text and left + "15.5403 to 25 m/s" in text
    for phrase in ("constant wind", "rigid shaft, tower and blades", "c_P of the table"):
        assert phrase in claim.assumes


def test_gaps_lie_between_the_ranges_and_at_the_ends() -> None:
    whole = (F(3), F(25))
    assert gaps(whole, [whole]) == []
    assert gaps(whole, [(F(3), F(5)), (F(6), F(24))]) == [(F(5), F(6)), (F(24), F(25))]


def test_a_gain_file_with_another_observer_is_refused(
    document: dict[str, Any], tmp_path: Path
) -> None:
    """Also where the certificate has no ``controller`` to compare the file with."""
    controller = document.pop("controller")
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(json.dumps(sealed(document)), encoding="utf-8")
    gains.write_text(json.dumps({"law": document["gains"], **controller}), encoding="utf-8")
    assert check(certificate, gains=gains, allow_old_gain_files=True).verdict.name == "PROVED"
    assert read_observer(gains) == controller
    controller["observer"]["l1"] = 1.8
    gains.write_text(json.dumps({"law": document["gains"], **controller}), encoding="utf-8")
    with pytest.raises(OtherGains, match="observer.l1 is not the gain file's"):
        check(certificate, gains=gains, allow_old_gain_files=True)


OTHER_LOOPS: dict[str, Callable[[Any], None]] = {
    "limits.torque_rate": lambda file: file["limits"].update(torque_rate=1.0),
    "limits.pitch_rate": lambda file: file["limits"].update(pitch_rate=1e-4),
    "rotor.inertia": lambda file: file["rotor"].update(inertia=3 * file["rotor"]["inertia"]),
    "programs[3].send[0].formula": lambda file: file["programs"][3]["send"][0].update(
        formula="torque"
    ),
    "rotor": lambda file: file.update(rotor=[]),
}


@pytest.mark.parametrize(
    ("early", "place"),
    [
        (early, place)
        for early in (False, True)
        for place in OTHER_LOOPS
        if not (early and place.startswith("programs"))
    ],
)
def test_a_gain_file_of_another_loop_is_refused(
    document: dict[str, Any], tmp_path: Path, early: bool, place: str
) -> None:
    """Nothing of the file follows from a certificate without ``controller``, or with an early one.

    An early one is the content of the file itself, which had no programs then.
    """
    own = document.pop("controller")
    whole = content.plain(
        turbine_content.turbine_content(document["model"], document["gains"], own)
    )
    file = {**own, **{part: whole[part] for part in ("limits", "rotor", "programs")}}
    head: dict[str, Any] = {"law": document["gains"]}
    if early:
        del file["programs"]
        head |= {"format": "takagi-gains"}
        file["version"] = 2
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"

    def written() -> None:
        beside = {"controller": file} if early else {}
        certificate.write_text(json.dumps(sealed({**document, **beside})), encoding="utf-8")
        gains.write_text(json.dumps({**head, **file}), encoding="utf-8")

    written()
    assert check(certificate, gains=gains, allow_old_gain_files=True).verdict.name == "PROVED"
    OTHER_LOOPS[place](file)
    written()
    with pytest.raises(OtherGains, match=f"{re.escape(place)} is not the certificate's"):
        check(certificate, gains=gains, allow_old_gain_files=True)


def test_the_summary_names_rate_and_gaps(
    stored: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    unmeasured(monkeypatch)
    checked, turbine = check_document(sealed(stored)), SimpleNamespace(cut_in=3.0, cut_out=25.0)
    design: Any = SimpleNamespace(
        document=stored, checked=checked, turbine=turbine, effort_sharing_law=None, measured=None
    )
    (row,) = (row for row in summary_rows(design) if row.name == "observer")
    assert row.numbers[0].value == 0.004 and row.claim == checked.claims[0].name
    assert row.partial and row.shortfall.startswith("not 3 to 8.238, 8.7 to 11.476")
    design.checked = replace(checked, claims=[replace(checked.claims[0], verdict=UNDECIDED)])
    assert all(row.name != "observer" for row in summary_rows(design))


# The nonlinear loop.


def plant(seed: int) -> Any:
    rng = np.random.default_rng(seed)
    return motion.Plant(rng.uniform(0.9, 1.1), rng.uniform(40, 80), rng.uniform(0, 1))


def first_cell(stored: Any, k: int) -> tuple[Cell, dict[str, Any]]:
    data = read_text(json.dumps(stored), "document")
    claim, stated = data["claims"][0], data["claims"][0]["cells"][k]
    machine = Machine.read(claim, data["model"], data["gains"], "claim")
    winds = (F(str(stated["wind"][0])), F(str(stated["wind"][1])))
    sides = Sides.read(stated, "cell")
    cell = Cell(Plant.read(data["model"]), Law.read(data["gains"]), machine, winds, sides)
    return cell, dict(factors(cell))


@pytest.mark.parametrize("k", CELLS)
def test_the_embedding_holds_the_nonlinear_loop(stored: Any, k: int) -> None:
    """The secants of random states lie in the ranges and give back the loop's rates."""
    cell, spans = first_cell(stored, k)
    own = stored["claims"][0]["cells"][k]
    at = motion.Motion(stored, own, float(np.mean(own["wind"])) + 0.003, plant(k))
    for xi in 0.95 * motion.boundary(np.array(own["P"]), 25, seed=40 + k):
        if at.pitch + xi[1] / at.b0 < stored["gains"]["pitch_min"]:
            continue
        secants = at.secants(xi)
        for name, value in secants.items():
            least, most = cell.ramp_share if name == "share" else spans[name]
            slack = 1e-6 * max(1.0, abs(value))
            assert least - slack <= value <= most + slack, name
        fixed = {name: (F(value), F(value)) for name, value in secants.items()}
        signals, rates = equations(cell, fixed, fixed["share"])
        assert not signals.outer
        found = [sum(float(a) * xi[i] for i, a in rate.items()) for rate in rates]
        assert np.allclose(found, at.rate(xi), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("k", CELLS)
def test_commands_move_no_faster_than_the_bounds(stored: Any, k: int) -> None:
    """Torque's and pitch's, along the nonlinear loop, where no node is passed."""
    cell, _ = first_cell(stored, k)
    own = stored["claims"][0]["cells"][k]
    torque, pitch = (float(bound) for bound in command_rates(cell))
    assert torque <= stored["model"]["torque_rate_limit"]
    assert pitch <= stored["model"]["pitch_rate_limit"]
    at = motion.Motion(stored, own, float(np.mean(own["wind"])), plant(k))
    per, step = at.J / at.n, 1e-6
    for xi in motion.boundary(np.array(own["P"]), 40, seed=60 + k):
        after = xi + step * at.rate(xi)
        if at.interval(at.v + xi[3]) != at.interval(at.v + after[3]):
            continue
        moved = np.subtract(at.commands(after), at.commands(xi)) / step
        assert abs(moved[0]) * per <= torque * 1.001 + 1e-3
        assert abs(moved[1]) <= pitch * 1.001 + 1e-9


def test_the_judge_sees_a_false_claim(stored: Any) -> None:
    """It is silent about the claim, and loud about a rate and a function that are not so."""
    rng = np.random.default_rng(5)
    assert motion.why_running_false(stored, stored["claims"][0], rng) == ""
    fast = stored["claims"][0] | {"decay_rate": 0.3}
    assert "V moves at" in motion.why_running_false(stored, fast, rng)
    round_ = deepcopy(stored["claims"][0])
    for cell in round_["cells"]:
        cell["P"] = np.diag(np.diag(cell["P"])).tolist()
    assert "V moves at" in motion.why_running_false(stored, round_, rng)


def test_the_judge_compares_what_is_shown(stored: Any) -> None:
    claim, text = stored["claims"][0], check_document(sealed(stored)).claims[0].text
    assert motion.why_running_misshown(claim, text) == ""
    for old, new in (
        ("a rate of 0.004", "a rate of 0.005"),
        ("in 4 cells", "in 5 cells"),
        ("8.7006 to 11.4759 m/s, ", ""),
    ):
        assert old in text
        assert motion.why_running_misshown(claim, text.replace(old, new)) != "", old


# The candidate.


SOME = [F(1, 4), F(1, 20), F(1, 100)]


def fastest_growth(document: Any, wind: float) -> float:
    nodes = document["gains"]["wind"]
    k = int(np.searchsorted(nodes, wind))
    claim = document["claims"][0] | {"cells": [{"wind": [nodes[k - 1], nodes[k]]}]}
    at = motion.Motion(document | {"claims": [claim]}, claim["cells"][0], wind, motion.Plant())
    step = 1e-6
    columns = [(at.rate(step * e) - at.rate(-step * e)) / (2 * step) for e in np.eye(10)]
    return float(np.linalg.eigvals(np.array(columns).T).real.max())


def candidate_at(document: Any, wind: str) -> Any:
    subject = loop_subject(document["model"], document["gains"], document["claims"][0])
    return running_candidate(subject, (F(wind), F(wind) + F(1, 100)), sizes=SOME)[0]


@pytest.mark.numeric
@pytest.mark.parametrize("wind", ["12", "13"])
def test_a_loop_that_swings_has_no_function(document: dict[str, Any], wind: str) -> None:
    """Filter of 0.05 s and an observer twenty times as strong: the linear loop grows by itself.

    With the filter alone the law swings in OpenFAST, by tower and blades, which are assumed to be
    rigid here.  So a function for it is no error of the claim; docs/running-loop.md says so.
    """
    document["gains"]["wind_filter"] = 0.05
    assert fastest_growth(document, float(wind)) < -0.02
    assert candidate_at(document, wind) is not None
    document["claims"][0]["observer"]["l2"] *= 20
    assert fastest_growth(document, float(wind)) > 0.05
    assert candidate_at(document, wind) is None


@pytest.mark.numeric
@pytest.mark.parametrize("stopped", [True, False])
def test_the_claim_of_a_short_law_is_proved_twice(document: dict[str, Any], stopped: bool) -> None:
    """Two intervals of the tables, with a band-stop and without: ten states and eight."""
    law, controller = document["gains"], document["controller"]
    count = len(law["wind"])
    for name, column in law.items():
        if isinstance(column, list):
            law[name] = column[47 : 50 - (count - len(column))]
    if not stopped:
        controller["measurement"] = {"speed_filter": 8.0}
    claim = running_loop_claim(document["model"], law, controller, [0.9, 1.1])
    assert claim["winds"] == [[law["wind"][0], law["wind"][-1]]]
    assert len(claim["cells"][0]["P"]) == (10 if stopped else 8)
    short = document | {"claims": [claim]}
    assert verdict(short) == "PROVED"
    # The loop that is written anew finds nothing against it, and something against a faster one.
    assert motion.why_running_false(short, claim, np.random.default_rng(1)) == ""
    fast = claim | {"decay_rate": 20 * claim["decay_rate"]}
    assert "V moves at" in motion.why_running_false(short, fast, np.random.default_rng(1))


def test_no_claim_without_observer_filters_or_function(document: dict[str, Any]) -> None:
    model, law, controller = (document[part] for part in ("model", "gains", "controller"))
    with pytest.raises(Refused, match="no low-pass on the measured speed"):
        running_loop_claim(model, law, {"observer": controller["observer"]}, [0.9, 1.1])
    with pytest.raises(Refused, match="no filter of the wind estimate"):
        running_loop_claim(model, law | {"wind_filter": 0.0}, controller, [0.9, 1.1])


# The parts.


def is_definite(matrix: list[list[int]]) -> bool:
    return rounded_form(matrix).is_positive_definite


def test_uncertain_factor_of_one_state() -> None:
    """x' = a x with a in [-3, -1] falls at 1 and not at more."""
    signals = Signals(1)
    rate = signals.times("a", (F(-3), F(-1)), signals.state(0))
    assert is_definite(decay_form(signals, [rate], [[F(1)]], [F(1)], F("0.999999")))
    assert not is_definite(decay_form(signals, [rate], [[F(1)]], [F(1)], F(1)))
    assert not is_definite(decay_form(signals, [rate], [[F(1)]], [F(1)], F("1.000001")))
    assert combined((2, {0: F(1)}), (1, {0: F(1), 1: F(3)})) == {0: F(3), 1: F(3)}


def test_the_form_is_the_quadratic_form_of_its_text() -> None:
    """A multiple of -(2 x'P x' + 2 a x'P x + sum tau (z^2 - w^2)), at a random point."""
    signals = Signals(2)
    x, y = signals.state(0), signals.state(1)
    inner = signals.times("a", (F(1), F(2)), combined((1, x), (3, y)))
    rates = [combined((-2, x), (1, inner)), signals.times("b", (F(-3), F(-1)), inner)]
    P, tau, alpha = [[F(2), F(1, 3)], [F(1, 3), F(1)]], [F(2), F(5, 7)], F(1, 9)
    form = decay_form(signals, rates, P, tau, alpha)
    point = [F(1), F(-2), F(3), F(5, 2)]

    def value(signal: dict[int, Fraction]) -> Fraction:
        return sum((a * point[i] for i, a in signal.items()), F(0))

    moved = [value(rate) for rate in rates]
    V = sum(point[i] * P[i][j] * point[j] for i in range(2) for j in range(2))
    wanted = -2 * sum(point[i] * P[i][j] * moved[j] for i in range(2) for j in range(2))
    wanted -= 2 * alpha * V
    for k, weight in enumerate(tau):
        wanted -= weight * (value(signals.outer[k]) ** 2 - point[2 + k] ** 2)
    found = sum(point[i] * form[i][j] * point[j] for i in range(4) for j in range(4))
    scale = F(form[2][2]) / (tau[0] - tau[1] * signals.outer[1].get(2, F(0)) ** 2)
    assert scale > 0 and scale.denominator == 1 and found == scale * wanted


def test_rounding_never_makes_a_matrix_definite() -> None:
    """Both sides of the threshold: a matrix whose determinant is 0 but for its last digit."""
    big = 10**30
    assert is_definite([[4 * big, 2 * big], [2 * big, big + big // 10**12]])
    for last in (0, -1, 1):
        assert not is_definite([[4 * big, 2 * big], [2 * big, big + last]]), last
    assert is_definite([[3, 1], [1, 3]]) and not is_definite([[1, 3], [3, 1]])
    assert not is_definite([[0]])


def test_reaches_are_those_of_the_inverse() -> None:
    P = Matrix.of([[F(4), F(1), F(0)], [F(1), F(3), F(1, 2)], [F(0), F(1, 2), F(2)]])
    inverse = np.linalg.inv(np.array(P.rows, dtype=float) / P.below)
    found = squared_reaches(P, (0, 2))
    assert np.allclose([float(value) for value in found], [inverse[0, 0], inverse[2, 2]], 1e-12)
