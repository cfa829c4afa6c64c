"""Certificates about loops through an observer, with limits that are known by hand."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from takagi.certificates.checker import check_document
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import (
    law_members,
    observer_member,
    plant_data,
    slope_claim,
    slopes_data,
)
from takagi.models import Interval, Output, Plant, Variable, sector_model
from tests.certificates.kinds.claims import Data, law_data, model_data, sealed

x, v, u = sp.symbols("x v u", real=True)


SEEN = {"weights": "measured", "measured": ["y"]}


def outcome(model: Data, gains: Data, *claims: Data) -> tuple[str, str]:
    checked = check_document(sealed(model, gains, *claims)).claims[-1]
    return checked.verdict.name, checked.text


def line(**changed: Any) -> tuple[Data, Data, Data]:
    """Return x' = x + u, y = x, |x| <= 1, u = -3 xhat, L = 4, and P = diag(1, s).

    z = (x, e): z' = [[-2, 3], [0, -3]] z.  4 * 6 s > 9: s > 3/8; x in its range for c <= 1.
    """
    model = model_data(
        [[[1]]], B=[[[1]]], C=[[[1]]], output_names=["y"], input_names=["u [-]"],
        box={"x1 [-]": [-1, 1]},
    )  # fmt: skip
    gains = law_data([[[3]]], input_names=["u [-]"], observer=SEEN | {"L": [[[4]]]})
    claim = {"name": "line", "kind": "observed-loop", "level": 1, "decay_rate": 0}
    return model, gains, claim | {"P": [[1, 0], [0, 0.375000001]]} | changed


@cache
def cubic() -> tuple[Data, Data]:
    """Return x' = x - x^3 + u, y = x on |x| <= 1, |u| <= 2, and u = -3 xhat, L = 4 by estimate."""
    plant = Plant(
        equations=(x - x**3 + u,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-", Interval.of(-2, 2)),),
        outputs=(Output("y", x, "-"),),
        measured=("y",),
        name="cubic",
    )
    return _by_estimate(plant, [[3.0]], [[4.0]])


@cache
def hidden() -> tuple[Data, Data]:
    """Return x' = v, v' = u - v^3, y = x on |x|, |v| <= 1: its premise is not measured."""
    plant = Plant(
        equations=(v, u - v**3),
        states=(Variable(x, "-", Interval.of(-1, 1)), Variable(v, "-", Interval.of(-1, 1))),
        inputs=(Variable(u, "-"),),
        outputs=(Output("y", x, "-"),),
        measured=("y",),
        name="hidden",
    )
    return _by_estimate(plant, [[1.0, 1.0]], [[3.0], [3.0]])


def _by_estimate(plant: Plant, K: list[list[float]], L: list[list[float]]) -> tuple[Data, Data]:
    model = sector_model(plant)
    data = plant_data(model) | {"slopes": slopes_data(secant_model(plant))}
    own = {"observer": observer_member(np.array([L]), ["y"], at_estimate=True)}
    gains = pdc_law_data(model, np.broadcast_to(np.array(K), (len(model.A), 1, len(L))))
    return data, gains | law_members(data) | own


def of_cubic(data: Data | None = None, **changed: Any) -> tuple[Data, Data, Data, Data, Data]:
    """Return the cubic plant's certificate in parts.

    z = (xhat, e): xhat' = (1 - xhat^2 - 3) xhat + 4 e, e' = (S - 4) e with S in [-2, 1].  With
    P = diag(1, s): 4 * 6 s > 16, s > 2/3.  Of s = 0.7: c (1 + 1/s) <= 1 keeps x in its range,
    c <= 0.41176...; 9 c <= 4 keeps the input.
    """
    model, gains = cubic()
    claim = {"name": "cubic", "kind": "observed-loop", "level": 0.4117, "decay_rate": 0}
    claim |= {"P": [[1, 0], [0, 0.7]]}
    first = {"name": "cubic is its model", "kind": "sector-embedding"}
    return data or model, gains, first, slope_claim("cubic"), claim | changed
