"""Fuzzy Lyapunov functions: limits of the rate, motions that show them, discrete time, misuse."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from takagi.lmi import (
    Answer,
    common_lyapunov,
    exact_matrices,
    expressed,
    fuzzy_lyapunov,
    fuzzy_lyapunov_condition,
    latex,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.polynomials import Basis, Known, UnknownPolynomial, contributions
from takagi.lmi.refutation.exact_algebra import is_definite
from takagi.lmi.varying.parameter_motion import step_corners, velocity_corners
from takagi.models import Floats, ModelError, Premise, TSModel
from tests.lmi.known_models import oscillators, planar_pair, rolmip_pair


def fastest_growth(A: Floats, answer: Answer, phi: float) -> float:
    family = answer.lyapunov_function
    assert family is not None
    rng = np.random.default_rng(0)
    r = len(A)
    h = np.concatenate([np.eye(r), rng.dirichlet(np.ones(r), 300)])
    v = rng.standard_normal(h.shape)
    v -= v.mean(axis=1, keepdims=True)
    v *= phi / np.abs(v).max(axis=1, keepdims=True)
    P, e = family.at(h), 1e-5
    rate = (family.at(h + e * v) - family.at(h - e * v)) / (2 * e)
    drop = P @ np.tensordot(h, A, axes=1)
    drop = drop + drop.transpose(0, 2, 1) + rate
    L = np.linalg.cholesky(P)
    inside = np.linalg.solve(L, np.linalg.solve(L, drop).transpose(0, 2, 1))
    return float(np.linalg.eigvalsh(inside)[:, -1].max())


@pytest.mark.parametrize("A", [oscillators(20.0), planar_pair(40.0)])
def test_constant_parameters_need_no_common_P(A: Floats) -> None:
    """lam = 20 and a = 40: every blend is stable, no common P; one P a rule shows it."""
    answer = fuzzy_lyapunov(A, rate_bounds=0)

    assert common_lyapunov(A).status == "infeasible"
    assert answer.found and answer.P is None
    assert answer.decay_rate is not None and answer.decay_rate > 0
    assert fastest_growth(A, answer, 0.0) <= -2 * answer.decay_rate + 1e-8


def test_the_decay_rate_of_constant_blends_is_reached() -> None:
    """lam = 20: all blends decay with Re = -2 exactly, which P of degree 1 shows to 1e-4."""
    A = oscillators(20.0)
    np.testing.assert_allclose(np.linalg.eigvals(A).real, -2.0)

    assert fuzzy_lyapunov(A, rate_bounds=0, decay_rate=1.9999).found
    assert fuzzy_lyapunov(A, rate_bounds=0, decay_rate=2.0001).status == "infeasible"


def test_units_do_not_matter() -> None:
    A, s = oscillators(20.0), np.array([1.0, 2.0**20])
    plain, scaled = (fuzzy_lyapunov(M, rate_bounds=0) for M in (A, A * s / s[:, None]))
    assert plain.lyapunov_function is not None and scaled.lyapunov_function is not None

    assert scaled.margin == pytest.approx(plain.margin, rel=1e-9)
    assert scaled.decay_rate == pytest.approx(plain.decay_rate, rel=1e-6)
    np.testing.assert_allclose(
        scaled.lyapunov_function.members / s / s[:, None],
        plain.lyapunov_function.members,
        rtol=1e-5,
    )


def test_any_rate_is_a_common_P() -> None:
    """rate_bounds = inf from both sides of 4 + 4 sqrt(2); a huge rate comes to the same."""
    limit = 4 + 4 * np.sqrt(2)
    answer = fuzzy_lyapunov(oscillators(limit - 1e-2), rate_bounds=np.inf)

    assert answer.found and answer.lyapunov_function is not None
    assert answer.lyapunov_function.basis.degrees == (0,)
    np.testing.assert_array_equal(
        answer.lyapunov_function.vertices[0], answer.lyapunov_function.vertices[1]
    )
    assert fuzzy_lyapunov(oscillators(limit + 1e-2), rate_bounds=np.inf).status == "infeasible"
    assert fuzzy_lyapunov(oscillators(limit - 1e-2), rate_bounds=1e6).found
    assert not fuzzy_lyapunov(oscillators(limit + 1e-2), rate_bounds=1e6).found


@pytest.mark.parametrize(
    ("options", "limit"),
    [
        ({"relaxation": "polya-0"}, 3.4887),
        ({"relaxation": "wang-tanaka-griffin"}, 3.4887),
        ({"relaxation": "polya-1"}, 3.5084),
        ({"relaxation": "liu-zhang"}, 3.8330),
        ({"degree": 2}, 4.2886),
        ({"degree": 8, "relaxation": "polya-1"}, 6.7872),
    ],
)
def test_how_fast_the_memberships_may_move(options: Mapping[str, Any], limit: float) -> None:
    """lam = 20: to these rates in 1/s, by bisection; degree 2 is the inequalities of all pairs."""
    A = oscillators(20.0)
    below = fuzzy_lyapunov(A, rate_bounds=limit - 1e-2, **options)
    above = fuzzy_lyapunov(A, rate_bounds=limit + 1e-2, **options)

    assert below.found and not above.found
    assert below.decay_rate is not None
    assert fastest_growth(A, below, limit - 1e-2) <= -2 * below.decay_rate + 1e-6


def oscillator() -> TSModel:
    A: Any = [[[0, 1], [-4 - q, -1.5 - p]] for p in (-0.5, 0.5) for q in (-2.5, 2.5)]
    return TSModel(A, premises=[Premise("p", -0.5, 0.5), Premise("q", -2.5, 2.5)])


def test_premises_have_a_simplex_each() -> None:
    """Two premises: 3 x 3 coefficients in the place of the 10 of four vertices."""
    model = oscillator()
    product = fuzzy_lyapunov_condition(model, rate_bounds=0)
    flat = fuzzy_lyapunov_condition(model.A, rate_bounds=0)
    family = fuzzy_lyapunov(model, rate_bounds=0).lyapunov_function
    assert family is not None
    h = model.memberships(p=[0.3, -0.5], q=[0.1, 2.5]).T

    assert (product.lmis[-1].count, flat.lmis[-1].count) == (9, 10)
    assert product.lmis[-1].label(1) == "(p low) (p low) (q low) (q high)"
    np.testing.assert_allclose(family.at(h)[1], family.vertices[1], atol=1e-9)
    np.testing.assert_allclose(family.at(h), np.tensordot(h, family.vertices, axes=1), atol=1e-9)


def test_rates_of_premises_say_more_than_rates_of_memberships() -> None:
    """|h_i'| of a product is at most the sum of the |w_k'|, which forgets what moves together."""
    model = oscillator()
    rates = {"p": 1.5, "q": 7.5}
    flat = 1.5 / 1.0 + 7.5 / 5.0
    answer = fuzzy_lyapunov(model, rate_bounds=rates)

    assert common_lyapunov(model).status == "infeasible"
    assert answer.found
    assert not fuzzy_lyapunov(model.A, rate_bounds=flat).found


def test_the_rate_of_a_product_is_that_of_its_premises() -> None:
    """dP/dt at the corners +-rho bounds every motion; found values checked along random ones."""
    model = oscillator()
    answer = fuzzy_lyapunov(model, rate_bounds=[1.5, 7.5], decay_rate=0.01)
    family = answer.lyapunov_function
    assert family is not None and answer.decay_rate is not None
    rng = np.random.default_rng(0)
    z = rng.uniform(-1, 1, (2, 400)) * [[0.49], [2.49]]
    speed = rng.uniform(-1, 1, (2, 400)) * [[1.5], [7.5]]
    h, e = model.memberships(z).T, 1e-6
    moved = model.memberships(z + e * speed).T - model.memberships(z - e * speed).T
    rate = np.tensordot(moved / (2 * e), family.vertices, axes=1)
    P = family.at(h)
    drop = P @ np.tensordot(h, model.A, axes=1)
    drop = drop + drop.transpose(0, 2, 1) + rate + 2 * answer.decay_rate * P

    assert answer.decay_rate >= 0.01
    assert np.linalg.eigvalsh(drop).max() <= 1e-6 * np.abs(P).max()


def test_a_premise_that_jumps_is_left_out_of_P() -> None:
    """inf for p: P depends on q alone, which is enough here; the other way round it is not."""
    answer = fuzzy_lyapunov(oscillator(), rate_bounds={"p": np.inf, "q": 7.5})
    assert answer.lyapunov_function is not None

    assert answer.lyapunov_function.basis.degrees == (0, 1)
    np.testing.assert_array_equal(
        answer.lyapunov_function.vertices[0], answer.lyapunov_function.vertices[2]
    )
    other = fuzzy_lyapunov(oscillator(), rate_bounds={"p": 0.0, "q": np.inf})
    assert other.status == "infeasible"


def test_gains_close_the_loop() -> None:
    """A law that makes lam = 20 of an unstable plant; the loop's P holds along the motion."""
    K = np.array([[[3.0, 0.0]], [[3.0, 0.0]]])
    B = np.array([[[0.0], [1.0]], [[0.0], [1.0]]])
    model = TSModel(oscillators(20.0) + B @ K, B)
    answer = fuzzy_lyapunov(model, rate_bounds=3.0, gains=K)

    assert fuzzy_lyapunov(model, rate_bounds=3.0).found is False
    assert answer.found
    assert fastest_growth(oscillators(20.0), answer, 3.0) < 0
    scheduled = fuzzy_lyapunov(model, rate_bounds=2.9, gains=K * [[[0.9]], [[1.1]]])
    assert scheduled.found and scheduled.condition is not None
    assert scheduled.condition.lmis[-1].count == 2 * 4


def test_a_found_P_holds_in_rationals() -> None:
    """lam = 20 at a rate of 1/s: exact coefficients of exact numbers."""
    A = np.vectorize(Fraction, otypes=[object])(oscillators(20.0))
    condition = fuzzy_lyapunov_condition(A, rate_bounds=1.0)
    answer = fuzzy_lyapunov(oscillators(20.0), rate_bounds=1.0)
    assert answer.lyapunov_function is not None
    members = np.vectorize(lambda entry: Fraction(f"{entry:.6f}"), otypes=[object])(
        answer.lyapunov_function.members
    )
    exact = exact_matrices(condition, condition.lmis[-1], {"P": members})
    unfit = exact_matrices(condition, condition.lmis[-1], {"P": members[::-1]})

    assert len(exact) == 2 * 3 and all(is_definite(matrix) for matrix in exact)
    assert not all(is_definite(matrix) for matrix in unfit)


def test_a_no_says_what_binds_and_what_to_do() -> None:
    """lam = 20 at 10 1/s by degree 1; and an unstable rule or blend, which needs no solver."""
    answer = fuzzy_lyapunov(oscillators(20.0), rate_bounds=10.0)
    unstable = fuzzy_lyapunov(-oscillators(20.0), rate_bounds=10.0)

    assert answer.status == "infeasible" and answer.lyapunov_function is None
    assert "rates " in answer.diagnosis and "lower the rate bounds" in answer.diagnosis
    assert "rule 1 of 2 alone rules it out" in unstable.diagnosis and not unstable.tries
    pair = [[[-1, 10], [0, -1]], [[-1, 0], [10, -1]]]
    mean = fuzzy_lyapunov(pair, rate_bounds=0, degree=4)
    assert mean.diagnosis.startswith("the mean of rules 1 and 2 of 2 alone rules it out")
    assert mean.status == "infeasible" and not mean.tries


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"rate_bounds": -1.0}, r"rate_bounds\[0\] is -1.0; it must be 0, positive, or inf"),
        ({"rate_bounds": np.nan}, r"rate_bounds\[0\] is nan"),
        ({"rate_bounds": [1.0, 1.0, 1.0]}, r"has shape \(3,\); \(2,\) is needed"),
        ({"rate_bounds": "fast"}, "cannot be read as real numbers"),
        ({"rate_bounds": {"z": 1.0}}, "has no premises; give one bound for each membership"),
        ({"degree": -1}, "degree is -1; whole numbers from 0"),
        ({"degree": 1.5}, "degree is 1.5"),
        ({"degree": (1, 1)}, r"degree is \(1, 1\); whole numbers from 0 are needed, one number"),
        ({"gains": np.zeros((2, 1, 2))}, "no B"),
        ({"relaxation": "polya"}, "relaxation 'polya' is not known"),
        ({"relaxation": "tanaka-wang", "degree": 2}, "is for a double sum"),
        ({"relaxation": "tanaka-wang", "sample_time": 1.0}, "is for a double sum"),
    ],
)
def test_misuse_is_said(options: Mapping[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        fuzzy_lyapunov(oscillators(1.0), **{"rate_bounds": 1.0, **options})


def test_bounds_of_premises_are_checked_by_name() -> None:
    with pytest.raises(ModelError, match="none is given for q"):
        fuzzy_lyapunov(oscillator(), rate_bounds={"p": 1.0})
    with pytest.raises(ModelError, match="there is no premise 'Q'; there are p, q"):
        fuzzy_lyapunov(oscillator(), rate_bounds={"p": 1.0, "Q": 1.0})
    with pytest.raises(ModelError, match="leaves 2 of 3 memberships without a bound"):
        fuzzy_lyapunov([[[-1.0]], [[-2.0]], [[-3.0]]], rate_bounds=[1.0, np.inf, np.inf])


def steepest_step(A: Floats, answer: Answer, bound: float) -> float:
    """Return the largest V(x+) / V(x) over h and h+ that are no farther apart than the bound."""
    family = answer.lyapunov_function
    assert family is not None
    rng = np.random.default_rng(0)
    r = len(A)
    h = np.concatenate([np.repeat(np.eye(r), 40, axis=0), rng.dirichlet(np.ones(r), 300)])
    other = np.concatenate([np.tile(np.eye(r), (40, 1)), rng.dirichlet(np.ones(r), 300)])
    far = np.abs(other - h).max(axis=1, keepdims=True)
    after = h + (other - h) * np.minimum(1.0, bound / np.maximum(far, 1e-12))
    M = np.tensordot(h, A, axes=1)
    L = np.linalg.cholesky(family.at(h))
    moved = M.transpose(0, 2, 1) @ family.at(after) @ M
    inside = np.linalg.solve(L, np.linalg.solve(L, moved).transpose(0, 2, 1))
    return float(np.linalg.eigvalsh(inside)[:, -1].max())


@pytest.mark.parametrize(
    ("bound", "options", "limit"),
    [
        (np.inf, {"degree": 0}, 0.92932),
        (np.inf, {"relaxation": "polya-1"}, 0.99359),
        (0.5, {"relaxation": "polya-1"}, 1.09935),
        (0.1, {"relaxation": "polya-1"}, 1.13988),
        (0.0, {"relaxation": "polya-1"}, 1.14712),
        (0.0, {"relaxation": "polya-3"}, 1.18103),
        (0.0, {"degree": 2}, 1.16873),
        (0.0, {"degree": 12}, 1.22334),
    ],
)
def test_discrete_time_from_any_step_to_none(
    bound: float, options: Mapping[str, Any], limit: float
) -> None:
    """ROLMIP's vertices times k with |h(t+1) - h(t)| <= bound; limits recomputed by bisection.

    Any step is Daafouz and Bernussou's condition, degree 0 the common P.  Without steps the blends
    are stable for k < 1.22732, the inverse of their largest spectral radius.
    """
    pose = {"rate_bounds": bound, "sample_time": 1.0, **options}
    below = fuzzy_lyapunov(rolmip_pair(limit - 1e-3), **pose)

    assert below.found
    assert not fuzzy_lyapunov(rolmip_pair(limit + 1e-3), **pose).found
    assert steepest_step(rolmip_pair(limit - 1e-3), below, bound) <= 1


def test_any_step_agrees_with_daafouz_and_bernussou() -> None:
    """[P_i, A_i' P_l; ., P_l] > 0 for every i and l: four items, in cvxpy as by ourselves."""
    A = rolmip_pair(0.99)
    condition = fuzzy_lyapunov_condition(
        A, rate_bounds=np.inf, relaxation="polya-0", sample_time=1.0
    )
    decrease = condition.lmis[-1]
    said = expressed(condition)
    said.problem().solve(solver="CLARABEL")
    answer = fuzzy_lyapunov(
        A, rate_bounds=np.inf, relaxation="polya-0", sample_time=1.0, scales=[1, 1]
    )

    assert [decrease.label(k) for k in range(4)] == ["h1 h1+", "h1 h2+", "h2 h1+", "h2 h2+"]
    assert margin(condition, said.values()) == pytest.approx(answer.margin, rel=1e-4)
    assert r"P(h^+)" in latex(condition)


def test_three_discrete_rules_with_bounded_steps() -> None:
    A = np.array([[[0.1, 0.9], [0.0, 0.1]], [[0.5, 0.0], [0.9, 0.5]], [[0.3, 0.3], [-0.6, 0.2]]])
    answer = fuzzy_lyapunov(
        A, rate_bounds=3.0, sample_time=0.1, relaxation="polya-0", decay_rate=0.2
    )
    assert answer.decay_rate is not None and answer.decay_rate >= 0.2

    assert steepest_step(A, answer, 0.3) <= np.exp(-2 * 0.1 * answer.decay_rate) * (1 + 1e-6)


BOUNDS = [[1, 1], [1, 2, 3], [0.1, 0.5, 2], [1, 1, 1, 1], [0, 0.2, 0.3], [0, 0, 2], [np.inf, 1, 1]]


def farthest(c: Floats, **constraints: Any) -> float:
    best = linprog(-c, **constraints)
    assert best.status == 0
    return -float(best.fun or 0.0)


@pytest.mark.parametrize("bound", BOUNDS)
def test_velocities_reach_as_far_as_the_bounds_let_them(bound: list[float]) -> None:
    """In every direction the farthest corner is the linear program's optimum, and none beyond."""
    phi = np.array(bound, dtype=np.float64)
    corners = velocity_corners(phi)
    for c in np.random.default_rng(0).standard_normal((20, len(phi))):
        far = farthest(c, A_eq=np.ones((1, len(phi))), b_eq=[0], bounds=np.stack([-phi, phi], 1))
        assert (corners @ c).max() == pytest.approx(far, abs=1e-9)
    assert np.abs(corners.sum(axis=1)).max() < 1e-12


@pytest.mark.parametrize("bound", [[0.3, 0.3], [0.3, 5], [0.3, 0.3, 0.3], [0.1, 0.5, 2], [0.3] * 4])
def test_steps_reach_as_far_as_the_bounds_let_them(bound: list[float]) -> None:
    phi = np.array(bound)
    n = len(phi)
    corners = np.concatenate(step_corners(phi)).T
    apart = np.hstack([-np.eye(n), np.eye(n)])
    sums = np.kron(np.eye(2), np.ones((1, n)))
    for c in np.random.default_rng(0).standard_normal((20, 2 * n)):
        far = farthest(
            c,
            A_ub=np.vstack([apart, -apart]),
            b_ub=np.concatenate([phi, phi]),
            A_eq=sums,
            b_eq=[1, 1],
        )
        assert (corners @ c).max() == pytest.approx(far, abs=1e-9)


def test_constant_memberships_have_one_velocity_and_step_to_themselves() -> None:
    assert velocity_corners(np.zeros(4)).tolist() == [[0.0] * 4]
    now, then = step_corners(np.zeros(3))
    np.testing.assert_array_equal(now, np.eye(3))
    np.testing.assert_array_equal(then, np.eye(3))


def test_too_many_are_refused_with_a_way_out() -> None:
    """The corners multiply with the memberships; the message says what to do instead."""
    with pytest.raises(ModelError, match="13 memberships .* more than 12; give the model"):
        velocity_corners(np.ones(13))
    with pytest.raises(ModelError, match="5 memberships .* more than 4; let"):
        step_corners(np.full(5, 0.1))


def test_fractions_stay_exact() -> None:
    """A third is no dyadic: raised by one degree, h1 h1 h2 takes 2/3 and 1/3 of its neighbours."""
    X = Known(Basis((2,), (2,)), np.array([[[Fraction(k)]] for k in (1, 10, 100)]))
    raised = X.raised((1,)).values[:, 0, 0]
    found = contributions(UnknownPolynomial.of(Basis((2,), (1,))), X, (4,))

    assert raised.tolist() == [1, Fraction(1, 3) + Fraction(20, 3), Fraction(120, 3), 100]
    assert all(type(entry) is Fraction for entry in found.values.flat)
