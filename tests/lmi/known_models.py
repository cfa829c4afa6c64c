"""Models of the literature that many tests of gains use, and the values of their designs."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import control
import numpy as np

from takagi.lmi import Answer, Design
from takagi.lmi.varying.robust_gain import robust_hinf_norm
from takagi.models import Floats, Premise, TSModel


def planar_pair(a: float) -> Floats:
    """Dayawansa and Martin (1999), IEEE Trans. Automatic Control 44(4).

    A common P exists exactly for 3 - sqrt 8 < a < 3 + sqrt 8; each vertex is stable for every a.
    """
    return np.array([[[-1.0, -1.0], [1.0, -1.0]], [[-1.0, -a], [1 / a, -1.0]]])


def oscillators(stiffening: float) -> Floats:
    """Two rules of the fuzzy-Lyapunov literature: a common P exactly below 4 + 4 sqrt 2.

    The limit is that of Shorten and Narendra's determinant test.
    """
    return np.array([[[-2.0, 4.0], [-1.0, -2.0]], [[-2.0, 4.0], [-(1 + stiffening), -2.0]]])


def feasp_triple() -> Floats:
    """MathWorks, Robust Control Toolbox, feasp and gevp: three vertices that share a P."""
    return np.array([[[-1, 2], [1, -3]], [[-0.8, 1.5], [1.3, -2.7]], [[-1.4, 0.9], [0.7, -2.0]]])


def rolmip_pair(k: float = 1.0) -> Floats:
    """ROLMIP manual, section 7.1, x+ = A x, times k: stable by a P that moves, not by one P."""
    return k * np.array([[[0.1, 0.9], [0.0, 0.1]], [[0.5, 0.0], [1.0, 0.5]]])


def book_pair() -> Floats:
    """Qi, Tao and Jiang, page 38, as in github S4JJ4D/MATLAB, .Misc/LMI: x+ = A x, a common P."""
    return np.array([[[-0.6, 0.3], [0.1, -0.5]], [[-0.5, 0.2], [0.3, -0.5]]])


def masses_and_spring() -> TSModel:
    """Two masses, springs and a damper, each parameter in an interval: ROLMIP manual, table 2.

    xdot = A(t) x + [0, 0, t1, 0]' w, y = x2; t1 t3 makes it one simplex for each t.
    """
    corners = list(product((2 / 3, 2.0), (0.8, 4 / 3), (1.0, 3.0)))
    A = np.array(
        [
            [[0, 0, 1, 0], [0, 0, 0, 1], [-2 * a, a, -a * c, 0], [b, -b, 0, -b * c]]
            for a, b, c in corners
        ]
    )
    t1, t2 = Premise("t1", Fraction(2, 3), 2), Premise("t2", "0.8", Fraction(4, 3))
    E = [[[0.0], [0.0], [a], [0.0]] for a, _, _ in corners]
    return TSModel(A, E=E, C=[[0, 1, 0, 0]], premises=[t1, t2, Premise("t3", 1, 3)])


def tanaka_wang_rules(a: float = 2.5, b: float = 25.0) -> TSModel:
    """Tanaka and Wang (2001), pages 58 to 60: two rules with parameters a and b."""
    return TSModel(
        [[[2.0, -10.0], [1.0, 0.0]], [[a, -10.0], [1.0, 0.0]]], [[[1.0], [0.0]], [[b], [0.0]]]
    )


def cart_pole() -> TSModel:
    """Wang, Tanaka and Griffin (1996), IEEE Trans. Fuzzy Systems 4(1): pole on a cart, two rules.

    m = 2 kg, M = 8 kg, 2 l = 1 m, g = 9.8 m/s^2; the second rule is at 88 degrees.
    """
    mass, half, gravity = 2.0, 0.5, 9.8
    a, beta = 1 / (mass + 8.0), np.cos(np.deg2rad(88))
    first = 4 * half / 3 - a * mass * half
    second = 4 * half / 3 - a * mass * half * beta**2
    A = np.zeros((2, 2, 2))
    A[:, 0, 1] = 1.0
    A[:, 1, 0] = gravity / first, 2 * gravity / (np.pi * second)
    B = np.zeros((2, 2, 1))
    B[:, 1, 0] = -a / first, -a * beta / second
    return TSModel(A, B)


def placed(model: TSModel, poles: tuple[float, float] = (-2.0, -2.0)) -> Floats:
    return np.stack([control.acker(*rule[:2], poles) for rule in model.vertices]).reshape(2, 1, 2)


def rules_and_pair(model: TSModel, K: Floats) -> Floats:
    """Return G_11, G_22, (G_12 + G_21) / 2 of u = -sum_i h_i K_i x."""
    A, B = model.A, model.B
    pair = (A[0] - B[0] @ K[1] + A[1] - B[1] @ K[0]) / 2
    return np.stack([A[0] - B[0] @ K[0], A[1] - B[1] @ K[1], pair])


# Tanaka and Sano (1994): gains of the truck with a trailer as printed, u = K x.
TRUCK_GAINS = np.array([[[1.2837, -0.4139, 0.0201]], [[0.9773, -0.0709, 0.0005]]])


def truck_trailer() -> TSModel:
    """The truck-trailer of Tanaka and Sano (1994), IEEE Trans. Fuzzy Systems 2(2): two rules.

    l = 2.8 m, L = 5.5 m, v = -1 m/s, T = 2 s; the last row of the second rule times 0.01/pi.
    """
    length, trailer, speed, step = 2.8, 5.5, -1.0, 2.0
    ratio = speed * step / trailer

    def vertex(share: float) -> list[list[float]]:
        return [
            [1 - ratio, 0, 0],
            [ratio, 1, 0],
            [share * speed * step * ratio / 2, share * speed * step, 1],
        ]

    B = [[[speed * step / length], [0.0], [0.0]]] * 2
    return TSModel([vertex(1.0), vertex(0.01 / np.pi)], B, sample_time=step)


def three_rules(b: float, a: float = 2.0) -> TSModel:
    """Kim and Lee (2000), IEEE Trans. Fuzzy Systems 8(5), with a = 2: separates the relaxations."""
    return TSModel(
        [[[1.59, -7.29], [0.01, 0]], [[0.02, -4.64], [0.35, 0.21]], [[-a, -4.33], [0, 0.05]]],
        [[[1.0], [0.0]], [[8.0], [0.0]], [[6.0 - b], [-1.0]]],
    )


def pendulum(step: float | None = None, authority: tuple[float, float] = (-0.177, -0.1)) -> TSModel:
    """Return two rules of a pendulum on a cart; by Euler's rule in discrete time."""
    A = np.array([[[0.0, 1.0], [17.3, 0.0]], [[0.0, 1.0], [9.4, 0.0]]])
    B = np.array([[[0.0], [b]] for b in authority])
    if step is None:
        return TSModel(A, B)
    return TSModel(np.eye(2) + step * A, step * B, sample_time=step)


def torque_pendulum() -> TSModel:
    return pendulum(authority=(-2.0, -1.0))


def blended_rates(model: TSModel, design: Design, h: Floats | None = None) -> Floats:
    """Return -1/2 lambda_max(P^-1 He(P (A(h) - B(h) K(h)))); h random, at corners."""
    K, P = design.require()
    r = len(model.A)
    if h is None:
        h = np.concatenate([np.random.default_rng(0).dirichlet(np.ones(r), 200), np.eye(r)])
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    L = np.linalg.cholesky(P)
    inside = np.linalg.solve(L, ((A - B @ K).transpose(0, 2, 1)) @ L)
    return np.asarray(-np.linalg.eigvalsh(inside + inside.transpose(0, 2, 1))[:, -1] / 2)


def gain_of(answer: Answer) -> float:
    assert answer.status == "candidate", answer.diagnosis
    assert answer.gain is not None
    return answer.gain


def cost_of(design: Design) -> float:
    assert design.status == "candidate", design.answer.diagnosis
    assert design.cost is not None
    return design.cost


def family_gain(model: TSModel, F: float = 0.0, **options: Any) -> Answer:
    """Return ``robust_hinf_norm`` from E to C of the model as it is, with the direct path F."""
    r, p, q = len(model.A), model.C.shape[1], model.E.shape[2]
    channel = model.E, model.C, np.zeros((r, p, 0)), np.full((r, p, q), F)
    return robust_hinf_norm(model, None, channel, **options)
