"""The generic eigenvalue problem: exact values, both sides of the threshold, bounds, misuse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    LMI,
    Condition,
    Parameter,
    Term,
    Unknown,
    common_lyapunov_condition,
    decide,
    extreme_parameter,
    pdc_condition,
    pose,
)
from takagi.lmi.gains.requirements.limits import limits_of
from takagi.lmi.parameter_search.largest_parameter import adjoint, excluded_from
from takagi.lmi.parameter_search.parameter_pencil import ParameterPencil
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import feasp_triple, tanaka_wang_rules


def limited_design(sample_time: float | None) -> Condition:
    model = tanaka_wang_rules(b=3.0)
    limits = limits_of(2, 1, input_limit=[50.0], initial_box=[1.0, 1.0])
    if sample_time is not None:
        A, B = np.eye(2) + sample_time * model.A, sample_time * model.B
        model = TSModel(A, B, sample_time=sample_time)
    return pdc_condition(model, relaxation="tanaka-wang", limits=limits)


def test_the_decay_rate_of_the_gevp_page() -> None:
    """MathWorks, gevp: V' <= -0.1221308 V."""
    found = extreme_parameter(common_lyapunov_condition(feasp_triple()), "alpha")

    assert found.found
    assert found.value == pytest.approx(0.12213081121 / 2, rel=2e-6)
    assert found.value <= found.bound <= found.value * (1 + 1e-5)
    # Bisection to 1e-6 of the rate takes twenty.
    assert len(found.outcome.tries) < 10


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_gains_that_are_limited(sample_time: float | None) -> None:
    condition = limited_design(sample_time)
    name, d = ("alpha", 1.0) if sample_time is None else ("contraction", -1.0)
    found = extreme_parameter(condition, name, largest=sample_time is None)

    assert found.found and found.outcome.margin > 0
    assert d * (found.bound - found.value) >= 0
    assert found.bound == pytest.approx(found.value, rel=2e-3)
    inside, outside = (
        decide(condition.with_parameters(**{name: found.value * (1 - d * side)}))
        for side in (1e-3, -1e-3)
    )
    assert inside.status == "candidate"
    assert outside.status == "infeasible"


def test_the_value_is_what_the_unknowns_show() -> None:
    condition = common_lyapunov_condition(feasp_triple())
    found = extreme_parameter(condition, "alpha")
    P = found.best["P"]
    pencil = ParameterPencil.of(condition, "alpha", largest=True)

    assert pencil.allowed({"P": P}, 0.0) == pytest.approx(found.value, rel=1e-9)
    rates = [
        -np.linalg.eigvals(np.linalg.inv(P[0]) @ (A.T @ P[0] + P[0] @ A)).real.max() / 2
        for A in feasp_triple()
    ]
    assert min(rates) == pytest.approx(found.value, rel=1e-9)
    assert np.isnan(pencil.allowed({"P": -P}, 0.0))


def test_unknowns_without_a_margin_are_not_handed_back() -> None:
    """Centred: the margin at a hair before the value is positive, and larger than at the value."""
    condition = common_lyapunov_condition(feasp_triple())
    centred = extreme_parameter(condition, "alpha", tolerance=1e-3)
    plain = extreme_parameter(condition, "alpha", tolerance=1e-3, centre=False)

    assert centred.outcome.margin > 1e-6
    assert plain.outcome.margin == 0
    assert centred.condition.parameters["alpha"] < centred.value


def test_infeasible_from_the_start() -> None:
    far = np.array([[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -8.0], [1 / 8, -1.0]]])
    found = extreme_parameter(common_lyapunov_condition(far), "alpha")

    assert not found.found
    assert found.outcome.status == "infeasible"
    assert np.isnan(found.value)
    assert "vertex" in found.outcome.multipliers


@settings(max_examples=10)
@given(st.integers(0, 10**6))
def test_multipliers_exclude_every_value_beyond_the_bound(seed: int) -> None:
    """S0 + theta S1 <= 0 at the excluded theta, recomputed here; and the adjoint is an adjoint."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((3, 3)) - 3 * np.eye(3) + 0.3 * rng.standard_normal((4, 3, 3))
    condition = common_lyapunov_condition(A, decay_rate=0.3)
    Z = rng.standard_normal((4, 3, 5))
    Z = Z @ Z.transpose(0, 2, 1)
    S0, S1 = adjoint(condition, condition.lmis[2], "alpha", Z)
    P = rng.standard_normal((3, 3))
    P = P + P.T

    for alpha in (0.0, 0.7):
        F = [-(M.T @ P + P @ M + 2 * alpha * P) for M in A]
        direct = sum(float(np.trace(f @ z)) for f, z in zip(F, Z, strict=True))
        assert float(np.sum((S0 + alpha * S1) * P)) == pytest.approx(direct, rel=1e-9)

    multipliers = {"vertex": Z, "P positive definite": np.eye(3)[None]}
    limit = excluded_from(condition, "alpha", multipliers, largest=True)
    flow = (A @ Z + (A @ Z).transpose(0, 2, 1)).sum(axis=0)
    assert np.linalg.eigvalsh(flow + 2 * limit * Z.sum(axis=0))[0] == pytest.approx(0, abs=1e-7)


def test_bound_and_multipliers_need_one_homogeneous_unknown() -> None:
    """With constants, or more unknowns, the multipliers' argument says nothing: inf."""
    condition = limited_design(None)
    outcome = decide(condition)

    assert excluded_from(condition, "alpha", outcome.multipliers, largest=True) == np.inf
    assert (
        excluded_from(common_lyapunov_condition(feasp_triple()), "alpha", {}, largest=False)
        == -np.inf
    )


def test_misuse_is_named() -> None:
    condition = common_lyapunov_condition(feasp_triple())
    with pytest.raises(ModelError, match="no term has the parameter 'gamma'; there are alpha"):
        extreme_parameter(condition, "gamma")
    with pytest.raises(ModelError, match="feasible at no value of alpha"):
        extreme_parameter(condition, "alpha", start={"P": -np.eye(2)[None]})
    with pytest.raises(ModelError, match="tolerance"):
        extreme_parameter(condition, "alpha", tolerance=0.0)
    with pytest.raises(ModelError, match="there are none"):
        extreme_parameter(replace(condition, lmis=condition.lmis[:2], parameters={}), "alpha")


@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "tanaka-wang", "liu-zhang"])
@pytest.mark.parametrize(("a", "b", "most"), [(1.0, 2.0, 7.0), (0.3, 0.5, 10.0), (-2.0, 1.0, 5.0)])
def test_other_unknowns_beside_one_matrix(relaxation: str, a: float, b: float, most: float) -> None:
    """x' = a x + b u with |K| <= g: b g - a, reached although each step alone gains little."""
    model = TSModel([[[a]], [[a]]], [[[b]], [[b]]])
    limits = limits_of(1, 1, gain_bound=most)
    found = extreme_parameter(pdc_condition(model, relaxation=relaxation, limits=limits), "alpha")

    assert found.converged
    assert found.value == pytest.approx(b * most - a, rel=1e-4)
    assert found.value <= (b * most - a) * (1 + 1e-9)
    assert found.bound == pytest.approx(b * most - a, rel=1e-4)


def test_a_search_that_was_cut_short_says_so() -> None:
    condition = limited_design(None)
    short, whole = (extreme_parameter(condition, "alpha", steps=steps) for steps in (1, 60))

    assert whole.converged and not short.converged
    assert short.value < whole.value <= short.bound


X = Unknown("X", 2, 2, symmetric=True)


def indefinite() -> Condition:
    """Return X_11 > 0, -X_22 > theta X_11 with X_11 >= 1, X_22 >= -50, -100 I <= X <= 100 I."""
    theta = Parameter("theta", 0.0)
    return pose(
        (X[0, 0] >> 0).named("first"),
        (-X[1, 1] - theta * X[0, 0] >> 0).named("main"),
        X[0, 0] >= 1,
        X[1, 1] >= -50,
        X <= 100 * np.eye(2),
        X >= -100 * np.eye(2),
    )


def test_an_unknown_that_is_not_positive_is_not_excluded_by_semidefiniteness() -> None:
    """The largest theta is 50 by hand, at X_11 = 1, X_22 = -50."""
    one = np.ones((1, 1, 1))
    multipliers = {"first": one, "main": one}
    assert excluded_from(indefinite(), "theta", multipliers, largest=True) == np.inf
    found = extreme_parameter(indefinite(), "theta")
    assert found.value == pytest.approx(50.0, rel=1e-4)
    assert found.bound >= 50.0 * (1 - 1e-6)


@pytest.mark.parametrize("L", [np.eye(2), np.array([[2.0, 1.0], [0.0, 0.5]])])
def test_a_congruent_of_a_positive_unknown_excludes(L: NDArray[np.float64]) -> None:
    """X > 0 and -X_22 > theta X_11: every theta >= 0 is excluded, none below."""
    positive = Term(unknown=X, left=L.T[None], right=L[None])
    plain = indefinite()
    condition = Condition(
        name="a positive definite one",
        unknowns=(X,),
        lmis=(LMI(name="positive", blocks=(2,), terms=(positive,)), plain.lmis[1]),
        parameters={"theta": 0.0},
    )
    multipliers = {"positive": np.eye(2)[None], "main": np.ones((1, 1, 1))}
    assert excluded_from(condition, "theta", multipliers, largest=True) == pytest.approx(0.0)
    singular = Term(unknown=X, left=np.ones((1, 2, 2)), right=np.ones((1, 2, 2)))
    weaker = LMI(name="positive", blocks=(2,), terms=(singular,))
    poor = Condition(
        name="positive in one direction",
        unknowns=(X,),
        lmis=(weaker, plain.lmis[1]),
        parameters={"theta": 0.0},
    )
    assert excluded_from(poor, "theta", multipliers, largest=True) == np.inf
