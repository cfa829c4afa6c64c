"""The certificates that are changed: library plants, general models of every kind, the turbine."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from takagi.certificates import DesignSettings, certify, design_turbine
from takagi.certificates.claims.problem_verification import verify
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.requests import (
    Decay,
    FuzzyDecay,
    GainRounding,
    ObserverError,
    Poles,
)
from takagi.certificates.requests.request import Request
from takagi.lmi import EigenvalueRegion
from takagi.lmi.problem_files.problem import (
    NONNEGATIVE,
    SEMIDEFINITE,
    ZERO,
    Block,
    ConicProblem,
)
from takagi.models import Plant, Premise, TSModel, load_model, nrel5mw

Data = dict[str, Any]
PLANTS: tuple[str, ...] = (
    *("cart_pole", "duffing", "truck_trailer", "lorenz"),
    *("mass_spring_damper", "quarter_car", "flexible_joint", "dayawansa_martin"),
)


def plants() -> Iterator[tuple[str, Data]]:
    """Yield the certificates of designs for library plants: embedding, claims, consequences."""
    for name in PLANTS:
        plant = load_model(name)
        assert isinstance(plant, Plant)
        design = design_plant(plant)
        assert isinstance(design, PlantDesign)
        yield name, _plain(design.certificate.document)


def general_models() -> Iterator[tuple[str, Data]]:
    """Yield certificates about two rules, in both times, with and without premises; and a no."""
    A = np.array([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [2.0, 0.0]]])
    B = np.array([[[0.0], [1.0]], [[0.0], [1.1]]])
    C = np.array([[[1.0, 0.0]], [[1.0, 0.2]]])
    K = np.array([[[3.0, 2.0]], [[4.0, 2.0]]])
    L = np.array([[[4.0], [6.0]], [[3.0], [6.0]]])
    premises = [Premise("z", "-1", "1")]
    for step in (None, 0.1):
        region: EigenvalueRegion = EigenvalueRegion.half_plane(0.1)
        vertices, entrance, gain = A, B, L
        if step is not None:
            vertices, entrance, gain = np.eye(2) + step * A, step * B, step * L
            region = EigenvalueRegion.disc(0.999)
        requests: list[Request] = [Decay(0.2), Poles(region), GainRounding()]
        requests += [FuzzyDecay(rate_bounds=0.1, decay_rate=0.1), ObserverError(gain)]
        for name, known in (("products", premises), ("any weights", None)):
            model = TSModel(vertices, entrance, C=C, premises=known or (), sample_time=step)
            time = "continuous" if step is None else "discrete"
            document = certify(model, K, claims=requests).document
            yield f"two rules, {time}, {name}", _plain(document)


def exclusions() -> Iterator[tuple[str, Data]]:
    """Yield a certificate that says no: a pair of order 2 without a common function."""
    pair = TSModel([[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -6.0], [0.1667, -1.0]]])
    yield "no function for a pair", _plain(certify(pair, decay_rate=0).document)


def problems() -> Iterator[tuple[str, Data]]:
    """Yield certificates about conic problems: an enclosed optimum, none, and no bound."""
    box = Block(NONNEGATIVE, 2, entries={(1, 0): 1.0, (0, 1): 4.0, (1, 1): -1.0})
    line = Block(ZERO, 1, entries={(1, 0): 1.0, (2, 0): 1.0, (3, 0): -1.0, (0, 0): -1.0})
    product = Block(SEMIDEFINITE, 2, entries={(1, 0): 1.0, (0, 1): 1.0, (2, 2): 1.0})
    far = Block(NONNEGATIVE, 1, entries={(1, 0): -1.0, (2, 0): -1.0, (0, 0): 1.0})
    for name, c, blocks in (
        ("optimum", (1, 1, 0), (box, line, product)),
        ("no solution", (1, 1, 0), (product, far)),
        ("no bound", (0, -1, 0), (box, line, product)),
    ):
        problem = ConicProblem(name, np.array(c, dtype=float), 0.0, False, blocks)
        yield f"conic problem, {name}", _plain(verify(problem).document)


def turbine() -> Iterator[tuple[str, Data]]:
    """Yield the NREL 5-MW turbine's certificate."""
    asked = DesignSettings(synthesis="two-step")
    yield "nrel5mw", _plain(design_turbine(nrel5mw(), asked).document)


def _plain(document: Mapping[str, Any]) -> Data:
    found: Data = json.loads(json.dumps(document))
    return found
