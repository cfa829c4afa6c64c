"""Sentences that a review found to say more than what was shown, and one false DISPROVED."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.checker import check_document
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.requests import InputLimits, L2Gain, Peak
from takagi.certificates.requests.request import Request
from takagi.models import Plant, TSModel, load_model, sector_model
from tests.certificates.both_checkers import second
from tests.certificates.embedding.plants import as_read
from tests.certificates.kinds.claims import model_data, said_of

Data = dict[str, Any]
REST_U = "here u is u - u*, with * for the point of rest"
REST_W = "here w is w - w*, with * for the point of rest"
REST_Y = "here y is y less its value at rest"
ITO = "in Ito's sense"


def both(model: Data, gains: Data | None, claims: list[Data]) -> tuple[list[str], str]:
    """Return the sentences, and the verdict on the last claim, which both checkers give."""
    document = certificate_document(model=model, gains=gains, claims=claims, provenance={})
    found = check_document(document).claims
    assert [claim.verdict.name for claim in found] == second(document)
    return [one.text for one in found], found[-1].verdict.name


# A function that decays at the rate that is asked for, and no faster


def exclusion(rate: float, blend: int = 0, factor: Any = ((1,),)) -> Data:
    multiplier = {"blend": blend, "factor": [list(row) for row in factor]}
    return {"name": "no", "kind": "no-common-decay", "decay_rate": rate} | {
        "multipliers": [multiplier]
    }


@pytest.mark.parametrize(
    ("A", "claim"),
    [
        ([[[-1]]], exclusion(1)),
        ([[[-2]], [[-1]]], exclusion(1, 1)),
        ([[[-1, 1], [-1, -1]]], exclusion(1, 0, [[1, 0], [0, 1]])),
    ],
)
def test_a_rate_that_is_reached_is_not_disproved(A: Any, claim: Data) -> None:
    """V = x'x has V' <= -2 V along every blend: it decays as exp(-2 t), at 1 1/s."""
    beyond = claim | {"decay_rate": 1.000001}

    assert both(model_data(A), None, [claim])[1] == "UNDECIDED"
    assert both(model_data(A), None, [beyond])[1] == "DISPROVED"


def test_a_function_that_only_stands_still_does_not_fall() -> None:
    """x' = 0: at the rate 0 V is to fall strictly, and the sum is zero.  So in samples, x+ = x."""
    still, sampled = model_data([[[0]]]), model_data([[[1]]], sample_time=1)
    for model, falls in ((still, "has V' < 0"), (sampled, "falls in each sample")):
        (text,), verdict = both(model, None, [exclusion(0)])

        assert verdict == "DISPROVED"
        wherever = "wherever x is not 0 along the loop"
        assert text.startswith(f"no common quadratic function {falls} {wherever}")
        assert "0 1/s" not in text


@pytest.mark.numeric
def test_certify_disproves_beyond_the_rate_and_not_at_it() -> None:
    model = TSModel([[[-2.0]], [[-1.0]]])

    assert certify(model, decay_rate=1.0).verdict is Verdict.UNDECIDED
    assert certify(model, decay_rate=1.001).verdict is Verdict.DISPROVED


# Deviations from rest

VALVE = """format = 1
kind = "plant"
units = "unchecked"
name = "valve"
description = "d"
[states]
x = {{ range = [-1, 1], description = "x" }}
[inputs]
u = {{ rest = {u}, description = "V" }}
[disturbances]
w = {{ rest = {w}, range = [-1, 11], description = "w" }}
[equations]
x = "-x + u - {u} + w - {w}"
[outputs]
y = {{ expression = "x + {y}" }}
"""


def valve(folder: Path, u: int, w: int, y: int) -> list[str]:
    """Return the sentences about a plant whose input, disturbance and output rest there."""
    path = folder / "valve.toml"
    path.write_text(VALVE.format(u=u, w=w, y=y))
    plant = load_model(path)
    assert isinstance(plant, Plant)
    claims: list[Request] = [InputLimits(limits=[1.0]), Peak(), L2Gain()]
    found = certify(sector_model(plant), [[1.0]], claims=claims)
    assert found.verdict is Verdict.PROVED
    return [one.text for one in found.checked.claims[1:]]


@pytest.mark.parametrize(
    ("rests", "ends"),
    [
        # The valve reaches 6 V with |u - 5| <= 1, and y = 100.5 with |y - 100| <= 0.5.
        ((5, 0, 100), (REST_U, REST_Y, REST_Y)),
        ((0, 5, 0), ("", REST_W, REST_W)),
        ((0, 0, 0), ("", "", "")),
    ],
)
def test_what_rests_elsewhere_is_a_deviation(
    rests: tuple[int, int, int], ends: tuple[str, str, str], tmp_path: Path
) -> None:
    for text, end in zip(valve(tmp_path, *rests), ends, strict=True):
        if end:
            assert text.endswith(f"; {end}")
        else:
            assert not any(words in text for words in ("; here", "at rest", "*"))


@pytest.mark.parametrize(
    ("rests", "offsets", "told"),
    [
        ((0, 0), (0, 0), ""),
        ((0, 2), (0, 0), "xy"),
        ((0, 0), (3, 0), "y"),
        ((0, 0), (0, 3), "y"),
        ((2, 2), (-2, -2), "x"),
    ],
)
def test_one_that_rests_elsewhere_is_enough(
    rests: tuple[int, int], offsets: tuple[int, int], told: str
) -> None:
    """Of two states, and of the outputs a + offset and b + offset."""
    names = ("a", "b")
    model: Data = {"kind": "plant", "sample_time": None, "embedding": {"premises": []}}
    model["states"] = [
        {"name": n, "symbol": f"d{n}", "unit": "-", "rest": rest, "range": [rest - 1, rest + 1]}
        for n, rest in zip(names, rests, strict=True)
    ]
    model["equations"] = [f"{rest} - {n}" for n, rest in zip(names, rests, strict=True)]
    model["outputs"] = [
        {"name": f"y{n}", "unit": "-", "expression": f"{n} + ({off})"}
        for n, off in zip(names, offsets, strict=True)
    ]
    model["embedding"] |= {"A": [["-1", "0"], ["0", "-1"]], "C": [["1", "0"], ["0", "1"]]}

    assert plant_loop(as_read(model)).resting_elsewhere == told


def lines(expression: str = "x", rest: int = 0) -> Data:
    """Return x' = -(x - x*) + w with an output."""
    state = {"name": "x", "symbol": "dx" if rest else "x", "unit": "-", "rest": rest}
    w = {"name": "w", "symbol": "dw" if rest else "w", "unit": "-", "rest": rest}
    return {
        "kind": "plant",
        "name": "p",
        "sample_time": None,
        "states": [state | {"range": [rest - 1, rest + 1]}],
        "inputs": [],
        "disturbances": [w | {"range": [rest - 1, rest + 1]}],
        "outputs": [{"name": "y", "unit": "-", "expression": expression}],
        "parameters": {},
        "equations": ["-x + w"],
        "embedding": {"premises": [], "A": [["-1"]], "C": [["1"]], "E": [["1"]]},
    }


EMBEDDED: Data = {"name": "e", "kind": "sector-embedding"}
HELD: Data = {"name": "set", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}
HELD |= {"disturbance": "disturbances", "disturbance_bounds": [1]}
MEAN: Data = {"name": "h2", "kind": "h2-norm", "P": [[0.51]], "norm": 0.72}
MEAN |= {"disturbance": "disturbances"}


def test_a_set_about_a_rest_that_is_not_zero() -> None:
    """|w| <= 1 would be another claim than |w - 10| <= 1, and so would {x^2 <= 1}."""
    elsewhere = both(lines(rest=10), None, [EMBEDDED, HELD])
    here = both(lines(), None, [EMBEDDED, HELD])

    assert elsewhere[1] == here[1] == "PROVED"
    assert "; here x is x - x*, w is w - w*, with * for" in elsewhere[0][1]
    assert "; here" not in here[0][1]


FALLS: Data = {"name": "v", "decay_rate": 0.5, "P": [[1]]}
TRANSIENT: Data = {"kind": "transient", "scales": [1], "lower": 1, "overshoot": 1}
TRANSIENT |= {"settled_share": 0.5, "settling_time": 2}
LAW: Data = {"sample_time": None, "K": [[[0]]], "trim": {"state": [10], "input": [0]}}
LAW |= {"state_names": ["dx [-]"], "input_names": ["u [-]"]}


@pytest.mark.parametrize(
    ("kind", "gains"),
    [
        ({"kind": "decay"}, None),
        (TRANSIENT, None),
        ({"kind": "gain-rounding", "relative": 0.1, "absolute": [[0]], "tau": [0.5]}, LAW),
    ],
    ids=lambda one: one["kind"] if one and "kind" in one else "",
)
def test_a_function_of_the_deviation_says_so(kind: Data, gains: Data | None) -> None:
    model = lines(rest=10)
    if gains is not None:
        u = {"name": "u", "unit": "-", "rest": 0, "range": None}
        model |= {"inputs": [u], "equations": ["-x + w + u"]}
        model["embedding"] |= {"B": [["1"]], "D": [["0"]]}
    texts, verdict = both(model, gains, [EMBEDDED, FALLS | kind])

    assert verdict == "PROVED"
    assert "; here x is x - x*" in texts[1]


@pytest.mark.parametrize(
    ("written", "told"), [("x + 100", True), ("x + sin(1/2)", True), ("x", False), ("x + 0", False)]
)
def test_the_mean_square_is_of_the_output_less_its_value_at_rest(written: str, told: bool) -> None:
    texts, verdict = both(lines(written), None, [EMBEDDED, MEAN])

    assert verdict == "PROVED"
    assert texts[1].endswith(REST_Y) == told


# White noise that enters by a matrix that moves


def moving(E: Any, sample_time: float | None = None) -> Data:
    return model_data([[[-1]], [[-1]]] if sample_time is None else [[[0.1]], [[0.1]]],
                      sample_time=sample_time, C=[[[1]], [[1]]], E=E)  # fmt: skip


@pytest.mark.parametrize(
    ("E", "sample_time", "told"),
    [
        ([[[1]], [[-1]]], None, True),
        ([[[1]], [[1]]], None, False),
        ([[[1]], [[-1]]], 1, False),
    ],
)
def test_the_sense_of_the_noise_is_told_where_it_matters(
    E: Any, sample_time: float | None, told: bool
) -> None:
    found = said_of(moving(E, sample_time), None, MEAN | {"P": [[1.1]], "norm": 2})

    assert found.verdict is Verdict.PROVED
    assert (ITO in found.text) == told
