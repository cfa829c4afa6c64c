"""Functions that are scheduled by the weights: scalar thresholds, and pairs that need them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.requests import Decay, FuzzyDecay
from takagi.models import Premise, TSModel
from tests.certificates.kinds.claims import law_data, model_data, said_of, verdict_of

Data = dict[str, Any]


def scalar(p1: float, p2: float, **others: Any) -> Data:
    """Return the claim with P(h) = p1 h1 + p2 h2."""
    P = [{"powers": [[1, 0]], "matrix": [[p1]]}, {"powers": [[0, 1]], "matrix": [[p2]]}]
    claim = {"name": "x", "kind": "fuzzy-decay", "decay_rate": 0, "degrees": [1], "P": P}
    return claim | {"polya": 0, "rates": [[1, 1]]} | others


def test_rates_are_proved_up_to_their_limit() -> None:
    """x' = -x with P = h1 + 2 h2: -V' = (2 (h1 + 2 h2) - h2') x^2 > 0 for all h iff |h2'| < 2."""
    model = model_data([[[-1]], [[-1]]])

    below, at = [[1.999999999, 1.999999999]], [[2, 2]]
    assert verdict_of(model, None, scalar(1, 2, rates=below)) == "PROVED"
    assert verdict_of(model, None, scalar(1, 2, rates=at)) == "UNDECIDED"
    # One bound alone keeps the other, for h1' = -h2'.
    assert verdict_of(model, None, scalar(1, 2, rates=[[100, 1.9]])) == "PROVED"


def test_rates_and_decay_share_the_margin() -> None:
    """2 (1 - alpha) > 2: at rate 0 the decay rate may be as large as 1, at rates 1 half of it."""
    model = model_data([[[-1]], [[-1]]])

    for rate, alpha in ((0, 1.0), (1, 0.5)):
        claim = scalar(1, 2, rates=[[rate, rate]])
        below = claim | {"decay_rate": alpha - 1e-9}
        assert verdict_of(model, None, below) == "PROVED"
        assert verdict_of(model, None, claim | {"decay_rate": alpha}) == "UNDECIDED"


def test_jumps_in_discrete_time_cost_the_ratio_of_both_functions() -> None:
    """x+ = a x: P(h) > a^2 P(h+) for all h, h+ iff 1 > 4 a^2, with P1 = 1 and P2 = 4."""
    claim = scalar(1, 4)
    del claim["rates"]

    for a, verdict in ((0.499999, Verdict.PROVED), (0.5, Verdict.UNDECIDED)):
        model = model_data([[[a]], [[a]]], sample_time=1)
        assert verdict_of(model, None, claim) == verdict.name


@pytest.mark.parametrize(
    "change",
    [
        {"P": [{"powers": [[1, 0]], "matrix": [[-1]]}, {"powers": [[0, 1]], "matrix": [[2]]}]},
        {"decay_rate": 1},
        {"decay_rate": -1},
        {"rates": [[9, 9]]},
    ],
    ids=str,
)
def test_what_is_false_is_not_proved(change: Data) -> None:
    """A negative P, a faster decay, faster weights: never PROVED."""
    model = model_data([[[-1]], [[-1]]])
    assert verdict_of(model, None, scalar(1, 2)) == "PROVED"

    assert verdict_of(model, None, scalar(1, 2) | change) == "UNDECIDED"


@pytest.mark.parametrize(
    "change",
    [
        {"rates": [None]},
        {"rates": [[1]]},
        {"rates": [[-1, 1]]},
        {"rates": []},
        {"degrees": [2]},
        {"degrees": [0.5]},
        {"degrees": [0.5], "P": [{"powers": [[0, 0]], "matrix": [[1]]}]},
        {"degrees": [9]},
        {"degrees": [1, 1]},
        {"polya": 9},
        {"polya": -1},
        {"P": []},
        {"P": [{"powers": [[1, 0]], "matrix": [[1]]}] * 2},
        {"P": [{"powers": [[1, 0], [0, 1]], "matrix": [[1]]}] * 2},
        {"P": [{"powers": "1", "matrix": [[1]]}] * 2},
        {"P": [{"powers": [[1, 0.5]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[1]]}]},
        {"P": [{"powers": [[2, -1]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[1]]}]},
        {"P": [{"powers": [[1, 0]], "matrix": [[1]]}, {"powers": [[0, 1]], "matrix": [[1, 2]]}]},
    ],
    ids=lambda change: str(change)[:40],
)
def test_what_does_not_fit_is_refused(change: Data) -> None:
    """Degrees, exponents and rates that fit no polynomial raise CertificateError, nothing else."""
    with pytest.raises(CertificateError):
        said_of(model_data([[[-1]], [[-1]]]), None, scalar(1, 2) | change)


@pytest.mark.parametrize(("degree", "verdict"), [(8, "PROVED"), (9, "REFUSED")])
def test_the_highest_degree(degree: int, verdict: str) -> None:
    """P = 1 as a polynomial of that degree, all of whose coefficients are 1, at any rates."""
    P = [{"powers": [[k, degree - k]], "matrix": [[1]]} for k in range(degree + 1)]
    claim = scalar(1, 1, degrees=[degree], P=P, rates=[[1000, 1000]])

    assert verdict_of(model_data([[[-1]], [[-1]]]), None, claim) == verdict


@pytest.mark.parametrize("degrees", [[1, 0], [1, 0.5], [0.5, 0]])
def test_the_degree_of_every_simplex_is_whole(degrees: list[float]) -> None:
    model = model_data([[[-1]]] * 4, rules=[[0, 0], [0, 1], [1, 0], [1, 1]])
    P = [{"powers": [row, [0, 0]], "matrix": [[1]]} for row in ([1, 0], [0, 1])]
    claim = scalar(1, 1, degrees=degrees, P=P, rates=[[1, 1], None])

    assert verdict_of(model, None, claim) == ("PROVED" if degrees == [1, 0] else "REFUSED")


@pytest.mark.parametrize(
    ("limit", "value", "words"),
    [
        ("fuzzy_decay.MOST_CORNERS", 1, "2 corners; at most 1"),
        ("fuzzy_decay.MOST_CORNERS", 0, "a simplex of 2 corners is too large"),
        ("fuzzy_decay.MOST_WORK", 1, "too many rules, corners of rates"),
        ("simplex_polynomial.MOST_TERMS", 1, "a polynomial of 2 terms; at most 1"),
        ("simplex_polynomial.MOST_PRODUCTS", 3, "a product of 2 by 2 terms"),
        ("simplex_polynomial.MOST_WORK", 3, "a product of 2 by 2 terms"),
    ],
)
def test_more_work_than_a_reader_waits_for_is_refused(
    limit: str, value: int, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """x' = (-1 and -2) x by two functions: four products, two terms, two corners."""
    model = model_data([[[-1]], [[-2]]])
    assert said_of(model, None, scalar(1, 2)).verdict is Verdict.PROVED

    monkeypatch.setattr(f"takagi.certificates.checker.kinds.{limit}", value)
    try:
        said = said_of(model, None, scalar(1, 2)).text
    except CertificateError as refused:
        said = str(refused)
    assert words in said


def test_a_law_with_weights_of_its_own_is_refused() -> None:
    """P(h) is a function of one set of weights."""
    model = model_data([[[-1]], [[-1]]], B=[[[1]], [[2]]])
    own = [{"name": "z", "lower": 0, "upper": 1}]
    gains = law_data([[[0]], [[1]]], premises=own)

    with pytest.raises(CertificateError, match="weights of its own"):
        said_of(model, gains, scalar(1, 2))


def pair(a: float) -> list[list[list[float]]]:
    """Return Dayawansa and Martin's pair."""
    return [[[-1, -1], [1, -1]], [[-1, -a], [1 / a, -1]]]


def test_slow_weights_are_proved_where_no_common_function_exists() -> None:
    """Dayawansa & Martin (1999): none for a >= 3 + sqrt(8); every blend is stable by itself."""
    model = TSModel(pair(7.0), name="pair")

    assert certify(model, claims=[Decay(0.0)]).verdict is Verdict.DISPROVED
    slow = certify(model, claims=[FuzzyDecay(rate_bounds=0.05)])
    assert slow.verdict is Verdict.PROVED
    assert certify(model, claims=[FuzzyDecay(rate_bounds=1e3)]).verdict is Verdict.UNDECIDED


def test_premises_with_gains_and_rates_in_their_unit() -> None:
    """Two premises, a paired loop; one premise moves as it likes, so P does not depend on it."""
    premises = [Premise("a", "-1", "1"), Premise("b", "0", "2")]
    A = [[[0.0, 1.0], [a, -1.0]] for a in (-2.0, -1.5, -1.0, -0.5)]
    B = [[[0.0], [b]] for b in (1.0, 1.5, 1.0, 1.5)]
    K = [[[1.0, 1.0]], [[1.2, 1.0]], [[1.5, 1.1]], [[2.0, 1.0]]]
    model = TSModel(A, B, premises=premises)
    rates = {"a": 0.5, "b": np.inf}

    found = certify(model, K, claims=[FuzzyDecay(rate_bounds=rates, decay_rate=0.2)])

    assert found.verdict is Verdict.PROVED
    claim = found.document["claims"][0]
    assert claim["degrees"] == [1, 0]
    # |a'| <= 0.5 over a width of 2.
    assert claim["rates"] == [[0.25, 0.25], None]


def test_a_sampled_pair_needs_two_functions() -> None:
    """ROLMIP manual, section 7.1, at half size: one P(h) serves jumps of the weights."""
    pair = 0.8 * np.array([[[0.1, 0.9], [0.0, 0.1]], [[0.5, 0.0], [1.0, 0.5]]])
    model = TSModel(pair, sample_time=1.0)

    assert certify(model, claims=[FuzzyDecay()]).verdict is Verdict.PROVED


HALF: list[list[int]] = [[0, 0, 1], [], []]
QUARTERS: list[list[int]] = [[0, 0, 1], *HALF, *HALF]


def opposed(s: float) -> tuple[Data, Data]:
    """Return one state with G(h) = -1 + s h_1 h_2: every blend falls exactly where s < 4."""
    return model_data([[[-1]], [[2 * s - 1]]], B=[[[1]], [[2]]]), law_data([[[0]], [[s]]])


@pytest.mark.parametrize(
    ("s", "polya", "halvings", "verdict"),
    [
        (2.999, 1, None, "PROVED"),
        (3.001, 1, None, "UNDECIDED"),
        (3.9, 8, None, "UNDECIDED"),
        (3.9, 0, HALF, "PROVED"),
        (3.999, 0, HALF, "PROVED"),
        (3.999, 0, QUARTERS, "PROVED"),
        (4.0, 0, QUARTERS, "UNDECIDED"),
        (4.001, 8, QUARTERS, "UNDECIDED"),
    ],
)
def test_pieces_reach_the_limit_where_degrees_do_not(
    s: float, polya: int, halvings: Any, verdict: str
) -> None:
    """P = 1 as h_1 + h_2: (h_1 + h_2)^3 less s h_1 h_2 (h_1 + h_2) has no negative term to s = 3.

    In the halves of the weights it is a square beyond: h_1 h_2 is 1/4 at most, in the middle.
    """
    more = {} if halvings is None else {"halvings": halvings}

    assert verdict_of(*opposed(s), scalar(1, 1, polya=polya, **more)) == verdict


def test_rates_on_pieces_have_the_same_limit() -> None:
    """x' = -x, P = h1 + 2 h2: |h2'| < 2 on any pieces, for P and V' are of degree 1 there too."""
    model = model_data([[[-1]], [[-1]]])

    for rate, verdict in ((1.999999, "PROVED"), (2, "UNDECIDED")):
        claim = scalar(1, 2, rates=[[rate, rate]], halvings=QUARTERS)
        assert verdict_of(model, None, claim) == verdict


def test_jumps_between_pieces_count() -> None:
    """x+ = a x, P1 = 1, P2 = 4: the next weights are any, not those of the piece: a < 1/2."""
    claim = scalar(1, 4, halvings=QUARTERS)
    del claim["rates"]

    for a, verdict in ((0.499999, "PROVED"), (0.5, "UNDECIDED")):
        assert verdict_of(model_data([[[a]], [[a]]], sample_time=1), None, claim) == verdict


@pytest.mark.parametrize(
    "halvings", [[], "x", None, [[0, 0, 1]], [[], []], [[0, 0, 2], [], []], [[1, 0, 1], [], []]]
)
def test_a_tree_that_is_none_is_refused(halvings: Any) -> None:
    """Though every inequality holds."""
    model, gains = opposed(1.5)
    claim = scalar(1, 1, halvings=halvings)

    with pytest.raises(CertificateError):
        said_of(model, gains, claim)


def test_a_function_that_needs_pieces_is_found() -> None:
    """Blends of Tanaka, Ohtake and Wang (2007), a = 10, b = 1.9, |dh/dt| <= 1; no degree shows it.

    The gains are those of ``fuzzy_pdc(model, rate_bounds=1.0, relaxation="liu-zhang")``, rounded.
    """
    model = TSModel(
        [[[3.6, -1.6], [6.2, -4.3]], [[-10.0, -1.6], [6.2, -4.3]]],
        [[[-0.45], [-3.0]], [[-1.9], [-3.0]]],
    )
    K = [[[27.637, -8.683]], [[-14.7, 0.257]]]
    found = certify(model, K, claims=[FuzzyDecay(rate_bounds=1.0)])
    claim = found.document["claims"][0]

    assert found.verdict is Verdict.PROVED
    assert (claim["kind"], claim["degrees"], claim["rates"]) == ("fuzzy-decay", [1], [[1, 1]])
    assert claim["halvings"].count([]) > 1
    assert certify(model, K, claims=[FuzzyDecay(rate_bounds=50.0)]).verdict is Verdict.UNDECIDED


def test_premises_have_their_own_pieces() -> None:
    """``opposed`` by each of two premises, s = 3.9: both ranges are halved."""
    premises = [Premise("a", 0, 1), Premise("b", 0, 1)]
    corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
    a, b, k = (-1.0, 6.8), (1.0, 2.0), (0.0, 3.9)
    model = TSModel(
        [np.diag([a[p], a[q]]) for p, q in corners],
        [np.diag([b[p], b[q]]) for p, q in corners],
        premises=premises,
    )
    gains = [np.diag([k[p], k[q]]) for p, q in corners]

    found = certify(model, gains, claims=[FuzzyDecay(rate_bounds=0.01)])
    claim = found.document["claims"][0]

    assert found.verdict is Verdict.PROVED
    assert claim["kind"] == "fuzzy-decay"
    assert {entry[0] for entry in claim["halvings"] if entry} == {0, 1}


@pytest.mark.parametrize(
    ("sample_time", "halvings", "work"),
    [(None, None, 4 * 2), (None, HALF, 3 * 4 * 2), (1, None, 4 * 2 * 2**4)],
)
def test_the_work_of_a_claim_is_counted(
    sample_time: Any, halvings: Any, work: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Four monomials of degree 1 + 1 + 1, two speeds or two P_b, three nodes, order 1 or 2."""
    model = model_data([[[-0.1]], [[-0.2]]], sample_time=sample_time)
    claim = scalar(1, 1, polya=1) | ({} if halvings is None else {"halvings": halvings})

    for most, verdict in ((work, "PROVED"), (work - 1, "REFUSED")):
        monkeypatch.setattr("takagi.certificates.checker.kinds.fuzzy_decay.MOST_WORK", most)
        assert verdict_of(model, None, claim) == verdict
