"""How far a model of fewer rules is from the original, proved, and as norm-bounded uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.models.errors import ModelError
from takagi.models.reduction.exact_residual import Decimals, root_above
from takagi.models.reduction.norm_block import NormBlock, block_around, entry_blocks

Place: TypeAlias = tuple[str, int, int]
"""Letter of the matrix, row, column."""

Structure: TypeAlias = Literal["whole", "entries"]
LETTERS = ("A", "B", "C", "D", "E")


@dataclass(frozen=True, slots=True, eq=False)
class ErrorBound:
    """|S(h) - S_reduced(g)| <= size for every h >= 0 of sum 1, with g the reduced weights of h.

    S = [A B E; C D 0].  The difference is sum_i h_i X_i, with X_i that at the original's vertex i,
    so the largest |X_i| bounds it; the norm is Frobenius', so the spectral one too.

    Attributes
    ----------
    size : of S, in the units of the entries; 0 if and only if nothing is lost.  Proved in
        rationals, entries read as the decimals they print as, and rounded up.
    parts : the same for each of A, B, C, D, E alone.
    differences : (k, n, n + m) of Fractions, the [A B] part of the X_i, each once up to its sign.
    """

    size: Fraction
    parts: Mapping[str, Fraction]
    differences: NDArray[Any]

    def blocks(self, structure: Structure = "entries") -> tuple[NormBlock, ...]:
        """Return D, E, F with [A B](h) = [A B]_reduced(g) + sum_k D_k Delta_k [E_k, F_k](h).

        Each |Delta_k| <= 1 may depend on h in any way.  ``takagi.lmi`` takes
        ``[NormBounded(*block) for block in error.blocks()]``; C, D and E keep their own error.

        Parameters
        ----------
        structure : ``"entries"`` is one for each entry that differs, as if they moved
            independently; ``"whole"`` is one block, turned and weighed after the differences, for
            many entries that move together.

        Returns
        -------
        None of them where A and B lose nothing.
        """
        n = self.differences.shape[1]
        if structure == "whole":
            return block_around(self.differences, n)
        if structure == "entries":
            return entry_blocks(self.differences, n)
        raise ModelError(f"structure {structure!r} was given; 'whole' or 'entries' is known")


def error_bound(lost: Decimals, places: Sequence[Place], states: int, inputs: int) -> ErrorBound:
    """Return the bound for what is lost at each vertex.

    Parameters
    ----------
    lost : (vertices, entries).
    places : of the entries; all others lose nothing.
    states, inputs : n and m.
    """
    sums = {letter: np.zeros(len(lost.integers), dtype=object) for letter in LETTERS}
    for column, (letter, _, _) in enumerate(places):
        sums[letter] = sums[letter] + lost.integers[:, column] ** 2
    parts = {letter: _largest(some, lost.places) for letter, some in sums.items()}
    return ErrorBound(
        size=_largest(sum(sums.values()), lost.places),
        parts=MappingProxyType(parts),
        differences=_differences(lost, places, states, inputs),
    )


def _largest(squares: Any, places: int) -> Fraction:
    return root_above(Fraction(int(max(squares)), 100**places))


def _differences(lost: Decimals, places: Sequence[Place], states: int, inputs: int) -> NDArray[Any]:
    chosen = [k for k, place in enumerate(places) if place[0] in "AB"]
    kept: dict[tuple[int, ...], int] = {}
    for index, row in enumerate(lost.integers[:, chosen]):
        first = next((value for value in row if value), 0)
        if first:
            kept.setdefault(tuple(int(value) * (1 if first > 0 else -1) for value in row), index)
    found = np.full((len(kept), states, states + inputs), Fraction(0), dtype=object)
    for k, values in enumerate(kept):
        for column, value in zip(chosen, values, strict=True):
            letter, i, j = places[column]
            found[k, i, j + (states if letter == "B" else 0)] = Fraction(value, 10**lost.places)
    return found
