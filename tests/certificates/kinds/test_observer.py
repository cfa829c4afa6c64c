"""Observers and loops with observers: exact limits, and designs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from takagi.certificates.document.model_data import as_read
from takagi.certificates.requests import ObservedFeedback, ObserverError
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import observer, pdc
from takagi.models import TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import Data, model_data, verdict_of


def line() -> tuple[Data, Data]:
    """Return x' = x, y = x, L = 3: the error decays at 2 exactly; and a claim just below."""
    claim = {"name": "line", "kind": "observer", "L": [[[3]]], "P": [[1]]}
    return model_data([[[1]]], C=[[[1]]]), claim | {"decay_rate": 1.999999999}


def crossed() -> TSModel:
    return TSModel(
        [[[0.0, 1.0], [-1.0, 0.2]], [[0.0, 1.0], [-3.0, 0.1]]],
        [[[0.0], [1.0]], [[0.0], [1.4]]],
        C=[[[1.0, 0.0]], [[1.3, 0.1]]],
    )


def test_rate_from_both_sides_of_its_exact_value() -> None:
    model, claim = line()

    assert verdict_of(model, None, claim) == "PROVED"
    for mutant in ({"decay_rate": 2}, {"L": [[[2.999]]]}, {"L": [[[-3]]]}, {"P": [[-1]]}):
        assert verdict_of(model, None, claim | mutant) == "UNDECIDED"


def test_sampled_error() -> None:
    """e+ = (1 - 1/2) e over T = 1 s: ln 2 = 0.693147180559945... (OEIS A002162)."""
    _, claim = line()
    model = model_data([[[1]]], C=[[[1]]], sample_time=1)
    claim |= {"L": [[[0.5]]]}

    assert verdict_of(model, None, claim | {"decay_rate": 0.69314718}) == "PROVED"
    assert verdict_of(model, None, claim | {"decay_rate": 0.69314719}) == "UNDECIDED"


def test_designed_observer_and_loop_are_proved() -> None:
    """Gains of ``pdc`` and ``observer``, rounded, and the poles of blends as a second way."""
    model = crossed()
    K = np.round(pdc(model, decay_rate=0.5).require()[0], 3)
    L = np.round(observer(model, decay_rate=1.0).require()[0], 3)
    loop = ClaimedLoop.of(model, K)

    error, both = ObserverError(L).attempt(loop), ObservedFeedback(L).attempt(loop)

    assert error.proved
    assert both.proved
    draw = np.random.default_rng(5)
    for h in draw.dirichlet([0.4, 0.4], size=100):
        blend = [np.tensordot(h, part, axes=1) for part in (model.A, model.C, L)]
        poles = np.linalg.eigvals(blend[0] - blend[2] @ blend[1])
        assert poles.real.max() <= -error.claim["decay_rate"]
    assert both.claim["decay_rate"] <= error.claim["decay_rate"] * 1.001


def test_secants_from_the_solver_layer() -> None:
    model = TSModel([[[0.0, 1.0], [0.0, 0.0]]], C=[[1.0, 0.0]])
    S = np.array([[[0.0, 0.0], [a, b]] for a in (-2.0, 1.0) for b in (-1.0, 0.0)])
    errors = TSModel(model.A + S, C=model.C[0])
    L = np.round(observer(errors, decay_rate=0.5, relaxation="common-gain").require()[0][:1], 2)

    attempt = ObserverError(L, decay_rate=0.4, secants=S).attempt(ClaimedLoop.of(model))

    assert attempt.proved


def test_gains_that_do_not_observe_are_not_claimed() -> None:
    attempt = ObserverError(np.zeros((2, 1))).attempt(ClaimedLoop.of(crossed()))

    assert attempt.checked.verdict is Verdict.UNDECIDED


@pytest.mark.parametrize(("name", "proved"), [("duffing", True), ("mass_spring_damper", False)])
def test_premises_of_a_plant_must_be_measured(name: str, proved: bool) -> None:
    """Duffing's premise is x, which is the output; the damper's is its speed, which is none."""
    model = sector_model(load_plant(name))
    L = np.round(observer(model, decay_rate=0.5).require()[0], 2)

    certificate = certify(model, claims=[ObserverError(L)])

    found = certificate.checked.claims[-1]
    assert (found.verdict is Verdict.PROVED) == proved
    assert proved or "not measured" in found.text


def two_states(C: Any) -> Data:
    """Return x' = -x with two states, an input and a disturbance, measured by C."""
    names = {"input_names": ["u [N]"], "disturbance_names": ["w [N]"]}
    model = model_data([[[-1, 0], [0, -1]]] * 2, B=[[[1], [0]]], C=C, E=[[[1], [0]]])
    return {**model, **names}


@pytest.mark.parametrize(
    ("C", "depends_on", "verdict"),
    [
        ([[[2, 0]]], "x1 [-]", Verdict.PROVED),
        ([[[0, 1], [1, 0]]], "x1 [-]", Verdict.PROVED),
        ([[[1, 0]]], "u [N]", Verdict.PROVED),
        ([[[1, 0]]], "x2 [-]", Verdict.UNDECIDED),
        ([[[1, 1]]], "x1 [-]", Verdict.UNDECIDED),
        ([[[0, 0]]], "x1 [-]", Verdict.UNDECIDED),
        ([[[1, 0]], [[2, 0]]], "x1 [-]", Verdict.UNDECIDED),
        ([[[1, 0]]], "w [N]", Verdict.UNDECIDED),
    ],
)
def test_what_premises_depend_on_is_looked_for_among_outputs(
    C: Any, depends_on: str, verdict: Verdict
) -> None:
    """One output that shows it by itself, the same at every rule; inputs are known."""
    p = len(C[0])
    claim = {"name": "m", "kind": "observer", "L": [[[0] * p] * 2], "decay_rate": 0.5}
    family = replace(read_model_loop(as_read(two_states(C)), None), scheduled_by=(depends_on,))

    found = replay(as_read(claim | {"P": [[1, 0], [0, 1]]}), None, family, [], "claim").in_words()

    assert found.verdict is verdict
    assert verdict is Verdict.PROVED or "not measured" in found.text


def test_secants_are_no_part_of_a_whole_plant() -> None:
    family = replace(read_model_loop(as_read(two_states([[[1, 0]]])), None), scheduled_by=())
    claim = {"name": "m", "kind": "observer", "L": [[[0], [0]]], "decay_rate": 0}
    secants = {"P": [[1, 0], [0, 1]], "secants": [[[0, 0], [0, 0]]]}

    with pytest.raises(CertificateError, match="whole plant"):
        replay(as_read(claim | secants), None, family, [], "claim")
