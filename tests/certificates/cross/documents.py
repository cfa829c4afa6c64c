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
from takagi.certificates.requests import ExitProbability, FuzzyDecay, FuzzyL2Gain, SampledLoop
from takagi.certificates.requests.attempts import attempts_at_all
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import observer, pdc
from takagi.models import TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.test_damage import damage, documents, paths, resealed
from tests.certificates.weights.cells import cubic

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


def sampled_certificate() -> Data:
    """Return all that is claimed of a sampled loop with disturbance, box and output."""
    model = TSModel(
        [[[1.0, 0.1], [0.1, 1.0]], [[1.0, 0.1], [0.3, 0.95]]],
        [[0.0], [0.1]],
        C=[[1.0, 0.0]],
        E=[[0.0], [0.02]],
        states=["p [m]", "v [m/s]"],
        box={"p [m]": (-1, 1), "v [m/s]": (-3, 3)},
        sample_time=0.1,
    )
    gains = np.round(pdc(model, decay_rate=0.3).require()[0], 3)
    return dict(certify(model, gains, claims="all").document)


def observed_certificate() -> Data:
    """Return an observer's claims beside those of its loop."""
    model = sector_model(load_plant("duffing"))
    gains = np.round(pdc(model, decay_rate=0.5).require()[0], 3)
    L = np.round(observer(model, decay_rate=1.0).require()[0], 3)
    loop = ClaimedLoop.of(model, gains)
    found, _ = attempts_at_all(loop, observer=L)
    whole = dict(certify(model, gains).document)
    whole["claims"] = [whole["claims"][0], *(attempt.claim for attempt in found)]
    return resealed(whole)


def observed_loop_certificate() -> Data:
    """Return what is claimed of a pendulum and its observer, where the angle alone is measured."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "pendulum.toml"
        file.write_text(MEASURED, encoding="utf-8")
        found = design_plant(load_plant(file))
    assert isinstance(found, PlantDesign)
    return dict(found.document)


def impossible_certificate() -> Data:
    """Return a disproof: two stable vertices without a common function."""
    A = [[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -10.0], [0.1, -1.0]]]
    return dict(certify(TSModel(A)).document)


def all_kinds() -> Iterator[tuple[str, Data]]:
    """Yield (name, certificate) of every kind of claim that loops have."""
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
    yield "sampled", sampled_certificate()
    yield (
        "held command",
        dict(certify(cubic(), [[[1.0]], [[1.5]]], claims=[SampledLoop(0.1)]).document),
    )
    noisy = certify(cubic(), [[[1.0]], [[1.5]]], claims=[ExitProbability([0.3], 10.0)])
    yield "white noise", dict(noisy.document)
    yield "observed", observed_certificate()
    yield "observed loop", observed_loop_certificate()
    yield "impossible", impossible_certificate()


def mutants(whole: list[Data], count: int, seed: int) -> Iterator[tuple[str, Data]]:
    """Yield (what was changed, certificate) with hashes that fit what it now says."""
    rng = random.Random(seed)
    for _ in range(count):
        document = deepcopy(rng.choice(whole))
        path = rng.choice([p for p in paths(document) if "provenance" not in p])
        damage(document, path, rng)
        yield f"{document.get('claims', [{}])!s:.60} {path}", resealed(document)
