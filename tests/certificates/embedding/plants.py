"""Plants and certificates of their embedding, for the tests of this folder."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from takagi.certificates import Checked, Claim
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.document.plant_embedding import embedding_claim, plant_data
from takagi.models import TSModel
from tests.certificates.kinds.claims import as_read, sealed

CLAIM = {"name": "the plant is its model", "kind": "sector-embedding"}


def said_of(data: Any) -> Claim:
    return embedding_outcome(as_read(data)).in_words()


def embedding_outcome(model: Any, gains: Any = None, claim: Any = CLAIM) -> Outcome:
    return replay(claim, {"model": model, "gains": gains}, None, [], "claims[0]")


def checked(model: TSModel) -> Checked:
    return check_document(sealed(plant_data(model), None, embedding_claim(model)))


def changed(data: dict[str, Any], change: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    copy = deepcopy(data)
    change(copy)
    assert copy != data
    return copy


def one_state(
    equation: str, premise: str, lower: object, upper: object, **more: Any
) -> dict[str, Any]:
    """Return x' = equation as z x with z = premise, on -1 <= x <= 2 unless ``range`` is given."""
    side = more.pop("range", [-1, 2])
    return {
        "kind": "plant",
        "sample_time": None,
        "states": [{"name": "x", "unit": "-", "rest": 0, "range": side}],
        "equations": [equation],
        "embedding": {
            "premises": [{"name": "z", "expression": premise, "lower": lower, "upper": upper}],
            "A": [["z"]],
        },
        **more,
    }
