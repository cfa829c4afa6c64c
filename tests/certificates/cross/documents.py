"""Certificates of every kind, and damaged ones."""

from __future__ import annotations

import random
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from takagi.certificates import certify
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.requests import (
    Decay,
    ExitProbability,
    FuzzyDecay,
    FuzzyL2Gain,
    GainRounding,
    ObservedFeedback,
    ObserverError,
    Poles,
    SampledLoop,
)
from takagi.certificates.requests.attempts import attempted, attempts_at_all
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.request import Request
from takagi.lmi import EigenvalueRegion, observer, pdc
from takagi.models import Premise, TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import resealed
from tests.certificates.weights.cells import EVIDENCE, cell_document, cubic, verdicts
from tests.plant_files import filed_plant

Data = dict[str, Any]
MEASURED = """
format = 1
kind = "plant"
units = "unchecked"
measured = ["x"]
[states]
x = { range = [-1, 1] }
v = { range = [-4, 4] }
[inputs]
u = { range = [-15, 15] }
[equations]
x = "v"
v = "20*sin(x) + 2*u"
"""
PLANTS = ("duffing", "flexible_joint", "lorenz", "ball_and_beam", "quarter_car")


def plant_certificate(name: str) -> Data:
    """Return all that is claimed of a library plant with gains of four digits."""
    model = sector_model(load_plant(name))
    gains = np.round(pdc(model, decay_rate=0.2).require()[0], 4) if model.B is not None else None
    return dict(certify(model, gains, claims="all").document)


def sampled_loop() -> tuple[TSModel, Any]:
    """Return a sampled model with disturbance, box and output, and gains of three digits."""
    model = TSModel(
        [[[1.0, 0.1], [0.1, 1.0]], [[1.0, 0.1], [0.3, 0.95]]],
        [[0.0], [0.1]],
        C=[[1.0, 0.0]],
        E=[[0.0], [0.02]],
        states=["p [m]", "v [m/s]"],
        box={"p [m]": (-1, 1), "v [m/s]": (-3, 3)},
        sample_time=0.1,
    )
    return model, np.round(pdc(model, decay_rate=0.3).require()[0], 3)


def observed_certificate() -> Data:
    """Return an observer's claims beside those of its loop."""
    model = sector_model(load_plant("duffing"))
    gains = np.round(pdc(model, decay_rate=0.5).require()[0], 3)
    L = np.round(observer(model, decay_rate=1.0).require()[0], 3)
    loop = ClaimedLoop.of(model, gains)
    found, _ = attempts_at_all(loop)
    found += [attempted(request, loop) for request in (ObserverError(L), ObservedFeedback(L))]
    whole = dict(certify(model, gains).document)
    whole["claims"] = [whole["claims"][0], *(attempt.claim for attempt in found)]
    return resealed(whole)


def observed_loop_certificate() -> Data:
    """Return what is claimed of a pendulum and its observer, where the angle alone is measured."""
    with TemporaryDirectory() as folder:
        found = design_plant(filed_plant(Path(folder), MEASURED))
    assert isinstance(found, PlantDesign)
    return dict(found.document)


def impossible_certificate() -> Data:
    """Return a disproof: two stable vertices without a common function."""
    A = [[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -10.0], [0.1, -1.0]]]
    return dict(certify(TSModel(A)).document)


def all_kinds() -> Iterator[tuple[str, Data]]:
    """Yield (name, certificate) of every kind of claim that loops have, small ones and designed."""
    for kind in EVIDENCE:
        for form in ("shared", "products"):
            document = cell_document(kind, form)
            if verdicts(document)[-1] in ("PROVED", "DISPROVED"):
                yield f"{kind}, {form}", document
    for step in (None, 0.1):
        for document in documents(step):
            yield f"{document['claims'][0]['kind']}, step {step}", document
    A = np.array([[[0.0, 1.0], [-2.0, -1.0]], [[0.0, 1.0], [-3.0, -1.0]]])
    fuzzy = certify(TSModel(A), claims=[FuzzyDecay(rate_bounds=0.2, decay_rate=0.1)])
    yield "fuzzy, rules", dict(fuzzy.document)
    pushed = TSModel(A, E=[[0.0], [1.0]], C=[[1.0, 0.0]])
    yield (
        "fuzzy gain",
        dict(certify(pushed, claims=[FuzzyL2Gain(rate_bounds=0.2)]).document),
    )
    yield "sampled", dict(certify(*sampled_loop(), claims="all").document)
    yield (
        "held command",
        dict(certify(cubic(), [[[1.0]], [[1.5]]], claims=[SampledLoop(0.1)]).document),
    )
    noisy = certify(cubic(), [[[1.0]], [[1.5]]], claims=[ExitProbability([0.3], 10.0)])
    yield "white noise", dict(noisy.document)
    yield "observed", observed_certificate()
    yield "observed loop", observed_loop_certificate()
    yield "impossible", impossible_certificate()


STRANGE: list[Any] = [None, True, "", "1", [], {}, [[]], [1], {"a": 1}, -1, 0, 1e-30, 1e30]


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


def mutants(whole: list[Data], count: int, seed: int) -> Iterator[tuple[str, Data]]:
    """Yield (what was changed, certificate) with hashes that fit what it now says."""
    rng = random.Random(seed)
    for _ in range(count):
        document = deepcopy(rng.choice(whole))
        path = rng.choice([p for p in paths(document) if "provenance" not in p])
        damage(document, path, rng)
        yield f"{document.get('claims', [{}])!s:.60} {path}", resealed(document)
