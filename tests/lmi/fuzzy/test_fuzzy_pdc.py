"""Gains with one Lyapunov matrix a rule: against common ones, along motions, by analysis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    FuzzyDesign,
    fuzzy_lyapunov,
    fuzzy_pdc,
    pdc,
)
from takagi.models import Floats, ModelError, Premise, TSModel

pytestmark = pytest.mark.numeric

RELAXATIONS = ("wang-tanaka-griffin", "tanaka-wang", "tuan", "liu-zhang", "polya-1")


def guerra_vermeiren(beta: float) -> TSModel:
    """The example of Guerra and Vermeiren (2004), Automatica 40(5): harder as beta grows."""
    return TSModel(
        [[[1.0, -beta], [-1.0, -0.5]], [[1.0, beta], [-1.0, -0.5]]],
        [[[5 + beta], [2 * beta]], [[5 - beta], [-2 * beta]]],
        sample_time=1.0,
    )


def tanaka_ohtake(b: float, *, premise: bool = False) -> TSModel:
    """Two rules as in Tanaka, Ohtake and Wang (2007), a = 10: harder as b grows."""
    return TSModel(
        [[[3.6, -1.6], [6.2, -4.3]], [[-10.0, -1.6], [6.2, -4.3]]],
        [[[-0.45], [-3.0]], [[-b], [-3.0]]],
        premises=[Premise("z", -1, 1)] if premise else (),
    )


def memberships(rules: int, count: int, seed: int = 0) -> Floats:
    rng = np.random.default_rng(seed)
    h = rng.dirichlet(np.ones(rules), count)
    h[::2] = np.eye(rules)[rng.integers(0, rules, len(h[::2]))]
    return h


def blended(stack: Floats | None, h: Floats) -> Floats:
    assert stack is not None
    return np.asarray(np.tensordot(h, stack, axes=1))


def lyapunov(design: FuzzyDesign, h: Floats) -> Floats:
    blend = blended(design.matrices, h)
    return np.asarray(np.linalg.inv(blend)) if design.discrete else blend


def steepest_step(model: TSModel, design: FuzzyDesign) -> float:
    h, after = (memberships(len(model.A), 2000, seed) for seed in (1, 2))
    loop = blended(model.A, h) - blended(model.B, h) @ blended(design.gains, h)
    L = np.linalg.cholesky(lyapunov(design, h))
    moved = loop.transpose(0, 2, 1) @ lyapunov(design, after) @ loop
    inside = np.linalg.solve(L, np.linalg.solve(L, moved).transpose(0, 2, 1))
    return float(np.linalg.eigvalsh(inside)[:, -1].max())


def slowest(model: TSModel, design: FuzzyDesign, phi: float) -> float:
    """Return the least alpha with V' <= -2 alpha V, two rules with |dh/dt| <= phi."""
    h = memberships(2, 1000)
    loop = blended(model.A, h) - blended(model.B, h) @ blended(design.gains, h)
    P = lyapunov(design, h)
    drop = P @ loop + (P @ loop).transpose(0, 2, 1)
    rates = []
    for sign in (-phi, phi):
        move = lyapunov(design, h + sign * np.array([1.0, -1.0])) - P
        L = np.linalg.cholesky(P)
        inside = np.linalg.solve(L, np.linalg.solve(L, drop + move).transpose(0, 2, 1))
        rates.append(np.linalg.eigvalsh(inside)[:, -1].max())
    return -float(max(rates)) / 2


@pytest.mark.parametrize(
    ("relaxation", "limit"), [("wang-tanaka-griffin", 1.3935), ("polya-2", 1.6256)]
)
def test_discrete_rules_from_both_sides_of_each_limit(relaxation: str, limit: float) -> None:
    """Guerra and Vermeiren (2004): by all pairs one P reaches beta = 1.359; limits recomputed."""
    below = guerra_vermeiren(limit - 3e-3)
    design = fuzzy_pdc(below, relaxation=relaxation)

    assert design.found and design.answer.decay_rate is not None
    assert steepest_step(below, design) <= np.exp(-2 * design.answer.decay_rate) * (1 + 1e-6)
    above = fuzzy_pdc(guerra_vermeiren(limit + 3e-3), relaxation=relaxation)
    assert above.status == "infeasible"
    assert above.gains is None
    assert pdc(guerra_vermeiren(1.35)).found
    assert pdc(guerra_vermeiren(1.37)).status == "infeasible"


@pytest.mark.parametrize("relaxation", RELAXATIONS)
def test_discrete_gains_wherever_a_common_P_has_them(relaxation: str) -> None:
    """S_i = G = Q is ``pdc``: it has what that finds at a decay rate; so also in 1/s."""
    model = guerra_vermeiren(1.2)
    common = pdc(model, relaxation=relaxation).answer.decay_rate
    assert common is not None and common > 0
    rate = 0.95 * common

    design = fuzzy_pdc(model, relaxation=relaxation, decay_rate=rate)
    assert design.found
    assert steepest_step(model, design) <= np.exp(-2 * rate) * (1 + 1e-6)


@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "liu-zhang"])
def test_any_rate_is_a_common_P(relaxation: str) -> None:
    """Tanaka, Ohtake and Wang (2007), a = 10: rate_bounds = inf is ``pdc``, to b = 1.07."""
    for b, found in ((1.06, True), (1.1, False)):
        assert pdc(tanaka_ohtake(b), relaxation=relaxation).found is found
        design = fuzzy_pdc(tanaka_ohtake(b), rate_bounds=np.inf, relaxation=relaxation)
        assert design.found is found


@pytest.mark.parametrize(("bound", "limit"), [(1.0, 1.606), (0.1, 3.080), (0.0, 5.206)])
def test_the_slower_the_memberships_the_more_can_be_held(bound: float, limit: float) -> None:
    """Limits of b, a = 10, all pairs, over the epsilons that are tried; recomputed by bisection."""
    below = tanaka_ohtake(limit - 0.03)
    design = fuzzy_pdc(below, rate_bounds=bound)

    assert design.found and design.gains is not None and design.answer.decay_rate is not None
    assert slowest(below, design, bound) >= design.answer.decay_rate - 1e-6
    assert not fuzzy_pdc(tanaka_ohtake(limit + 0.03), rate_bounds=bound).found


def test_the_loop_is_certified_by_analysis_too() -> None:
    """b = 1.5, beyond every common P: ``fuzzy_lyapunov`` of the loop with these gains agrees."""
    model = tanaka_ohtake(1.5)
    design = fuzzy_pdc(model, rate_bounds=1.0, decay_rate=0.05)
    again = fuzzy_lyapunov(model, rate_bounds=1.0, gains=design.gains, relaxation="polya-2")

    assert pdc(model).status == "infeasible"
    assert design.answer.decay_rate is not None and design.answer.decay_rate >= 0.05
    assert again.found
    assert not fuzzy_lyapunov(model, rate_bounds=1.0, gains=-np.array(design.gains)).found


def test_a_premise_has_a_rate_in_its_own_unit() -> None:
    """z in [-1, 1] at 2 per second moves the memberships at 1/s: the same design."""
    plain = fuzzy_pdc(tanaka_ohtake(1.5), rate_bounds=1.0)
    named = fuzzy_pdc(tanaka_ohtake(1.5, premise=True), rate_bounds={"z": 2.0})
    assert plain.gains is not None and named.gains is not None

    np.testing.assert_allclose(named.gains, plain.gains, rtol=1e-5)
    assert fuzzy_pdc(
        tanaka_ohtake(1.5, premise=True), rate_bounds={"z": 2.0}, relaxation="product"
    ).found


def test_a_premise_that_jumps_has_no_part_in_P() -> None:
    A = [[[0, 1], [4 + 2 * p + q, 0]] for p in (-1, 1) for q in (-1, 1)]
    model = TSModel(A, [[[0], [1]]] * 4, premises=[Premise("p", -1, 1), Premise("q", -1, 1)])
    design = fuzzy_pdc(model, rate_bounds={"p": 1.0, "q": np.inf}, relaxation="product")
    assert design.matrices is not None

    np.testing.assert_array_equal(design.matrices[0], design.matrices[1])
    assert np.abs(design.matrices[0] - design.matrices[2]).max() > 0


def test_units_do_not_matter() -> None:
    s, tau, time = np.array([2.0**12, 1.0]), 2.0**-7, 2.0**4
    model = tanaka_ohtake(1.5)
    other = TSModel(time * model.A * s / s[:, None], time * model.B * tau / s[:, None])
    plain = fuzzy_pdc(model, rate_bounds=1.0)
    scaled = fuzzy_pdc(other, rate_bounds=time)
    assert plain.gains is not None and scaled.gains is not None

    np.testing.assert_allclose(scaled.gains * tau / s, plain.gains, rtol=1e-4)


def test_a_no_says_what_binds_and_what_to_do() -> None:
    model = TSModel([[[-1.0, 0.0], [0.0, 1.0]]] * 2, [[[0.0], [1.0]]] * 2)
    design = fuzzy_pdc(guerra_vermeiren(1.9))
    fixed = fuzzy_pdc(model, rate_bounds=1.0, decay_rate=2.0)

    assert "the no rests on next rule" in design.answer.diagnosis
    assert fixed.status == "infeasible"
    assert "no input moves the mode at -1" in fixed.answer.diagnosis
    assert "below 1 1/s" in fixed.answer.diagnosis


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "rate_bounds is missing"),
        ({"rate_bounds": -1.0}, "must be 0, positive, or inf"),
        ({"rate_bounds": 1.0, "relaxation": "none"}, "relaxation 'none' is not known"),
        ({"rate_bounds": 1.0, "sample_time": 1.0}, "of continuous time"),
    ],
)
def test_misuse_is_said(options: Mapping[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        fuzzy_pdc(tanaka_ohtake(1.0), **options)
