r"""The values of a parameter that the multipliers of a homogeneous condition exclude.

Let X > 0 be the only unknown, symmetric, and let the LMIs sign F_k(X, theta) > 0 have no constant
terms.  For multipliers Z_k >= 0,

    sum_k <sign F_k(X, theta), Z_k> = <S0 + theta S1, X>.

If S0 + theta S1 <= 0, no X satisfies the condition: the LMIs make the sum positive, but X > 0 makes
the right-hand side at most zero.  If -S1 >= 0, this holds for all theta from the largest eigenvalue
of the pencil (S0, -S1) on.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from takagi.lmi.condition.term import LMI, Condition, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.models.arrays import Floats

# A direction without multipliers gives no bound.  Its eigenvalue is raised to this share of the
# largest one, so that the division stays finite.
LEAST = 1e-13


def excluded_from(
    condition: Condition, name: str, multipliers: Mapping[str, Floats], *, largest: bool
) -> float:
    """Return the value of the parameter beyond which no unknown satisfies the condition.

    All larger values (smaller ones if ``largest`` is False) are excluded, to the accuracy with
    which the multipliers are semidefinite.  The result is inf (-inf) if the multipliers exclude no
    value, or if this argument does not apply.
    """
    d = 1.0 if largest else -1.0
    never = d * np.inf
    if len(condition.unknowns) != 1 or not multipliers:
        return never
    X = condition.unknowns[0]
    if X.count != 1 or not X.symmetric:
        return never
    S0, S1 = np.zeros((X.rows, X.rows)), np.zeros((X.rows, X.rows))
    positive = False
    for lmi in condition.lmis:
        if not lmi.strict:
            continue
        if lmi.constants:
            return never
        positive = positive or _says_positive(lmi, X)
        plain, slope = adjoint(condition, lmi, name, multipliers[lmi.name])
        if not slope.any() and np.linalg.eigvalsh(plain)[0] >= -LEAST * np.abs(plain).max():
            # Such an LMI, X > 0 for example, restricts X but excludes no theta.
            continue
        S0, S1 = S0 + plain, S1 + slope
    growths, vectors = np.linalg.eigh(-d * S1)
    if not positive or growths[-1] <= 0 or growths[0] < -1e-9 * growths[-1]:
        return never
    root = vectors / np.sqrt(np.maximum(growths, LEAST * growths[-1]))
    return d * float(np.linalg.eigvalsh(root.T @ S0 @ root)[-1])


def _says_positive(lmi: LMI, X: Unknown) -> bool:
    """Return whether the LMI is L' X L > 0 with L regular, from which X > 0 follows."""
    if len(lmi.terms) != 1 or lmi.sign != 1 or lmi.size != X.rows:
        return False
    term = lmi.terms[0]
    if term.right is None:
        # A scalar unknown.
        return term.parameter is None and bool((term.left[0] > 0).all())
    if term.parameter is not None or term.items is not None:
        return False
    L, R = term.left[0].astype(np.float64), term.right[0].astype(np.float64)
    square = L.shape == (X.rows, X.rows) and np.array_equal(L.T, R)
    return square and int(np.linalg.matrix_rank(L)) == X.rows


def adjoint(condition: Condition, lmi: LMI, name: str, Z: Floats) -> tuple[Floats, Floats]:
    """Return (S0, S1): sum_k <sign F_k(X, theta), Z_k> = <S0 + theta S1, X>, theta being ``name``.

    Parameters
    ----------
    Z : (count, size, size), one symmetric multiplier an item.
    """
    X = lmi.terms[0].unknown
    parts = [np.zeros((X.rows, X.cols)), np.zeros((X.rows, X.cols))]
    for term in lmi.terms:
        factor = 1.0
        if term.parameter not in (None, name):
            factor = condition.parameters[term.parameter]
        share = lmi.sign * factor * _adjoint(term, lmi, Z)
        parts[int(term.parameter == name)] += share
    return (parts[0] + parts[0].T) / 2, (parts[1] + parts[1].T) / 2


def _adjoint(term: Term, lmi: LMI, Z: Floats) -> Floats:
    """Return sum_t L_t' Z R_t', twice where a mirror image or a transpose is implied."""
    item, _, left, right = term.spread(lmi.count)
    rows, columns = lmi.spans(term.at)
    block = Z[item][:, rows, columns]
    if right is None:
        total = np.array([[np.sum(left * block)]])
    else:
        total = (left.transpose(0, 2, 1) @ block @ right.transpose(0, 2, 1)).sum(axis=0)
    return 2.0 * total if rows != columns or term.plus_transpose else total
