"""Polynomial Lyapunov functions for constant parameters: published numbers, laws, exact checks."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import (
    Answer,
    common_lyapunov,
    exact_matrices,
    expressed,
    latex,
    polynomial_lyapunov,
    polynomial_lyapunov_condition,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.refutation.exact_algebra import is_definite
from takagi.models import ModelError, Premise, TSModel
from tests.lmi.known_models import oscillators, planar_pair

pytestmark = pytest.mark.numeric

Floats = NDArray[np.float64]


def blends(A: Floats, answer: Answer) -> tuple[Floats, Floats]:
    """Return A(h) and P(h) at the corners and at random h."""
    assert answer.lyapunov_function is not None
    r = len(A)
    h = np.concatenate([np.eye(r), np.random.default_rng(0).dirichlet(np.ones(r), 300)])
    return np.tensordot(h, A, axes=1), answer.lyapunov_function.at(h)


def slowest(A: Floats, answer: Answer) -> float:
    """Return the least alpha with He(P A) + 2 alpha P <= 0 over blends: what V really shows."""
    M, P = blends(A, answer)
    L = np.linalg.cholesky(P)
    inside = np.linalg.solve(L, (P @ M + (P @ M).transpose(0, 2, 1)))
    inside = np.linalg.solve(L, inside.transpose(0, 2, 1))
    return -float(np.linalg.eigvalsh(inside)[:, -1].max()) / 2


def test_degree_zero_is_a_common_P() -> None:
    """Both sides of 4 + 4 sqrt(2); further off a no is shown."""
    for off, status in ((-1e-2, "candidate"), (1e-1, "infeasible")):
        A = oscillators(4 + 4 * np.sqrt(2) + off)
        assert polynomial_lyapunov(A, degree=0).status == status
    beyond = oscillators(4 + 4 * np.sqrt(2) + 1e-2)
    assert not polynomial_lyapunov(beyond, degree=0).found


@pytest.mark.parametrize("A", [oscillators(20.0), planar_pair(40.0)])
def test_constant_parameters_need_no_common_P(A: Floats) -> None:
    """lam = 20 and a = 40: every blend is stable, no common P; one P a rule shows it."""
    answer = polynomial_lyapunov(A)

    assert common_lyapunov(A).status == "infeasible"
    assert answer.found and answer.P is None
    assert answer.decay_rate is not None and answer.decay_rate > 0
    assert slowest(A, answer) >= answer.decay_rate - 1e-9
    assert np.linalg.eigvals(blends(A, answer)[0]).real.max() <= -answer.decay_rate


def test_the_decay_rate_of_frozen_blends_is_reached() -> None:
    """lam = 20: all blends decay with Re = -2 exactly, which P of degree 1 shows to 1e-4."""
    A = oscillators(20.0)
    np.testing.assert_allclose(np.linalg.eigvals(A).real, -2.0)

    assert polynomial_lyapunov(A, decay_rate=1.9999).found
    assert polynomial_lyapunov(A, decay_rate=2.0001).status == "infeasible"


def two_premises(k: float) -> TSModel:
    """x'' + (1 + p) x' + (2 + q) x = 0 with p, q moved by k."""
    A: Any = [[[0, 1], [-2 - k * q, -1 - k * p]] for p in (-1, 1) for q in (-1, 1)]
    return TSModel(A, premises=[Premise("p", -k, k), Premise("q", -k, k)])


def test_premises_have_a_simplex_each() -> None:
    """Two premises: 3 x 3 coefficients in the place of the 10 of four vertices."""
    model = two_premises(0.9)
    product = polynomial_lyapunov_condition(model)
    flat = polynomial_lyapunov_condition(model.A)
    answer = polynomial_lyapunov(model)
    assert answer.lyapunov_function is not None
    h = model.memberships(p=[0.3, -0.9], q=[0.1, 0.9]).T

    assert (product.lmis[-1].count, flat.lmis[-1].count) == (9, 10)
    assert product.lmis[-1].label(1) == "(p low) (p low) (q low) (q high)"
    np.testing.assert_allclose(
        answer.lyapunov_function.at(h)[1], answer.lyapunov_function.vertices[1], atol=1e-9
    )
    np.testing.assert_allclose(
        answer.lyapunov_function.at(h),
        np.tensordot(h, answer.lyapunov_function.vertices, axes=1),
        atol=1e-9,
    )


def test_gains_close_the_loop() -> None:
    """With K the loop is of degree 2; K = 0 is the open loop; a P holds for A(h) - B(h) K(h)."""
    model = TSModel([[[0, 1], [1, 0]], [[0, 1], [3, 0]]], [[[0], [1]], [[0], [2]]], C=[[1, 0]])
    K = np.array([[[4.0, 2.0]], [[3.0, 2.0]]])
    answer = polynomial_lyapunov(model, gains=K)
    assert answer.lyapunov_function is not None
    h = np.random.default_rng(0).dirichlet(np.ones(2), 100)
    A, B, gain = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    P, loop = answer.lyapunov_function.at(h), A - B @ gain
    drop = P @ loop + (P @ loop).transpose(0, 2, 1)

    assert np.linalg.eigvalsh(drop).max() < 0
    open_loop = polynomial_lyapunov(model, gains=0 * K)
    assert open_loop.status == "infeasible"
    assert open_loop.diagnosis.startswith("rule 2 of 2 alone rules it out: its eigenvalue 1.73205")


def test_a_found_P_rounded_to_short_decimals_holds_in_rationals() -> None:
    """lam = 20 as rationals: every coefficient positive definite, without floating point."""
    A = np.vectorize(Fraction, otypes=[object])(oscillators(20.0))
    condition = polynomial_lyapunov_condition(A, degree=3, polya=1, decay_rate=1.0)
    answer = polynomial_lyapunov(oscillators(20.0), degree=3, polya=1, decay_rate=1.0)
    assert answer.lyapunov_function is not None
    members = np.vectorize(lambda entry: Fraction(f"{entry:.6f}"), otypes=[object])(
        answer.lyapunov_function.members
    )

    for lmi in (condition.lmis[0], condition.lmis[-1]):
        exact = exact_matrices(condition, lmi, {"P": members})
        assert all(type(entry) is Fraction for entry in exact.flat)
        assert all(is_definite(matrix) for matrix in exact)
    members[0] = -members[0]
    broken = exact_matrices(condition, condition.lmis[-1], {"P": members})
    assert not all(is_definite(matrix) for matrix in broken)


def test_cvxpy_finds_the_same_margin() -> None:
    """The same condition through another modeller; and it prints."""
    A = oscillators(20.0)
    condition = polynomial_lyapunov_condition(A, polya=1)
    said = expressed(condition)
    said.problem().solve(solver="CLARABEL")
    values = said.values()

    answer = polynomial_lyapunov(A, scales=[1, 1], polya=1)
    assert margin(condition, values) == pytest.approx(answer.margin, rel=1e-4)
    assert "P(h)" in latex(condition)


def test_units_do_not_matter() -> None:
    """States in other units: the same margin and rate, and P in those units."""
    A, s = oscillators(20.0), np.array([1.0, 2.0**20])
    plain, scaled = polynomial_lyapunov(A), polynomial_lyapunov(A * s / s[:, None])
    assert plain.lyapunov_function is not None and scaled.lyapunov_function is not None

    assert scaled.margin == pytest.approx(plain.margin, rel=1e-9)
    assert scaled.decay_rate == pytest.approx(plain.decay_rate, rel=1e-6)
    np.testing.assert_allclose(
        scaled.lyapunov_function.members / s / s[:, None],
        plain.lyapunov_function.members,
        rtol=1e-5,
    )


def test_an_unstable_blend_rules_out_every_degree() -> None:
    """Two stable vertices whose mean is not: said without a solver."""
    answer = polynomial_lyapunov([[[-1, 10], [0, -1]], [[-1, 0], [10, -1]]], degree=4)

    assert answer.status == "infeasible" and not answer.tries
    assert answer.diagnosis.startswith("the mean of rules 1 and 2 of 2 alone rules it out")


def test_a_no_is_about_its_own_degree_and_names_what_binds() -> None:
    """lam = 20 with one P: the diagnosis says that others are not ruled out."""
    answer = polynomial_lyapunov(oscillators(20.0), degree=0)

    assert answer.status == "infeasible" and answer.lyapunov_function is None
    assert "says nothing of others: the no rests on h1 (" in answer.diagnosis
    assert "raise the degree" in answer.diagnosis


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"degree": -1}, "degree is -1; whole numbers from 0"),
        ({"degree": 1.5}, "degree is 1.5"),
        ({"degree": (1, 1)}, r"degree is \(1, 1\); whole numbers from 0 are needed, one number"),
        ({"polya": -1}, "polya is -1"),
        ({"polya": True}, "polya is True"),
        ({"decay_rate": np.nan}, "decay_rate is nan"),
        ({"gains": np.zeros((2, 1, 2))}, "no B"),
        ({"sample_time": -1.0}, "sample_time is -1 s"),
    ],
)
def test_misuse_is_said(options: Mapping[str, Any], said: str) -> None:
    """What was given, and what is needed."""
    with pytest.raises(ModelError, match=said):
        polynomial_lyapunov(oscillators(1.0), **options)
