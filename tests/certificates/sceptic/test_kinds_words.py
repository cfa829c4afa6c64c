"""What a verdict says in words is not more than what was shown."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict
from takagi.certificates.checker import read_text
from takagi.certificates.checker.loop.model_loop import read_model_loop
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.words.rounded import exactly
from tests.certificates.kinds.claims import law_data, model_data, said_of

Data = dict[str, Any]
BOX = {"x1 [-]": [-1, 1]}
DECAY: Data = {"name": "a", "kind": "decay", "decay_rate": 0.5, "P": [[1]]}
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
    assert said_of(model, None, KEPT | {"level": 1.0000000000001}).verdict is Verdict.UNDECIDED


def test_bounds_on_weights_that_are_assumed_are_rounded_down() -> None:
    """Speeds up to 0.123457 were not looked at where 0.12345678 is stated."""
    P = [{"powers": [[1, 0]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[2]]}]
    claim = {"name": "a", "kind": "fuzzy-decay", "decay_rate": 0, "degrees": [1], "P": P}
    claim |= {"polya": 0, "rates": [[0.12345678, 0.12345678]]}
    found = said_of(model_data([[[-1]], [[-2]]]), None, claim)

    assert found.verdict is Verdict.PROVED
    assert "0.123456, 0.123456 1/s" in found.text


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
