"""Relaxations by products of memberships: all coefficients of a polynomial are to be negative.

The polynomial is that of ``simplex_products``.  Products of weights are nonnegative and not all
zero, so it is negative wherever each of its coefficients is negative definite.  Pairs of rules
whose products coincide share a coefficient: with p premises of two corners 3^p inequalities
replace r (r + 1) / 2, r = 2^p, and ask for less.

Source: Sala and Arino (2007), Fuzzy Sets and Systems 158(24), for one simplex (Polya's theorem);
Arino and Sala (2007), Eng. Applications of Artificial Intelligence 20(8), for tensor products.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.term import LMI, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.sums.corner_rules import ProductRules, product_rules
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, selections
from takagi.lmi.sums.rule_pairs import slack_unknown
from takagi.lmi.sums.simplex_products import (
    Simplex,
    SimplexCoefficients,
    coefficients,
    simplexes_of,
)
from takagi.lmi.sums.slack_matrices import negative_whole
from takagi.models.errors import ModelError

# The shares of the Theta_ij in a coefficient, which sum to 1.
_POLYA = r"\sum_{{i,j}} \tfrac{{k_i (k_j - \delta_{{ij}})}}{{{}}}"
_PAIRS = r"\tfrac{1}{|\mathcal{P}_k|} \sum_{(i,j) \in \mathcal{P}_k}"
_SHARES = r"\sum_{i,j} c^{k}_{ij}"


def polya(loop: DoubleSum, degree: int) -> RelaxedSum:
    """Every coefficient of (h_1 + ... + h_r)^d sum_ij h_i h_j Theta_ij is negative definite.

    Degree 0 is all pairs; necessary and sufficient as d grows, with (r + d + 1 choose d + 2)
    LMIs.  Products of memberships that never act together are left out.

    Source: Sala and Arino (2007), Fuzzy Sets and Systems 158(24), theorem 5.
    """
    rules = ProductRules(np.arange(loop.rules)[:, None], ("h",))
    sums = coefficients(loop, rules, degree)
    chosen = sums.exponents[0]
    lmi = loop.lmi(
        "product of memberships",
        (sums.summand(_POLYA.format((degree + 2) * (degree + 1))),),
        count=sums.count,
        label=lambda item: " ".join(f"h{c + 1}" for c in chosen[item].tolist()),
        index=rf"k \in \mathbb{{N}}_0^{{{loop.rules}}},\; |k| = {degree + 2}",
        scale=sums.scale,
        printed=sums.total,
    )
    return (), (lmi,)


def product(loop: DoubleSum, degree: int = 0) -> RelaxedSum:
    """Every coefficient of prod_k (sum_c w_kc)^d sum_ij h_i h_j Theta_ij is negative definite.

    Never more conservative than all pairs, and for one premise the same as Polya's of that
    degree; necessary and sufficient as d grows, with prod_k (D_k + d + s_k - 1 choose s_k - 1)
    LMIs for s_k corners.

    Raises
    ------
    ModelError : the memberships are not known to be products.

    Source: as the module.
    """
    return (), (_product_lmi(loop, degree),)


def product_liu_zhang(loop: DoubleSum) -> RelaxedSum:
    """Every coefficient of sum_ij h_i h_j (Theta_ij - X_ij) is negative definite, X = [X_ij] < 0.

    As Liu and Zhang's, with pairs of equal products added up: never more conservative than that,
    nor than "product".

    Raises
    ------
    ModelError : the memberships are not known to be products.

    Source: derived here: sum_ij h_i h_j Theta_ij < sum_ij h_i h_j X_ij = (h x I)' X (h x I) < 0.
    """
    X = slack_unknown(loop, "X", loop.rules * loop.size)
    return (X,), (_product_lmi(loop, 0, X), negative_whole(loop, X))


def known_rules(loop: DoubleSum) -> ProductRules:
    """Return the rules as products.

    Raises
    ------
    ModelError : they are not known to be products.
    """
    if loop.corners is None:
        raise ModelError(
            "relaxation product needs memberships that are products over premises, and knows "
            'of none; give the model premises, or take "polya-<d>"'
        )
    return product_rules(loop.corners)


def _product_lmi(loop: DoubleSum, degree: int, X: Unknown | None = None) -> LMI:
    rules = known_rules(loop)
    simplexes = simplexes_of(rules)
    sums = coefficients(loop, rules, degree)

    def label(item: int) -> str:
        corners = (
            f"{simplex.name} at {' '.join(str(c + 1) for c in rows[item].tolist())}"
            for simplex, rows in zip(simplexes, sums.exponents, strict=True)
        )
        return "corners " + ", ".join(corners)

    return loop.lmi(
        "product of corner weights",
        (sums.summand(_SHARES if degree else _PAIRS),),
        () if X is None else (_less(loop, sums, X),),
        count=sums.count,
        label=label,
        index=_index(simplexes, degree),
        scale=sums.scale,
        printed=sums.total,
    )


def _index(simplexes: tuple[Simplex, ...], degree: int) -> str:
    """Return which products w^k there are, and what their coefficients are means of."""
    sides = r",\; ".join(
        rf"|k_{{{number}}}| = {simplex.degree + degree}"
        for number, simplex in enumerate(simplexes, start=1)
    )
    if not degree:
        return sides + r",\; \mathcal{P}_k = \{(i,j) : h_i h_j = w^k\}"
    power = "" if degree == 1 else f"^{degree}"
    return sides + rf",\; c^{{k}}_{{ij}} \propto [w^k] \prod_p (\sum_c w_{{pc}}){power} h_i h_j"


def _less(loop: DoubleSum, sums: SimplexCoefficients, X: Unknown) -> Term:
    """Return -X_ij summed as the Theta_ij are; (i, j) and (j, i) appear in the same coefficient."""
    E = selections(loop.rules, loop.size)
    half = sums.i <= sums.j
    i, j = sums.i[half], sums.j[half]
    # The term is added to its transpose, which the pairs i < j need and i = j has twice.
    weight = sums.scale * sums.weight[half] * np.where(i == j, 0.5, 1.0)
    return Term(
        unknown=X,
        left=-weight[:, None, None] * E.transpose(0, 2, 1)[i],
        right=E[j],
        at=None,
        plus_transpose=True,
        items=sums.item[half],
        latex=(r"-\tfrac12 E_i^\top", "E_j"),
        factor=_PAIRS,
    )
