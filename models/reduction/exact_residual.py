"""Original minus reduced vertices, in exact arithmetic about the decimals that are stored.

Every entry and every weight is read as the shortest decimal that prints it (``exact``), so that
products and sums are those of integers over a power of ten.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import exact

Integers: TypeAlias = NDArray[Any]  # Python integers, of any size


@dataclass(frozen=True, slots=True, eq=False)
class Decimals:
    """An array of numbers ``integers / 10**places``."""

    integers: Integers
    places: int

    @classmethod
    def of(cls, array: Floats) -> Decimals:
        """Return the floats as the shortest decimals that print them.

        Raises
        ------
        ModelError : an entry that is not finite.
        """
        values, where = np.unique(array, return_inverse=True)
        written = [exact(float(value)) for value in values]
        places = 0
        while any(10**places % value.denominator for value in written):
            places += 1
        whole = np.empty(len(written), dtype=object)
        whole[:] = [int(value * 10**places) for value in written]
        return cls(whole[where.reshape(-1)].reshape(array.shape), places)

    def __sub__(self, other: Decimals) -> Decimals:
        places = max(self.places, other.places)
        first = self.integers * 10 ** (places - self.places)
        return Decimals(first - other.integers * 10 ** (places - other.places), places)

    def fractions(self, index: Any) -> NDArray[Any]:
        """Return the part at the index as Fractions."""
        part = np.asarray(self.integers[index], dtype=object)
        found = np.empty(part.shape, dtype=object)
        for place, number in np.ndenumerate(part):
            found[place] = Fraction(number, 10**self.places)
        return found


def residual(tensor: Floats, factors: Sequence[Floats], core: Floats) -> Decimals:
    """Return T[i1, ..., iK, :] - sum_j G_1[i1, j1] ... G_K[iK, jK] R[j1, ..., jK, :], exactly.

    Parameters
    ----------
    tensor : T, (N_1, ..., N_K, entries).
    factors : G_k, (N_k, rho_k), rows of sum one.
    core : R, (rho_1, ..., rho_K, entries).
    """
    whole = Decimals.of(core)
    for axis, factor in enumerate(factors):
        if np.all((factor == 0) | (factor == 1)):
            # One of the reduced rules each: nothing is to be multiplied.
            picked = np.take(whole.integers, factor.argmax(axis=1), axis=axis)
            whole = Decimals(picked, whole.places)
            continue
        weights = Decimals.of(factor)
        along = np.tensordot(weights.integers, whole.integers, axes=(1, axis))
        whole = Decimals(np.moveaxis(along, 0, axis), whole.places + weights.places)
    return Decimals.of(tensor) - whole


def row_sums_are_one(factor: Floats) -> bool:
    """Return whether the decimals are nonnegative, and those of each row add up to exactly 1."""
    weights = Decimals.of(factor)
    sums = weights.integers.sum(axis=1)
    return bool(np.all(factor >= 0) and np.all(sums == 10**weights.places))


def root_above(squared: Fraction) -> Fraction:
    """Return sqrt(squared), rounded up to 16 digits or more; exact where it is a short decimal.

    Raises
    ------
    ModelError : a negative number.
    """
    if squared < 0:
        raise ModelError(f"{float(squared):.9g} has no real root")
    if squared == 0:
        return Fraction(0)
    size = len(str(squared.denominator)) - len(str(squared.numerator))
    places = max(0, size // 2 + 18)
    scaled = squared * 100**places
    whole = -(-scaled.numerator // scaled.denominator)
    root = isqrt(whole)
    return Fraction(root if root * root == whole else root + 1, 10**places)
