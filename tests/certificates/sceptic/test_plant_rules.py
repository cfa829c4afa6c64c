"""Every rule of a plant counts, also where one matrix alone differs and a claim puts it aside.

The rules of these plants differ in one of B, C and E.  The gains differ too, and the second one is
bad: it has to be tested though the matrices that are left are the same in both rules.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import (
    law_members,
    observer_member,
    plant_data,
    slopes_data,
)
from takagi.models import Interval, Output, Plant, Variable, sector_model
from tests.certificates.kinds.claims import verdict_of

Data = dict[str, Any]
x, u, w = sp.symbols("x u w", real=True)
EMBEDDED: Data = {"name": "e", "kind": "sector-embedding"}
KEPT: Data = {"name": "k", "P": [[1]], "level": 0.5, "multiplier": 1, "disturbance": "inputs"}
KEPT |= {"disturbance_norm": 0.1}


def plant_of(rate: sp.Expr, output: sp.Expr, *, pushed: bool = False, **others: Any) -> Plant:
    return Plant(
        equations=(rate,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-"),),
        disturbances=(Variable(w, "-", Interval.of(-1, 1)),) if pushed else (),
        outputs=(Output("y", output, "-"),),
        name="line",
        **others,
    )


def last(plant: Plant, gains: list[float], *claims: Data, **law: Any) -> str:
    """Return the verdict on the last claim, under one gain for each rule."""
    model = sector_model(plant)
    data = plant_data(model)
    if plant.measured:
        data["slopes"] = slopes_data(secant_model(plant))
    own = pdc_law_data(model, np.reshape(gains, (2, 1, 1))) | law_members(data) | law
    return verdict_of(data, own, EMBEDDED, *claims)


@pytest.mark.parametrize(
    "claim",
    [
        KEPT | {"kind": "invariant-ellipsoid"},
        KEPT | {"kind": "peak", "gain": 1000},
        KEPT | {"kind": "input-limits", "input_limits": [1000]},
    ],
    ids=lambda claim: str(claim["kind"]),
)
def test_second_gain_is_tested_where_the_disturbance_alone_differs(claim: Data) -> None:
    """x' = -3 x + u + (1 + x^2) w; with u = 100 x in the second rule it leaves every set."""
    plant = plant_of(-3 * x + u + (1 + x**2) * w, x, pushed=True)

    assert last(plant, [0, 0], claim) == "PROVED"
    assert last(plant, [0, -100], claim) == "UNDECIDED"
    assert last(plant, [-100, 0], claim) == "UNDECIDED"


def test_second_gain_of_an_observer_is_tested_where_the_input_alone_differs() -> None:
    """x' = -x + (2 + x^2) u, y = x; the error grows as exp(39 t) with L = -40."""
    plant = plant_of(-x + (2 + x**2) * u, x)
    claim = {"name": "o", "kind": "observer", "decay_rate": 0, "P": [[1]]}

    assert last(plant, [1, 1], claim | {"L": [[[1]], [[2]]]}) == "PROVED"
    assert last(plant, [1, 1], claim | {"L": [[[1]], [[-40]]]}) == "UNDECIDED"


def test_second_gain_is_tested_where_the_output_alone_differs() -> None:
    """x' = -3 x + u, y = x + x^3, u = -K xhat with the weights at the estimate."""
    plant = plant_of(-3 * x + u, x + x**3, measured=("y",))
    observer = observer_member(np.array([[[1.0]]]), ["y"], at_estimate=True)
    slopes = {"name": "s", "kind": "slope-embedding"}
    claim = {"name": "l", "kind": "observed-loop", "level": 0.2, "decay_rate": 0}
    claim |= {"P": [[1, 0], [0, 20]]}

    assert last(plant, [0, 0], slopes, claim, observer=observer) == "PROVED"
    assert last(plant, [0, -100], slopes, claim, observer=observer) == "UNDECIDED"
