"""Functions that are scheduled by the weights: scalar thresholds, and pairs that need them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.requests import Decay, FuzzyDecay
from takagi.models import Premise, TSModel
from tests.certificates.kinds.claims import Data, model_data, said_of, verdict_of


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
    model = model_data([[[-1]], [[-2]]])
    assert said_of(model, None, scalar(1, 2)).verdict is Verdict.PROVED

    monkeypatch.setattr(f"takagi.certificates.checker.kinds.{limit}", value)
    try:
        said = said_of(model, None, scalar(1, 2)).text
    except CertificateError as refused:
        said = str(refused)
    assert words in said


def pair(a: float) -> list[list[list[float]]]:
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
