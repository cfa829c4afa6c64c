"""Known matrices in an expression: conversion of the user's data, and symbols for formulas."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from takagi.models.errors import ModelError

# float64, or objects that are all Fractions.
Data = NDArray[Any]
# A matrix without a name is printed entry by entry if it has at most so many entries.
PRINTED = 9


@dataclass(frozen=True, slots=True)
class Letter:
    """A symbol in a product; a symmetric one is its own transpose."""

    text: str
    symmetric: bool = False

    @property
    def T(self) -> Letter:
        if self.symmetric:
            return self
        if self.text.endswith(r"^\top"):
            return Letter(self.text.removesuffix(r"^\top"))
        return Letter(self.text + r"^\top")


def data_stack(value: object, what: str) -> Data:
    """Return (N, p, q) of float64 or of Fractions; a matrix (p, q) and a number have N = 1.

    Decimal strings and Fractions stay exact.

    Raises
    ------
    ModelError : entries that are not numbers or not finite, or an array with one axis.
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind in "OUS":
            exact = np.empty(array.shape, dtype=object)
            for index, entry in np.ndenumerate(array):
                if isinstance(entry, bool) or entry is None:
                    raise TypeError(f"{entry!r} in the place of a number")
                exact[index] = Fraction(entry if not hasattr(entry, "item") else entry.item())
            array = exact
        elif array.dtype.kind in "iuf":
            array = array.astype(np.float64)
        else:
            raise TypeError(f"entries of type {array.dtype}")
    except (TypeError, ValueError, OverflowError) as error:
        raise ModelError(
            f"{what} cannot be read as a matrix of real numbers ({error}); give nested lists of "
            "equal length or a numpy array"
        ) from error
    if array.ndim == 0:
        array = array.reshape(1, 1, 1)
    if array.ndim not in (2, 3) or 0 in array.shape:
        raise ModelError(
            f"{what} has shape {array.shape}; (p, q) is needed, or (N, p, q) for one matrix a "
            "vertex: a column of n numbers is (n, 1)"
        )
    if not np.isfinite(array.astype(np.float64)).all():
        raise ModelError(f"{what} has an entry that is not finite; every entry must be")
    return array[None] if array.ndim == 2 else array


def number_text(number: float | Fraction) -> str:
    """Return a number as it is printed."""
    return f"{float(number):.6g}"


def identity_multiple(array: Data) -> float | Fraction | None:
    """Return c where every matrix of the stack is c I, else None."""
    p, q = array.shape[1:]
    c = array[0, 0, 0]
    same = p == q and bool(np.all(array == c * np.eye(p, dtype=np.intp)))
    return c if same else None


def symbol_of(array: Data) -> Letter:
    """Return the symbol of a matrix without a name: its entries, if they are few."""
    symmetric = array.shape[1] == array.shape[2] and bool(np.all(array == array.transpose(0, 2, 1)))
    if len(array) > 1 or array[0].size > PRINTED:
        return Letter(r"\mathrm{data}" + ("_{i}" if len(array) > 1 else ""), symmetric)
    rows = r" \\ ".join(" & ".join(number_text(entry) for entry in row) for row in array[0])
    if array[0].size == 1:
        return Letter(rows, symmetric=True)
    return Letter(rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}", symmetric)
