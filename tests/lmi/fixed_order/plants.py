"""COMPleib's plants with HIFOO's norms by static output feedback, from ``compleib.json``.

The plants are those of F. Leibfritz, COMPleib 1.1 (2004).

``published`` is the column "HIFOO" of the table on H-infinity synthesis in Q. Tran Dinh, S.
Gumussoy, W. Michiels, M. Diehl (2012), IEEE Trans. Automatic Control 57(6): these figures are
recalled, the paper was not at hand.  ``run`` is what HIFOO 3.501 with HANSO 2.0 (as in github
xi1ngang/Hinf-structured-output-Feedback) returned for the same matrices under GNU Octave 7.3, at
default options, cpumax = 60 s, random state 1.  Eighteen plants agree to all the printed digits,
the others are two results of one random search.  NN1 gave no result in the run; WEC1 is not in the
table as recalled.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from takagi.lmi import GeneralisedPlant

FILE = Path(__file__).with_name("compleib.json")
# Beside a norm of zero, the last digit that was printed.
PRINTED = 5e-5


@cache
def _document() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return document


def names() -> list[str]:
    return list(_document()["hifoo"])


def hifoo(name: str) -> tuple[float | None, float | None]:
    """Return HIFOO's norm as published, and as it came out of the run."""
    found = _document()["hifoo"][name]
    return found["published"], found["run"]


def best_of_hifoo(name: str) -> float:
    return min(value for value in hifoo(name) if value is not None)


def plant(name: str) -> GeneralisedPlant:
    """Return x' = A x + B1 w + B2 u, z = C1 x + D11 w + D12 u, y = C2 x + D21 w."""
    stored = _document()["plants"][name]
    n, q, m = (len(stored[key][0]) for key in ("A", "B1", "B2"))
    z, p = len(stored["C1"]), len(stored["C2"])
    shapes = {"A": (n, n), "B1": (n, q), "B2": (n, m), "C1": (z, n), "C2": (p, n)}
    shapes |= {"D11": (z, q), "D12": (z, m), "D21": (p, q)}
    return GeneralisedPlant(
        **{
            key: np.zeros(shape) if stored[key] is None else np.array(stored[key], dtype=np.float64)
            for key, shape in shapes.items()
        }
    )
