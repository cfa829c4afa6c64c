"""Damaged claims about loops: refused, left open, or true by another way to see it."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.requests import Decay, FuzzyDecay, GainRounding, Poles
from takagi.certificates.requests.request import Request
from takagi.lmi import EigenvalueRegion
from takagi.models import Premise, TSModel

Data = dict[str, Any]
STRANGE: list[Any] = [None, True, "", "1", [], {}, [[]], [1], {"a": 1}, -1, 0, 1e-30, 1e30]
FREE = {"name", "unit", "input_names", "output_names", "disturbance_names", "trim", "provenance"}


def documents(sample_time: float | None) -> list[Data]:
    """Return a certificate of each kind about one loop of two rules with their own gains."""
    A = np.array([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [2.0, 0.0]]])
    B = np.array([[[0.0], [1.0]], [[0.0], [1.1]]])
    K = np.array([[[3.0, 2.0]], [[4.0, 2.0]]])
    region = EigenvalueRegion.half_plane(0.1)
    if sample_time is not None:
        A, B, region = np.eye(2) + sample_time * A, sample_time * B, EigenvalueRegion.disc(0.999)
    model = TSModel(A, B, premises=[Premise("z", "-1", "1")], sample_time=sample_time)
    requests: list[Request] = [
        Decay(0.2),
        Poles(region),
        GainRounding(),
        FuzzyDecay(rate_bounds=0.1, decay_rate=0.1),
    ]
    return [dict(certify(model, K, claims=[request]).document) for request in requests]


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every part."""
    if path:
        yield path
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from paths(value[key], (*path, key))


def damage(document: Data, path: tuple[Any, ...], rng: random.Random) -> None:
    """Replace, remove or double the part at the path; numbers change by a factor."""
    place: Any = document
    for key in path[:-1]:
        place = place[key]
    before = place[path[-1]]
    way = rng.random()
    if way < 0.1:
        del place[path[-1]]
    elif way < 0.15 and isinstance(place, list):
        place.append(deepcopy(before))
    elif isinstance(before, (int, float)) and not isinstance(before, bool) and way < 0.7:
        place[path[-1]] = before * rng.choice([-1, 0, 0.5, 0.99, 1.01, 2, 1e6]) + rng.choice(
            [0, 0.1]
        )
    else:
        place[path[-1]] = deepcopy(rng.choice(STRANGE))


def resealed(document: Data) -> Data:
    """Return the document with the hashes of what it now says."""
    read = read_text(json.dumps(document), "document")
    hashes = {part: digest(read.get(part)) for part in ("model", "gains", "claims")}
    return document | {"provenance": {"sha256": hashes}}


def holds(document: Data) -> bool:
    """Return whether the claim is true as floats see it: sampled, so only a no means something."""
    model, law, claim = document["model"], document["gains"], document["claims"][0]
    rng = np.random.default_rng(0)
    A, B = np.array(model["A"], dtype=float), np.array(model["B"], dtype=float)
    K = np.array(law["K"], dtype=float)
    step, kind = model["sample_time"], claim["kind"]
    rate = float(claim.get("decay_rate", 0.0))
    rules, gains = max(len(A), len(B)), len(K)
    same = all(law.get(key) == model.get(key) for key in ("premises", "rules"))
    shared = same and gains in (1, rules)
    for _ in range(60):
        h = rng.dirichlet(np.full(rules, 0.4))
        g = h if gains == rules else np.ones(1)
        if not shared:
            g = rng.dirichlet(np.full(gains, 0.4))
        blend = [np.tensordot(h, np.broadcast_to(X, (rules, *X.shape[1:])), axes=1)
                 for X in (A, B)]  # fmt: skip
        gain = np.tensordot(g, K, axes=1)
        if kind == "gain-rounding":
            room = np.array(claim["absolute"]) + claim["relative"] * np.abs(K)
            gain = np.tensordot(g, K + rng.uniform(-1, 1, K.shape) * room, axes=1)
        G = blend[0] - blend[1] @ gain
        if not _inside(np.linalg.eigvals(G), step, rate, claim):
            return False
    return True


def _inside(poles: np.ndarray[Any, Any], step: Any, rate: float, claim: Data) -> bool:
    """Return whether eigenvalues of one blend agree with the claim, but for rounding."""
    if claim["kind"] == "region":
        worst = [
            np.linalg.eigvalsh(
                np.array(p["L"]) + z * np.array(p["M"]) + np.conj(z) * np.array(p["M"]).T
            )
            for z in poles
            for p in claim["parts"]
        ]
        return bool(np.max(worst) < 1e-9)
    if step is None:
        return bool(poles.real.max() < -rate + 1e-9)
    return bool(np.abs(poles).max() < np.exp(-rate * step) + 1e-9)


@pytest.fixture(scope="module")
def whole() -> list[Data]:
    return [*documents(None), *documents(0.1)]


def campaign(documents: list[Data], count: int, seed: int) -> tuple[int, list[str]]:
    """Return how many damaged certificates are still PROVED, and where that is false."""
    rng = random.Random(seed)
    proved, wrong = 0, []
    for _ in range(count):
        document = deepcopy(rng.choice(documents))
        path = rng.choice([p for p in paths(document) if not set(p) & FREE])
        damage(document, path, rng)
        try:
            verdict = check_document(resealed(document)).verdict
        except CertificateError:
            continue
        if verdict is Verdict.PROVED:
            proved += 1
            if not holds(document):
                wrong.append(f"{document['claims'][0]['kind']}: {path}")
    return proved, wrong


def test_all_kinds_are_proved_undamaged(whole: list[Data]) -> None:
    """The campaign begins with what is true."""
    for document in whole:
        assert check_document(document).verdict is Verdict.PROVED, document["claims"][0]["kind"]
        assert holds(document)


def test_damage_leaves_nothing_false_proved(whole: list[Data]) -> None:
    """Of 400 damaged certificates some stay true and are proved, and none that is false."""
    proved, wrong = campaign(whole, 400, seed=1)

    assert proved > 10
    assert wrong == []


@pytest.mark.slow
def test_much_damage_leaves_nothing_false_proved(whole: list[Data], reduced: bool) -> None:
    """The same campaign with another seed, ten thousand times (reduced: 500)."""
    assert campaign(whole, 500 if reduced else 10_000, seed=2)[1] == []


def test_the_judge_of_the_campaign_sees_what_is_false(whole: list[Data]) -> None:
    """A campaign whose judge says yes to everything would find nothing."""
    changes: list[Callable[[Data], None]] = [
        lambda d: d["claims"][0].update(decay_rate=50.0),
        lambda d: d["gains"].update(K=[[[-9.0, -9.0]]]),
        lambda d: d["model"]["A"][1].__setitem__(1, [90.0, 90.0]),
    ]
    for document in whole:
        for change in changes[1 if document["claims"][0]["kind"] == "region" else 0 :]:
            false = deepcopy(document)
            change(false)
            assert not holds(false)
