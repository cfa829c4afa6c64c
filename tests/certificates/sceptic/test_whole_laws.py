"""A law that is more than gains: claims about u = -K x are about another law then."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from functools import cache
from typing import Any, Final

import numpy as np
import pytest
import sympy as sp

from takagi.certificates.checker import check_document
from takagi.certificates.design.plant.secant_model import secant_model
from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.document.model_data import pdc_law_data
from takagi.certificates.document.plant_embedding import (
    law_members,
    observer_member,
    plant_data,
    slopes_data,
)
from takagi.certificates.requests import SampledLoop
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import Interval, Output, Plant, TSModel, Variable, sector_model
from tests.certificates.kinds.claims import resealed, verdicts
from tests.certificates.kinds.tracking_documents import arm

Data = dict[str, Any]


def arm_with(change: Callable[[Data], None], *kinds: str) -> Data:
    """The arm that follows a reference, with these claims alone, changed and sealed again."""
    found = arm()
    found["claims"] = [
        claim for claim in found["claims"] if claim["kind"] in ("secant-embedding", *kinds)
    ]
    # Model and law hold one list, also after a copy.
    found["gains"]["references"] = deepcopy(found["gains"]["references"])
    change(found)
    return resealed(found)


def observer(document: Data) -> None:
    """The law would run as u = -K xhat, with an observer that corrects nothing."""
    own = {"weights": "measured", "measured": ["twice"], "L": [[[0], [0], [0]]]}
    document["gains"]["observer"] = own


def blend(document: Data) -> None:
    """The law would command two actuators."""
    document["gains"]["blending"] = {"effort": "q"}


def other_law(document: Data) -> None:
    """The law would integrate 5 q less the reference, the model has q."""
    document["gains"]["references"][0]["follow"] = "5*q"


def other_model(document: Data) -> None:
    """Both name 5 q, and the model has q."""
    for owner in ("model", "gains"):
        document[owner]["references"][0]["follow"] = "5*q"


def no_reference(document: Data) -> None:
    """The law integrates; the model has a state of that name, and says of no reference."""
    del document["model"]["references"]


def leaking(document: Data) -> None:
    """The integral of the model leaks, that of the law does not."""
    document["model"]["equations"][2] = "q - target - target_integral"
    document["model"]["embedding"]["A"][2][2] = "-1"


@pytest.mark.parametrize("kinds", [("tracking",), ("decay", "invariant-ellipsoid")])
@pytest.mark.parametrize("change", [observer, blend, other_law, other_model, no_reference, leaking])
def test_law_that_runs_otherwise_is_not_proved(
    change: Callable[[Data], None], kinds: tuple[str, ...]
) -> None:
    assert unchanged(kinds) == {"PROVED"}
    assert "PROVED" not in verdicts(arm_with(change, *kinds))


@cache
def unchanged(kinds: tuple[str, ...]) -> set[str]:
    return {*verdicts(arm_with(lambda _: None, *kinds))}


def follower() -> tuple[Data, Data]:
    """Return x' = u - x, xi' = x - r with both as outputs, and u = -2 x - 2 xi."""
    ranges: dict[str, list[float]] = {"x": [-2, 2], "u": [-10, 10], "r": [-1, 1]}

    def listed(*names: str) -> list[Data]:
        return [{"name": n, "unit": "-", "range": ranges.get(n), "rest": 0} for n in names]

    model: Data = {"kind": "plant", "name": "follower", "source": "", "sample_time": None}
    model |= {"states": listed("x", "xi"), "inputs": listed("u"), "disturbances": listed("r")}
    model |= {"parameters": {}, "equations": ["u - x", "x - r"]}
    model["outputs"] = [{"name": n, "unit": "-", "expression": n} for n in ("x", "xi")]
    model["references"] = [{"reference": "r", "integral": "xi", "follow": "x"}]
    model["embedding"] = {"premises": [], "A": [["-1", "0"], ["1", "0"]], "B": [["1"], ["0"]]}
    model["embedding"] |= {"C": [["1", "0"], ["0", "1"]], "D": [["0"], ["0"]]}
    model["embedding"]["E"] = [["0"], ["-1"]]
    gains: Data = {"name": "pdc", "sample_time": None, "state_names": ["x [-]", "xi [-]"]}
    gains |= {"input_names": ["u [-]"], "K": [[[2, 2]]], "trim": {"state": [0, 0], "input": [0]}}
    return model, gains


def follows(P: list[list[float]], change: Callable[[Data], None], kind: str) -> str:
    """Return the verdict on the follower's law, changed."""
    model, gains = follower()
    change(gains)
    claim: Data = {"name": "loop", "kind": kind, "decay_rate": 0.5, "P": P}
    if kind == "observed-loop":
        claim["level"] = 0.01
    claims: list[Data] = [{"name": "e", "kind": "sector-embedding"}, claim]
    document = certificate_document(model=model, gains=gains, claims=claims, provenance={})
    return verdicts(document)[-1]


OBSERVER = {"weights": "measured", "measured": ["x", "xi"], "L": [[[4, 0], [1, 5]]]}
# V = (x + xi)^2 + (x + 2 xi)^2 along the modes of -1 and -2; of the error beside it far more.
LOOP: Final[list[list[float]]] = [[2, 3], [3, 5]]
BOTH: Final[list[list[float]]] = [[2, 3, 0, 0], [3, 5, 0, 0], [0, 0, 900, 0], [0, 0, 0, 900]]
PROVED, REFUSED = "PROVED", "REFUSED"


def test_references_are_of_a_law_of_states() -> None:
    """The observer of a law with references would have to know them: nothing says that it does."""
    references = {"references": follower()[0]["references"]}

    assert follows(LOOP, lambda gains: gains.update(references), "decay") == PROVED
    assert follows(BOTH, lambda gains: gains.update(observer=OBSERVER), "observed-loop") == PROVED
    both = references | {"observer": OBSERVER}
    assert follows(BOTH, lambda gains: gains.update(both), "observed-loop") == REFUSED


@pytest.mark.parametrize("blending", [None, {}, [], {"effort": "x"}, "effort"])
def test_a_blend_needs_its_claim_whatever_is_written(blending: Any) -> None:
    """Two actuators take the place of u, and no claim says which."""
    assert follows(LOOP, lambda gains: None, "decay") == PROVED
    assert follows(LOOP, lambda gains: gains.update(blending=blending), "decay") == REFUSED
    both = {"blending": blending, "observer": OBSERVER}
    assert follows(BOTH, lambda gains: gains.update(both), "observed-loop") == REFUSED


def sampled_follower(change: Callable[[Data], object]) -> str:
    """Return the verdict on x' = u, xi' = x - r, u = -x - 1.5 xi held for a second at a time."""
    model, gains = follower()
    model["equations"][0] = "u"
    model["embedding"]["A"][0] = ["0", "0"]
    gains["K"] = [[[1, 1.5]]]
    change(gains)
    loop = TSModel([[[0.0, 0.0], [1.0, 0.0]]], [[[1.0], [0.0]]])
    held = SampledLoop(1.0).attempt(ClaimedLoop.of(loop, np.array([[1.0, 1.5]])))
    assert held.proved
    claim = dict(held.claim) | {"level": 1e-3}
    claims: list[Data] = [{"name": "e", "kind": "sector-embedding"}, claim]
    document = certificate_document(model=model, gains=gains, claims=claims, provenance={})
    return verdicts(document)[-1]


def test_the_integral_of_a_sampled_law_is_a_sum() -> None:
    """A second of xi' = x adds x(t_k) + u/2, and the product of the eigenvalues is 3/4.

    The program of a law with references adds x(t_k) alone: then it is 3/2, and the loop unstable.
    """
    references = {"references": follower()[0]["references"]}

    assert sampled_follower(lambda gains: None) == PROVED
    assert sampled_follower(lambda gains: gains.update(references)) == REFUSED


x, u = sp.symbols("x u", real=True)


@pytest.mark.parametrize("at_estimate", [False, True])
@pytest.mark.parametrize(("rate", "verdict"), [
    (-x - x**3 / 2 + u, "PROVED"),
    # The observer evaluates its premise u x before it commands u.
    (-x - x * u**2 / 2 + u, "UNDECIDED"),
])  # fmt: skip
def test_observer_does_not_know_a_premise_of_the_command(
    at_estimate: bool, rate: sp.Expr, verdict: str
) -> None:
    plant = Plant(
        equations=(rate,),
        states=(Variable(x, "-", Interval.of(-1, 1)),),
        inputs=(Variable(u, "-", Interval.of(-2, 2)),),
        outputs=(Output("y", x, "-"),),
        measured=("y",),
        name="line",
    )
    model = sector_model(plant)
    data = plant_data(model) | {"slopes": slopes_data(secant_model(plant))}
    gains = pdc_law_data(model, np.ones((2, 1, 1))) | law_members(data)
    gains["observer"] = observer_member(np.array([[[4.0]]]), ["y"], at_estimate=at_estimate)
    claim = {"name": "l", "kind": "observed-loop", "level": 0.2, "decay_rate": 0}
    claims: list[Data] = [
        {"name": "e", "kind": "sector-embedding"},
        {"name": "s", "kind": "slope-embedding"},
        claim | {"P": [[1, 0], [0, 20]]},
    ]
    document = certificate_document(model=data, gains=gains, claims=claims, provenance={})

    assert check_document(document).claims[-1].verdict.name == verdict
