"""Changed certificates: refused with the old hashes; with new ones, PROVED only if still true."""

from __future__ import annotations

import random
import subprocess
import sys
from copy import deepcopy
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from tests.certificates.kinds.claims import Data
from tests.certificates.kinds.test_norms import NAMES, claims, plant

ROOT = Path(__file__).resolve().parents[3]
campaign: Any = import_module("mutations")
damage: Any = import_module("damage")
judge: Any = import_module("judge")
mutated: Any = import_module("mutated")


@pytest.fixture(scope="module")
def documents() -> dict[str, Data]:
    found = [*mutated.general_models(), *mutated.exclusions(), *mutated.problems()]
    return {name: damage.as_written(document) for name, document in found}


def test_what_is_true_is_not_judged_false(documents: dict[str, Data]) -> None:
    for name, document in documents.items():
        if name != "no function for a pair":
            assert judge.why_false(document, random.Random(1)) == ""


@pytest.mark.parametrize(
    ("kind", "key", "value"),
    [
        ("decay", "decay_rate", "0.7"),
        ("region", "parts", [{"L": [["40"]], "M": [["1"]]}]),
        ("gain-rounding", "relative", "0.9"),
        ("fuzzy-decay", "decay_rate", "2"),
        ("observer", "L", [[["-1"], ["0"]]]),
    ],
)
def test_the_judge_sees_what_is_false(
    kind: str, key: str, value: Any, documents: dict[str, Data]
) -> None:
    """A campaign whose judge says yes to everything would find nothing."""
    document = deepcopy(documents["two rules, continuous, products"])
    document["claims"] = [claim for claim in document["claims"] if claim["kind"] == kind]
    document["claims"][0][key] = value

    assert judge.why_false(document, random.Random(1)).startswith(kind)


@pytest.mark.parametrize(
    ("name", "number", "key", "value"),
    [
        ("optimum", 0, "point", ["2", "0.1", "0.5"]),
        ("optimum", 0, "basis", []),
        ("optimum", 1, "point", ["0", "0", "0", "3", "-3", "3"]),
        ("optimum", 1, "point", ["0", "0", "0", "1", "-3", "1"]),
        ("no bound", 0, "ray", ["0", "-1", "-1"]),
        ("no bound", 0, "ray", ["0", "1", "2"]),
        ("no bound", 0, "point", ["1", "0.9", "0.9"]),
        ("no solution", 1, "ray", ["0", "0", "0", "0"]),
    ],
)
def test_the_judge_sees_a_false_claim_about_a_problem(
    name: str, number: int, key: str, value: Any, documents: dict[str, Data]
) -> None:
    """x_1 x_2 >= 1 with 0 <= x_1 <= 4 and x_1 + x_2 = x_3 + 1: the least sum is 2."""
    document = deepcopy(documents[f"conic problem, {name}"])
    document["claims"][number][key] = value
    if key == "point" and number == 1:
        document["claims"][1]["basis"] = []
    document["claims"][:] = [*document["claims"][:1], document["claims"][number]]

    assert judge.why_false(document, random.Random(1)) != ""


@pytest.mark.parametrize("number", range(3))
def test_the_judge_reads_which_disturbances_enter(number: int) -> None:
    """What is true of w1 is false of w2, and of both."""
    claim = claims(0.2, entering=NAMES[:1])[number]
    model = {**plant(), "B": [[[0]]]}
    for members, false in (
        ({}, False),
        ({"entering": NAMES[1:]}, True),
        ({"entering": NAMES}, True),
    ):
        document = damage.as_written({"model": model, "claims": [claim | members]})
        assert (judge.why_false(document, random.Random(1)) != "") == false


def test_the_judge_sees_a_plant_that_is_not_its_model() -> None:
    """A premise's bound, an entry, an equation, a rest: each changed a little."""
    plant = damage.as_written(
        {
            "model": {
                "kind": "plant",
                "sample_time": None,
                "states": [{"name": "x", "unit": "-", "range": [-2, 2], "rest": 0}],
                "inputs": [{"name": "u", "unit": "-", "range": None, "rest": 0}],
                "parameters": {"k": 3},
                "equations": ["k*u - x^3"],
                "embedding": {
                    "premises": [{"name": "z", "expression": "x^2", "lower": 0, "upper": 4}],
                    "A": [["-z"]],
                    "B": [["3"]],
                },
            },
            "gains": {"trim": {"state": [0], "input": [0]}},
        }
    )
    reading: Any = import_module("second_reading")
    changes: list[tuple[tuple[Any, ...], Any]] = [
        (("model", "embedding", "premises", 0, "upper"), damage.Number("3.999999")),
        (("model", "embedding", "premises", 0, "lower"), damage.Number("0.0001")),
        (("model", "embedding", "A", 0, 0), "z"),
        (("model", "equations", 0), "k*u - 1.0000001*x^3"),
        (("model", "parameters", "k"), damage.Number("3.1")),
        (("gains", "trim", "state", 0), damage.Number("0.001")),
    ]

    assert reading.why_not_the_plant(plant, random.Random(1)) == ""
    for place, value in changes:
        changed = deepcopy(plant)
        owner: Any = changed
        for key in place[:-1]:
            owner = owner[key]
        owner[place[-1]] = value
        assert reading.why_not_the_plant(changed, random.Random(1)) != ""


@pytest.mark.slow
def test_the_campaign_lets_nothing_pass(reduced: bool) -> None:
    """As ``make campaigns`` runs it, with another seed; reduced: a tenth, no turbine."""
    command = [sys.executable, "benchmarks/mutations.py", "--print-only", "--seed", "2"]
    command += ["--count", "600", "--without-turbine"] if reduced else ["--count", "6000"]

    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)

    assert ran.returncode == 0, ran.stdout + ran.stderr
