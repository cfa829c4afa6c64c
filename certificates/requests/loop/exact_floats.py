"""The checker's exact matrices as floats, so that candidates are about the same loops."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import read_text
from takagi.models.arrays import Floats


def floats(matrix: Matrix) -> Floats:
    """Return the nearest floats of a matrix's entries."""
    return np.array([[entry / matrix.below for entry in row] for row in matrix.rows])


def stack_of(matrices: Iterable[Matrix]) -> Floats:
    """Return (N, rows, columns) of matrices of one shape."""
    return np.array([floats(matrix) for matrix in matrices])


def as_read(evidence: Mapping[str, Any]) -> dict[str, Any]:
    """Return plain data as the checker reads it from a file."""
    return read_text(json.dumps(evidence), "evidence")
