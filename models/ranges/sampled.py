"""Bounds from samples of a function: values between the samples may lie outside the bounds."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.ranges.domain import as_domain

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.intervals.interval import Number
    from takagi.models.ranges.cell_search import Cell
    from takagi.models.ranges.domain import Domain, DomainLike


class SampledBounds(NamedTuple):
    """Smallest and largest sampled value, widened, and words that say so.

    Attributes
    ----------
    bounds : contains every sampled value; values between the samples may lie outside.
    evidence : for ``Premise(evidence=...)``; says "sampled", and that it is not a proof.
    """

    bounds: Interval
    evidence: str


def sampled_bounds(
    expression: sp.Expr,
    domain: DomainLike,
    *,
    points: int = 1000,
    margin: Number = 0,
    seed: int = 0,
) -> SampledBounds:
    """Return [min f, max f] over random points of the domain, widened by a margin.  NO PROOF.

    For functions that cannot be enclosed, and only where a model without proof will do; the
    range that holds is ``expression_range``.

    Parameters
    ----------
    points : in each cell; half of the coordinates lie at ends of their sides.
    margin : added at each end, as a share of the sampled width.
    seed : of the random points.

    Raises
    ------
    ModelError : fewer than two points, a negative margin, a symbol without range, or a value that
        is not a finite number.
    """
    import sympy as sp

    share = exact(margin)
    if points < 2 or share < 0:
        raise ModelError(
            f"{points} points and a margin of {margin} were given; at least 2 points and a "
            "margin >= 0 are needed"
        )
    chance = np.random.default_rng(seed)
    low, high = np.inf, -np.inf
    for cell in as_domain(domain).cells:
        written = cell.written(expression)
        symbols = sorted(written.free_symbols, key=str)
        missing = ", ".join(str(s) for s in symbols if s not in cell.box)
        if missing:
            raise ModelError(f"{expression} depends on {missing}, which has no range; give one")
        samples = _drawn(cell, symbols, points, chance)
        value = sp.lambdify(symbols, written, modules=["scipy", "numpy"])
        with np.errstate(all="ignore"):
            values = np.broadcast_to(np.asarray(value(*samples.T), dtype=np.float64), (points,))
        if not np.all(np.isfinite(values)):
            worst = int(np.argmin(np.isfinite(values)))
            at = ", ".join(f"{s} = {v:.6g}" for s, v in zip(symbols, samples[worst], strict=True))
            raise ModelError(
                f"{expression} has no finite value at {at or 'any point'}; take that point out of "
                "the domain, or write the expression without the singularity"
            )
        low, high = min(low, float(values.min())), max(high, float(values.max()))
    first, last = Fraction(low), Fraction(high)
    wider = share * (last - first)
    total = points * len(as_domain(domain).cells)
    return SampledBounds(
        Interval(first - wider, last + wider),
        f"sampled at {total} random points (seed {seed}), which is no proof",
    )


def moved_into(
    domain: Domain, symbols: Sequence[sp.Symbol], points: Floats, chance: np.random.Generator
) -> Floats:
    """Return points, (k, number of symbols), with the domain's variables moved into its cells.

    Columns of symbols that a cell does not contain stay as they are.
    """
    import sympy as sp

    moved_points = points.copy()
    turns = np.arange(len(points)) % len(domain.cells)
    for number, cell in enumerate(domain.cells):
        rows = np.flatnonzero(turns == number)
        cell_symbols = list(cell.box)
        drawn = _drawn(cell, cell_symbols, len(rows), chance)
        for column, symbol in enumerate(symbols):
            if symbol in cell.box:
                moved_points[rows, column] = drawn[:, cell_symbols.index(symbol)]
            elif symbol in cell.places:
                function = sp.lambdify(
                    cell_symbols, cell.places[symbol], modules=["scipy", "numpy"]
                )
                moved_points[rows, column] = function(*drawn.T)
    return moved_points


def _drawn(
    cell: Cell, symbols: Sequence[sp.Symbol], points: int, chance: np.random.Generator
) -> Floats:
    """Return random points of the cell's box, (points, number of symbols)."""
    shares = chance.random((points, len(symbols)))
    at_ends = chance.random(shares.shape) < 0.5
    # Extremes are more often at the ends than inside.
    shares = np.where(at_ends, np.round(shares), shares)
    ends = np.array([cell.box[s].outward_floats() for s in symbols]).reshape(-1, 2)
    return np.asarray(ends[:, 0] + (ends[:, 1] - ends[:, 0]) * shares)
