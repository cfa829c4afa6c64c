"""How wide the hull of a cell's vertices is, from the ranges of its premises."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import product

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.equations.equations import Factored
from takagi.models.intervals.interval import Interval
from takagi.models.sector.multilinear import MultiAffine, multi_affine

DIRECTIONS = 64


class HullSpread:
    """Mean width of the hull of the vertices, 1 for the ranges of the whole box.

    Entries are divided by their range over the whole box, so that units do not matter; the mean is
    over fixed directions.  It shows where cutting reduces the width, and nothing is proved with it.
    """

    def __init__(self, factored: Factored, whole: Sequence[Interval]) -> None:
        symbols = list(factored.premises)
        polynomials = [
            multi_affine(entry, symbols, constants=factored.constants)
            for matrix in factored.matrices.values()
            for entry in matrix
            if entry.free_symbols & set(symbols)
        ]
        # An entry that does not move with the premises has no width.
        self.terms: list[Mapping[tuple[int, ...], float]] = [
            {members: float(c) for members, c in _moving(polynomial).items()}
            for polynomial in polynomials
        ]
        values = self._corners(whole)
        span = np.ptp(values, axis=0)
        self.scale = np.divide(1.0, span, out=np.zeros_like(span), where=span > 0)
        found = np.random.default_rng(20).normal(size=(len(self.terms), DIRECTIONS))
        self.directions = found / np.maximum(np.linalg.norm(found, axis=0), 1e-300)
        self.whole = 1.0
        self.whole = self(whole) or 1.0

    def __call__(self, ranges: Sequence[Interval]) -> float:
        """Return the width for these ranges of the premises."""
        if not self.terms:
            return 0.0
        along = (self._corners(ranges) * self.scale) @ self.directions
        return float(np.ptp(along, axis=0).mean()) / self.whole

    def _corners(self, ranges: Sequence[Interval]) -> Floats:
        """Return the moving part of each entry at each corner, (corners, entries)."""
        ends = [(float(side.lower), float(side.upper)) for side in ranges]
        corners = np.array(list(product(*ends))).reshape(2 ** len(ends), len(ends))
        found = np.zeros((len(corners), len(self.terms)))
        for column, terms in enumerate(self.terms):
            for members, coefficient in terms.items():
                found[:, column] += coefficient * corners[:, list(members)].prod(axis=1)
        return found


def _moving(polynomial: MultiAffine) -> dict[tuple[int, ...], Fraction]:
    return {members: c for members, c in polynomial.items() if members}
