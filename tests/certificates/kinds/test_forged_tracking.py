"""Claims about references that are false or about another loop: none of them is proved."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.containment import of_the_plant
from tests.certificates.kinds.claims import resealed, verdicts
from tests.certificates.kinds.tracking_documents import Data, at, changed


def wrong(name: str, factor: float) -> Callable[[Data], None]:
    """A number of the claim, or all of them, times a factor."""

    def change(document: Data) -> None:
        claim = document["claims"][1]
        value = claim[name]
        if isinstance(value, list):
            claim[name] = (np.array(value, dtype=float) * factor).tolist()
        else:
            claim[name] = float(value) * factor

    return change


def no_gravity(document: Data) -> None:
    """The plant's equation without gravity: the vertices are not its slopes."""
    document["model"]["equations"][1] = "(tau - c*w)/(m*l^2)"


def other_law(document: Data) -> None:
    """A law that integrates something else than the model says."""
    document["gains"]["references"][0]["follow"] = "2*q"


def other_output(document: Data) -> None:
    """Both say that 2 q follows, though q is integrated."""
    for owner in ("model", "gains"):
        document[owner]["references"][0]["follow"] = "2*q"


def uncertain_reference(document: Data) -> None:
    """The mass is named as the reference."""
    for owner in ("model", "gains"):
        document[owner]["references"][0]["reference"] = "m"


def wider_reference(document: Data) -> None:
    for v in document["model"]["disturbances"]:
        if v["name"] == "target":
            v["range"] = [-1, 1]


def narrower_input(document: Data) -> None:
    document["model"]["inputs"][0]["range"] = [-3, 3]


def two_gains(document: Data) -> None:
    document["gains"]["K"] = [document["gains"]["K"][0], [[30, 6, 61]]]


def flipped(document: Data) -> None:
    """An indefinite P."""
    document["claims"][1]["P"][0][0] *= -1


def asymmetric(document: Data) -> None:
    document["claims"][1]["P"][0][1] *= 1.01


@pytest.mark.parametrize(
    "damage",
    [
        wrong("decay_rate", 1.5),
        wrong("radius", 1.01),
        wrong("radius", 0.01),
        wrong("rates", 100),
        wrong("residuals", 0.8),
        wrong("residual_norm", 0.9),
        wrong("slope_norms", 0.99),
        wrong("error_factors", 0.99),
        wrong("slope", 1.5),
        wrong("slope", 0.0),
        wrong("decay_rate", -1),
        wrong("error_factors", -1),
        no_gravity,
        other_law,
        other_output,
        uncertain_reference,
        wider_reference,
        narrower_input,
        two_gains,
        flipped,
        asymmetric,
    ],
)
def test_a_forged_claim_is_not_proved(damage: Callable[[Data], None]) -> None:
    document = changed(damage)

    assert verdicts(document)[-1] != "PROVED"


def sampled(document: Data) -> None:
    """The same matrices, of x(t + 1)."""
    document["model"]["sample_time"] = document["gains"]["sample_time"] = 1


def implicit(document: Data) -> None:
    document["model"]["mass"] = [["1", "0"], ["0", "1"]]


def of_sectors(document: Data) -> None:
    del document["model"]["embedding"]["form"]
    document["claims"][0]["kind"] = "sector-embedding"


def of_a_ball(document: Data) -> None:
    """A number that no decimal is: a parameter that no equation has."""
    ball = {"value": 1.4142135, "within": "1e-7", "equals": "sqrt(2)"}
    document["model"]["parameters"]["c"] = ball


def nearly_at_rest(document: Data) -> None:
    """Within the slack of other claims; here rests are those that the law has."""
    document["gains"]["trim"]["state"] = [1e-13, 0]


def without_law(document: Data) -> None:
    document["gains"] = None


def of_matrices(document: Data) -> None:
    document["model"]["kind"] = "takagi-sugeno"


@pytest.mark.parametrize(
    "change",
    [sampled, implicit, of_sectors, of_a_ball, nearly_at_rest, without_law, of_matrices],
)
def test_claims_about_other_loops_are_refused(change: Callable[[Data], None]) -> None:
    document = at()
    change(document)

    assert verdicts(resealed(document)) == ["REFUSED"]


def test_references_behind_a_blend_need_its_proof() -> None:
    kinds = ["secant-embedding", "effort-blend", "tracking"]
    claim: Any = SimpleNamespace(shows=Verdict.PROVED)
    for reason in ("", "not shown"):
        outcomes = [Outcome(claim), Outcome(claim, reason), Outcome(claim)]
        assert bool(of_the_plant(outcomes, kinds, "here")[2].failure) is bool(reason)
