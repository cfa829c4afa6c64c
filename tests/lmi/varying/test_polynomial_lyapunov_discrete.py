"""Polynomial Lyapunov functions in discrete time: the ROLMIP manual's example, exactly too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import (
    LMI,
    Answer,
    Condition,
    Constant,
    Term,
    Unknown,
    exact_matrices,
    optimise,
    polynomial_lyapunov,
    polynomial_lyapunov_condition,
)
from takagi.lmi.refutation.exact_algebra import is_definite
from tests.lmi.known_models import rolmip_pair

Floats = NDArray[np.float64]


def steepest(A: Floats, answer: Answer) -> float:
    """Return the largest V(x+) / V(x) over blends."""
    assert answer.lyapunov_function is not None
    h = np.concatenate([np.eye(2), np.random.default_rng(0).dirichlet(np.ones(2), 300)])
    M, P = np.tensordot(h, A, axes=1), answer.lyapunov_function.at(h)
    L = np.linalg.cholesky(P)
    moved = np.linalg.solve(L, (L.transpose(0, 2, 1) @ M).transpose(0, 2, 1))
    return float(np.linalg.norm(moved, 2, axis=(1, 2)).max() ** 2)


def printed_P() -> list[list[list[str]]]:
    """Return the P that the ROLMIP manual prints in section 7.1."""
    return [
        [["0.56664", "0.0039574"], ["0.0039574", "0.87634"]],
        [["1.0987", "0.062489"], ["0.062489", "0.45827"]],
    ]


def exact_discrete() -> Any:
    entries = [[["1/10", "9/10"], ["0", "1/10"]], [["1/2", "0"], ["1", "1/2"]]]
    return np.vectorize(Fraction, otypes=[object])(np.array(entries))


def test_the_printed_P_of_the_rolmip_manual_holds_exactly() -> None:
    """Section 7.1: residuals 0.17957, 0.12168, 0.056108 of [[P, A'P], [., P]], by rationals.

    They are of the polynomial's plain coefficients; that of h_1 h_2 is twice Bernstein's.
    """
    condition = polynomial_lyapunov_condition(exact_discrete(), sample_time=1.0)
    F = exact_matrices(condition, condition.lmis[-1], {"P": np.array(printed_P())})
    plain = F * np.array([1, 2, 1])[:, None, None]

    for matrix, residual in zip(plain, (0.17957, 0.12168, 0.056108), strict=True):
        below, above = Fraction(residual) - Fraction("1e-5"), Fraction(residual) + Fraction("1e-5")
        one = np.eye(4, dtype=int).astype(object)
        assert is_definite(matrix - below * one)
        assert not is_definite(matrix - above * one)


def test_discrete_time_without_a_common_P() -> None:
    """ROLMIP section 7.1: a common P is not strictly feasible; one a vertex is, also faster."""
    A = rolmip_pair()
    answer = polynomial_lyapunov(A, sample_time=0.5, decay_rate=0.1)

    assert polynomial_lyapunov(A, degree=0, sample_time=0.5).status == "infeasible"
    assert answer.found and answer.decay_rate is not None
    assert 0.1 < answer.decay_rate
    assert steepest(A, answer) <= np.exp(-2 * 0.5 * answer.decay_rate) * (1 + 1e-9)


@pytest.mark.parametrize(
    ("options", "limit"),
    [
        ({"degree": 1}, 1.11079),
        ({"degree": 1, "polya": 1}, 1.14712),
        ({"degree": 1, "polya": 3}, 1.18103),
        ({"degree": 2}, 1.16873),
        ({"degree": 3}, 1.19218),
        ({"degree": 12}, 1.22334),
    ],
)
def test_how_far_the_discrete_vertices_may_be_scaled(
    options: Mapping[str, Any], limit: float
) -> None:
    """ROLMIP's vertices times k are stable for k < 1.22732, the largest spectral radius's inverse.

    The limits are recomputed by bisection.
    """
    h = np.linspace(0, 1, 2001)
    A = rolmip_pair()
    radius = np.abs(np.linalg.eigvals(np.tensordot(np.stack([h, 1 - h], 1), A, axes=1))).max()
    pose = polynomial_lyapunov

    assert 1 / radius == pytest.approx(1.22732, abs=1e-5)
    assert pose(A * (limit - 1e-4), sample_time=1.0, **options).found
    assert not pose(A * (limit + 1e-4), sample_time=1.0, **options).found


@pytest.mark.parametrize("polya", range(5))
def test_least_trace_of_yalmips_robust_example(polya: int) -> None:
    """YALMIP, test_robust_4: min max(tr P_1, tr P_2) = 1.8203 for each degree of Polya's theorem.

    sum_ij h_i h_j He(A_i' P_j) <= -I, recomputed 1.8203463.  As both traces count, so does their
    maximum; P needs no scale of its own.
    """
    A = [[[-1.0, 2.0], [0.0, -1.1]], [[-1.0, 1.1], [0.0, -2.0]]]
    posed = polynomial_lyapunov_condition(A, polya=polya)
    P, decrease = posed.unknowns[0], posed.lmis[-1]
    assert decrease.name == "decrease" and decrease.count == polya + 3
    tau = Unknown("tau", 1, 1)
    rows = np.eye(2)[:, None, :]
    traces = LMI(
        name="trace",
        blocks=(1,),
        terms=(
            Term(unknown=tau, left=np.ones((1, 1, 1))),
            *(
                Term(unknown=P, left=-row[None], right=row.T[None], members=np.arange(2))
                for row in rows
            ),
        ),
        count=2,
    )
    condition = Condition(
        name="least trace",
        unknowns=(P, tau),
        lmis=(
            posed.lmis[0],
            replace(decrease, constants=(Constant(value=np.eye(2)[None]),)),
            traces,
        ),
        objective={"tau": np.ones((1, 1, 1))},
        parameters=posed.parameters,
    )

    assert optimise(condition).objective == pytest.approx(1.8203463, abs=5e-6)
