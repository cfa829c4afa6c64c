"""Put values into an LMI: the matrices F_k and their smallest eigenvalues, in floating point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.term import LMI, Array, Condition

__all__ = ["lmi_value", "margin", "smallest_eigenvalues"]


def lmi_value(
    lmi: LMI, values: Mapping[str, Array], parameters: Mapping[str, Any], zero: object = 0.0
) -> Array:
    """Return F_k(X), (count, size, size), summed term by term; the sign is not applied.

    Parameters
    ----------
    values : unknown name -> (count, rows, cols).
    parameters : parameter name -> number.
    zero : what empty entries start from; 0.0 for floats, Fraction(0) for exact arithmetic.
    """
    dtype = np.float64 if isinstance(zero, float) else object
    total = np.full((lmi.count, lmi.size, lmi.size), zero, dtype=dtype)
    for constant in lmi.constants:
        row, column = lmi.spans(constant.at)
        total[:, row, column] += constant.value
        if row != column:
            total[:, column, row] += constant.value.transpose(0, 2, 1)
    for term in lmi.terms:
        item, member, left, right = term.spread(lmi.count)
        X = values[term.unknown.name][member]
        block = X * left if right is None else left @ X @ right
        if term.parameter is not None:
            block = block * parameters[term.parameter]
        if term.plus_transpose:
            block = block + block.transpose(0, 2, 1)
        row, column = lmi.spans(term.at)
        np.add.at(total[:, row, column], item, block)
        if row != column:
            np.add.at(total[:, column, row], item, block.transpose(0, 2, 1))
    return total


def smallest_eigenvalues(condition: Condition, lmi: LMI, values: Mapping[str, Array]) -> Array:
    """Return lambda_min(sign F_k), (count,), by numpy from the values alone."""
    F: NDArray[np.float64] = lmi.sign * lmi_value(lmi, values, condition.parameters)
    return np.asarray(np.linalg.eigvalsh((F + F.transpose(0, 2, 1)) / 2)[:, 0])


def margin(condition: Condition, values: Mapping[str, Array]) -> float:
    """Return the largest t with sign F >= t weight I for every LMI with a weight.

    Normalisations (weight 0) do not count: dividing by their excess mends them.
    """
    return min(
        float(smallest_eigenvalues(condition, lmi, values).min()) / lmi.weight
        for lmi in condition.lmis
        if lmi.weight > 0
    )
