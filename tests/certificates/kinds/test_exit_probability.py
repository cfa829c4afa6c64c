"""Leaving a set under white noise: exact thresholds, a known answer, simulation."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

from takagi.certificates import Verdict
from takagi.certificates.checker.kinds.exit_probability import exit_bound
from takagi.certificates.document.plant_embedding import plant_data
from takagi.certificates.requests import ExitProbability
from takagi.certificates.requests.attempts import attempted
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import Interval, ModelError, Plant, TSModel, Variable, sector_model
from tests.certificates.kinds.claims import Data, model_data, verdict_of

x, w = sp.symbols("x w", real=True)


def lag() -> tuple[Data, Data]:
    """Return x' = -x + w/2 on |x| <= 2, V = x^2/4: k = (2 - a) 4 / (2/4) = 8 (2 - a), c = 1/16.

    At a = 1/2, k = 12: k c = 3/4 > a, m = exp(1/2) / 2, and p = exp(-12) + 10 m exp(-12).
    """
    model = model_data([[[-1]]], E=[[[1]]], disturbance_names=["w [-]"], box={"x1 [-]": [-2, 2]})
    claim: Data = {"name": "lag", "kind": "exit-probability", "disturbance": "disturbances"}
    claim |= {"noise": [0.5], "P": [[0.25]], "rate": 0.5, "exponent": 12, "start": 0}
    return model, claim | {"horizon": 10, "probability": round(lag_bound() * 1.0001, 10)}


def lag_bound() -> float:
    return math.exp(-12) * (1 + 10 * 0.5 * math.exp(0.5))


PROVED, UNDECIDED, REFUSED = "PROVED", "UNDECIDED", "REFUSED"


def test_probability_from_both_sides_of_its_exact_value() -> None:
    model, claim = lag()
    for factor, expected in ((1 + 1e-9, PROVED), (1 - 1e-9, UNDECIDED)):
        at = claim | {"probability": lag_bound() * factor}
        assert verdict_of(model, None, at) == expected


@pytest.mark.parametrize(
    ("key", "inside", "outside"),
    [("exponent", 12, 12.000001), ("rate", 0.5, 0.500001), ("P", [[0.25]], [[0.2499999]])],
)
def test_thresholds_of_the_inequality(key: str, inside: Any, outside: Any) -> None:
    """k = 8 (2 - a) exactly for P = 1/4; {V <= 1} is |x| <= 2 exactly, the box."""
    model, claim = lag()
    assert verdict_of(model, None, claim | {key: inside}) == PROVED
    assert verdict_of(model, None, claim | {key: outside}) == UNDECIDED


def test_the_bound_at_the_end_of_its_second_form() -> None:
    """1 + k (1 - c/a) = 0 for a = k = 1, c = 2: m exp(-k) = a exactly, and no more."""
    numbers: Data = {"rate": Fraction(1), "exponent": Fraction(1), "start": Fraction(0)}
    found = exit_bound(**numbers, level=Fraction(2), horizon=Fraction(1, 10))
    assert found is not None
    assert float(found) == pytest.approx(math.exp(-1) + 0.1, abs=1e-12)
    beyond = exit_bound(**numbers, level=Fraction(2001, 1000), horizon=Fraction(1, 10))
    assert beyond is None


def exactly_left(rate: float, noise: float, limit: float, horizon: float) -> float:
    """Return P(|x| reaches the limit) of x' = -rate x + noise w from 0.

    Kolmogorov's backward equation u_t = noise^2/2 u'' - rate x u', u = 0 at the limits and 1 at
    first, by Chebyshev collocation (Trefethen 2000, Spectral Methods in Matlab, program cheb).
    """
    N = 60
    k = np.arange(N + 1)
    x = np.cos(np.pi * k / N)
    c = np.where((k == 0) | (k == N), 2.0, 1.0) * (-1.0) ** k
    D = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(N + 1))
    D = (D - np.diag(D.sum(axis=1))) / limit
    G = noise**2 / 2 * D @ D - rate * np.diag(limit * x) @ D
    stays = expm(G[1:-1, 1:-1] * horizon) @ np.ones(N - 1)
    return float(1 - stays[N // 2 - 1])


@pytest.mark.parametrize(("limit", "most"), [(1.2, 1.9), (1.4, 2.0), (1.6, 2.6), (2.0, 5.2)])
def test_one_state_against_the_exact_probability(limit: float, most: float) -> None:
    loop = ClaimedLoop.of(TSModel([[[-1.0]]], E=[[0.5]]))
    attempt = ExitProbability([1.0], 60.0, state_limits={"x1": limit}).attempt(loop)
    truth = exactly_left(1.0, 0.5, limit, 60.0)

    assert attempt.proved
    assert truth < attempt.claim["probability"] < most * truth


def oscillator() -> tuple[ClaimedLoop, ExitProbability]:
    """Return x'' + 0.6 x' + x = 0.5 w and |x| <= 1.6 for 60 s."""
    loop = ClaimedLoop.of(TSModel([[[0.0, 1.0], [-1.0, -0.6]]], E=[[0.0], [0.5]]))
    return loop, ExitProbability([1.0], 60.0, state_limits={"x1": 1.6})


def test_probability_that_is_asked_for() -> None:
    loop, asked = oscillator()
    at: Data = {"noise": [1.0], "horizon": 60.0, "state_limits": {"x1 [-]": 1.6}}
    assert ExitProbability(**at, probability=0.69).attempt(loop).proved
    missed = ExitProbability(**at, probability=0.68).attempt(loop)
    assert missed.checked.verdict is Verdict.UNDECIDED
    wild = ExitProbability([3.0], 60.0, state_limits={"x1": 1.6}).attempt(loop)
    assert wild.checked.verdict is Verdict.UNDECIDED
    assert "not below 1" in wild.tried[-1]


def test_gains_by_rule_are_proved_on_blends() -> None:
    model = TSModel(
        [[[0.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [0.5, 0.0]]],
        [[[0.0], [1.0]], [[0.0], [0.8]]],
        E=[[0.0], [0.3]],
    )
    gains = [[[3.0, 2.0]], [[3.2, 2.2]]]
    asked = ExitProbability([1.0], 60.0, state_limits={"x1": 1.0})
    assert attempted(asked, ClaimedLoop.of(model, gains)).proved


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"horizon": -1.0}, "horizon"),
        ({"start": 1.0}, "start"),
        ({"probability": 1.5}, "probability"),
        ({"rate": 0.0}, "rate"),
        ({"noise": [0.0]}, "all entries are 0"),
        ({"noise": [1.0, 2.0]}, "1 numbers"),
        ({"state_limits": {}}, "no set to leave"),
        ({"state_limits": {"y": 1.0}}, "no state 'y'"),
        ({"state_limits": {"x1": -1.0}}, "positive"),
        ({"disturbance": "inputs"}, "none such"),
    ],
)
def test_misuse_raises(changed: Data, words: str) -> None:
    loop, _ = oscillator()
    given: Data = {"noise": [1.0], "horizon": 60.0, "state_limits": {"x1": 1.6}} | changed
    with pytest.raises(ModelError, match=words):
        ExitProbability(**given).attempt(loop)


def test_a_given_shape_is_made_as_large_as_fits() -> None:
    """A multiple of the P that is found gives its bound again; another shape gives a worse one."""
    loop, asked = oscillator()
    best = asked.attempt(loop).claim
    found = np.array(best["P"])
    for shape, worst in ((7 * found, 1.001), (found * [[1, 1], [1, 1.03]], 1.6)):
        at = ExitProbability([1.0], 60.0, state_limits={"x1": 1.6}, P=shape, rate=best["rate"])
        again = at.attempt(loop)
        assert again.proved
        ratio = again.claim["probability"] / best["probability"]
        assert 0.999 <= ratio <= worst
    with pytest.raises(ModelError, match="symmetric, positive"):
        ExitProbability([1.0], 60.0, state_limits={"x1": 1.6}, P=-np.eye(2)).attempt(loop)


def cubic(equation: sp.Expr, side: Interval | None = None) -> ClaimedLoop:
    state = Variable(x, "-", Interval.of(-1, 1))
    pushes = (Variable(w, "-", side),)
    model = sector_model(Plant(equations=(equation,), states=(state,), disturbances=pushes))
    return ClaimedLoop.of(model, model_data=plant_data(model))


def test_noise_in_a_premise_proves_nothing() -> None:
    loop = cubic(-3 * x - x * sp.sin(w) + w, Interval.of(-1, 1))
    attempt = ExitProbability([0.3], 10.0).attempt(loop)
    assert attempt.checked.verdict is Verdict.UNDECIDED
    assert "may be in no premise" in attempt.checked.text


def test_noise_that_moves_with_the_state() -> None:
    """x' = -x - x^3 + (1 + x^2/4) w, |x| <= 1: 3,000 runs by Euler and Maruyama (Ito)."""
    asked = ExitProbability([0.4], 20.0)
    attempt = asked.attempt(cubic(-x - x**3 + (1 + x**2 / 4) * w))
    assert attempt.proved
    assert "in Ito's sense" in attempt.checked.text
    random, step = np.random.default_rng(3), 0.01
    at, left = np.zeros(3000), np.zeros(3000, dtype=bool)
    for _ in range(2000):
        kick = 0.4 * math.sqrt(step) * random.standard_normal(at.shape)
        at = at - step * (at + at**3) + (1 + at**2 / 4) * kick
        left |= attempt.claim["P"][0][0] * at**2 >= 1
        at = np.clip(at, -1.5, 1.5)  # runs that have left count no more

    assert 0.001 < left.mean() < attempt.claim["probability"]
    assert 0.1 < attempt.claim["probability"] < 0.7
