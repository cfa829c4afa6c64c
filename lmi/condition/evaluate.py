"""Put values into an LMI: the matrices F_k and their smallest eigenvalues, in floating point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from numbers import Rational
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.term import LMI, Array, Condition, Equality, Term
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

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
        left, right = term.left, term.right
        if dtype is np.float64:
            # Products of Fractions with floats are floats too, a hundred times as slow.
            left = left.astype(np.float64, copy=False)
            right = None if right is None else right.astype(np.float64, copy=False)
        X = term.picked(values)
        block = X * left if right is None else left @ X @ right
        if term.parameter is not None:
            block = block * parameters[term.parameter]
        if term.plus_transpose:
            block = block + block.transpose(0, 2, 1)
        row, column = lmi.spans(term.at)
        _added(total[:, row, column], term, block)
        if row != column:
            _added(total[:, column, row], term, block.transpose(0, 2, 1))
    return total


def _added(total: Array, term: Term, blocks: Array) -> None:
    """Add to every item what the term contributes to it."""
    if term.items is None:
        total += blocks
    else:
        np.add.at(total, np.broadcast_to(term.items, max(len(term.items), len(blocks))), blocks)


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
    nonstrict = [
        (float(shares(condition, lmi, values).min()), lmi)
        for lmi in condition.lmis
        if not lmi.strict
    ]
    violations = [share for share, lmi in nonstrict if not share >= -lmi.tolerance]
    gaps = [equality_gap(equality, values) for equality in condition.equalities]
    violations += [-gap for gap in gaps if not gap <= EQUAL]
    if strict or violations:
        return min([*strict, *violations])
    return max(0.0, min((share for share, _ in nonstrict), default=0.0))


def holds(condition: Condition, value: float) -> bool:
    """Return whether every LMI holds, from the margin; a strict LMI needs a positive one."""
    return value > SMALLEST_MARGIN if any(lmi.strict for lmi in condition.lmis) else value >= 0


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
        constants=tuple(
            replace(constant, value=np.abs(constant.value)) for constant in equality.constants
        ),
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
        X, left, right = term.picked(values), term.left, term.right
        block = X * left if right is None else left @ X @ right
        factor = 1.0 if term.parameter is None else abs(float(parameters[term.parameter]))
        factor *= 2.0 if term.plus_transpose else 1.0
        diagonals = np.abs(np.diagonal(block, axis1=1, axis2=2)).astype(np.float64)
        _added(sizes[:, row], term, factor * diagonals)
    return np.asarray(np.maximum(sizes, np.where(largest > 0, largest, 1.0)[:, None]))


def fractions(array: ArrayLike) -> Array:
    """Return the array with each entry as the Fraction it is exactly.

    A float becomes the dyadic number it stores: 0.1 is not 1/10.  Give ``Fraction("0.1")``, or a
    string, for the decimal.

    Raises
    ------
    ModelError : an entry that is not a finite number.
    """
    source = np.asarray(array, dtype=object)
    result = np.empty(source.shape, dtype=object)
    for index, entry in np.ndenumerate(source):
        try:
            result[index] = entry if type(entry) is Fraction else Fraction(_number(entry))
        except (TypeError, ValueError, OverflowError) as error:
            raise ModelError(
                f"entry {index} is {entry!r}; a finite number, a Fraction or a decimal string "
                "is needed"
            ) from error
    return result


def exact_matrices(
    condition: Condition,
    lmi: LMI,
    values: Mapping[str, ArrayLike],
    parameters: Mapping[str, Fraction] | None = None,
) -> Array:
    """Return sign F_k over the rationals, (count, size, size) of Fractions.

    The LMI holds exactly when each is positive semidefinite.

    Parameters
    ----------
    values : unknown name -> (count, rows, cols) of Fractions, integers, strings or floats; a
        float counts as the dyadic number it stores.
    parameters : exact values; None takes the condition's own, as the dyadics they store.
    """
    numbers = {name: Fraction(value) for name, value in condition.parameters.items()}
    numbers |= {name: Fraction(value) for name, value in (parameters or {}).items()}
    total = lmi_value(
        exact_terms(lmi),
        {name: fractions(value) for name, value in values.items()},
        numbers,
        zero=Fraction(0),
    )
    return lmi.sign * total


def exact_difference(equality: Equality, values: Mapping[str, ArrayLike]) -> Array:
    """Return E_k of an equality over the rationals, (count, p, q); it holds where all are 0."""
    exact = {name: fractions(value) for name, value in values.items()}
    frame = exact_terms(equality.frame())
    p = equality.shape[0]
    return np.asarray(lmi_value(frame, exact, {}, zero=Fraction(0))[:, :p, p:])


def exact_terms(lmi: LMI) -> LMI:
    """Return the LMI with the numbers of its terms and constants as the Fractions they are."""
    terms = tuple(
        replace(
            term,
            left=fractions(term.left),
            right=None if term.right is None else fractions(term.right),
        )
        for term in lmi.terms
    )
    return replace(
        lmi,
        terms=terms,
        constants=tuple(replace(c, value=fractions(c.value)) for c in lmi.constants),
    )


def _number(entry: Any) -> Any:
    if isinstance(entry, (Rational, float, str)):
        return entry
    return entry.item()


def rate_of_values(condition: Condition, values: Mapping[str, Array], step: float | None) -> float:
    """Return the largest decay rate in 1/s at which these unknowns satisfy the condition.

    With G = sign F > 0 at the parameter theta and D = -d G / d theta, the LMI holds up to theta +
    delta for delta = 1 / lambda_max(L^-1 D L'^-1), G = L L'.  (For ``contraction`` the same with
    D = d G / d theta, down to theta - delta.)

    ``condition`` : has the parameter ``alpha``, or ``contraction`` = e^(-2 alpha T), and holds with
    a positive margin at ``values``.
    ``step`` : T in s; None for continuous time.
    """
    name = "alpha" if step is None else "contraction"
    towards = 1.0 if step is None else -1.0
    theta = condition.parameters[name]
    room = min(
        (
            _room(condition, lmi, values, name, towards)
            for lmi in condition.lmis
            if any(term.parameter == name for term in lmi.terms)
        ),
        default=np.inf,
    )
    return rate_of_parameter(theta + towards * room, step)


def rate_of_parameter(theta: float, step: float | None) -> float:
    """Return alpha in 1/s from ``alpha``, or from ``contraction``."""
    if step is None:
        return float(theta)
    return float(-np.log(theta) / (2.0 * step)) if theta > 0 else np.inf


def _room(
    condition: Condition, lmi: LMI, values: Mapping[str, Array], name: str, towards: float
) -> float:
    """Return how far the parameter may move before an item of the LMI is singular."""
    here = dict(condition.parameters)
    there = {**here, name: here[name] + towards}
    G = lmi.sign * lmi_value(lmi, values, here)
    D = G - lmi.sign * lmi_value(lmi, values, there)
    try:
        L = np.linalg.cholesky((G + G.transpose(0, 2, 1)) / 2)
    except np.linalg.LinAlgError:
        return 0.0
    inside = np.linalg.solve(L, np.linalg.solve(L, D).transpose(0, 2, 1))
    largest = float(np.linalg.eigvalsh((inside + inside.transpose(0, 2, 1)) / 2)[:, -1].max())
    return 1.0 / largest if largest > 0 else np.inf
