r"""The change of variables that makes dynamic output feedback linear, and its inverse.

For the plant x' = A x + B u, y = C x and a controller s' = A_K s + B_K y, u = C_K s + D_K y of the
same order, the Lyapunov matrix P of z = (x, s) is written with X and Y,

    P = [[Y, N], [N', *]],    P^-1 = [[X, M], [M', *]],    M N' = I - X Y.

In the unknowns X, Y and

    Dh = D_K
    Ch = C_K M' + D_K C X
    Bh = N B_K + Y B D_K
    Ah = N A_K M' + N B_K C X + Y B C_K M' + Y (A + B D_K C) X

the Lyapunov inequality of the closed loop is linear after a congruence.  P > 0 is W > 0,
W = [[X, I], [I, Y]].  In discrete time x+ and s+ replace x' and s'.

Source: Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42(7):896-911, section IV,
recalled.
"""

from __future__ import annotations

import numpy as np

from takagi.models.arrays import Floats


def factors(X: Floats, Y: Floats) -> tuple[Floats, Floats]:
    """Return M and N (n, n) with M N' = I - X Y, by its singular values."""
    U, sizes, V = np.linalg.svd(np.eye(len(X)) - X @ Y)
    return U * np.sqrt(sizes), V.T * np.sqrt(sizes)


def controller_matrices(
    plant: tuple[Floats, Floats, Floats],
    X: Floats,
    Y: Floats,
    hats: tuple[Floats, Floats, Floats, Floats],
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return A_K, B_K, C_K, D_K from the unknowns of the LMIs.

    Parameters
    ----------
    plant : A (n, n), or (r, n, n) for one matrix a rule; B (n, m); C (p, n).
    X, Y : (n, n), with I - X Y invertible.
    hats : Ah (n, n), Bh (n, p), Ch (m, n), Dh (m, p), each with a first axis of rules where A has
        one.
    """
    A, B, C = plant
    Ah, Bh, Ch, Dh = hats
    M, N = factors(X, Y)
    C_K = _transposed(_solved(M, _transposed(Ch - Dh @ C @ X)))
    B_K = _solved(N, Bh - Y @ B @ Dh)
    rest = Ah - N @ B_K @ C @ X - Y @ B @ C_K @ M.T - Y @ (A + B @ Dh @ C) @ X
    A_K = _transposed(_solved(M, _transposed(_solved(N, rest))))
    return A_K, B_K, C_K, Dh


def lyapunov_matrix(X: Floats, Y: Floats) -> Floats:
    """Return P (2n, 2n) of V = z' P z, z = (x, s): P [X, I; M', 0] = [I, Y; 0, N']."""
    M, N = factors(X, Y)
    zero, one = np.zeros_like(X), np.eye(len(X))
    P = np.block([[one, Y], [zero, N.T]]) @ np.linalg.inv(np.block([[X, one], [M.T, zero]]))
    return np.asarray((P + P.T) / 2)


def _solved(M: Floats, right: Floats) -> Floats:
    return np.asarray(np.linalg.solve(M, right), dtype=np.float64)


def _transposed(stack: Floats) -> Floats:
    return np.asarray(stack.swapaxes(-1, -2))
