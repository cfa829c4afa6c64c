"""A necessary condition for every relaxation: the double sum at single blends of the rules."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import log2, prod

import numpy as np

from takagi.lmi.sums.corner_rules import Corners, ProductRules, product_rules
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum
from takagi.lmi.sums.simplex_products import count_of, multisets
from takagi.lmi.sums.summands import Summand
from takagi.models.arrays import Floats, Indices


def number_of_points(rules: int, corners: Corners | None, subdivision: int) -> int:
    """Return how many blends there are whose shares are multiples of 1/parts."""
    sizes = [rules] if corners is None else product_rules(corners).sizes.values()
    return prod(count_of(size, subdivision) for size in sizes)


def points_of(rules: int, corners: Corners | None, subdivision: int) -> Floats:
    """Return memberships h, (blends, rules): every choice of shares that are multiples of 1/parts.

    The shares are those of the rules. If the memberships are products, they are those of the
    corners of each premise, because other blends never occur then.
    """
    shares = _whole_shares(rules, corners, subdivision)
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))


def at_points(subdivision: int) -> Callable[[DoubleSum], RelaxedSum]:
    """Return a function that poses sum_ij h_i h_j Theta_ij < 0 at all blends h in steps of 1/parts.

    Each inequality is multiplied by a positive number near 1. The condition is necessary, not
    sufficient: unknowns that satisfy any relaxation satisfy this too. So if it has no solution, no
    relaxation has one. It says nothing about the blends between these points.
    """
    return partial(_pose, subdivision=subdivision)


def _pose(loop: DoubleSum, subdivision: int) -> RelaxedSum:
    shares = _whole_shares(loop.rules, loop.corners, subdivision)
    shares = shares[_possible(loop, shares)]
    item, i, j = np.nonzero((shares[:, :, None] * shares[:, None, :]) > 0)
    # Whole numbers times a power of two: an exact no needs the ratios of the weights unrounded.
    scale = 2.0 ** -round(2.0 * log2(shares[0].sum()))
    weight = (shares[item, i] * shares[item, j]).astype(np.float64)
    lmi = loop.lmi(
        "blend",
        (Summand(i, j, weight, item, factor=r"\sum_{i,j} h^{k}_i h^{k}_j"),),
        count=len(shares),
        label=lambda k: _label(shares[k]),
        index=rf"k = 1, \dots, {len(shares)}",
        scale=scale,
    )
    return (), (lmi,)


def _possible(loop: DoubleSum, shares: Indices) -> Indices:
    """Return which blends can occur: no more rules than act at a time, no pair that never does."""
    active = shares > 0
    fits = active.sum(axis=1) <= loop.most_active
    if loop.active is not None:
        fits &= ~np.einsum("ki,ij,kj->k", active, ~loop.active, active)
    return np.flatnonzero(fits)


def _whole_shares(rules: int, corners: Corners | None, subdivision: int) -> Indices:
    """Return the shares of all rules as whole numbers, (blends, rules), with equal sums."""
    plain = ProductRules(np.arange(rules)[:, None], ("h",))
    product = plain if corners is None else product_rules(corners)
    tables = {name: _counts(size, subdivision) for name, size in product.sizes.items()}
    grid = np.indices([len(table) for table in tables.values()]).reshape(len(tables), -1)
    chosen = {name: tables[name][row] for name, row in zip(tables, grid, strict=True)}
    shares = np.ones((grid.shape[1], rules), dtype=np.intp)
    for column, premise in enumerate(product.premises):
        shares *= chosen[premise][:, product.corners[:, column]]
    return shares


def _counts(size: int, subdivision: int) -> Indices:
    """Return (count, size): all nonnegative whole numbers with the sum ``subdivision``."""
    chosen = multisets(size, subdivision)
    return np.asarray((chosen[:, :, None] == np.arange(size)).sum(axis=1), dtype=np.intp)


def _label(shares: Indices) -> str:
    active, total = np.flatnonzero(shares), int(shares.sum())
    if len(active) == 1:
        return f"rule {active[0] + 1}"
    return "blend of " + ", ".join(f"{shares[k]}/{total} of rule {k + 1}" for k in active)
