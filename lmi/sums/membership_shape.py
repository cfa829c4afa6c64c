"""P(h) in double sums, and a double sum at single memberships.

P(h) = sum_i h_i P_i and its derivative dP/dt as parts of a double sum.

Where the memberships are products of those of premises, h_i = prod_k w^k_(c_ik), the rate of P is

    dP/dt = sum_i h_i sum_k sum_c (dw^k_c/dt) P_(i with corner c of premise k),

because P_(i with corner c of premise k) does not depend on rule i's own corner of premise k, and
the weights of the corners of one premise sum to 1.  Without premises dP/dt is sum_k dh_k/dt P_k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import log2, prod

import numpy as np

from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, matrix
from takagi.lmi.polynomials import Basis
from takagi.lmi.sums.corner_rules import Corners, ProductRules, product_rules
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, Summand, double_sum_of
from takagi.lmi.sums.product_premises import count_of
from takagi.models.arrays import Floats, Indices


def rule_table(rules: int, by: str, members: Indices | None = None) -> Indices:
    """Return the table (r, r) of members for a part that has the member of rule i, or of rule j.

    ``by`` : "vertex" for i, "gain" for j.
    ``members`` : (r,) the member of each rule; None for the rules' own order.
    """
    rule_members = np.arange(rules) if members is None else members
    table = np.broadcast_to(rule_members[:, None], (rules, rules))
    return np.asarray(table if by == "vertex" else table.T)


def swapped_rules(corners: Indices, premise: int, corner: int) -> Indices:
    """Return (r,): the rule with this corner of the premise, and else the corners of rule i."""
    sizes = tuple(int(size) for size in corners.max(axis=0) + 1)
    number = Basis(sizes, (1,) * len(sizes)).corners
    rule = np.argsort(number(corners))
    changed = corners.copy()
    changed[:, premise] = corner
    return np.asarray(rule[number(changed)])


def rate_of(
    P: Unknown, corners: Indices, velocity: Sequence[Floats], *, members: Indices | None = None
) -> Expression | int:
    """Return dP/dt at one velocity of the memberships, by the rule of the vertex.

    Parameters
    ----------
    corners : (r, K), the corner of each simplex that rule i takes.
    velocity : dw^k/dt, one array for each simplex.
    members : (r,), the member of P for each rule; None for the rules' own order.
    """
    rule_members = np.arange(len(corners)) if members is None else members
    total: Expression | int = 0
    for k, rates in enumerate(velocity):
        for corner in np.flatnonzero(rates):
            rules = rule_members[swapped_rules(corners, k, int(corner))]
            # Rule i where premise k is at this corner, or, without premises, the rule itself.
            index = f"{k + 1},{corner + 1}" if len(velocity) > 1 else f"{corner + 1}"
            rate = rf"\dot w_{{{index}}}" if len(velocity) > 1 else rf"\dot h_{{{index}}}"
            at = f"{{i}}|{index}" if len(velocity) > 1 else index
            P_i = P.members(rule_table(len(corners), "vertex", rules), f"{P.symbol}_{{{at}}}")
            total = total + matrix([[rates[corner]]], rate) * P_i
    return total


def double_sums(
    thetas: Sequence[Expression], name: str, *, rules: int, weight: float, corners: Corners | None
) -> tuple[DoubleSum, ...]:
    """Return a double sum Theta < 0 for each, numbered where there are several."""
    titles = [f"{name} {k + 1}" if len(thetas) > 1 else "" for k in range(len(thetas))]
    return tuple(
        double_sum_of((theta << 0).named(title, weight=weight), rules=rules, corners=corners)
        for title, theta in zip(titles, thetas, strict=True)
    )


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


def _whole_shares(rules: int, corners: Corners | None, subdivision: int) -> Indices:
    """Return the shares of all rules as whole numbers, (blends, rules), with equal sums."""
    plain = ProductRules(np.arange(rules)[:, None], ("h",))
    product = plain if corners is None else product_rules(corners)
    tables = {
        name: Basis((size,), (subdivision,)).exponents for name, size in product.sizes.items()
    }
    grid = np.indices([len(table) for table in tables.values()]).reshape(len(tables), -1)
    chosen = {name: tables[name][row] for name, row in zip(tables, grid, strict=True)}
    shares = np.ones((grid.shape[1], rules), dtype=np.intp)
    for column, premise in enumerate(product.premises):
        shares *= chosen[premise][:, product.corners[:, column]]
    return shares


def _label(shares: Indices) -> str:
    active, total = np.flatnonzero(shares), int(shares.sum())
    if len(active) == 1:
        return f"rule {active[0] + 1}"
    return "blend of " + ", ".join(f"{shares[k]}/{total} of rule {k + 1}" for k in active)
