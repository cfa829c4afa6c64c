"""The loop of a claim: every rule counts, names agree, and too much work is refused."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.checker.kernel.reader import MOST_CLAIMS
from takagi.certificates.checker.loop.polytopic_loop import bounded
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.kinds.claims import Data, law_data, model_data, said_of, verdict_of

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

    assert verdict_of(model, law_data([SLOW, SLOW]), claim) == "PROVED"
    assert verdict_of(model, law_data([SLOW, FAST]), claim) == "UNDECIDED"


@pytest.mark.parametrize("way", ["F", "D"])
def test_second_output_of_the_claim_is_not_left_out(way: str) -> None:
    """With y = x1 + 1000 w in the second rule the gain is at least 1000."""
    model = differing_in("C")
    into = "disturbances" if way == "F" else "inputs"
    claim = L2 | {"disturbance": into, "output": {"C": [[[1, 0]]], way: [[[0]], [[0]]]}}
    large = L2 | {"disturbance": into, "output": {"C": [[[1, 0]]], way: [[[0]], [[1000]]]}}

    assert verdict_of(model, None, claim) == "PROVED"
    assert verdict_of(model, None, large) == "UNDECIDED"


def test_gains_that_are_not_one_per_rule_are_paired_with_every_rule() -> None:
    """Three gains beside two rules have weights of their own: any may meet any."""
    model = differing_in("E")
    claim = {"name": "a", "kind": "decay", "P": ONE, "decay_rate": 0.1}

    assert verdict_of(model, law_data([SLOW, SLOW, FAST]), claim) == "UNDECIDED"
    assert "any of 3 gains" in said_of(model, law_data([SLOW, [[1, 0]], [[2, 0]]]), claim).text


DECAY = {"name": "a", "kind": "decay", "decay_rate": 0.5, "P": [[1, 0], [0, 1]]}
# The first input drives x1 and the second x2, each with its own gain.
MODEL = model_data([[[1, 0], [0, 1]]], B=[[[1, 0], [0, 1]]], input_names=["u [-]", "v [-]"])
K = [[[2, 0], [0, 2]]]


def test_inputs_in_another_order_are_refused() -> None:
    """The same numbers with the rows' names exchanged are another law."""
    assert verdict_of(MODEL, law_data(K, input_names=["u [-]", "v [-]"]), DECAY) == "PROVED"
    with pytest.raises(CertificateError, match="inputs are not the model's"):
        said_of(MODEL, law_data(K, input_names=["v [-]", "u [-]"]), DECAY)


def test_number_of_input_names_is_compared() -> None:
    with pytest.raises(CertificateError, match="2 different names"):
        said_of(MODEL, law_data(K, input_names=["u [-]"]), DECAY)


def test_box_that_may_mean_a_state_or_an_input_shows_nothing() -> None:
    """With |u| <= 0.1 the ellipsoid asks for too much; as a range of x1 it would be kept."""
    model = model_data([[[-1]]], B=[[[1]]], box={"x1 [-]": [-2, 2]})
    claim = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}

    named = model | {"input_names": ["x1 [-]"]}
    assert verdict_of(model, law_data([[[3]]]), claim) == "PROVED"
    assert "have one name" in said_of(named, law_data([[[3]]]), claim).text
    assert verdict_of(named, law_data([[[3]]]), claim) == "UNDECIDED"
    assert verdict_of(named, law_data([[[3]]]), claim) == "UNDECIDED"


@pytest.mark.parametrize(("gain", "expected"), [(1.0, "PROVED"), (1.01, "UNDECIDED")])
def test_range_of_an_input_that_the_law_alone_names(gain: float, expected: str) -> None:
    """u = -K x with |x| <= 1 keeps |u| <= 1 up to K = 1, whoever says that the input is u."""
    model = model_data([[[-1]]], B=[[[1]]], box={"x1 [-]": [-1, 1], "u [-]": [-1, 1]})
    gains = law_data([[[gain]]], input_names=["u [-]"])
    claim = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}

    assert verdict_of(model, gains, claim) == expected
    assert verdict_of(model | {"input_names": ["u [-]"]}, gains, claim) == expected


@pytest.mark.parametrize(("name", "expected"), [("w [-]", "PROVED"), ("x1 [-]", "UNDECIDED")])
def test_box_that_may_mean_a_state_or_a_disturbance(name: str, expected: str) -> None:
    """|x1| <= 1 is kept for |w| <= 10, and |w| <= 1 is not."""
    model = model_data([[[-11]]], E=[[[1]]], box={"x1 [-]": [-1, 1]}, disturbance_names=[name])
    claim = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 10}
    claim |= {"disturbance": "disturbances", "disturbance_bounds": [10]}

    assert verdict_of(model, None, claim) == expected


def unit(size: int, factor: int = 1) -> list[list[int]]:
    return [[factor * (i == j) for j in range(size)] for i in range(size)]


def test_limit_of_work_has_two_sides() -> None:
    bounded(10**4, 10)
    with pytest.raises(CertificateError, match="too many"):
        bounded(10**4 + 1, 10)


def test_more_claims_than_a_chain_has_are_refused() -> None:
    claim = {"name": "a", "kind": "decay", "P": [[1]], "decay_rate": 0}
    model = model_data([[[-1]]])
    most, more = (
        certificate_document(model=model, gains=None, claims=[claim] * count, provenance={})
        for count in (MOST_CLAIMS, MOST_CLAIMS + 1)
    )

    assert len(check_document(most).claims) == MOST_CLAIMS
    with pytest.raises(CertificateError, match="claims"):
        check_document(more)


def test_polynomial_of_many_terms_is_refused_before_it_is_made() -> None:
    """Two hundred rules, raised eight times: more than 10^15 terms."""
    r = 200
    model = model_data([[[-1]]] * r)
    powers = [[int(i == j) for j in range(r)] for i in range(r)]
    P = [{"powers": [row], "matrix": [[1]]} for row in powers]
    claim = {"name": "a", "kind": "fuzzy-decay", "decay_rate": 0, "degrees": [1], "P": P}

    with pytest.raises(CertificateError, match="terms"):
        said_of(model, None, claim | {"polya": 8, "rates": [[1] * r]})


WIDE: list[tuple[str, Data]] = [
    ("l2-gain", {"gain": 1000, "disturbance": "disturbances"}),
    ("h2-norm", {"norm": 1000, "disturbance": "disturbances"}),
    ("peak", {"gain": 1, "disturbance": "disturbances", "disturbance_norm": 1}),
]


@pytest.mark.parametrize(("kind", "others"), WIDE)
def test_many_disturbances_count_as_order(kind: str, others: Data) -> None:
    """Four rules of one state with eighty disturbances have matrices of eighty-one rows."""
    model = model_data([[[-1]], [[-2]], [[-3]], [[-4]]], E=[[[1] * 80]], C=[[[1]]])
    claim = {"name": "a", "kind": kind, "P": [[1]], "level": 1, "multiplier": 1, **others}

    with pytest.raises(CertificateError, match="order 81"):
        said_of(model, None, claim)


def test_parts_of_a_region_and_the_error_of_an_observer_count_as_order() -> None:
    part = {"L": unit(4, -1), "M": unit(4)}
    region = {"name": "a", "kind": "region", "P": unit(40), "parts": [part]}
    with pytest.raises(CertificateError, match="order 160"):
        said_of(model_data([unit(40, -1)]), None, region)

    model = model_data([unit(60, -1)], B=[[[0]] * 60], C=[[[0] * 60]])
    claim = {"name": "a", "kind": "observed-feedback", "decay_rate": 0, "P": [[1] * 80] * 80}
    with pytest.raises(CertificateError, match="120"):
        said_of(model, law_data([[[0] * 60]]), claim | {"L": [[[0]] * 60]})


def test_more_multipliers_than_a_reader_waits_for_are_refused() -> None:
    claim: Data = {"name": "a", "kind": "no-common-decay", "decay_rate": 0}
    one = {"blend": 0, "factor": [[1]] * 80}
    model = model_data([unit(80, 1)])

    with pytest.raises(CertificateError, match="a list"):
        said_of(model, None, claim | {"multipliers": []})
    with pytest.raises(CertificateError, match="3 inequalities of order 80"):
        said_of(model, None, claim | {"multipliers": [one] * 3})


DECAY_OF_LAW: Data = {"name": "V", "kind": "decay", "decay_rate": 1, "P": [[1, 0], [0, 1]]}
MODEL_OF_LAW = model_data([[[-2, 0], [0, -2]]], B=[[[0], [1]]], input_names=["u [N]"])
LAW = law_data([[[0, 0]]], input_names=["u [N]"])


def test_the_law_of_the_model() -> None:
    assert verdict_of(MODEL_OF_LAW, LAW, DECAY_OF_LAW) == "PROVED"


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"sample_time": 0.1}, "sample_time is not the model's"),
        ({"state_names": ["x2 [-]", "x1 [-]"]}, "in its order"),
        ({"state_names": ["x1 [-]", "x1 [-]"]}, "2 different names"),
        ({"state_names": ["x1 [-]"]}, "2 different names"),
        ({"state_names": ["x1 [-]", "x2 [-]", "x3 [-]"]}, "2 different names"),
        ({"state_names": "x1 [-]"}, "2 different names"),
        ({"input_names": ["F [N]"]}, "in its order"),
        ({"input_names": []}, "1 different names"),
        ({"K": []}, "a list of matrices"),
        ({"K": {"0": [[0, 0]]}}, "a list of matrices"),
        ({"K": [[[0]]]}, "1 by 2"),
    ],
)
def test_another_law_is_refused(part: Data, words: str) -> None:
    with pytest.raises(CertificateError, match=words):
        said_of(MODEL_OF_LAW, LAW | part, DECAY_OF_LAW)


@pytest.mark.parametrize("A", [[], {"0": [[-2]]}, "[[-2]]", None])
def test_a_model_without_a_list_of_matrices_is_refused(A: Any) -> None:
    model = model_data([[[-2]]]) | {"A": A}

    with pytest.raises(CertificateError, match="a list of matrices"):
        said_of(model, None, DECAY_OF_LAW | {"P": [[1]]})


def test_cross_terms_of_outputs_and_gains_count() -> None:
    """y = x - D_i K_j x is 0 in each rule with its own gain, and 2 x in each with the other's.

    Half and half y = x, so that no gain below 2 is shown by these conditions; the inputs are equal,
    and the loop itself is affine in the weights.
    """
    model = model_data([[[-1]]], B=[[[0]]], E=[[[1]]], C=[[[1]]], D=[[[1]], [[-1]]])
    gains = law_data([[[1]], [[-1]]])
    claim = {"name": "y", "kind": "l2-gain", "disturbance": "disturbances", "P": [[2]]}

    below = said_of(model, gains, claim | {"gain": 1.9})
    assert below.verdict is Verdict.UNDECIDED
    assert "rules 1 and 2" in below.text
    assert verdict_of(model, gains, claim | {"gain": 2.1}) == "PROVED"


@pytest.mark.parametrize(("bound", "expected"), [(1.41, Verdict.PROVED), (1.42, Verdict.UNDECIDED)])
def test_energy_that_keeps_the_state_in_its_box(bound: float, expected: Verdict) -> None:
    """x^2 <= gain bound^2 = 1 with gain 1/2: the bound is the root of two, 1.4142."""
    model = model_data([[[-2.1]]], E=[[[1]]], C=[[[1]]], box={"x1 [-]": [-1, 1]})
    claim = {"name": "y", "kind": "l2-gain", "disturbance": "disturbances", "P": [[1]]}

    found = said_of(model, None, claim | {"gain": 0.5, "energy_bound": bound})

    assert found.verdict is expected, found.text


A = [[[-2]], [[-4]]]
# Of two premises without ranges the first never changes its end: the lower one, or the upper one.
AT_LOWER, AT_UPPER = [[0, 0], [0, 1]], [[1, 0], [1, 1]]
HALVED: Data = {"halvings": [[1, 0, 1], [], []]}
DECAY_OF_ONE: Data = {"name": "x", "kind": "decay", "decay_rate": 0, "P": [[1]]}
IMPOSSIBLE: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0}


def scheduled(powers: list[list[int]]) -> Data:
    """Return a claim about a function of the weights that is the same for all of them."""
    listed = [{"powers": powers, "matrix": [[1]]}]
    base = {"name": "x", "kind": "fuzzy-decay", "decay_rate": 0, "polya": 0}
    return base | {"degrees": [0, 0], "P": listed, "rates": [None, None]}


def multiplied(blend: list[list[int]]) -> Data:
    return IMPOSSIBLE | {"multipliers": [{"blend": blend, "matrix": [[1]]}]}


@pytest.mark.parametrize(
    ("rules", "claim"),
    [
        (AT_LOWER, DECAY_OF_ONE | HALVED),
        (AT_UPPER, DECAY_OF_ONE | HALVED),
        (AT_LOWER, scheduled([[0], [0, 0]]) | HALVED),
        (AT_UPPER, scheduled([[0, 0], [0, 0]])),
        (AT_LOWER, multiplied([[0, 1], [1, 0]])),
    ],
)
def test_a_corner_that_there_is_not_is_refused(rules: list[list[int]], claim: Data) -> None:
    """Though the model itself has all its corners."""
    model = model_data(A, rules=rules)

    assert verdict_of(model, None, DECAY_OF_ONE) == "PROVED"
    with pytest.raises(CertificateError, match="leave out"):
        said_of(model, None, claim)


W = {"disturbance": "disturbances"}
SET = {"level": 1, "multiplier": 0.5}
GROWING: dict[str, Data] = {
    "l2-gain": {**W, "gain": 10},
    "h2-norm": {**W, "norm": 1},
    "peak": {**W, **SET, "disturbance_norm": 1, "gain": 10},
    "invariant-ellipsoid": SET,
    "input-limits": {**SET, "input_limits": [9]},
    "transient": {
        "decay_rate": 0.1,
        "scales": [1],
        "lower": 1,
        "overshoot": 2,
        "settled_share": 0.5,
        "settling_time": 90,
    },
    "observer": {"L": [[[1]]], "decay_rate": 0},
}


@pytest.mark.parametrize("kind", GROWING)
@pytest.mark.parametrize("step", [None, 1])
@pytest.mark.parametrize("p", [-1, 0, 1])
def test_growth_is_never_proved(kind: str, step: Any, p: int) -> None:
    """x' = 2 x + w and x+ = 2 x + w grow; u = -0 x and L = 1 leave 2 or 1 and more of it."""
    model = model_data([[[2]]], B=[[[1]]], C=[[[0.9]]], E=[[[1]]], sample_time=step)
    claim = {"name": "growing", "kind": kind, "P": [[p]], **GROWING[kind]}

    found = said_of(model, law_data([[[0]]], sample_time=step), claim)

    assert found.verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("step", [None, 1])
def test_growth_with_an_observer_is_never_proved(step: Any) -> None:
    model = model_data([[[2]]], B=[[[1]]], C=[[[0.9]]], sample_time=step)
    claim = {"name": "g", "kind": "observed-feedback", "L": [[[0]]], "decay_rate": 0}

    for P in ([[-1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, -1]]):
        found = said_of(model, law_data([[[0]]], sample_time=step), claim | {"P": P})
        assert found.verdict is Verdict.UNDECIDED


def test_symmetry_is_needed() -> None:
    model = model_data([[[-1, 0], [0, -1]]], B=[[[1], [0]]], C=[[[1, 0]]], E=[[[1], [0]]])
    changed = {"scales": [1, 1], "L": [[[1], [0]]]}

    for kind, evidence in GROWING.items():
        own = {key: changed.get(key, value) for key, value in evidence.items()}
        claim = {"name": "s", "kind": kind, "P": [[1, 0.1], [0, 1]], **own}
        found = said_of(model, law_data([[[0, 0]]]), claim)
        assert found.verdict is Verdict.UNDECIDED
