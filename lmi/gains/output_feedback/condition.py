r"""Energy gain by dynamic output feedback as LMIs; nothing here solves them.

For the generalised plant and a controller of its order, with the unknowns X, Y symmetric, Ah, Bh,
Ch and Dh,

    [ He(A X + B2 Ch)   Ah' + A + B2 Dh C2   B1 + B2 Dh D21   (C1 X + D12 Ch)'     ]
    [ .                 He(Y A + Bh C2)      Y B1 + Bh D21    (C1 + D12 Dh C2)'    ]  < 0
    [ .                 .                    -gamma I         (D11 + D12 Dh D21)'  ]
    [ .                 .                    .                -gamma I             ]

    [ X   I ]
    [ I   Y ]  > 0

and gamma least: the bounded real lemma of the loop after a congruence and a change of variables
that makes it linear.  Every norm above the optimum is reached by such a controller, so the least
gamma is that of all linear controllers.

Continuous time alone: the bilinear transform carries a sampled problem there and back, with its
norm.

Source: Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42, section IV, recalled.

The change of variables that makes dynamic output feedback linear, and its inverse.

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

from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, block, matrix
from takagi.lmi.gains.output_feedback.generalised_plant import GeneralisedPlant
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
    remainder = Ah - N @ B_K @ C @ X - Y @ B @ C_K @ M.T - Y @ (A + B @ Dh @ C) @ X
    A_K = _transposed(_solved(M, _transposed(_solved(N, remainder))))
    return A_K, B_K, C_K, Dh


def _solved(M: Floats, right_side: Floats) -> Floats:
    return np.asarray(np.linalg.solve(M, right_side), dtype=np.float64)


def _transposed(stack: Floats) -> Floats:
    return np.asarray(stack.swapaxes(-1, -2))


def hinf_output_feedback_condition(plant: GeneralisedPlant) -> Condition:
    """Pose the module's LMIs; the objective is gamma.

    Parameters
    ----------
    plant : in continuous time; u does not reach y directly.

    Returns
    -------
    The condition in the plant's coordinates as they are, with the unknowns ``X``, ``Y``, ``Ah``,
    ``Bh``, ``Ch``, ``Dh`` and ``gamma``.  Nothing is solved.

    Raises
    ------
    ModelError : none; the plant has been checked.

    Source: Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42.
    """
    n, q, m = len(plant.A), plant.B1.shape[1], plant.B2.shape[1]
    p, outputs = len(plant.C1), len(plant.C2)
    X = Unknown("X", n, n, symmetric=True)
    Y = Unknown("Y", n, n, symmetric=True)
    Ah = Unknown("Ah", n, n, latex=r"\hat A")
    Bh = Unknown("Bh", n, outputs, latex=r"\hat B")
    Ch = Unknown("Ch", m, n, latex=r"\hat C")
    Dh = Unknown("Dh", m, outputs, latex=r"\hat D")
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    A, B1, B2 = matrix(plant.A, "A"), matrix(plant.B1, "B_1"), matrix(plant.B2, "B_2")
    C1, C2 = matrix(plant.C1, "C_1"), matrix(plant.C2, "C_2")
    D11, D12 = matrix(plant.D11, "D_{11}"), matrix(plant.D12, "D_{12}")
    D21 = matrix(plant.D21, "D_{21}")
    gain = block(
        [
            [
                He(A @ X + B2 @ Ch),
                Ah.T + A + B2 @ Dh @ C2,
                B1 + B2 @ Dh @ D21,
                (C1 @ X + D12 @ Ch).T,
            ],
            [None, He(Y @ A + Bh @ C2), Y @ B1 + Bh @ D21, (C1 + D12 @ Dh @ C2).T],
            [None, None, -gamma * np.eye(q), (D11 + D12 @ Dh @ D21).T],
            [None, None, None, -gamma * np.eye(p)],
        ]
    )
    return pose(
        (block([[X, np.eye(n)], [None, Y]]) >> 0).named("Lyapunov function"),
        (gain << 0).named("bounded real"),
        minimise=gamma,
        name="energy gain by dynamic output feedback",
        source="Scherer, Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42",
    )
