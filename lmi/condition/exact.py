"""Put exact numbers into an LMI: the matrices F_k over the rationals, no rounding anywhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from numbers import Rational
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.evaluate import lmi_value
from takagi.lmi.condition.term import LMI, Array, Condition, Equality
from takagi.models.errors import ModelError


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
    known = {name: Fraction(value) for name, value in condition.parameters.items()}
    known |= {name: Fraction(value) for name, value in (parameters or {}).items()}
    total = lmi_value(
        exact_terms(lmi),
        {name: fractions(value) for name, value in values.items()},
        known,
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
