"""Problems in SDPA's sparse format as conditions: minimise c' x with sum_k F_k x_k - F_0 >= 0.

Source of the format: Fujisawa, Kojima, Nakata and Yamashita (2002), SDPA user's manual; of the
problems and their optima: Borchers (1999), SDPLIB 1.2, Optimization Methods and Software 11.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from takagi.lmi import LMI, Condition, Constant, Term, Unknown

# Borchers (1999), table of optimal objective values, to the digits printed there.
OPTIMA = {
    "control1": "1.778463e+01",
    "control2": "8.300000e+00",
    "control3": "1.363327e+01",
    "control4": "1.979423e+01",
    "control5": "1.68836e+01",
    "control6": "3.73044e+01",
    "hinf1": "2.0326e+00",
    "hinf2": "1.0967e+01",
    "hinf3": "5.69e+01",
    "hinf4": "2.74764e+02",
    "hinf5": "3.63e+02",
    "hinf6": "4.490e+02",
    "hinf7": "3.91e+02",
    "hinf8": "1.16e+02",
    "hinf9": "2.3625e+02",
    "hinf10": "1.09e+02",
    "hinf11": "6.59e+01",
    "hinf12": "2e-1",
    "hinf13": "4.6e+01",
    "hinf14": "1.30e+01",
    "hinf15": "2.5e+01",
}


def read_sdpa(path: Path) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    """Return the cost c, (m,), and F of every block, (m + 1, n, n)."""
    lines = [
        line for line in path.read_text().splitlines() if line[:1] not in '"*' and line.strip()
    ]
    m = int(lines[0].split()[0])
    sizes = [abs(int(word)) for word in re.findall(r"-?\d+", lines[2])]
    cost = np.array([float(word) for word in re.split(r"[\s,{}()]+", lines[3]) if word])
    blocks = [np.zeros((m + 1, size, size)) for size in sizes]
    for line in lines[4:]:
        k, which, i, j, value = line.split()[:5]
        block, row, column = blocks[int(which) - 1], int(i) - 1, int(j) - 1
        block[int(k), row, column] = block[int(k), column, row] = float(value)
    return cost, blocks


def condition_of(
    name: str, cost: NDArray[np.float64], blocks: list[NDArray[np.float64]]
) -> Condition:
    """Return the problem as a condition on the unknown ``x``, one LMI a block."""
    m = len(cost)
    x = Unknown("x", 1, 1, count=m)
    lmis = []
    for number, F in enumerate(blocks, start=1):
        every = Term(unknown=x, left=F[1:], items=np.zeros(m, dtype=np.intp), members=np.arange(m))
        lmis.append(
            LMI(
                name=f"block {number}",
                blocks=(F.shape[1],),
                terms=(every,),
                constants=(Constant(value=-F[:1]),),
            )
        )
    return Condition(
        name=name, unknowns=(x,), lmis=tuple(lmis), objective={"x": cost[:, None, None]}
    )
