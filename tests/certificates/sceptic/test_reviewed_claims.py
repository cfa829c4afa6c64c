"""Claims that were called PROVED or DISPROVED and said more than was shown."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import Claim
from takagi.certificates.checker import check_document
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.kinds.claims import law_data, model_data

Data = dict[str, Any]


def outcomes(model: Data, gains: Data | None, *claims: Data) -> tuple[Claim, ...]:
    """Return what the checker says of each claim."""
    document = certificate_document(model=model, gains=gains, claims=list(claims), provenance={})
    return tuple(check_document(document).claims)


def halved(depth: int) -> list[list[int]]:
    """Return a tree that halves the edge between two rules, and each half again."""
    return [[]] if not depth else [[0, 0, 1], *halved(depth - 1), *halved(depth - 1)]


@pytest.mark.parametrize(("limit", "verdict"), [(0.1, "UNDECIDED"), (1.99, "PROVED")])
@pytest.mark.parametrize("depth", [0, 4])
def test_the_next_sample_s_weights_may_lie_in_any_piece(
    depth: int, limit: float, verdict: str
) -> None:
    """x+ = 0.99 x: rule 1 commands -x, rule 2 a sample later 0.99 x, 1.99 more."""
    model = model_data([[[0.99]], [[0.99]]], sample_time=1, B=[[[0]]])
    claim = {"name": "r", "kind": "input-limits", "P": [[1]], "level": 1, "multiplier": 0.01}
    claim |= {"input_limits": [1], "rate_limits": [limit], "rate_shares": {"motion": [limit]}}

    found = outcomes(
        model, law_data([[[1]], [[-1]]], sample_time=1), claim | {"halvings": halved(depth)}
    )

    assert [claim.verdict.name for claim in found] == [verdict]


def noisy(premise: str) -> Data:
    """Return x+ = z x / 2 + u, where z moves with the signal p or with the state."""
    signal = {"name": "p", "unit": "-", "rest": 0, "range": [-1, 1]}
    model: Data = {"kind": "plant", "sample_time": 1, "disturbances": [signal]}
    model["states"] = [{"name": "x", "unit": "-", "rest": 0, "range": [-5, 5]}]
    model["inputs"] = [{"name": "u", "unit": "-", "rest": 0}]
    model["equations"] = [f"({premise})*x/2 + u"]
    model["outputs"] = [{"name": "y", "expression": "x"}]
    ends = {"name": "z", "expression": premise, "lower": -1, "upper": 1}
    matrices = {"A": [["z/2"]], "B": [["1"]], "C": [["1"]], "D": [["0"]], "E": [["0"]]}
    return model | {"embedding": {"premises": [ends], **matrices}}


EMBEDDING = {"name": "e", "kind": "sector-embedding"}
H2 = {"name": "h", "kind": "h2-norm", "P": [[1.334]], "norm": 1.156, "disturbance": "inputs"}


def test_a_signal_may_depend_on_the_noise_and_is_named() -> None:
    """p = sign(x w) in its range, w = +-1 at random: E x^2 is 4, where 1.336 is claimed without."""
    (_, by_signal), (_, by_state) = (
        outcomes(noisy("p"), None, EMBEDDING, H2),
        outcomes(noisy("x/5"), None, EMBEDDING, H2),
    )

    assert (
        "for values of p [-] that do not depend on the noise at the same instant" in by_signal.text
    )
    assert by_state.verdict.name == by_signal.verdict.name == "PROVED"
    assert "same instant" not in by_state.text


@pytest.mark.parametrize(("equation", "verdict"), [("x", "UNDECIDED"), ("-x", "PROVED")])
def test_what_holds_of_a_model_that_is_not_the_plant_s_is_not_proved(
    equation: str, verdict: str
) -> None:
    """x' = x runs away; its model x' = -x decays."""
    state = {"name": "x", "unit": "-", "rest": 0, "range": [-1, 1]}
    model: Data = {"kind": "plant", "sample_time": None, "states": [state], "equations": [equation]}
    model["embedding"] = {"premises": [], "A": [["-1"]]}
    decay = {"name": "d", "kind": "decay", "P": [[1]], "decay_rate": 0.5}
    kept = {"name": "i", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}

    for order in ((EMBEDDING, decay, kept), (decay, kept, EMBEDDING)):
        found = outcomes(model, None, *order)
        assert [claim.verdict.name for claim in found] == [verdict] * 3


def test_a_function_that_stands_still_at_an_instant_is_not_said_never_to_fall() -> None:
    """|x|^2 falls along every solution of this pair; at rule 1 V' is -2 x2^2, at rule 2 -2 x1^2."""
    pair = [[[0, -1], [1, -1]], [[-1, -1], [1, 0]]]
    factors = [{"blend": k, "factor": [[1 - k], [k]]} for k in (0, 1)]
    claim = {"name": "n", "kind": "no-common-decay", "decay_rate": 0, "multipliers": factors}

    (found,) = outcomes(model_data(pair), None, claim)

    assert found.verdict.name == "DISPROVED"
    assert "has V' < 0 wherever x is not 0" in found.text and "falls" not in found.text


@pytest.mark.parametrize(
    ("rate", "factor", "verdict"),
    [
        # x1' = x1, x2' = -x2: along e1 nothing decays, and the sum is diag(3, 0).
        (0.5, [[1], [0]], "DISPROVED"),
        (0, [[0], [0]], "UNDECIDED"),
        (0, [[0], [1]], "UNDECIDED"),
        (0, [[0], [0.001]], "UNDECIDED"),
    ],
)
def test_multipliers_exclude_by_their_sum_alone(
    rate: float, factor: list[list[float]], verdict: str
) -> None:
    """Zeros show nothing, small ones no more than large ones; a sum may have rows of zeros."""
    claim: Data = {"name": "n", "kind": "no-common-decay", "decay_rate": rate}
    claim |= {"multipliers": [{"blend": 0, "factor": factor}]}

    (found,) = outcomes(model_data([[[1, 0], [0, -1]]]), None, claim)

    assert found.verdict.name == verdict
