"""Systems of COMPleib that the tests share, and the least norms that state feedback reaches.

Source: F. Leibfritz (2004), COMPleib: COnstraint Matrix-optimization Problem library, University of
Trier; release 1.1, as ``fixed_order/compleib.json`` has them.  x' = A x + B1 w + B u, z = C1 x +
D12 u, y = C x; nothing direct from w.  The least norms are not printed there: they are the limits
of the Riccati equations for u = -K x, to the digits given, computed before these conditions were
written.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from takagi.models import Floats
from tests.lmi.fixed_order.plants import plant


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


def system(name: str) -> System:
    matrices, (hinf, h2) = plant(name), LEAST_NORMS[name]
    A, B1, B, C1, D12, C = (
        np.asarray(array, dtype=np.float64)
        for array in (
            *(matrices.A, matrices.B1, matrices.B2),
            *(matrices.C1, matrices.D12, matrices.C2),
        )
    )
    return System(A=A, B1=B1, B=B, C1=C1, D12=D12, C=C, hinf=hinf, h2=h2)


LEAST_NORMS = {
    "AC15": (14.8556162359, 12.298252849),
    "AC17": (6.61242785625, 3.89378093778),
    "AC3": (2.58807097366, 3.68262094244),
    "DIS2": (0.910424852808, 1.34150472432),
    "HE1": (0.0601462843451, 0.0316084670584),
    "MFP": (3.80676884357, 3.25142572003),
    "NN2": (1.49899286389, 1.48235226142),
    "NN4": (1.28439338642, 1.52679365191),
    "REA1": (0.502808990518, 1.26609934415),
    "TG1": (3.46523362625, 5.12136920892),
}
SYSTEMS = {name: partial(system, name) for name in LEAST_NORMS}
ac15, mfp, tg1 = (SYSTEMS[name] for name in ("AC15", "MFP", "TG1"))
