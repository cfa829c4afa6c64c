"""Small certificates for every kind of claim and every kind of weights, and their verdicts."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import (
    embedding_claim,
    law_members,
    plant_data,
    slope_claim,
    slopes_data,
)
from takagi.models import (
    Interval,
    Output,
    Plant,
    TSModel,
    Variable,
    interpolate_curve,
    sector_model,
    table_function,
)
from tests.certificates.kinds.claims import Data, sealed

x, u, w = sp.symbols("x u w", real=True)
GAINS = [[[1.0]], [[1.5]]]
SET = {"P": [[1]], "level": 1, "multiplier": 0.5}
PUSHED = {"disturbance": "disturbances"}
MULTIPLIED = {"multiplier_degree": 0, "multiplier": [[1]]}
# One state, P = 1: with A from -4 to -1 and gains from 1 to 1.5 the loop lies in [-5.5, -2].
EVIDENCE: dict[str, Data] = {
    "decay": {"P": [[1]], "decay_rate": 1},
    "transient": {"P": [[1]], "decay_rate": 1, "scales": [1], "lower": 1, "overshoot": 1}
    | {"settled_share": 0.5, "settling_time": 1},
    "region": {"P": [[1]], "parts": [{"L": [[2]], "M": [[1]]}]},
    "gain-rounding": {"P": [[1]], "decay_rate": 1, "absolute": [[0.01]], "relative": 0}
    | {"tau": [0.01]},
    "no-common-decay": {"P": [[-1]], "decay_rate": 100, "blend": 0},
    "invariant-ellipsoid": SET,
    # -V' = 2 x^2 (2 + 1.5 x^2) of V = x^2 at these gains, and 1 - x^2 = 0.005 + (0.995 - V).
    "attraction-region": {"function": "x^2", "level": 0.995, "box": [[-1, 1]]}
    | {
        "decrease": [
            {"degree": 2, "squares": [[3, 0], [0, 4]]} | MULTIPLIED | {"multiplier_degree": 1}
        ]
    }
    | {"states": [{"degree": 0, "squares": [[0.005]]} | MULTIPLIED], "inputs": []},
    "input-limits": SET | {"input_limits": [1.5]},
    "input-limits, rates": SET
    | {"input_limits": [1.5], "rate_limits": [10], "membership_rates": [1, 1]}
    | {"rate_shares": {"motion": [9], "memberships": [0.5]}},
    "l2-gain": PUSHED | {"P": [[1]], "gain": 1},
    "l2-gain, output by rule": PUSHED | {"P": [[1]], "gain": 1, "output": {"C": [[[0.5]], [[1]]]}},
    "fuzzy-l2-gain": PUSHED
    | {"gain": 1.2, "degrees": [1], "polya": 0, "rates": [[0.1, 0.1]]}
    | {"P": [{"powers": [[1, 0]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[1.01]]}]},
    "h2-norm": PUSHED | {"P": [[1]], "norm": 1},
    "peak": PUSHED | SET | {"disturbance_norm": 0.5, "gain": 2},
    "exit-probability": PUSHED
    | {"noise": [0.5], "P": [[1]], "rate": 1, "exponent": 5, "start": 0, "horizon": 1}
    | {"probability": 0.1},
    "sampled-loop": {"P": [[2]], "level": 1, "sample_time": 0.1, "decay_rate": 0.1}
    | {"functions": [[[1.924, 0.18], [0.18, 0.172]], [[2.15, 0], [0, 0.0665]]]},
    "fuzzy-decay": {"decay_rate": 1, "degrees": [1], "polya": 0, "rates": [[0.1, 0.1]]}
    | {"P": [{"powers": [[1, 0]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[1.01]]}]},
    "observer": {"P": [[1]], "decay_rate": 1, "L": [[[1]]]},
    "observed-feedback": {"P": [[1, 0], [0, 1]], "decay_rate": 0.5, "L": [[[1]]]},
    "observed-loop": {"P": [[1, 0], [0, 1]], "decay_rate": 0.5, "level": 0.5},
    "observed-loop, by estimate": {"P": [[1, 0], [0, 1]], "decay_rate": 0.5, "level": 0.5},
}


def claim_of(kind: str, **members: Any) -> Data:
    claim = {"name": "cell", "kind": kind.partition(",")[0], **EVIDENCE.get(kind, {})}
    return claim | members


# Asked of the plant by itself: with gains it would be refused for another reason.
LAWLESS = {("fuzzy-decay", "secants"), ("fuzzy-l2-gain", "secants"), ("observer", "secants")}


@cache
def cubic(form: str = "sector") -> TSModel:
    """Return x' = -x - x^3 + u + w, y = x on |x| <= 1; the force is a table in form "tables"."""
    if form == "tables":
        ends = [-1, -0.5, 0, 0.5, 1]
        curve = interpolate_curve(ends, [1 + v**2 for v in ends])
        force = table_function("stiffness", curve)(x) * x
    else:
        force = x + x**3
    plant = Plant(
        equations=(-force + u + w,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-"),),
        disturbances=(Variable(w, "-"),),
        outputs=(Output("y", x, "-"),),
        name="cubic",
    )
    return secant_model(plant) if form == "secants" else sector_model(plant)


def _vertices(form: str) -> tuple[Data, Data]:
    names = {"state_names": ["x [-]"], "input_names": ["u [-]"]}
    weights = {"premises": [{"name": "z", "lower": 0, "upper": 1}], "rules": [[0], [1]]}
    model = {"kind": "takagi-sugeno", "name": "two", "sample_time": None, **names, **weights}
    model |= {"disturbance_names": ["w [-]"], "A": [[[-1]], [[-2]]], "B": [[[1]]]}
    model |= {"output_names": ["y"], "C": [[[1]]], "E": [[[1]]], "box": {"x [-]": [-1, 1]}}
    law = {"name": "pdc", "sample_time": None, **names, **weights, "K": GAINS}
    if form == "own":
        law["premises"] = [{"name": "other", "lower": 0, "upper": 1}]
    return model, law


def column(form: str) -> tuple[Data, Data, list[Data]]:
    if form in ("shared", "own"):
        return (*_vertices(form), [])
    model = cubic(form)
    data = plant_data(model)
    law = pdc_law_data(model, np.array(GAINS)) | law_members(data)
    return data, law, [embedding_claim(model)]


def observed(kind: str, form: str, parts: tuple[Data, Data, list[Data]]) -> Any:
    model, law, before = parts
    at_estimate = kind.endswith("by estimate")
    if not (kind.startswith("observed-loop") or kind == "slope-embedding"):
        return parts
    # The slope of a table has no name in a certificate.
    if form not in ("shared", "own", "tables") and (at_estimate or kind == "slope-embedding"):
        plant = cubic().derivation
        assert plant is not None and plant.form is not None and plant.form.plant is not None
        model = model | {"slopes": slopes_data(secant_model(plant.form.plant))}
    if kind == "slope-embedding":
        return model, law, before
    if at_estimate:
        before = [*before, slope_claim("cubic")]
    weights = {"weights": "estimated" if at_estimate else "measured"}
    return model, law | {"observer": weights | {"measured": ["y"], "L": [[[1]]]}}, before


def cell_document(kind: str, form: str) -> Data:
    """Return a certificate with one claim of a kind, or of a variant, for a kind of weights."""
    model, law, before = observed(kind, form, column(form))
    gains = None if (kind, form) in LAWLESS else law
    claims = [*before, claim_of(kind)]
    return sealed(model, gains, *claims)


def plant_document(
    model: TSModel, claim: Data, gains: Any = None, *, law: Data | None = None
) -> Data:
    data = plant_data(model)
    if gains is not None:
        law = pdc_law_data(model, np.array(gains, dtype=float)) | law_members(data)
    named = {"name": claim["kind"], **claim}
    claims = [embedding_claim(model), named]
    return sealed(data, law, *claims)


@cache
def sampled() -> TSModel:
    """Return x' = -x + 3 p(x) x + u, p with a narrow peak at 0.37."""
    z = sp.Symbol("z", real=True)
    peak = sp.exp(-1000 * (x - sp.Rational(37, 100)) ** 2)
    plant = Plant(
        equations=(-x + 3 * peak * x + u,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-"),),
        outputs=(Output("y", x, "-"),),
        premises={z: peak},
        name="peaked",
    )
    return sector_model(plant)


def verdicts(document: Data) -> list[str]:
    try:
        return [claim.verdict.name for claim in check_document(document).claims]
    except CertificateError as error:
        return ["REFUSED", str(error)]
