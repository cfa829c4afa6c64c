"""Relaxations by products of memberships or of premise weights.

Where rules are combinations of corners, h_i = prod_k w_(k, c_ik), the double sum is a polynomial in
the weights w_k of each premise, homogeneous in each: of degree D_k where premise k is a factor D_k
times, 2 where it is a factor of each membership once.  Times prod_k (w_k1 + w_k2 + ...)^d, which is
1, it is so of degree D_k + d.

Products of weights are nonnegative and not all
zero, so it is negative wherever each of its coefficients is negative definite.  Pairs of rules
whose products coincide share a coefficient: with p premises of two corners 3^p inequalities
replace r (r + 1) / 2, r = 2^p, and ask for less.

Source: Sala and Arino (2007), Fuzzy Sets and Systems 158(24), for one simplex (Polya's theorem);
Arino and Sala (2007), Eng. Applications of Artificial Intelligence 20(8), for tensor products.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, log2, perm, prod

import numpy as np

from takagi.lmi.condition.term import LMI
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, He, added, matrix
from takagi.lmi.polynomials import Basis
from takagi.lmi.sums.corner_rules import ProductRules, product_rules
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, Summand, Weights, selections
from takagi.lmi.sums.slack_matrices import negative_whole, slack_unknown
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError


def count_of(values: int, degree: int) -> int:
    """Return how many multisets of ``degree`` numbers from 0 ... values - 1 there are."""
    return comb(values + degree - 1, degree)


@dataclass(frozen=True, slots=True)
class Simplex:
    """The weights of one premise, and the columns of corners in which they are factors.

    Attributes
    ----------
    name : of the premise.
    corners : number of weights.
    columns : of the rules' corners.
    """

    name: str
    corners: int
    columns: tuple[int, ...]

    @property
    def degree(self) -> int:
        """Return D_k: both memberships of a pair have the factors."""
        return 2 * len(self.columns)


@dataclass(frozen=True, slots=True, eq=False)
class SimplexCoefficients:
    """Coefficient k of the polynomial is scale sum_(t: item_t = k) weight_t Theta_(i_t, j_t).

    Attributes
    ----------
    i, j, item, weight : (T,); the weights are whole numbers, with the same sum in all items.
    total : their sum.
    scale : a power of two near 1 / total, that makes a coefficient about a mean of the Theta_ij.
    basis : of the items, premise after premise: each is a product of corner weights.
    """

    i: Indices
    j: Indices
    item: Indices
    weight: Weights
    total: int
    scale: float
    basis: Basis

    @property
    def count(self) -> int:
        """Return the number of coefficients."""
        return self.basis.count

    def summand(self, factor: str) -> Summand:
        """Return the weighted sum, with the weights written as ``factor``."""
        return Summand(self.i, self.j, self.weight, self.item, factor=factor)


def simplexes_of(rules: ProductRules) -> tuple[Simplex, ...]:
    """Return every premise of the rules, in the order of the columns.

    Raises
    ------
    ModelError : a premise with different numbers of corners in its columns.
    """
    simplexes = []
    for name in dict.fromkeys(rules.premises):
        columns = tuple(c for c, premise in enumerate(rules.premises) if premise == name)
        sides = {int(rules.corners[:, c].max()) + 1 for c in columns}
        if len(sides) > 1:
            raise ModelError(
                f"premise {name} has {' and '.join(map(str, sorted(sides)))} corners in different "
                "columns; a premise has the same corners wherever it is a factor"
            )
        simplexes.append(Simplex(name, sides.pop(), columns))
    return tuple(simplexes)


def coefficients(rules: ProductRules, degree: int) -> SimplexCoefficients:
    """Return which Theta_ij appear in which coefficient.

    A coefficient divided by the number of orderings of its product is a mean of the Theta_ij; the
    weights are those of the mean times prod_k (D_k + d)! / d!, the same for all coefficients.
    """
    r = rules.rules
    item = np.zeros((r, r, 1), dtype=np.intp)
    weight = np.ones((r, r, 1))
    simplexes = simplexes_of(rules)
    for simplex in simplexes:
        number, factor, count = _table(simplex, rules, degree)
        item = (item[..., None] * count + number[:, :, None, :]).reshape(r, r, -1)
        weight = (weight[..., None] * factor[:, :, None, :]).reshape(r, r, -1)
    i, j, _ = (indices.ravel() for indices in np.indices(item.shape))
    total = prod(perm(simplex.degree + degree, simplex.degree) for simplex in simplexes)
    return SimplexCoefficients(
        i=i,
        j=j,
        item=item.ravel(),
        weight=weight.ravel(),
        total=total,
        # A power of two, so that rounding never touches the ratios of the weights.
        scale=2.0 ** -round(log2(total)),
        basis=Basis(
            tuple(simplex.corners for simplex in simplexes),
            tuple(simplex.degree + degree for simplex in simplexes),
        ),
    )


def _table(simplex: Simplex, rules: ProductRules, degree: int) -> tuple[Indices, Weights, int]:
    """Return number and weight, (r, r, products of ``degree``), of one premise; count of numbers.

    With the exponents a of rules i and j together, and those p of a product of the power, e = a + p
    are those of the product ``number``; the weight is prod_c e_c! / (e_c - a_c)!.
    """
    size = simplex.corners
    powers = Basis((size,), (degree,)).exponents
    basis = Basis((size,), (simplex.degree + degree,))
    factors = (rules.corners[:, simplex.columns, None] == np.arange(size)).sum(axis=1)
    # Rules agree in many premises: the table is made for each combination of corners once.
    factors, row = np.unique(factors, axis=0, return_inverse=True)
    row = row.ravel()
    a = factors[:, None, None] + factors[None, :, None]
    e = a + powers
    degrees = range(simplex.degree + 1), range(simplex.degree + degree + 1)
    falling = np.array([[float(perm(n, k)) for k in degrees[0]] for n in degrees[1]])
    number = basis.rank(e.reshape(-1, size)).reshape(e.shape[:-1])
    weight = falling[e, a].prod(axis=-1)
    return number[row[:, None], row], weight[row[:, None], row], basis.count


# The shares of the Theta_ij in a coefficient, which sum to 1.
_POLYA = r"\sum_{{i,j}} \tfrac{{k_i (k_j - \delta_{{ij}})}}{{{}}}"
_PAIRS = r"\tfrac{1}{|\mathcal{P}_k|} \sum_{(i,j) \in \mathcal{P}_k}"
_SHARES = r"\sum_{i,j} c^{k}_{ij}"


def polya(loop: DoubleSum, degree: int) -> RelaxedSum:
    """Every coefficient of (h_1 + ... + h_r)^d sum_ij h_i h_j Theta_ij is negative definite.

    Degree 0 is all pairs; necessary and sufficient as d grows, with (r + d + 1 choose d + 2)
    LMIs.

    Source: Sala and Arino (2007), Fuzzy Sets and Systems 158(24), theorem 5.
    """
    rules = ProductRules(np.arange(loop.rules)[:, None], ("h",))
    sums = coefficients(rules, degree)
    axes = [f"h{c + 1}" for c in range(loop.rules)]
    lmi = loop.lmi(
        "product of memberships",
        (sums.summand(_POLYA.format((degree + 2) * (degree + 1))),),
        count=sums.count,
        label=lambda item: sums.basis.label(item, axes),
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
    sums = coefficients(rules, degree)

    ends = np.cumsum(sums.basis.sizes)[:-1]

    def label(item: int) -> str:
        powers = np.split(sums.basis.exponents[item], ends)
        corners = (
            f"{simplex.name} at {' '.join(str(c + 1) for c in np.repeat(np.arange(len(p)), p))}"
            for simplex, p in zip(simplexes, powers, strict=True)
        )
        return "corners " + ", ".join(corners)

    return loop.lmi(
        "product of corner weights",
        (sums.summand(_SHARES if degree else _PAIRS),),
        None if X is None else _less(loop, sums, X),
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


def _less(loop: DoubleSum, sums: SimplexCoefficients, X: Unknown) -> Expression:
    """Return -X_ij summed as the Theta_ij are; (i, j) and (j, i) appear in the same coefficient."""
    E = selections(loop.rules, loop.size)
    half = sums.i <= sums.j
    i, j = sums.i[half], sums.j[half]
    # The sum is added to its transpose, which the pairs i < j need and i = j has twice.
    weight = sums.scale * sums.weight[half] * np.where(i == j, 0.5, 1.0)
    E_i = matrix(weight[:, None, None] * E.transpose(0, 2, 1)[i], r"\tfrac12 E_i^\top")
    blocks = added(E_i @ X @ matrix(E[j], "E_j"), sums.item[half], count=sums.count, latex=_PAIRS)
    return -He(blocks)
