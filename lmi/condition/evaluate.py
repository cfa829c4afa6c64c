"""Put values into an LMI: the matrices F_k and their smallest eigenvalues, in floating point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from takagi.lmi.condition.term import LMI, Array, Condition, Equality
from takagi.models.arrays import Floats

# A margin is recomputed from the unknowns, so its only error is that of rounding, about 1e-15.
SMALLEST_MARGIN = 1e-10
# How far the sides of an equality may be apart, relative to what is summed up: rounding only.
EQUAL = 1e-9


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
        value = constant.value.astype(dtype, copy=False)
        total[:, row, column] += value
        if row != column:
            total[:, column, row] += value.transpose(0, 2, 1)
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
    F: Floats = lmi.sign * lmi_value(lmi, values, condition.parameters)
    return np.asarray(np.linalg.eigvalsh((F + F.transpose(0, 2, 1)) / 2)[:, 0])


def shares(condition: Condition, lmi: LMI, values: Mapping[str, Array]) -> Array:
    """Return lambda_min(sign F_k) relative to the size of what is summed up in F_k, (count,).

    In the units that ``LMI`` states for its tolerance: a non-strict LMI holds where this is at
    least -tolerance.
    """
    F: Floats = lmi.sign * lmi_value(lmi, values, condition.parameters)
    root = np.sqrt(_sizes(lmi, values, condition.parameters))
    inside = (F + F.transpose(0, 2, 1)) / 2 / root[:, :, None] / root[:, None, :]
    return np.asarray(np.linalg.eigvalsh(inside)[:, 0])


def margin(condition: Condition, values: Mapping[str, Array]) -> float:
    """Return the largest t with sign F >= t weight I for every strict LMI.

    If a non-strict LMI is violated by more than its tolerance, or an equality by more than rounding
    explains, return the violation as a negative share of its size. If no LMI is strict, return the
    least share of all; it is 0 if an LMI holds with equality.
    """
    strict = [
        float(smallest_eigenvalues(condition, lmi, values).min()) / lmi.weight
        for lmi in condition.lmis
        if lmi.strict
    ]
    others = [
        (float(shares(condition, lmi, values).min()), lmi)
        for lmi in condition.lmis
        if not lmi.strict
    ]
    missed = [share for share, lmi in others if not share >= -lmi.tolerance]
    gaps = [equality_gap(equality, values) for equality in condition.equalities]
    missed += [-gap for gap in gaps if not gap <= EQUAL]
    if strict or missed:
        return min([*strict, *missed])
    return max(0.0, min((share for share, _ in others), default=0.0))


def holds(condition: Condition, held: float) -> bool:
    """Return whether every LMI holds, from the margin; a strict LMI needs a positive one."""
    return held > SMALLEST_MARGIN if any(lmi.strict for lmi in condition.lmis) else held >= 0


def equality_value(equality: Equality, values: Mapping[str, Array], zero: object = 0.0) -> Array:
    """Return E_k, (count, p, q); ``zero`` as for ``lmi_value``."""
    p = equality.shape[0]
    return np.asarray(lmi_value(equality.frame(), values, {}, zero)[:, :p, p:])


def equality_gap(equality: Equality, values: Mapping[str, Array]) -> float:
    """Return the largest entry of E relative to what is summed up in E_k, without signs."""
    sizes = replace(
        equality,
        terms=tuple(
            replace(
                term,
                left=np.abs(term.left),
                right=None if term.right is None else np.abs(term.right),
            )
            for term in equality.terms
        ),
        constants=tuple(replace(one, value=np.abs(one.value)) for one in equality.constants),
    )
    alone = {name: np.abs(value) for name, value in values.items()}
    size = equality_value(sizes, alone).max(axis=(1, 2))
    gap = np.abs(equality_value(equality, values)).max(axis=(1, 2))
    return float(np.max(np.divide(gap, size, out=np.zeros_like(gap), where=gap > 0)))


def _sizes(lmi: LMI, values: Mapping[str, Array], parameters: Mapping[str, Any]) -> Array:
    """Return the diagonal of N_k, (count, size): see ``LMI``."""
    sizes, largest = np.zeros((lmi.count, lmi.size)), np.zeros(lmi.count)
    for constant in lmi.constants:
        row, column = lmi.spans(constant.at)
        value = np.abs(constant.value.astype(np.float64))
        largest = np.maximum(largest, value.max(axis=(1, 2)))
        if row == column:
            sizes[:, row] += np.diagonal(value, axis1=1, axis2=2)
    for term in lmi.terms:
        row, column = lmi.spans(term.at)
        if row != column:
            continue
        item, member, left, right = term.spread(lmi.count)
        X = values[term.unknown.name][member]
        block = X * left if right is None else left @ X @ right
        factor = 1.0 if term.parameter is None else abs(float(parameters[term.parameter]))
        factor *= 2.0 if term.plus_transpose else 1.0
        found = np.abs(np.diagonal(block, axis1=1, axis2=2)).astype(np.float64)
        np.add.at(sizes[:, row], item, factor * found)
    return np.asarray(np.maximum(sizes, np.where(largest > 0, largest, 1.0)[:, None]))
