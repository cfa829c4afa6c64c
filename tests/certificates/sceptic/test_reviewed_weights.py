"""What an observer can know, and products of weights that do not sum to one: found by a review."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, Verdict, check_document
from tests.certificates.kinds.claims import resealed, verdicts

Document = dict[str, Any]
RECORDED = Path(__file__).parents[1] / "recorded" / "damaged"


def document(model: Document, claims: list[Document], gains: Document | None = None) -> Document:
    """Return a sealed certificate."""
    plain = {"format": "takagi-certificate", "version": 1, "provenance": {"sha256": {}}}
    return resealed(plain | {"model": model, "gains": gains, "claims": claims})


def plant(output: str, C: str, D: str) -> Document:
    """x' = x + u with an output; the premise is x."""

    def signal(name: str, **more: Any) -> Document:
        return {"name": name, "unit": "-", **more}

    return {
        "kind": "plant", "name": "p", "sample_time": None, "parameters": {},
        "states": [signal("x", rest=0, range=[-3, 3])],
        "inputs": [signal("u", rest=0, range=[-3, 3])], "disturbances": [],
        "outputs": [signal("y", expression=output)], "equations": ["x + u"],
        "embedding": {
            "premises": [{"name": "z", "expression": "x", "lower": -3, "upper": 3}],
            "A": [["1"]], "B": [["1"]], "C": [[C]], "D": [[D]],
        },
    }  # fmt: skip


EMBEDDING = {"name": "embedding", "kind": "sector-embedding"}
OBSERVER = {"name": "o", "kind": "observer", "L": [[[2]]], "P": [[1]], "decay_rate": 0.99}


@pytest.mark.parametrize(
    ("output", "C", "D", "verdict"),
    [
        ("x", "1", "0", "PROVED"),
        # With u = -1 the output is 0 whatever x does: nothing can observe it.
        ("x + x*u", "1", "z", "UNDECIDED"),
        ("x + 2*u", "1", "2", "UNDECIDED"),
        # At x = -3 nothing is added, elsewhere it is.
        ("x + (x + 3)*u", "1", "z + 3", "UNDECIDED"),
    ],
)
def test_an_output_to_which_an_input_is_added_shows_no_premise(
    output: str, C: str, D: str, verdict: str
) -> None:
    """x' = x + u, premise x: the observer would need the weights to take the input away."""
    made = document(plant(output, C, D), [EMBEDDING, OBSERVER])

    assert verdicts(made) == ["PROVED", verdict]


def test_one_of_two_inputs_that_is_added_is_enough() -> None:
    """x' = x + u, y = x + 2 u, and an input that does nothing: the premise x is not seen."""
    model = plant("x + 2*u", "1", "2")
    model["inputs"].append({"name": "v", "unit": "-", "rest": 0, "range": [-1, 1]})
    model["embedding"] |= {"B": [["1", "0"]], "D": [["2", "0"]]}
    made = document(model, [EMBEDDING, OBSERVER])

    assert verdicts(made) == ["PROVED", "UNDECIDED"]


@pytest.mark.parametrize("seen", [["x2"], ["x2", "x1"], ["x1 + x2", "x2"]])
@pytest.mark.parametrize(("premise", "verdict"), [("x2", "PROVED"), ("p", "UNDECIDED")])
def test_a_signal_is_measured_by_no_output(premise: str, verdict: str, seen: list[str]) -> None:
    """x1' = -x1 + z x2, x2' = -x2, an output x2: z = x2 is seen, the signal z = p is not."""

    def ranged(name: str) -> Document:
        return {"name": name, "unit": "-", "rest": 0, "range": [-1, 1]}

    C = [[str(int(state in output)) for state in ("x1", "x2")] for output in seen]
    outputs = [
        {"name": f"y{k}", "unit": "-", "expression": output} for k, output in enumerate(seen)
    ]

    embedding: Document = {
        "premises": [{"name": "z", "expression": premise, "lower": -1, "upper": 1}]
    }
    embedding |= {"A": [["-1", "z"], ["0", "-1"]], "B": [["0"], ["0"]], "C": C}
    model = plant("x2", "1", "0") | {"states": [ranged("x1"), ranged("x2")]}
    model |= {"disturbances": [ranged("p")], "equations": [f"-x1 + ({premise})*x2", "-x2"]}
    model["outputs"] = outputs
    model["embedding"] = embedding | {"D": [["0"]] * len(seen), "E": [["0"], ["0"]]}
    claim = OBSERVER | {"L": [[[0] * len(seen)] * 2], "P": [[1, 0], [0, 1]], "decay_rate": 0.4}
    made = document(model, [EMBEDDING, claim])

    assert verdicts(made) == ["PROVED", verdict]


def square(rules: list[list[int]], *, stated: bool) -> Document:
    """Vertices x' = -x and x' = -2x, ... weighed by products of two premises."""
    premises = [{"name": name, "lower": -1, "upper": 1, "expression": name} for name in "ab"]
    model: Document = {
        "kind": "takagi-sugeno", "name": "", "sample_time": None, "state_names": ["x"],
        "A": [[[-1 - k]] for k in range(len(rules))], "rules": rules, "box": {},
    }  # fmt: skip
    return model | ({"premises": premises} if stated else {})


DECAY = {"name": "decay", "kind": "decay", "P": [[1]], "decay_rate": 0.5}
EVERY = [[0, 0], [0, 1], [1, 0], [1, 1]]


@pytest.mark.parametrize("stated", [True, False])
def test_a_model_s_products_sum_to_one(stated: bool) -> None:
    """Of corners 00 and 11 alone the products sum to less: at a = 1, b = -1 to nothing."""
    assert verdicts(document(square(EVERY, stated=stated), [DECAY])) == ["PROVED"]

    for rules in ([[0, 0], [1, 1]], EVERY[:3]):
        made = document(square(rules, stated=stated), [DECAY])
        with pytest.raises(CertificateError, match=r"model\.rules: not the corners of its 2"):
            check_document(made)


def test_two_rules_of_sixty_premises_are_refused_before_their_corners_are_listed() -> None:
    """2^60 corners do not fit into memory."""
    names = [f"z{k}" for k in range(60)]
    model = square([[0] * 60, [1] * 60], stated=False)
    for stated in (False, True):
        if stated:
            sides = {"lower": -1, "upper": 1}
            model["premises"] = [{"name": z, "expression": z, **sides} for z in names]
        made = document(model, [DECAY])
        with pytest.raises(CertificateError, match="not the corners of its 60 premises"):
            check_document(made)


def test_a_premise_that_never_changes_has_one_end() -> None:
    """Without stated bounds, one end in all rules is a constant premise."""
    made = document(square([[0, 1], [1, 1]], stated=False), [DECAY])

    assert verdicts(made) == ["PROVED"]


def test_gains_that_go_by_an_actuator_s_error_are_not_called_known() -> None:
    """The law's own first premise is the error that no law knows; its rules have other gains."""
    lines = (RECORDED / "effort-blend-2.jsonl").read_text(encoding="utf-8").splitlines()
    made = json.loads(lines[0])
    assert check_document(made).claims[-1].verdict is Verdict.PROVED

    own = deepcopy(made["model"]["embedding"]["premises"])
    own[0].update(expression="cooling_error", lower=-0.1, upper=0.1)
    rules = [[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    K = [[[0, 2]] if rule[0] else [[1, 3]] for rule in rules]
    made["gains"] |= {"premises": own, "rules": rules, "K": K}
    found = check_document(resealed(made)).claims[-1]

    assert found.verdict is Verdict.UNDECIDED
    assert "other weights than the model's" in found.text


def equal_gains(vertices: int, count: int, own: Document) -> Document:
    """x' = x + u with ``count`` equal gains 2, and ``own`` members of the law."""
    model: Document = {
        "kind": "takagi-sugeno", "name": "", "sample_time": None, "state_names": ["x"],
        "input_names": ["u"], "A": [[[1]]] * vertices, "B": [[[1]]] * vertices, "box": {},
    }  # fmt: skip
    law = {"name": "pdc", "sample_time": None, "state_names": ["x"], "input_names": ["u"]}
    claim = {"name": "decay", "kind": "decay", "P": [[1]], "decay_rate": 0.5}
    return document(model, [claim], law | {"K": [[[2]]] * count} | own)


def own_weights(count: int) -> list[Document]:
    return [{"name": f"z{k}", "lower": -1, "upper": 1, "unit": "-"} for k in range(count)]


@pytest.mark.parametrize("vertices", [1, 4])
@pytest.mark.parametrize("count", [1, 4])
def test_equal_gains_may_have_all_rules_of_weights_of_their_own(vertices: int, count: int) -> None:
    """Whatever the weights are, they sum to one, and u = -2 x."""
    made = equal_gains(vertices, count, {"premises": own_weights(2), "rules": EVERY})

    assert verdicts(made) == ["PROVED"]


@pytest.mark.parametrize("vertices", [1, 2, 3])
@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize(
    ("count", "rules"),
    [
        # At z0 = z1 = 1 these weights are 0, and so is u: x' = x.
        (1, EVERY[:3]),
        (3, EVERY[:3]),
        (2, [EVERY[0], EVERY[3]]),
        # Rows that are not those of the gains, or no rows.
        (3, EVERY),
        (2, EVERY),
        (1, [EVERY[0], *EVERY]),
        (1, [[]]),
        (1, []),
        (1, [[0, 0], [0, 1], [1, 0], [1, 2]]),
    ],
)
def test_equal_gains_need_weights_that_sum_to_one(
    vertices: int, stated: bool, count: int, rules: list[list[int]]
) -> None:
    """u = -sum_j g_j K x is -K x only where the products g_j sum to one."""
    own = {"premises": own_weights(2)} if stated else {}
    made = equal_gains(vertices, count, own | {"rules": rules})

    assert verdicts(made) == ["REFUSED"]


@pytest.mark.parametrize("premises", [True, {"name": "z"}, "z", 3, [None], ["z"]])
def test_premises_of_equal_gains_that_are_none_are_refused(premises: Any) -> None:
    made = equal_gains(1, 1, {"premises": premises, "rules": EVERY})

    assert verdicts(made) == ["REFUSED"]
