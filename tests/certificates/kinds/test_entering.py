"""Norms from some of the disturbances, the others at rest: exact thresholds and false claims.

x' = -2 x + w1/5 + 3 w2, y = x: from one disturbance with the entry e the energy gain and the peak
are e/2, and the variance of y under white noise is e^2/4; from both, e is their Euclidean norm.
"""

from __future__ import annotations

from typing import Any

import pytest

from tests.certificates.kinds.claims import model_data, said_of, verdict_of

Data = dict[str, Any]
NAMES = ["w1 [N]", "w2 [m/s]"]
GAIN = {"kind": "l2-gain"}
NOISE = {"kind": "h2-norm"}
PEAK = {"kind": "peak", "disturbance_norm": 1, "multiplier": 2}


def plant(**others: Any) -> Data:
    return model_data([[[-2]]], E=[[[0.2, 3]]], C=[[[1]]], disturbance_names=NAMES, **others)


def claims(entry: float, **members: Any) -> list[Data]:
    """Return the three norms for an entry e, each 1e-9 above its true value at most."""
    base = {"name": "norm", "disturbance": "disturbances", **members}
    norm = entry / 2 * (1 + 1e-9)
    return [
        base | GAIN | {"gain": norm, "P": [[1 / entry]]},
        base | NOISE | {"norm": norm, "P": [[0.2500000001]]},
        base | PEAK | {"gain": norm, "level": entry**2 / 4 * (1 + 1e-9), "P": [[1]]},
    ]


@pytest.mark.parametrize("number", range(3))
def test_each_disturbance_alone_from_both_sides(number: int) -> None:
    """The norm of a named disturbance is proved, and is none of the other, nor of both."""
    for name, entry in zip(NAMES, (0.2, 3.0), strict=True):
        claim = claims(entry, entering=[name])[number]

        assert verdict_of(plant(), None, claim) == "PROVED"
        less = {k: 0.999 * claim[k] for k in ("gain", "norm") if k in claim}
        assert verdict_of(plant(), None, claim | less) == "UNDECIDED"
        assert verdict_of(plant(), None, {k: v for k, v in claim.items() if k != "entering"}) == (
            "UNDECIDED"
        )
    weak = claims(0.2, entering=[NAMES[1]])[number]
    assert verdict_of(plant(), None, weak) == "UNDECIDED"


@pytest.mark.parametrize("number", range(3))
def test_all_by_name_are_all_in_any_order(number: int) -> None:
    for members in ({}, {"entering": NAMES}, {"entering": NAMES[::-1]}):
        claim = claims((0.04 + 9) ** 0.5, **members)[number]
        assert verdict_of(plant(), None, claim) == "PROVED"


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize(
    "entering", [[], ["w3 [N]"], ["w1"], [NAMES[0], NAMES[0]], [0], NAMES[0], None, [[NAMES[0]]]]
)
def test_names_that_are_none_are_refused(number: int, entering: Any) -> None:
    claim = claims(0.2, entering=entering)[number]

    assert verdict_of(plant(), None, claim) == "REFUSED"


@pytest.mark.parametrize("number", range(3))
def test_inputs_have_no_names_there(number: int) -> None:
    claim = claims(0.2, entering=NAMES[:1])[number] | {"disturbance": "inputs"}

    assert verdict_of(plant(B=[[[0.2]]]), None, claim) == "REFUSED"


def test_a_peak_keeps_the_range_of_the_disturbance_that_it_names() -> None:
    """|w2| <= 1 is more than its range of 1/2; beside w1 with |w1| <= 1 the other is at rest."""
    other_box = {NAMES[0]: [-1, 1], NAMES[1]: [-0.5, 0.5]}
    model = plant(box=other_box)

    assert verdict_of(model, None, claims(0.2, entering=NAMES[:1])[2]) == "PROVED"
    assert verdict_of(model, None, claims(3.0, entering=NAMES[1:])[2]) == "UNDECIDED"


def test_the_sentence_says_what_is_at_rest() -> None:
    for claim in claims(0.2, entering=NAMES[:1]):
        said = said_of(plant(), None, claim)
        assert "the model's disturbance w1 [N], the others at rest" in said.text


def test_discrete_time_from_both_sides() -> None:
    """x+ = x/2 + w1/5 + 3 w2: the energy gain is 2 e, at frequency 0, with P = 1/e at its edge."""
    model = {**plant(sample_time=1), "A": [[[0.5]]]}
    for entry, names in ((0.2, NAMES[:1]), ((0.04 + 9) ** 0.5, NAMES)):
        claim = claims(entry, entering=names)[0] | {"P": [[1 / entry]]}

        assert verdict_of(model, None, claim | {"gain": 2 * entry * (1 + 1e-6)}) == "PROVED"
        assert verdict_of(model, None, claim | {"gain": 2 * entry * (1 - 1e-6)}) == "UNDECIDED"


def test_what_the_input_adds_to_the_output() -> None:
    """x' = -2 x + w/5, y = x + w: the energy gain is 1 + 1/10, with P = 5 at its edge."""
    model = plant(B=[[[0.2]]], D=[[[1]]])
    claim = {"name": "norm", "disturbance": "inputs", "kind": "l2-gain", "P": [[5]]}

    assert verdict_of(model, None, claim | {"gain": 1.1 * (1 + 1e-6)}) == "PROVED"
    assert verdict_of(model, None, claim | {"gain": 1.1 * (1 - 1e-6)}) == "UNDECIDED"


@pytest.mark.parametrize("output", [{"C": [[[1, 0]]]}, {"C": [[[1]], [[1]]]}, {"F": [[[1]]]}])
def test_an_output_of_another_shape_is_refused(output: Data) -> None:
    """One state, and one of two disturbances: C is 1 by 1, one matrix, and F 1 by 1 for it."""
    claim = claims(3.0, entering=NAMES, output={"C": [[[1]]], **output})[0]

    assert verdict_of(plant(), None, claim) == "REFUSED"
