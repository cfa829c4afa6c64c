"""Short decimals for a claim, and the checker's exact matrices as floats.

The proof uses exactly these decimals; its margin decides how many digits they need.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import read_text
from takagi.models.arrays import Floats

# Tried in this order: few digits suffice if the margin is large.
DIGITS = (4, 6, 9, 12)


def short(P: Floats, digits: int) -> Floats:
    """Return symmetric P rounded to ``digits`` significant digits of each sqrt(P_ii P_jj).

    This size does not depend on the units of the states.
    """
    scale = np.sqrt(np.abs(np.diag(P)))
    size = np.maximum(np.outer(scale, scale), 1e-30)
    decimals = np.clip(digits - 1 - np.floor(np.log10(size)), -30, 30).astype(int)
    rounded = np.zeros_like(P, dtype=np.float64)
    for i in range(len(P)):
        row = [round(float(P[i, j]), int(decimals[i, j])) for j in range(i + 1)]
        rounded[i, : i + 1] = row
        rounded[: i + 1, i] = row
    return rounded


def rounded_down(value: float, digits: int = 6) -> float:
    """Return a number >= 0 with so many significant digits, rounded down; 0 for less than 0."""
    return _rounded(value, digits, np.floor)


def rounded_up(value: float, digits: int = 6) -> float:
    """Return a number >= 0 with so many significant digits, rounded up; 0 for less than 0."""
    return _rounded(value, digits, np.ceil)


def _rounded(value: float, digits: int, towards: np.ufunc) -> float:
    if value <= 0:
        return 0.0
    scale = 10.0 ** (digits - 1 - np.floor(np.log10(value)))
    return float(f"{towards(value * scale) / scale:.{digits + 6}g}")


def floats(matrix: Matrix) -> Floats:
    """Return the nearest floats of a matrix's entries."""
    return np.array([[entry / matrix.below for entry in row] for row in matrix.rows])


def stack_of(matrices: Iterable[Matrix]) -> Floats:
    """Return (N, rows, columns) of matrices of one shape."""
    return np.array([floats(matrix) for matrix in matrices])


def as_read(evidence: Mapping[str, Any]) -> dict[str, Any]:
    """Return plain data as the checker reads it from a file."""
    return read_text(json.dumps(evidence), "evidence")
