"""SDPLIB's control1, transcribed: a problem that a solver gets wrong without noticing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from takagi.lmi import LMI, Condition, Constant, Term, Unknown

# Borchers (1999), SDPLIB 1.2, table of optimal objective values: 1.778463e+01.
OPTIMUM = 17.78463
SIZES = (10, 5)

# ``control1.txt``: k, block, row, column, value of the upper triangles of F_0 ... F_21, as in
# control1.dat-s; the cost is 0 but for -1 of the last variable.
ENTRIES = Path(__file__).with_name("control1.txt").read_text(encoding="utf-8")


def matrices(block: int) -> NDArray[np.float64]:
    """Return F_0 ... F_21 of a block, (22, n, n)."""
    size = SIZES[block]
    F = np.zeros((22, size, size))
    for entry in ENTRIES.replace("\n", " ").split(";"):
        k, which, row, column, value = entry.split()
        if int(which) == block + 1:
            i, j = int(row) - 1, int(column) - 1
            F[int(k), i, j] = F[int(k), j, i] = float(value)
    return F


def control1(*, whole: bool = False) -> Condition:
    """Minimise -x_21 with sum_k F_k x_k - F_0 >= 0; ``whole`` is one block 15 wide for two."""
    x = Unknown("x", 1, 1, count=21)
    blocks = [matrices(0), matrices(1)]
    if whole:
        both = np.zeros((22, 15, 15))
        both[:, :10, :10], both[:, 10:, 10:] = blocks
        blocks = [both]
    cost = np.zeros((21, 1, 1))
    cost[20] = -1.0
    lmis = tuple(_lmi(f"block {k + 1}", F, x) for k, F in enumerate(blocks))
    return Condition(name="SDPLIB control1", unknowns=(x,), lmis=lmis, objective={"x": cost})


def _lmi(name: str, F: NDArray[np.float64], x: Unknown) -> LMI:
    every = Term(
        unknown=x, left=F[1:], items=np.zeros(21, dtype=np.intp), members=np.arange(21), at=None
    )
    return LMI(name=name, blocks=(F.shape[1],), terms=(every,), constants=(Constant(value=-F[:1]),))
