"""Energy gain by P(h): exact thresholds by hand, ROLMIP's masses, simulation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import FuzzyL2Gain
from takagi.lmi import common_lyapunov, hinf_norm
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, model_data, verdict_of
from tests.lmi.known_models import masses_and_spring


def function(*values: float) -> list[Data]:
    """Return the entries of P(h) = sum_i p_i h_i of one state."""
    unit = np.eye(len(values), dtype=int).tolist()
    return [{"powers": [row], "matrix": [[value]]} for row, value in zip(unit, values, strict=True)]


def lag(sample_time: Any = None, a: float = -1) -> Data:
    """Return x' = a x + w, y = x as two rules that are the same."""
    one: Data = {"A": [[[a]]] * 2, "E": [[[1]]], "C": [[[1]]]}
    return model_data(one.pop("A"), sample_time=sample_time, **one)


def claimed(p: tuple[float, float], gain: Any, **others: Any) -> Data:
    """Return the claim with P(h) = p_1 h_1 + p_2 h_2."""
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
def test_the_work_of_a_claim_is_counted(
    sample_time: Any, order: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five monomials of degree 1 + 2 + 1; two speeds or two P_b; three inputs and two outputs."""
    model = lag(sample_time, -0.1) | {"E": [[[1, 1, 1]]], "C": [[[1], [1]]]}
    claim = claimed((1, 1), 90, polya=1, P=function(1, 1))
    work = 5 * 2 * order**4

    for most, verdict in ((work, "PROVED"), (work - 1, "REFUSED")):
        monkeypatch.setattr("takagi.certificates.checker.kinds.fuzzy_decay.MOST_WORK", most)
        assert verdict_of(model, None, claim) == verdict
