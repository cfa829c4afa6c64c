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
