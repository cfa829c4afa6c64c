"""The variance under white noise: exact thresholds, and a second way."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from takagi.certificates.requests import H2Norm
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import ModelError, TSModel
from tests.certificates.kinds.claims import model_data, verdict_of

Data = dict[str, Any]


def line() -> tuple[Data, Data]:
    """Return x' = -2 x + w, y = x, of H2 norm 1 / sqrt(2 a) = 1/2, and a claim."""
    model = model_data([[[-2]]], E=[[[1]]], C=[[[1]]])
    claim = {"name": "line", "kind": "h2-norm", "disturbance": "disturbances"}
    return model, claim | {"norm": 0.500000001, "P": [[0.2500000001]]}


def sampled() -> tuple[Data, Data]:
    """Return x+ = 0.6 x + w, y = x, of H2 norm 1 / sqrt(1 - a^2) = 5/4, and a claim."""
    model = model_data([[[0.6]]], E=[[[1]]], C=[[[1]]], sample_time=0.1)
    claim = {"name": "line", "kind": "h2-norm", "disturbance": "disturbances"}
    return model, claim | {"norm": 1.250000001, "P": [[1.5625000001]]}


@pytest.mark.parametrize(("case", "limit"), [(line, 0.5), (sampled, 1.25)])
def test_norm_from_both_sides_of_its_exact_value(case: Any, limit: float) -> None:
    model, claim = case()

    assert verdict_of(model, None, claim) == "PROVED"
    for norm in (limit, limit - 1e-9):
        for p in (limit**2 - 1e-9, limit**2, limit**2 + 1e-9):
            at_limit = claim | {"norm": norm, "P": [[p]]}
            assert verdict_of(model, None, at_limit) == "UNDECIDED"


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
matrices = st.lists(numbers, min_size=4, max_size=4).map(lambda v: np.reshape(v, (2, 2)))


@settings(max_examples=15, deadline=None)
@given(matrices, st.booleans())
def test_one_vertex_has_the_norm_of_its_gramian(A: Any, discrete: bool) -> None:
    """sqrt(tr B'PB) with the observability Gramian P, solved by scipy: equal to 3e-4."""
    A = A * 0.45 if discrete else A - 2.5 * np.eye(2)
    B, C = np.array([[1.0], [0.5]]), np.array([[1.0, 0.2]])
    solve = solve_discrete_lyapunov if discrete else solve_continuous_lyapunov
    P = solve(A.T, C.T @ C if discrete else -C.T @ C)
    truth = float(np.sqrt((B.T @ P @ B)[0, 0]))
    loop = ClaimedLoop.of(TSModel([A], C=[C], E=[B], sample_time=0.5 if discrete else None))

    attempt = H2Norm().attempt(loop)

    assert attempt.proved
    assert truth < attempt.claim["norm"] < truth * (1 + 3e-4)
    assert H2Norm(truth * (1 + 1e-4)).attempt(loop).proved
    assert not H2Norm(truth * (1 - 1e-4)).attempt(loop).proved


def test_misuse_raises() -> None:
    with pytest.raises(ModelError, match="positive"):
        H2Norm(0.0)
