"""Polynomials of the state with exact coefficients, and where V' of one may be 0.

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

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, combinations_with_replacement, product
from math import comb, prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.argument_checks import number
from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.condition.term import Constant, Equality, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.expressions.parser import Scope, parse_expression

Exponent = tuple[int, ...]
# Most monomials of a Gram matrix: a matrix of this size is solved in about a minute.
MOST_MONOMIALS = 120


def monomials(n: int, degrees: Sequence[int]) -> tuple[Exponent, ...]:
    """Return the exponents of all monomials in n variables of these degrees, in a fixed order.

    Raises
    ------
    ModelError : more monomials than the limit for a Gram matrix.
    """
    count = sum(comb(n + d - 1, d) for d in degrees)
    if count > MOST_MONOMIALS:
        raise ModelError(
            f"{n} states and degree {max(degrees)}: {count} monomials in a Gram matrix, more than "
            f"{MOST_MONOMIALS}; take a lower degree, or fewer states"
        )
    exponents = []
    for degree in degrees:
        for chosen in combinations_with_replacement(range(n), degree):
            exponents.append(tuple(chosen.count(k) for k in range(n)))
    return tuple(exponents)


@dataclass(frozen=True, slots=True)
class StatePolynomial:
    """sum_a c_a x^a in n variables.

    Attributes
    ----------
    n : number of variables.
    terms : exponents -> coefficient, a Fraction other than 0.
    """

    n: int
    terms: Mapping[Exponent, Fraction]

    @classmethod
    def of(cls, expression: object, states: Sequence[str]) -> StatePolynomial:
        """Return the polynomial of a text or of a sympy expression, e.g. ``"-x1 + x1**2*x2"``.

        A text is read by the grammar of plant files: nothing in it is executed, and a decimal is
        that decimal, exactly.

        Raises
        ------
        ModelError : no polynomial with rational coefficients in these states.
        """
        import sympy as sp

        symbols = {name: sp.Symbol(name) for name in states}
        try:
            if isinstance(expression, str):
                read = parse_expression(expression, Scope(symbols))
            else:
                read = sp.nsimplify(sp.sympify(expression, strict=True), rational=True)
            renamed = read.subs(
                {s: symbols[s.name] for s in read.free_symbols if s.name in symbols}
            )
            poly = sp.Poly(renamed, *symbols.values(), domain="QQ")
        except (sp.SympifyError, sp.PolynomialError, sp.CoercionFailed, TypeError) as error:
            raise ModelError(
                f"{expression!r} is no polynomial in {', '.join(states)} with rational coefficients"
            ) from error
        except ModelError as error:
            raise ModelError(
                f"{expression!r} is no polynomial in {', '.join(states)}: {error}"
            ) from error
        terms = {
            tuple(int(power) for power in a): Fraction(int(c.p), int(c.q)) for a, c in poly.terms()
        }
        return cls(len(states), {a: c for a, c in terms.items() if c})

    @classmethod
    def quadratic(cls, P: ArrayLike) -> StatePolynomial:
        """Return x' P x; a float is the dyadic number it stores."""

        exact = fractions(P)
        terms: dict[Exponent, Fraction] = {}
        for (i, j), value in np.ndenumerate(exact):
            a = tuple(int(k == i) + int(k == j) for k in range(len(exact)))
            terms[a] = terms.get(a, Fraction(0)) + value
        return cls(len(exact), {a: c for a, c in terms.items() if c})

    @property
    def degree(self) -> int:
        """Return the largest degree of a term; 0 for the zero polynomial."""
        return max((sum(a) for a in self.terms), default=0)

    @property
    def least_degree(self) -> int:
        """Return the smallest degree of a term."""
        return min((sum(a) for a in self.terms), default=0)

    def __add__(self, other: StatePolynomial) -> StatePolynomial:
        terms = dict(self.terms)
        for a, c in other.terms.items():
            terms[a] = terms.get(a, Fraction(0)) + c
        return StatePolynomial(self.n, {a: c for a, c in terms.items() if c})

    def __mul__(self, other: StatePolynomial) -> StatePolynomial:
        terms: dict[Exponent, Fraction] = {}
        for a, c in self.terms.items():
            for b, d in other.terms.items():
                exponent = tuple(p + q for p, q in zip(a, b, strict=True))
                terms[exponent] = terms.get(exponent, Fraction(0)) + c * d
        return StatePolynomial(self.n, {a: c for a, c in terms.items() if c})

    def times(self, number: Fraction | int) -> StatePolynomial:
        """Return a number times the polynomial."""
        return StatePolynomial(self.n, {a: c * number for a, c in self.terms.items() if number})

    def power(self, times: int) -> StatePolynomial:
        """Return the polynomial to a whole power."""
        product = StatePolynomial(self.n, {(0,) * self.n: Fraction(1)})
        for _ in range(times):
            product = product * self
        return product

    def composed(self, lines: Sequence[StatePolynomial]) -> StatePolynomial:
        """Return p(q_1(z), ..., q_n(z))."""
        total = StatePolynomial(self.n, {})
        for a, c in self.terms.items():
            summand = StatePolynomial(self.n, {(0,) * self.n: c})
            for line, power in zip(lines, a, strict=True):
                summand = summand * line.power(power)
            total = total + summand
        return total

    def along(self, field: Sequence[StatePolynomial]) -> StatePolynomial:
        """Return the derivative along x' = f(x): sum_k dp/dx_k f_k."""
        total = StatePolynomial(self.n, {})
        for k, motion in enumerate(field):
            slope = {
                (*a[:k], a[k] - 1, *a[k + 1 :]): a[k] * c for a, c in self.terms.items() if a[k]
            }
            total = total + StatePolynomial(self.n, slope) * motion
        return total

    def __call__(self, x: ArrayLike) -> Floats:
        """Return its values at x, (..., n), in floating point."""
        at = np.asarray(x, dtype=np.float64)
        total: Any = np.zeros(at.shape[:-1])
        for a, c in self.terms.items():
            total = total + float(c) * np.prod(at ** np.array(a), axis=-1)
        return np.asarray(total)


def without_idle(basis: Sequence[Exponent], support: Iterable[Exponent]) -> tuple[Exponent, ...]:
    """Return the monomials m_i that m' S m with S >= 0 can hold, if its terms are in the support.

    The square of a monomial has a positive coefficient.  If it is not in the support and is no
    product of two other monomials, the monomial's row of S is 0.  This is repeated; what stays lies
    in half the Newton polytope of the support.

    Source: Reznick (1978), Duke Mathematical Journal 45; Loefberg (2009), IEEE Transactions on
    Automatic Control 54, section IV (diagonal inconsistency).
    """
    there, monomials_left = set(support), list(basis)
    while True:
        products = {_product(a, b) for a, b in combinations(monomials_left, 2)} | there
        fewer = [a for a in monomials_left if _product(a, a) in products]
        if len(fewer) == len(monomials_left):
            return tuple(monomials_left)
        monomials_left = fewer


def _product(a: Exponent, b: Exponent) -> Exponent:
    return tuple(p + q for p, q in zip(a, b, strict=True))


def identity(
    name: str,
    summands: Sequence[tuple[Unknown, Sequence[StatePolynomial], StatePolynomial]],
    right_side: StatePolynomial,
) -> Equality:
    """Return sum_k p_k(x) m_k(x)' X_k m_k(x) = q(x) for all x: one equation for each monomial.

    Parameters
    ----------
    summands : (X_k, polynomials m_k, p_k).
    right_side : q.
    """
    row_of: dict[Exponent, int] = {}
    rows: list[tuple[Unknown, list[tuple[int, int, int, Fraction]]]] = []
    for unknown, basis, factor in summands:
        entries = []
        for i, a in enumerate(basis):
            for j, b in enumerate(basis):
                for monomial, value in (a * b * factor).terms.items():
                    entries.append((row_of.setdefault(monomial, len(row_of)), i, j, value))
        rows.append((unknown, entries))
    for monomial in right_side.terms:
        row_of.setdefault(monomial, len(row_of))
    terms = []
    for unknown, entries in rows:
        left = np.full((len(entries), 1, unknown.rows), Fraction(0), dtype=object)
        right = np.zeros((len(entries), unknown.cols, 1))
        for t, (_, i, j, value) in enumerate(entries):
            left[t, 0, i], right[t, j, 0] = value, 1.0
        terms.append(
            Term(
                unknown=unknown,
                left=left,
                right=right,
                at=(0, 1),
                items=np.array([item for item, *_ in entries], dtype=np.intp),
                latex=(r"\textstyle\sum_{ij} p_{kij}\, e_i^\top", "e_j"),
            )
        )
    constant = np.full((len(row_of), 1, 1), Fraction(0), dtype=object)
    for monomial, coefficient in right_side.terms.items():
        constant[row_of[monomial], 0, 0] = -coefficient
    return Equality(
        name=name,
        shape=(1, 1),
        terms=tuple(terms),
        constants=(Constant(value=constant, at=(0, 1), latex="-q_k"),) if right_side.terms else (),
        count=len(row_of),
        labels=tuple(f"{name}, monomial {a}" for a in row_of),
        index=r"x^k \text{ a monomial}",
    )


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
        choices = product((0, 1, -1), repeat=n)
        for d in (d for d in choices if 0 < sum(map(abs, d)) <= 2):
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


def _asked(
    field: Sequence[object], function: object, states: Sequence[str], degree: int | None
) -> tuple[tuple[StatePolynomial, ...], StatePolynomial, int]:
    n = len(states)
    if isinstance(field, str) or len(field) != n or not n or len(set(states)) != n:
        raise ModelError(
            f"field has {len(field)} entries for the states {list(states)}; one polynomial for "
            "each of different states is needed"
        )
    f = tuple(StatePolynomial.of(entry, states) for entry in field)
    for name, motion in zip(states, f, strict=True):
        if motion.terms.get((0,) * n):
            raise ModelError(
                f"{name}' is {float(motion.terms[(0,) * n]):g} at 0; shift the states so that the "
                "equilibrium is 0"
            )
    V = _function(function, f, states)
    if V.degree % 2 or V.degree < 2 or V.least_degree < 2:
        raise ModelError(
            f"V has terms of degree {V.least_degree} to {V.degree}; an even degree is needed, and "
            "no term below degree 2"
        )
    largest_degree = max(p.degree for p in f)
    if degree is None:
        degree = max(0, largest_degree - 1 + (largest_degree - 1) % 2)
    number("multiplier_degree", degree, at_least=0)
    if degree % 2:
        raise ModelError(f"multiplier_degree is {degree}; an even number is needed")
    return f, V, int(degree)


def function_of_linearisation(f: Sequence[StatePolynomial]) -> StatePolynomial:
    """Return x'Px with A'P + P A = -I for the linear part x' = A x of x' = f(x), to six digits.

    Raises
    ------
    ModelError : A has an eigenvalue that is not stable.
    """
    n = len(f)
    A = np.array([[float(p.terms.get(_unit(n, k, 1), 0)) for k in range(n)] for p in f])
    if np.linalg.eigvals(A).real.max() >= 0:
        raise ModelError(
            "the linearisation at 0 is not stable, so it has no quadratic function; give V"
        )
    P = solve_continuous_lyapunov(A.T, -np.eye(n))
    short = [[f"{value:.6g}" for value in row] for row in (P + P.T) / 2]
    return StatePolynomial.quadratic(np.array(short))


def _function(
    function: object, f: Sequence[StatePolynomial], states: Sequence[str]
) -> StatePolynomial:
    n = len(states)
    if function is None:
        return function_of_linearisation(f)
    if isinstance(function, (list, tuple, np.ndarray)):
        if np.shape(function) != (n, n):
            raise ModelError(f"V is a matrix of shape {np.shape(function)}; ({n}, {n}) is needed")
        return StatePolynomial.quadratic(function)
    return StatePolynomial.of(function, states)
