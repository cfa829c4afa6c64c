"""A Takagi-Sugeno model and its law as a certificate states them: decimals as they are emitted.

The proof uses exactly these decimals; its margin decides how many digits they need.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import read_text
from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel
    from takagi.models.ts.premise import Premise


def ts_model_data(model: TSModel) -> dict[str, Any]:
    """Return the model of kind ``takagi-sugeno``: vertices, names, premises, rules, box.

    A matrix that is the same in all rules is written once; one without columns or rows is left
    out.  Every float is written as its shortest decimal, and proofs are about this decimal.
    """
    stacks = {
        letter: _stack(getattr(model, letter))
        for letter in ("A", "B", "C", "D", "E")
        if getattr(model, letter).size
    }
    data: dict[str, Any] = {
        "kind": "takagi-sugeno",
        "name": model.name,
        "sample_time": model.sample_time,
        "state_names": list(model.states),
        "input_names": list(model.inputs),
        "output_names": list(model.outputs),
        "disturbance_names": list(model.disturbances),
        **stacks,
        "box": {
            name: [inner_decimal(low, 1), inner_decimal(high, -1)]
            for name, (low, high) in model.box.items()
            # The model need not hold on the whole box around a band or a union of cells.
            if model.domain is None
        },
    }
    return data | _weights(model.premises, model.rules)


def pdc_law_data(model: TSModel, K: Floats) -> dict[str, Any]:
    """Return u = -sum_j h_j K_j x with the weights of the model, as in gain file and certificate.

    ``K`` : (r, m, n), or (m, n) for one gain in all rules.
    """
    n, m = model.A.shape[1], model.B.shape[2]
    return {
        "name": "pdc",
        "sample_time": model.sample_time,
        "state_names": list(model.states),
        "input_names": list(model.inputs),
        **_weights(model.premises, model.rules),
        "K": _stack(K.reshape(-1, m, n)),
        "trim": {"state": [0.0] * n, "input": [0.0] * m},
    }


def inner_decimal(end: Fraction, direction: int) -> float:
    """Return a float whose shortest decimal is not below the end (1), or not above it (-1)."""
    inner = float(end)
    while direction * (Fraction(repr(inner)) - end) < 0:
        inner = float(np.nextafter(inner, direction * np.inf))
    return inner


def _stack(matrices: Floats) -> list[list[list[float]]]:
    same = bool((matrices == matrices[0]).all())
    return (matrices[:1] if same else matrices).tolist()  # type: ignore[no-any-return]


def _weights(premises: Sequence[Premise], rules: Sequence[tuple[int, ...]]) -> dict[str, Any]:
    if not premises:
        return {}
    return {
        "premises": [
            {
                "name": premise.name,
                "lower": float(premise.lower),
                "upper": float(premise.upper),
                "unit": premise.unit,
            }
            for premise in premises
        ],
        "rules": [list(rule) for rule in rules],
    }


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


def as_read(data: Mapping[str, Any], source: str = "candidate") -> dict[str, Any]:
    """Return plain data as the checker reads it from a file; ``source`` is named in a refusal."""
    return read_text(json.dumps(data), source)
