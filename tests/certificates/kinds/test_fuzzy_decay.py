"""Decay and energy gain by a function of the weights: thresholds, and published examples."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError, Verdict, certify
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.kinds import simplex_polynomial
from takagi.certificates.requests import Decay, FuzzyDecay, FuzzyL2Gain
from takagi.lmi import common_lyapunov, hinf_norm
from takagi.models import Premise, TSModel
from tests.certificates.kinds.claims import Data, model_data, said_of, verdict_of
from tests.lmi.known_models import masses_and_spring


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


def function(*values: float) -> list[Data]:
    """Return the entries of P(h) = sum_i p_i h_i of one state."""
    unit = np.eye(len(values), dtype=int).tolist()
    return [{"powers": [row], "matrix": [[value]]} for row, value in zip(unit, values, strict=True)]


def lag(sample_time: Any = None, a: float = -1) -> Data:
    """Return x' = a x + w, y = x as two rules that are the same."""
    one: Data = {"A": [[[a]]] * 2, "E": [[[1]]], "C": [[[1]]]}
    return model_data(one.pop("A"), sample_time=sample_time, **one)


def claimed(p: tuple[float, float], gain: Any, **others: Any) -> Data:
    claim = {"name": "x", "kind": "fuzzy-l2-gain", "disturbance": "disturbances", "gain": gain}
    claim |= {"degrees": [1], "polya": 0, "P": function(*p), "rates": [[0.5, 0.5]]}
    return claim | others


@pytest.mark.parametrize(
    ("p", "rate", "limit"),
    [
        # 2 p_i - rate (p_2 - p_1) - (p_i^2 + 1) / gain > 0 at both rules.
        ((1, 1), 0.5, "1"),
        ((1, 2), 0.5, "1.4285714285714286"),
        ((1, 2), 0, "1.25"),
        ((1, 2), 1, "2"),
    ],
)
def test_the_gain_from_both_sides_of_its_value_by_hand(
    p: tuple[float, float], rate: float, limit: str
) -> None:
    """x' = -x + w, y = x: the inequality at a rule is 2 p - rate (p2 - p1) > (p^2 + 1) / gain."""
    least = float(limit)
    rates = {"rates": [[rate, rate]]}

    assert verdict_of(lag(), None, claimed(p, round(least + 1e-9, 12), **rates)) == "PROVED"
    assert verdict_of(lag(), None, claimed(p, round(least - 1e-9, 12), **rates)) == "UNDECIDED"


def test_the_masses_of_rolmips_manual_are_proved_at_its_number() -> None:
    """1.0540 by P of degree 1 and constant numbers, where one P shows 2.8429.

    Below the largest norm of a corner nothing is proved.
    """
    model = masses_and_spring()
    found = certify(model, claims=[FuzzyL2Gain(rate_bounds=0)])
    norms = [hinf_norm(model.A[k], model.E[k], model.C[0]).gain or 0.0 for k in range(8)]
    below = certify(model, claims=[FuzzyL2Gain(gain=0.999 * max(norms), rate_bounds=0)])

    assert found.verdict is Verdict.PROVED
    assert found.document["claims"][0]["gain"] == pytest.approx(1.0540, abs=3e-4)
    assert below.verdict is Verdict.UNDECIDED


def test_the_gain_of_a_moving_loop_is_never_exceeded_in_simulation() -> None:
    """Energies of y and w along a loop whose weights move at their rates keep the bound."""
    model = TSModel(
        [[[0.0, 1.0], [-1.0, -0.6]], [[0.0, 1.0], [-3.0, -0.4]]], E=[[0.0], [1.0]], C=[[1.0, 0.0]]
    )
    certificate = certify(model, claims=[FuzzyL2Gain(rate_bounds=0.2)])
    assert certificate.verdict is Verdict.PROVED
    gain = certificate.document["claims"][0]["gain"]
    # No common P serves this pair: only slow weights have a gain at all.
    assert common_lyapunov(model).status == "infeasible"

    dt, x = 1e-3, np.zeros(2)
    energy_y = energy_w = 0.0
    for k in range(40_000):
        t = k * dt
        h = 0.5 + 0.5 * np.sin(0.4 * t)  # |h'| <= 0.2
        A = h * model.A[0] + (1 - h) * model.A[1]
        w = np.sin(np.sqrt(h + 3 * (1 - h)) * t)
        x = x + dt * (A @ x + model.E[0][:, 0] * w)
        energy_y, energy_w = energy_y + dt * x[0] ** 2, energy_w + dt * w**2
    assert 0.3 * gain < np.sqrt(energy_y / energy_w) < gain


def test_discrete_time_with_gains_is_proved() -> None:
    """A sampled loop with a gain a rule: jumps of the weights allowed, no rates asked for."""
    model = TSModel(
        [[[1.0, 0.1], [0.1, 1.0]], [[1.0, 0.1], [0.3, 0.95]]],
        [[0.0], [0.1]],
        C=[[1.0, 0.0]],
        E=[[0.0], [0.02]],
        sample_time=0.1,
    )
    found = certify(model, [[[6.0, 5.0]], [[8.0, 5.0]]], claims=[FuzzyL2Gain()])

    assert found.verdict is Verdict.PROVED
    assert "rates" not in found.document["claims"][0]
    assert "however the weights move" in found.checked.claims[0].text


@pytest.mark.parametrize(("sample_time", "order"), [(None, 1 + 3 + 2), (1, 2 + 3 + 2)])
def test_the_work_of_a_claim_is_counted_gain(
    sample_time: Any, order: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five monomials of degree 1 + 2 + 1; two speeds or two P_b; three inputs and two outputs."""
    model = lag(sample_time, -0.1) | {"E": [[[1, 1, 1]]], "C": [[[1], [1]]]}
    claim = claimed((1, 1), 90, polya=1, P=function(1, 1))
    work = 5 * 2 * order**4

    for most, verdict in ((work, "PROVED"), (work - 1, "REFUSED")):
        monkeypatch.setattr("takagi.certificates.checker.kinds.fuzzy_decay.MOST_WORK", most)
        assert verdict_of(model, None, claim) == verdict


@pytest.mark.parametrize(("limit", "work"), [("MOST_PRODUCTS", 9), ("MOST_WORK", 9 * 2**3)])
def test_products_are_counted_before_they_are_made(
    limit: str, work: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three terms by three, each a product of matrices of order 2: eight of numbers."""
    terms = {a: Matrix.identity(2) for a in simplex_polynomial.exponents((3,), (1,))}
    X = simplex_polynomial.Polynomial((3,), (1,), terms)

    monkeypatch.setattr(simplex_polynomial, limit, work)
    assert len((X @ X).terms) == 6
    monkeypatch.setattr(simplex_polynomial, limit, work - 1)
    with pytest.raises(Refused, match="3 by 3 terms"):
        X @ X
