"""What excludes a common function: rules alone and blends that the weights take, never pairs."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict, certify
from takagi.models import TSModel
from tests.certificates.embedding.plants import CLAIM, one_state
from tests.certificates.kinds.claims import law_data, model_data, said_of, verdict_of

Data = dict[str, Any]
ALONE: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0, "P": [[-1]]}


def opposed(s: float) -> tuple[TSModel, list[list[list[float]]]]:
    """Return one state and two rules with G_11 = G_22 = -1 and G_12 + G_21 = s - 2.

    G(h) = -1 + s h_1 h_2: every blend falls exactly where s < 4, the mean of the pair where s < 2.
    """
    K = [[[0.0]], [[s]]]
    return TSModel([[[-1.0]], [[2 * s - 1]]], [[[1.0]], [[2.0]]]), K


def corner_model(s: float) -> tuple[Data, Data]:
    """Return ``opposed`` by the first of two premises; the second changes nothing."""
    one, K = opposed(s)
    twice = [0, 0, 1, 1]
    model = model_data(
        [one.A[i].tolist() for i in twice],
        B=[one.B[i].tolist() for i in twice],
        rules=[[0, 0], [0, 1], [1, 0], [1, 1]],
    )
    return model, law_data([K[i] for i in twice])


@pytest.mark.parametrize("s", [2.1, 3.0, 3.999])
def test_a_loop_whose_blends_all_fall_is_not_disproved(s: float) -> None:
    """V = x^2 falls along every blend, V' <= -(4 - s)/2 V, though the mean of the pair grows."""
    model, K = opposed(s)

    assert certify(model, K, decay_rate=0).verdict is not Verdict.DISPROVED
    assert certify(model, K).verdict is not Verdict.DISPROVED


def test_a_blend_that_grows_is_named() -> None:
    """Beyond s = 4 the middle of both rules is unstable; the text says which blend it is."""
    model, K = opposed(4.0)
    found = certify(model, K, decay_rate=0)

    assert found.verdict is Verdict.DISPROVED
    assert "none does along 1/2 rule 1 + 1/2 rule 2" in found.checked.claims[0].text


def test_a_blend_is_decided_at_its_threshold() -> None:
    """At h = (1/2, 1/2), and at (1/3, 2/3), where G = -1 + 2 s / 9."""
    for shares, edge in (([1, 1], 4), ([1, 2], 4.5), ([0.5, 1], 4.5)):
        claim = ALONE | {"blend": [shares]}
        for s, verdict in ((edge + 0.001, "DISPROVED"), (edge - 0.001, "UNDECIDED")):
            model, K = opposed(s)
            data = model_data(model.A.tolist(), B=model.B.tolist())
            assert verdict_of(data, law_data(K), claim) == verdict


def test_a_rule_alone_is_no_pair() -> None:
    """A number names a rule: the pair, which was number 1 once, is not a blend."""
    model, K = opposed(5.0)
    data, gains = model_data(model.A.tolist(), B=model.B.tolist()), law_data(K)

    assert verdict_of(data, gains, ALONE | {"blend": 0}) == "UNDECIDED"
    assert verdict_of(data, gains, ALONE | {"blend": 1}) == "UNDECIDED"
    with pytest.raises(CertificateError, match="0 to 1 is needed"):
        said_of(data, gains, ALONE | {"blend": 2})


def test_multipliers_stand_at_blends() -> None:
    """Z = 1 at the middle of the rules, and beside it at a rule alone: more of one than of both."""
    model, K = opposed(5.0)
    data, gains = model_data(model.A.tolist(), B=model.B.tolist()), law_data(K)
    claim: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0}
    middle, alone = {"blend": [[1, 1]], "factor": [[2]]}, {"blend": 0, "factor": [[1]]}

    # 4 (1/4) - 1 = 0, and 4 (1/4) - 2 < 0.
    assert verdict_of(data, gains, claim | {"multipliers": [middle, alone]}) == "DISPROVED"
    assert verdict_of(data, gains, claim | {"multipliers": [middle, alone, alone]}) == "UNDECIDED"
    text = said_of(data, gains, claim | {"multipliers": [middle, alone]}).text
    assert text.endswith("none does along 1/2 rule 1 + 1/2 rule 2, rule 1 alone")


def test_weights_of_products_are_those_of_each_premise() -> None:
    """h_i h_j of rules that differ in one premise is at most a quarter, of two a sixteenth."""
    claim = ALONE | {"blend": [[1, 1], [1, 3]]}

    assert verdict_of(*corner_model(4.001), claim) == "DISPROVED"
    assert verdict_of(*corner_model(3.999), claim) == "UNDECIDED"
    assert verdict_of(*corner_model(5.0), ALONE | {"blend": [[1, 0], [1, 1]]}) == "UNDECIDED"
    for wrong in ([[1, 1]], [[1, 1, 1], [1, 1]], [[0, 0], [1, 1]], [[-1, 2], [1, 1]], "x", []):
        with pytest.raises(CertificateError):
            said_of(*corner_model(5.0), ALONE | {"blend": wrong})


def test_rules_that_leave_out_a_corner_have_no_blend_of_it() -> None:
    """The weights at that corner would not sum to one."""
    model, gains = corner_model(5.0)
    short = model | {key: model[key][:3] for key in ("A", "B", "rules")}
    law = gains | {"K": gains["K"][:3]}

    for blend in ([[1, 1], [1, 1]], [[1, 0], [1, 1]]):
        with pytest.raises(CertificateError, match="not the corners"):
            said_of(short, law, ALONE | {"blend": blend})


def test_a_law_with_weights_of_its_own_excludes_nothing() -> None:
    """Which gain meets which rule is not known, so that even two equal numbers prove nothing."""
    model, K = opposed(5.0)
    data = model_data(model.A.tolist(), B=model.B.tolist())
    own = law_data(K, premises=[{"name": "z", "lower": 0, "upper": 1, "unit": "-"}])
    claim = ALONE | {"blend": [[1, 1]]}

    assert verdict_of(data, law_data(K), claim) == "DISPROVED"
    assert verdict_of(data, own, claim) == "UNDECIDED"
    # One gain for all rules meets every rule.
    assert verdict_of(data | {"A": [[[1]], [[2]]]}, own | {"K": [[[0]]]}, claim) == "DISPROVED"


def test_a_model_with_inputs_and_no_law_is_its_own_loop() -> None:
    """x' = x + u is x' = x where nothing is fed back."""
    claim = ALONE | {"blend": [[1]]}

    assert verdict_of(model_data([[[1]]], B=[[[1]]]), None, claim) == "DISPROVED"
    assert verdict_of(model_data([[[-1]]], B=[[[1]]]), None, claim) == "UNDECIDED"


@pytest.mark.parametrize(("growth", "verdict"), [("1/3", "DISPROVED"), ("1/pi", "UNDECIDED")])
def test_a_number_that_is_no_fraction_leaves_it_open(growth: str, verdict: str) -> None:
    """x' = c x grows at both ends of the bounds of c, but ends alone say nothing of c between."""
    model = one_state(f"x*{growth}", "1", 1, 1)
    number = {"name": "c", "expression": growth, "lower": "0.3", "upper": "0.4"}
    in_bounds = {"numbers": [number], "A": [["c"]]} if verdict == "UNDECIDED" else {"A": [["1/3"]]}
    model["embedding"] |= {"premises": []} | in_bounds

    assert verdict_of(model, None, CLAIM) == "PROVED"
    assert verdict_of(model, None, CLAIM, ALONE | {"blend": 0}) == verdict


@pytest.mark.parametrize(
    ("rules", "words"),
    [(1, "rule 1 alone"), (2, "1/2 rule 1 + 1/2 rule 2"), (4, "1/4 rule 4"), (5, "of 5 rules")],
)
def test_a_blend_of_many_rules_is_counted(rules: int, words: str) -> None:
    """x' = x at each of six rules; blends of more than four are not written out."""
    shares = [int(k < rules) for k in range(6)]

    found = said_of(model_data([[[1]]] * 6), None, ALONE | {"blend": [shares]})
    assert found.verdict is Verdict.DISPROVED
    assert found.text.endswith(words)
