"""How conservative a factored form is: the mean width of the hull of its vertices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.sampled import moved_into
from takagi.models.sector.factored_form import FactoredForm, Place

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.ranges.domain import Domain

SAMPLES = 400
DIRECTIONS = 64


class HullWidth:
    """Mean width of the convex hull of a form's vertices, in scaled entries.

    An entry is multiplied by half the range of its variable and divided by the largest |f_i| of
    its row, so that every entry is a share of its row; the mean is over fixed directions, drawn
    uniformly from the sphere of all entries.  A hull inside another one has the smaller width.

    The premises' ranges are SAMPLED here: the width chooses between forms that are all exact, and
    nothing is proved with it.
    """

    def __init__(
        self,
        box: Mapping[sp.Symbol, Interval],
        columns: Mapping[str, Sequence[sp.Symbol]],
        rows: Mapping[str, Sequence[sp.Expr]],
        shape: Sequence[Place],
        domain: Domain | None = None,
    ) -> None:
        chance = np.random.default_rng(20)
        self.columns = columns
        self.symbols = list(
            dict.fromkeys([*box, *(s for letters in columns.values() for s in letters)])
        )
        self.half = {
            s: float(box[s].magnitude) if s in box and box[s].magnitude else 1.0
            for s in self.symbols
        }
        self.missing = set(self.symbols) - set(box)
        sides = [box.get(s, Interval.of(-1, 1)) for s in self.symbols]
        low = np.array([float(side.lower) for side in sides])
        high = np.array([float(side.upper) for side in sides])
        shares = chance.random((SAMPLES, len(sides)))
        # Half of the coordinates are at their ends, because extremes are there more often than
        # inside.
        shares[SAMPLES // 2 :] = np.round(shares[SAMPLES // 2 :])
        self.points = low + (high - low) * shares
        if domain is not None:
            self.points = moved_into(domain, self.symbols, self.points, chance)
        self.ranges: dict[sp.Expr, tuple[float, float] | None] = {}
        self.scale = {letter: [self._size(row) for row in some] for letter, some in rows.items()}
        self.number = {place: index for index, place in enumerate(shape)}
        found = chance.normal(size=(DIRECTIONS, len(shape)))
        self.directions = found / np.linalg.norm(found, axis=1, keepdims=True)

    def __call__(self, form: FactoredForm) -> float:
        """Return the width; infinite where a premise has no finite sampled range."""
        ranges = [self._range(premise) for premise in form.premises]
        if any(r is None for r in ranges):
            return float("inf")
        total: Floats = np.zeros((DIRECTIONS, *(2,) * len(ranges)))
        for place, polynomial in form.entries.items():
            letter, row, column = place
            scale = self.half[self.columns[letter][column]] / self.scale[letter][row]
            value: Floats = np.zeros((2,) * len(ranges))
            for members, coefficient in polynomial.items():
                term = np.full((1,) * len(ranges), float(coefficient) * scale)
                for premise in members:
                    axis = form.premises.index(premise)
                    shape = [1] * len(ranges)
                    shape[axis] = 2
                    term = term * np.array(ranges[axis]).reshape(shape)
                value = value + term
            along = self.directions[:, self.number[place]]
            total += along.reshape(-1, *(1,) * len(ranges)) * value
        flat = total.reshape(DIRECTIONS, -1)
        return float(np.mean(flat.max(axis=1) - flat.min(axis=1)))

    def _size(self, row: sp.Expr) -> float:
        found = self._range(row)
        return max(map(abs, found)) or 1.0 if found is not None else 1.0

    def _range(self, expression: sp.Expr) -> tuple[float, float] | None:
        if expression not in self.ranges:
            self.ranges[expression] = self._sampled(expression)
        return self.ranges[expression]

    def _sampled(self, expression: sp.Expr) -> tuple[float, float] | None:
        import sympy as sp

        if not expression.free_symbols:
            return (float(expression),) * 2
        value = sp.lambdify(self.symbols, expression, modules=["scipy", "numpy"])
        try:
            with np.errstate(all="ignore"):
                found = np.asarray(value(*self.points.T), dtype=np.float64)
        except (TypeError, ValueError, NameError):
            # A function without float evaluation, or a table that does not cover the box.
            return None
        finite = found[np.isfinite(found)]
        return (float(finite.min()), float(finite.max())) if finite.size else None
