"""Every rule counts, also where a claim puts the matrices aside that differ between the rules.

The rules of these models differ in one matrix alone, their gains or outputs in more.  A claim that
brings matrices of its own must not make the checker forget that there are two rules.
"""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import Verdict
from tests.certificates.kinds.claims import law_data, model_data, said_of

Data = dict[str, Any]
ONE = [[1, 0], [0, 1]]
# x1' = -3 x1 + u + ..., so that the second gain, u = 100 x1, makes an unstable loop.
SLOW, FAST = [[0, 0]], [[-100, 0]]
L2: Data = {"name": "a", "kind": "l2-gain", "P": ONE, "gain": 5, "disturbance": "disturbances"}
KEPT: Data = {"name": "a", "P": ONE, "level": 1, "multiplier": 1, "disturbance": "inputs"}
KEPT |= {"disturbance_norm": 0.1}


def differing_in(letter: str) -> Data:
    """Return two rules that differ in C, or in E, and in nothing else."""
    two = {"C": [[[1, 0]], [[0, 1]]], "E": [[[1], [0]], [[0], [1]]]}
    same = {"B": [[[1], [0]]], "C": [[[1, 0]]], "E": [[[1], [0]]]}
    return model_data([[[-3, 0], [0, -3]]], **{**same, letter: two[letter]})


CLAIMS: list[tuple[str, Data]] = [
    ("C", L2 | {"output": {"C": [[[1, 0]]]}}),
    ("C", L2 | {"kind": "h2-norm", "norm": 100, "output": {"C": [[[1, 0]]]}}),
    ("E", KEPT | {"kind": "invariant-ellipsoid"}),
    ("E", KEPT | {"kind": "peak", "gain": 1000, "output": {"C": [[[1, 0]]]}}),
    ("E", KEPT | {"kind": "input-limits", "input_limits": [1000]}),
]


@pytest.mark.parametrize(("letter", "claim"), CLAIMS)
def test_unstable_second_gain_is_not_proved(letter: str, claim: Data) -> None:
    model = differing_in(letter)

    assert said_of(model, law_data([SLOW, SLOW]), claim).verdict is Verdict.PROVED
    assert said_of(model, law_data([SLOW, FAST]), claim).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("way", ["F", "D"])
def test_second_output_of_the_claim_is_not_left_out(way: str) -> None:
    """With y = x1 + 1000 w in the second rule the gain is at least 1000."""
    model = differing_in("C")
    into = "disturbances" if way == "F" else "inputs"
    claim = L2 | {"disturbance": into, "output": {"C": [[[1, 0]]], way: [[[0]], [[0]]]}}
    large = L2 | {"disturbance": into, "output": {"C": [[[1, 0]]], way: [[[0]], [[1000]]]}}

    assert said_of(model, None, claim).verdict is Verdict.PROVED
    assert said_of(model, None, large).verdict is Verdict.UNDECIDED


def test_gains_that_are_not_one_per_rule_are_paired_with_every_rule() -> None:
    """Three gains beside two rules have weights of their own: any may meet any."""
    model = differing_in("E")
    claim = {"name": "a", "kind": "decay", "P": ONE, "decay_rate": 0.1}

    assert said_of(model, law_data([SLOW, SLOW, FAST]), claim).verdict is Verdict.UNDECIDED
    assert "any of 3 gains" in said_of(model, law_data([SLOW, [[1, 0]], [[2, 0]]]), claim).text
