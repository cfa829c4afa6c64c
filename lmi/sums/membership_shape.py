"""What is known of the memberships in a double sum, and the sum at single memberships.

P(h) = sum_i h_i P_i and its derivative dP/dt as parts of a double sum.

Where the memberships are products of those of premises, h_i = prod_k w^k_(c_ik), the rate of P is

    dP/dt = sum_i h_i sum_k sum_c (dw^k_c/dt) P_(i with corner c of premise k),

because P_(i with corner c of premise k) does not depend on rule i's own corner of premise k, and
the weights of the corners of one premise sum to 1.  Without premises dP/dt is sum_k dh_k/dt P_k.

Use what is known of the memberships, besides h_i >= 0 and sum_i h_i = 1, in a double sum.

Bounds h_i h_j <= b_ij, by the S-procedure: with N_ij = N_ji > 0 where a bound is known, 0 else
and Sigma > sum_ij b_ij N_ij,

    sum_ij h_i h_j Theta_ij  <  sum_ij h_i h_j (Theta_ij + Sigma - N_ij),

because Sigma - sum_ij h_i h_j N_ij > sum_ij (b_ij - h_i h_j) N_ij >= 0 and sum_ij h_i h_j = 1.  Any
relaxation then asks for the right-hand side to be negative; it is a double sum too.  A pair that
never acts together needs no inequality at all.

The result holds for memberships that satisfy the bounds, and for no others.

Source: Sala and Arino (2007), IEEE Trans. Systems, Man and Cybernetics B 37(3), for bounds on
products; Sala and Arino (2008), IEEE Trans. Fuzzy Systems 16(5), for polynomial constraints.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import log2, prod
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.condition.statements import lmi_of, symmetric_summands
from takagi.lmi.condition.term import LMI, Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, added, matrix
from takagi.lmi.polynomials import Basis
from takagi.lmi.sums.corner_rules import Corners, HasPremises, ProductRules, product_rules
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, Summand, double_sum_of
from takagi.lmi.sums.product_premises import count_of, multisets
from takagi.lmi.sums.slack_matrices import SLACK_SHARE, slack_unknown
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError


def rule_table(rules: int, by: str, members: Indices | None = None) -> Indices:
    """Return the table (r, r) of members for a part that has the member of rule i, or of rule j.

    Parameters
    ----------
    by : "vertex" for i, "gain" for j.
    members : (r,) the member of each rule; None for the rules' own order.
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


Shaped: TypeAlias = tuple[DoubleSum, tuple[Unknown, ...], tuple[LMI, ...]]


def with_overlap(
    loop: DoubleSum, bounds: ArrayLike | None = None, *, active_rules: int | None = None
) -> Shaped:
    """Return the double sum with h_i h_j <= b_ij put in, its unknowns N, Sigma, and their LMIs.

    Parameters
    ----------
    bounds : (r, r) b, symmetric; 0 for rules that never act together, inf where nothing is known.
        Above 1/4, for i != j, it is taken as 1/4, which all memberships keep; fractions are
        rounded up.  None for no bounds.
    active_rules : at most this many rules act at a time.

    Returns
    -------
    The double sum for a relaxation, and the unknowns and LMIs that the condition needs in addition.

    Raises
    ------
    ModelError : shape, a bound that is negative or not a number, not symmetric, or that no
        memberships keep; gains with memberships of their own.

    Source: as the module.
    """
    if active_rules is not None:
        active_before = loop.active_rules
        loop = replace(loop, active_rules=min(active_rules, active_before or active_rules))
    if bounds is None:
        return loop, (), ()
    b = _checked(bounds, loop.rules)
    together = (b > 0) & (True if loop.active is None else loop.active)
    if not together.all():
        loop = replace(loop, active=together)
    b = np.where(np.isfinite(b) & ~np.eye(loop.rules, dtype=np.bool_), np.minimum(b, 0.25), b)
    i, j = np.nonzero(np.triu(together & (b < 1)))
    if not len(i):
        return loop, (), ()
    return _with_multipliers(loop, b, i, j)


def with_shape(loop: DoubleSum, forms: ArrayLike) -> Shaped:
    """Return the double sum with h' C_k h >= 0 put in, its unknowns N_k > 0, and their LMIs.

    Theta_ij + sum_k c_k,ij N_k in the place of Theta_ij.  A linear fact a' h >= 0 is the form
    (a e' + e a') / 2 with e = (1, ..., 1), or with e a unit vector: a' h h_l >= 0.

    Parameters
    ----------
    forms : (K, r, r), each C_k symmetric, for all memberships that occur.

    Raises
    ------
    ModelError : shape, not finite, not symmetric; gains with memberships of their own.

    Source: Sala and Arino (2008), IEEE Trans. Fuzzy Systems 16(5).
    """
    C = np.asarray(forms, dtype=np.float64)
    r = loop.rules
    if C.ndim != 3 or C.shape[1:] != (r, r) or not len(C) or not np.isfinite(C).all():
        raise ModelError(f"forms have shape {C.shape}; (K, {r}, {r}) finite numbers are needed")
    if not (C == C.transpose(0, 2, 1)).all():
        raise ModelError("forms are not symmetric; give (C + C') / 2")
    n = loop.size
    N = slack_unknown(loop, "N", n, count=len(C))
    added_forms = [
        matrix(C[k][:, :, None, None], rf"c_{{{k + 1},{{i}}{{j}}}}", over="ij") * N.member(k)
        for k in range(len(C))
    ]
    return with_matrices(loop, *added_forms), (N,), (_positive(loop, N),)


def with_matrices(loop: DoubleSum, *matrices: Expression) -> DoubleSum:
    """Return the double sum of Theta_ij and of symmetric matrices of its size."""
    parts = (part for added_matrix in matrices for part in symmetric_summands(added_matrix))
    whole = ((replace(piece, at=None), plus_transpose) for piece, plus_transpose in parts)
    return replace(loop, parts=(*loop.parts, *whole))


def product_bounds(source: HasPremises | Corners) -> Array:
    """Return b, (r, r) of Fractions, the largest value of each h_i h_j of product memberships.

    h_i h_j is a product of weights w^e over each premise, |e| = D, largest at w = e / D: a quarter
    for each premise in which the rules differ.  The relaxation "product" does not imply these
    bounds, nor do they imply it: "product" uses which products are equal, the bounds use that (w_1
    - w_2)^2 >= 0.

    Parameters
    ----------
    source : a model with premises, corners (r, premises), or ``ProductRules``.

    Raises
    ------
    ModelError : no premises.
    """
    rules = product_rules(source)
    b = np.full((rules.rules, rules.rules), Fraction(1), dtype=object)
    for name in rules.sizes:
        premise_corners = rules.corners[
            :, [c for c, premise in enumerate(rules.premises) if premise == name]
        ]
        different, corner_index = np.unique(premise_corners, axis=0, return_inverse=True)
        table = np.empty((len(different), len(different)), dtype=object)
        for first, second in np.ndindex(table.shape):
            table[first, second] = _largest(
                np.bincount(np.concatenate([different[first], different[second]]))
            )
        b = b * table[corner_index.ravel()[:, None], corner_index.ravel()]
    return b


def neighbouring_rules(source: HasPremises | Corners) -> NDArray[np.bool_]:
    """Return (r, r), True where the corners of two rules are equal or next to each other.

    Of weights that are hat functions over the corners of each premise, as of a table that is
    interpolated, no other rules act together: ``DoubleSum.active``, or bounds 0 elsewhere.

    Parameters
    ----------
    source : as in ``product_bounds``.
    """
    corners = product_rules(source).corners
    return np.asarray((np.abs(corners[:, None] - corners[None]) <= 1).all(axis=2))


def _largest(exponents: Indices) -> Fraction:
    """Return max of w^e on the simplex, prod_c (e_c / |e|)^(e_c)."""
    degree = int(exponents.sum())
    value = Fraction(1)
    for exponent in exponents.tolist():
        value *= Fraction(exponent, degree) ** exponent
    return value


def _checked(bounds: ArrayLike, rules: int) -> Floats:
    """Return float bounds, never below the given ones."""
    try:
        exact_bounds = np.asarray(bounds)
        b = exact_bounds.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"bounds cannot be read as a matrix of numbers ({error})") from error
    if b.shape != (rules, rules):
        raise ModelError(f"bounds have shape {b.shape}; ({rules}, {rules}) is needed")
    if np.isnan(b).any() or (b < 0).any():
        i, j = np.argwhere(np.isnan(b) | (b < 0))[0]
        raise ModelError(f"bounds[{i}, {j}] is {b[i, j]}; 0 or more is needed")
    if not (b == b.T).all():
        i, j = np.argwhere(b != b.T)[0]
        raise ModelError(
            f"bounds are not symmetric: [{i}, {j}] is {b[i, j]:g}, [{j}, {i}] is {b[j, i]:g}; "
            "h_i h_j is h_j h_i, give the smaller for both"
        )
    if b.sum() < 1:
        raise ModelError(
            f"the bounds sum to {b.sum():.6g}, but the products h_i h_j to 1: no memberships keep "
            "them"
        )
    if (b.diagonal() == 0).any():
        k = int(np.argmin(b.diagonal()))
        raise ModelError(f"bounds[{k}, {k}] is 0: rule {k + 1} never acts; leave it out")
    # A fraction and the float nearest to it compare exactly.
    return np.where(np.isfinite(b) & (b < exact_bounds), np.nextafter(b, np.inf), b)


def _with_multipliers(loop: DoubleSum, b: Floats, i: Indices, j: Indices) -> Shaped:
    r, n = loop.rules, loop.size
    N = slack_unknown(loop, "N", n, count=len(i))
    Sigma = replace(slack_unknown(loop, "Sigma", n), latex=r"\Sigma")
    pair_index = np.zeros((r, r), dtype=np.intp)
    is_bounded = np.zeros((r, r))
    pair_index[i, j] = pair_index[j, i] = np.arange(len(i))
    is_bounded[i, j] = is_bounded[j, i] = 1.0
    bounded = matrix(is_bounded[:, :, None, None], "1", over="ij")
    less = -(bounded * N.members(pair_index, "N_{{i}{j}}"))
    # There is no N of a pair without a bound, so that the formula needs no factor 0 or 1.
    less = replace(less, pieces=tuple(replace(piece, before=()) for piece in less.pieces))
    # (i, j) and (j, i).
    shares = matrix((np.where(i == j, 1.0, 2.0) * b[i, j])[:, None, None], "b_{ij}")
    N_ij = N.members(np.arange(len(i)), "N_{ij}")
    spare = Sigma - added(shares * N_ij, latex=r"\sum_{i,j}")
    name = f"{loop.name}, bounds of memberships" if loop.name else "bounds of memberships"
    bound = lmi_of((spare >> 0).named(name, weight=SLACK_SHARE * loop.weight))
    changed = with_matrices(loop, Sigma.as_expression(), less)
    return changed, (N, Sigma), (bound, _positive(loop, N))


def _positive(loop: DoubleSum, N: Unknown) -> LMI:
    """Return N_k > 0 for every member."""
    name = "multipliers of memberships"
    positive = N.members(np.arange(N.count), "N_k") >> 0
    return lmi_of(
        positive.named(
            f"{loop.name}, {name}" if loop.name else name,
            rf"k = 1, \dots, {N.count}",
            weight=SLACK_SHARE * loop.weight,
        )
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
