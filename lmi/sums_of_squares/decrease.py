r"""Where V' may be 0: directions that do not decay to first order, and LaSalle's theorem.

The state is written as x = T z, so that the directions along which the quadratic part of V' is 0
are axes of z.  Along the axis z_i let V' begin with the power L_i:

    r(z) = (sum_i z_i^L_i) (sum_i z_i^2)^(k - 1),     i in I, the axes along which V falls near 0.

r >= 0, and r = 0 only where z_i = 0 for all i in I.  If I has all axes, r > 0 except at 0.  If it
has not, V' may be 0 where r is, and solutions that stay there decide.  On such a solution all
derivatives of z_i, i in I, are 0: polynomials, of which a Groebner basis is computed over the
rationals.  If 0 is their only real zero with V < e, all solutions from an invariant set {V < c}, c
<= e, tend to 0 (LaSalle's theorem).

Source: Khalil (2002), Nonlinear Systems, theorems 4.1 and 4.4 with corollary 4.1; Cox, Little,
O'Shea (2015), Ideals, Varieties, and Algorithms, section 3.1 (elimination).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from math import prod

import numpy as np

from takagi.lmi.sums_of_squares.polynomial import StatePolynomial

# Points at which V' is sampled before a proof for all points is tried.
POINTS = 2000
# A sampled V' counts as positive above this share of the sum of its terms' sizes.
ROUNDING = 1e-9
# What is added to the powers L_i if they are not all 2 and no level is proved with them.
LIFT = 2
# Width of the intervals that hold the real zeros of a polynomial.
ROOT = Fraction(1, 10**12)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Decrease:
    """V and x' = f(x) in the coordinates z.

    Attributes
    ----------
    function, slope, field : V, V' and z', polynomials in z.
    orders : i in I -> L_i.
    ray : direction d in x, exact, such that V(t d) <= 0, or V'(t d) > 0, for all small t > 0; None
        where none was seen.
    rises : whether it is V' > 0.
    """

    function: StatePolynomial
    slope: StatePolynomial
    field: tuple[StatePolynomial, ...]
    orders: dict[int, int]
    ray: tuple[Fraction, ...] | None = None
    rises: bool = False

    @classmethod
    def of(cls, field: Sequence[StatePolynomial], V: StatePolynomial) -> Decrease:
        """Return V, V' and the field in coordinates z."""
        n, slope = V.n, V.along(field)
        T = _coordinates(slope)
        lines = [_line(n, row) for row in T]
        # T = I + N with N N = 0, so its inverse is 2 I - T.
        back = [[2 * int(i == j) - T[i][j] for j in range(n)] for i in range(n)]
        substituted = [component.composed(lines) for component in field]
        here = tuple(
            sum(
                (component.times(share) for component, share in zip(substituted, row, strict=True)),
                StatePolynomial(n, {}),
            )
            for row in back
        )
        function, slope = V.composed(lines), slope.composed(lines)
        decrease = cls(function=function, slope=slope, field=here, orders={})
        for d in _directions(n):
            (_, level), (order, change) = _first(function, d), _first(slope, d)
            if level <= 0 or change > 0:
                ray = tuple(
                    sum((a * b for a, b in zip(row, d, strict=True)), Fraction(0)) for row in T
                )
                return replace(decrease, ray=ray, rises=level > 0)
            if sum(map(abs, d)) == 1 and change < 0:
                decrease.orders[next(k for k in range(n) if d[k])] = order
        return decrease

    def with_other_weights(self) -> tuple[Decrease, ...]:
        """Return it, and with larger L_i where V' may fall more slowly along a curve."""
        if max(self.orders.values()) == 2:
            return (self,)
        return self, replace(self, orders={i: order + LIFT for i, order in self.orders.items()})

    def weight(self, k: int) -> StatePolynomial:
        """Return r."""
        n = self.function.n
        powers = {_unit(n, i, order): Fraction(1) for i, order in self.orders.items()}
        squares = {_unit(n, i, 2): Fraction(1) for i in self.orders}
        return StatePolynomial(n, powers) * StatePolynomial(n, squares).power(k - 1)

    def seems_to_rise(self) -> bool:
        """Return whether V' > 0 at one of many sampled points; this proves nothing."""
        random = np.random.default_rng(0)
        x = random.normal(size=(POINTS, self.function.n))
        x *= (10 ** random.uniform(-2, 3, POINTS) / np.linalg.norm(x, axis=1))[:, None]
        sizes = StatePolynomial(self.slope.n, {a: abs(c) for a, c in self.slope.terms.items()})
        return bool((self.slope(x) > ROUNDING * sizes(np.abs(x))).any())

    def attraction_end(self) -> Fraction | float:
        """Return e > 0 such that 0 alone stays where r = 0 and V < e; 0 where none is shown."""
        import sympy as sp

        n = self.function.n
        free_states = [i for i in range(n) if i not in self.orders]
        z = sp.symbols(f"z:{n}")
        derivatives = [_line(n, [Fraction(int(i == j)) for j in range(n)]) for i in self.orders]
        zero: list[object] = []
        for _ in free_states:
            derivatives = [derivative.along(self.field) for derivative in derivatives]
            for derivative in derivatives:
                there = [
                    sp.Rational(c.numerator, c.denominator)
                    * sp.prod([z[i] ** a[i] for i in free_states])
                    for a, c in derivative.terms.items()
                    if not any(a[i] for i in self.orders)
                ]
                zero += [sp.Add(*there)] if there else []
        roots = [[(Fraction(0), Fraction(0))]] * n
        for i in free_states:
            roots[i] = _roots(zero, z[i], [z[j] for j in free_states if j != i]) if zero else []
        levels = [_least(self.function, box) for box in product(*roots) if any(map(any, box))]
        return min(levels, default=np.inf) if all(roots) else 0.0


def _roots(
    polynomials: Sequence[object], last: object, other_symbols: Sequence[object]
) -> list[tuple[Fraction, Fraction]]:
    """Return intervals with all coordinates ``last`` of the common real zeros, by elimination.

    No interval but [0, 0] has 0 in it; there is none if elimination leaves no polynomial.
    """
    import sympy as sp

    basis = sp.groebner(polynomials, *other_symbols, last, order="lex", domain="QQ")
    for element in basis.exprs:
        if element.free_symbols == {last}:
            intervals = [
                (Fraction(int(low.p), int(low.q)), Fraction(int(high.p), int(high.q)))
                for (low, high), _ in sp.Poly(element, last, domain="QQ").intervals(eps=ROOT)
            ]
            # An interval that touches 0 without being 0 is too wide for its root.
            return (
                intervals
                if all(low * high > 0 or low == high == 0 for low, high in intervals)
                else []
            )
    return []


def _least(p: StatePolynomial, box: Sequence[tuple[Fraction, Fraction]]) -> Fraction:
    """Return a lower bound on a box in which no coordinate changes its sign."""
    corners = list(product(*box))
    values = (
        min(c * prod(x**k for x, k in zip(corner, a, strict=True)) for corner in corners)
        for a, c in p.terms.items()
    )
    return sum(values, Fraction(0))


def _coordinates(slope: StatePolynomial) -> list[list[Fraction]]:
    """Return T: the null vectors of the quadratic part's matrix, and axes beside them."""
    import flint

    n = slope.n
    Q = [[Fraction(0)] * n for _ in range(n)]
    for a, c in slope.terms.items():
        if sum(a) == 2:
            i, j = (k for k in range(n) for _ in range(a[k]))
            Q[i][j] += c / 2
            Q[j][i] += c / 2
    entries = [[flint.fmpq(c.numerator, c.denominator) for c in row] for row in Q]
    reduced, rank = flint.fmpq_mat(entries).rref()
    pivots = [next(j for j in range(n) if reduced[i, j] != 0) for i in range(rank)]
    T = [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]
    for j in set(range(n)) - set(pivots):
        for i, pivot in enumerate(pivots):
            T[pivot][j] = -Fraction(int(reduced[i, j].p), int(reduced[i, j].q))
    return T


def _directions(n: int) -> list[tuple[int, ...]]:
    return [d for d in product((0, 1, -1), repeat=n) if 0 < sum(map(abs, d)) <= 2]


def _first(p: StatePolynomial, d: Sequence[int]) -> tuple[int, Fraction]:
    """Return the lowest power of t in p(t d) and its coefficient; 0 where p(t d) is 0."""
    coefficients: dict[int, Fraction] = {}
    for a, c in p.terms.items():
        value = c
        for entry, power in zip(d, a, strict=True):
            value *= entry**power
        coefficients[sum(a)] = coefficients.get(sum(a), Fraction(0)) + value
    return next(
        ((power, coefficients[power]) for power in sorted(coefficients) if coefficients[power]),
        (0, Fraction(0)),
    )


def _line(n: int, row: Sequence[Fraction]) -> StatePolynomial:
    return StatePolynomial(n, {_unit(n, j, 1): c for j, c in enumerate(row) if c})


def _unit(n: int, k: int, power: int) -> tuple[int, ...]:
    return tuple(power * int(j == k) for j in range(n))
