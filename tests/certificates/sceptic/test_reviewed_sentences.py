"""Sentences that a review found to say more than what was shown, and one false DISPROVED."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Claim, Verdict, certify
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.replay.loop_reading import read_model_loop
from takagi.certificates.checker.words.rounded import exactly
from takagi.certificates.requests import InputLimits, L2Gain, Peak
from takagi.certificates.requests.request import Request
from takagi.models import Plant, load_model, sector_model
from tests.certificates.kinds.claims import (
    Data,
    as_read,
    law_data,
    model_data,
    said_of,
    sealed,
    verdict_of,
)

REST_U = "here u is u - u*, with * for the point of rest"
REST_W = "here w is w - w*, with * for the point of rest"
REST_Y = "here y is y less its value at rest"
ITO = "in Ito's sense"


def outcome(model: Data, gains: Data | None, claims: list[Data]) -> tuple[list[str], str]:
    found = check_document(sealed(model, gains, *claims)).claims
    return [one.text for one in found], found[-1].verdict.name


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
    elsewhere = outcome(lines(rest=10), None, [EMBEDDED, HELD])
    here = outcome(lines(), None, [EMBEDDED, HELD])

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
    texts, verdict = outcome(model, gains, [EMBEDDED, FALLS | kind])

    assert verdict == "PROVED"
    assert "; here x is x - x*" in texts[1]


@pytest.mark.parametrize(
    ("written", "told"), [("x + 100", True), ("x + sin(1/2)", True), ("x", False), ("x + 0", False)]
)
def test_the_mean_square_is_of_the_output_less_its_value_at_rest(written: str, told: bool) -> None:
    texts, verdict = outcome(lines(written), None, [EMBEDDED, MEAN])

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


BOX = {"x1 [-]": [-1, 1]}
KEPT: Data = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "multiplier": 1}


def of_each_kind() -> list[Data]:
    """Return claims about x' = -2 x with the gain 0 that say that something decays."""
    shared = {"name": "a", "decay_rate": 0.5, "P": [[1]]}
    settled = {"scales": [1], "lower": 1, "overshoot": 1, "settled_share": 0.5, "settling_time": 9}
    return [
        shared | {"kind": "decay"},
        shared | {"kind": "transient", **settled},
        shared | {"kind": "gain-rounding", "absolute": [[0.1]], "relative": 0, "tau": [1]},
        shared
        | {"kind": "fuzzy-decay", "degrees": [0], "P": [{"powers": [[0]], "matrix": [[1]]}]}
        | {"polya": 0, "rates": [None]},
        shared | {"kind": "observer", "L": [[[0]]]},
    ]


@pytest.mark.parametrize("claim", of_each_kind(), ids=lambda claim: str(claim["kind"]))
def test_decay_is_of_a_plant_in_its_box_and_without_disturbance(claim: Data) -> None:
    model = model_data([[[-2]]], B=[[[1]]], C=[[[1]]])
    law = law_data([[[0]]])
    plain = said_of(model, law, claim)
    boxed = said_of(model | {"box": BOX}, law, claim)
    pushed = said_of(model | {"E": [[[1]]]}, law, claim)

    assert {found.verdict for found in (plain, boxed, pushed)} == {Verdict.PROVED}
    assert "box" not in plain.text and "disturbance" not in plain.text
    assert boxed.text.endswith("while it stays in the model's box")
    assert "without disturbance" in pushed.text


def test_matrices_alone_are_not_said_to_be_their_plant() -> None:
    """No claim shows that vertices without equations contain a plant; of equations one does."""
    model = read_text(str(model_data([[[-2]]], box=BOX)).replace("'", '"').replace("None", "null"),
                      "model")  # fmt: skip
    family = read_model_loop(model, None)
    claim = read_text('{"name": "a", "kind": "decay", "decay_rate": 0.5, "P": [[1]]}', "claim")

    unknown = replay(claim, None, family, [], "a").in_words()
    assert "for a plant that the model contains" in unknown.text
    known = replay(claim, None, replace(family, scheduled_by=("x1 [-]",)), [], "a").in_words()
    assert "for its plant while" in known.text


def test_level_is_shown_as_it_is() -> None:
    """The set {x^2 <= 1} lies in the box and a larger one does not: 1.0000000000001 is larger."""
    model = model_data([[[-2]]], box=BOX)
    level = "0.99999999999"
    proved = said_of(model, None, KEPT | {"level": float(level)})

    assert proved.verdict is Verdict.PROVED
    assert f"<= {level}}}" in proved.text
    assert verdict_of(model, None, KEPT | {"level": 1.0000000000001}) == "UNDECIDED"


def test_from_outside_nothing_is_said_beyond_the_box() -> None:
    model = model_data([[[-2]]], B=[[[1]]], E=[[[1]]])
    claim = KEPT | {"level": 0.5, "disturbance": "inputs", "disturbance_norm": 0.1}

    assert "from outside V" in said_of(model, None, claim).text
    assert "from outside, but within the box, V" in said_of(model | {"box": BOX}, None, claim).text
    assert "without the model's disturbance" in said_of(model, None, claim).text


@given(st.fractions(-1000, 1000, max_denominator=10**6))
def test_exactly_is_the_number(value: Fraction) -> None:
    shown = exactly(value)

    assert Fraction(shown.strip("()")) == value
    assert shown.startswith("(") == ((10**20 * value).denominator != 1)


HALVES = model_data([[[0.5]], [[-0.5]]], sample_time=1, B=[[[1]]], E=[[[1]]], C=[[[1]]])
HALVES |= {"input_names": ["u [-]"], "disturbance_names": ["w [-]"]}
CLAIM: Data = {"name": "a", "kind": "h2-norm", "P": [[1.334]], "norm": 1.156}
CLAIM |= {"disturbance": "disturbances"}


def said_with(*scheduling: str, way: str = "disturbances") -> Verdict:
    text = str({**HALVES, "claim": CLAIM | {"disturbance": way}})
    data = read_text(text.replace("'", '"').replace("None", "null"), "model")
    family: PolytopicLoop = replace(read_model_loop(data, None), scheduled_by=scheduling)
    return replay(data["claim"], None, family, [], "claim").verdict


def test_premises_that_are_the_noise_prove_nothing() -> None:
    assert said_with("x1 [-]") is Verdict.PROVED
    assert said_with("x1 [-]", "w [-]") is Verdict.UNDECIDED
    assert said_with("u [-]") is Verdict.PROVED
    assert said_with("u [-]", way="inputs") is Verdict.UNDECIDED


def outcomes(model: Data, gains: Data | None, *claims: Data) -> tuple[Claim, ...]:
    return tuple(check_document(sealed(model, gains, *claims)).claims)


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


def test_a_function_that_stands_still_at_an_instant_is_not_said_never_to_fall() -> None:
    """|x|^2 falls along every solution of this pair; at rule 1 V' is -2 x2^2, at rule 2 -2 x1^2."""
    pair = [[[0, -1], [1, -1]], [[-1, -1], [1, 0]]]
    factors = [{"blend": k, "factor": [[1 - k], [k]]} for k in (0, 1)]
    claim = {"name": "n", "kind": "no-common-decay", "decay_rate": 0, "multipliers": factors}

    (found,) = outcomes(model_data(pair), None, claim)

    assert found.verdict.name == "DISPROVED"
    assert "has V' < 0 wherever x is not 0" in found.text and "falls" not in found.text
