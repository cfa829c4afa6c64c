"""The change of variables of output feedback, forward by its formulas and back by the code."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi.gains.output_feedback import (
    controller_matrices,
    factors,
    lyapunov_matrix,
)

RANDOM = np.random.default_rng(3)
X, Y = np.diag([3.0, 2.0]), np.array([[2.0, 0.5], [0.5, 4.0]])


@pytest.mark.parametrize("rules", [(), (3,)], ids=["one plant", "three rules"])
def test_the_controller_comes_back(rules: tuple[int, ...]) -> None:
    """Ah, Bh, Ch, Dh of a given controller by Scherer, Gahinet and Chilali (1997), section IV."""
    A, B, C = RANDOM.normal(size=(*rules, 2, 2)), RANDOM.normal(size=(2, 1)), np.eye(2)[:1]
    A_K, B_K = RANDOM.normal(size=(*rules, 2, 2)), RANDOM.normal(size=(*rules, 2, 1))
    C_K, D_K = RANDOM.normal(size=(*rules, 1, 2)), RANDOM.normal(size=(*rules, 1, 1))
    M, N = factors(X, Y)
    Ch = C_K @ M.T + D_K @ C @ X
    Bh = N @ B_K + Y @ B @ D_K
    Ah = N @ A_K @ M.T + N @ B_K @ C @ X + Y @ B @ C_K @ M.T + Y @ (A + B @ D_K @ C) @ X

    found = controller_matrices((A, B, C), X, Y, (Ah, Bh, Ch, D_K))

    np.testing.assert_allclose(M @ N.T, np.eye(2) - X @ Y, atol=1e-12)
    for one, other in zip(found, (A_K, B_K, C_K, D_K), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-10)


def test_the_lyapunov_matrix_has_the_blocks_that_are_stated() -> None:
    """P = [[Y, N], [N', *]] and P^-1 = [[X, M], [M', *]], positive as W = [[X, I], [I, Y]] is."""
    M, N = factors(X, Y)

    P = lyapunov_matrix(X, Y)

    np.testing.assert_allclose(P[:2], np.hstack([Y, N]), atol=1e-12)
    np.testing.assert_allclose(np.linalg.inv(P)[:2], np.hstack([X, M]), atol=1e-12)
    assert np.linalg.eigvalsh(P).min() > 0
