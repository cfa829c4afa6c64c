"""Systems of COMPleib that the tests share, and the least norms that state feedback reaches.

Source: F. Leibfritz (2004), COMPleib: COnstraint Matrix-optimization Problem library, University of
Trier; release 1.1.  x' = A x + B1 w + B u, z = C1 x + D12 u, y = C x; nothing direct from w.
The least norms are not printed there: they are the limits of the Riccati equations for u = -K x,
to the digits given, computed before these conditions were written.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class System(NamedTuple):
    """x' = A x + B1 w + B u, z = C1 x + D12 u, y = C x; the least H-infinity and H2 norms."""

    A: Floats
    B1: Floats
    B: Floats
    C1: Floats
    D12: Floats
    C: Floats
    hinf: float
    h2: float


def ac15() -> System:
    return System(
        A=np.array(
            [
                [-0.037, 0.0123, 0.00055, -1],
                [0, 0, 1, 0],
                [-6.37, 0, -0.23, 0.0618],
                [1.25, 0, 0.016, -0.0457],
            ],
            dtype=float,
        ),
        B1=np.eye(4),
        B=np.array([[0.00084, 0.000236], [0, 0], [0.08, 0.804], [-0.0862, -0.0665]], dtype=float),
        C1=np.array(
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0]],
            dtype=float,
        ),
        D12=np.array([[0, 0], [0, 0], [0, 0], [0, 0], [1, 0], [0, 1]], dtype=float),
        C=np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=float),
        hinf=14.8556162359,
        h2=12.298252849,
    )


def ac17() -> System:
    return System(
        A=np.array(
            [
                [-2.98, 0.93, 0, -0.034],
                [-0.99, -0.21, 0.035, -0.0011],
                [0, 0, 0, 1],
                [0.39, -5.555, 0, -1.89],
            ],
            dtype=float,
        ),
        B1=np.eye(4),
        B=np.array([[-0.032], [0], [0], [-1.6]], dtype=float),
        C1=np.eye(4),
        D12=np.array([[0], [0], [0], [1]], dtype=float),
        C=np.array([[0, 0, 1, 0], [0, 0, 0, 1]], dtype=float),
        hinf=6.61242785625,
        h2=3.89378093778,
    )


def ac3() -> System:
    return System(
        A=np.array(
            [
                [0, 0, 1, 0, 0],
                [0, -0.154, -0.0042, 1.54, 0],
                [0, 0.249, -1, -5.2, 0],
                [0.0386, -0.996, -0.0003, -0.117, 0],
                [0, 0.5, 0, 0, -0.5],
            ],
            dtype=float,
        ),
        B1=np.eye(5),
        B=np.array([[0, 0], [-0.744, -0.032], [0.337, -1.12], [0.02, 0], [0, 0]], dtype=float),
        C1=np.eye(5),
        D12=np.array([[0, 0], [0, 0], [0, 0], [1, 0], [0, 1]], dtype=float),
        C=np.array(
            [[0, 1, 0, 0, -1], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [1, 0, 0, 0, 0]], dtype=float
        ),
        hinf=2.58807097366,
        h2=3.68262094244,
    )


def dis2() -> System:
    return System(
        A=np.array([[-4, 2, 1], [3, -2, 5], [-7, 0, 3]], dtype=float),
        B1=np.eye(3),
        B=np.array([[1, 0], [1, 0], [0, 1]], dtype=float),
        C1=np.eye(3),
        D12=np.array([[0, 0], [1, 0], [0, 1]], dtype=float),
        C=np.array([[0, 1, 0], [0, 0, 1]], dtype=float),
        hinf=0.910424852808,
        h2=1.34150472432,
    )


def he1() -> System:
    return System(
        A=np.array(
            [
                [-0.0366, 0.0271, 0.0188, -0.4555],
                [0.0482, -1.01, 0.0024, -4.0208],
                [0.1002, 0.3681, -0.707, 1.42],
                [0, 0, 1, 0],
            ],
            dtype=float,
        ),
        B1=np.array(
            [[0.04678, 0], [0.04572, 0.00988], [0.04369, 0.00111], [-0.02179, 0]], dtype=float
        ),
        B=np.array([[0.4422, 0.1761], [3.5446, -7.5922], [-5.52, 4.49], [0, 0]], dtype=float),
        C1=np.array([[1.414213562373095, 0, 0, 0], [0, 0.7071067811865475, 0, 0]], dtype=float),
        D12=np.array([[0.7071067811865475, 0], [0, 0.7071067811865475]], dtype=float),
        C=np.array([[0, 1, 0, 0]], dtype=float),
        hinf=0.0601462843451,
        h2=0.0316084670584,
    )


def mfp() -> System:
    return System(
        A=np.array(
            [
                [0, 0, 1, 0],
                [0, 0, 0, 1],
                [-0.101, -0.1681, -0.04564, -0.01075],
                [0.06082, -2.1407, -0.05578, -0.1273],
            ],
            dtype=float,
        ),
        B1=np.eye(4),
        B=np.array(
            [[0, 0, 0], [0, 0, 0], [0.1179, 0.1441, 0.1476], [0.1441, 1.7057, -0.7557]], dtype=float
        ),
        C1=np.eye(4),
        D12=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float),
        C=np.array([[1, 0, 0, 0], [0, 1, 0, 0]], dtype=float),
        hinf=3.80676884357,
        h2=3.25142572003,
    )


def nn2() -> System:
    return System(
        A=np.array([[0, 1], [-1, 0]], dtype=float),
        B1=np.eye(2),
        B=np.array([[0], [1]], dtype=float),
        C1=np.array([[1, 0], [0, 0]], dtype=float),
        D12=np.array([[0], [1]], dtype=float),
        C=np.array([[0, 1]], dtype=float),
        hinf=1.49899286389,
        h2=1.48235226142,
    )


def nn4() -> System:
    return System(
        A=np.array(
            [
                [0, 1, 0, 0],
                [0, -2.93, -4.75, -0.78],
                [0.086, 0, -0.11, -1],
                [0, -0.042, 2.59, -0.39],
            ],
            dtype=float,
        ),
        B1=np.eye(4),
        B=np.array([[0, 0], [0, -3.91], [0.035, 0], [-2.53, 0.31]], dtype=float),
        C1=np.eye(4),
        D12=np.array([[0, 0], [0, 0], [1, 0], [0, 1]], dtype=float),
        C=np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], dtype=float),
        hinf=1.28439338642,
        h2=1.52679365191,
    )


def rea1() -> System:
    return System(
        A=np.array(
            [
                [1.38, -0.2077, 6.715, -5.676],
                [-0.5814, -4.29, 0, 0.675],
                [1.067, 4.273, -6.654, 5.893],
                [0.048, 4.273, 1.343, -2.104],
            ],
            dtype=float,
        ),
        B1=np.eye(4),
        B=np.array([[0, 0], [5.679, 0], [1.136, -3.146], [1.136, 0]], dtype=float),
        C1=np.eye(4),
        D12=np.array([[0, 0], [0, 0], [1, 0], [0, 1]], dtype=float),
        C=np.array([[1, 0, 1, -1], [0, 1, 0, 0], [0, 0, 1, -1]], dtype=float),
        hinf=0.502808990518,
        h2=1.26609934415,
    )


def tg1() -> System:
    return System(
        A=np.array(
            [
                [0, 1, 0, 0, 0, 0, 0, 0, 0, 0],
                [0, -0.11323, -0.98109, -11.847, -11.847, -63.08, -34.339, -34.339, -27.645, 0],
                [
                    324.121,
                    -1.1755,
                    -29.101,
                    0.12722,
                    2.83448,
                    -967.73,
                    -678.14,
                    -678.14,
                    0,
                    -129.29,
                ],
                [-127.3, 0.46167, 11.4294, -1.0379, 13.1237, 380.079, 266.341, 266.341, 0, 1054.85],
                [
                    -186.05,
                    0.67475,
                    16.7045,
                    0.86092,
                    -17.068,
                    555.502,
                    389.268,
                    389.268,
                    0,
                    -874.92,
                ],
                [341.917, 1.09173, 1052.75, 756.465, 756.465, -29.774, 0.16507, 3.27626, 0, 0],
                [-30.748, -0.09817, -94.674, -68.029, -68.029, 2.67753, -2.6558, 4.88497, 0, 0],
                [-302.36, -0.96543, -930.96, -668.95, -668.95, 26.3292, 2.42028, -9.5603, 0, 0],
                [0, 0, 0, 0, 0, 0, 0, 0, -1.6667, 0],
                [0, 0, 0, 0, 0, 0, 0, 0, 0, -10],
            ],
            dtype=float,
        ),
        B1=np.eye(10),
        B=np.array(
            [[0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [1.6667, 0], [0, 10]],
            dtype=float,
        ),
        C1=np.eye(10),
        D12=np.array(
            [[0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [0, 0], [1, 0], [0, 1]],
            dtype=float,
        ),
        C=np.array(
            [[1, 0, 0, 0, 0, 0, 0, 0, 0, 0], [-0.49134, 0, -0.63203, 0, 0, -0.20743, 0, 0, 0, 0]],
            dtype=float,
        ),
        hinf=3.46523362625,
        h2=5.12136920892,
    )


SYSTEMS = {
    "AC15": ac15,
    "AC17": ac17,
    "AC3": ac3,
    "DIS2": dis2,
    "HE1": he1,
    "MFP": mfp,
    "NN2": nn2,
    "NN4": nn4,
    "REA1": rea1,
    "TG1": tg1,
}
