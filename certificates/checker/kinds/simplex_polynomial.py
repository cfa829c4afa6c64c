r"""Matrix polynomials in weights, homogeneous in each of several simplexes.

    X(w) = sum_a w^a X_a,    w^a = prod_k prod_c w_kc^(a_kc),   sum_c a_kc = degree_k for every k,

with w_kc >= 0 and sum_c w_kc = 1.  Multiplication by sum_c w_kc = 1 raises a degree and does not
change the function.  No monomial is negative, and at every w at least one is positive.  So X(w) > 0
everywhere if X_a > 0 for every exponent a of these degrees.  The converse holds in the limit of
high degrees, and in the limit of small pieces of the weights.

Source: Polya's theorem, as in Scherer (2005), Math. Programming 107, recalled.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations_with_replacement, product
from math import comb, prod

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused

Exponent = tuple[tuple[int, ...], ...]
MOST_TERMS, MOST_PRODUCTS, MOST_WORK = 20_000, 1_000_000, 10**8


def exponents(sizes: Sequence[int], degrees: Sequence[int]) -> list[Exponent]:
    """Return every exponent a of these degrees."""
    _bounded(sizes, degrees)
    powers_by_simplex = [
        [tuple(chosen.count(c) for c in range(size))
         for chosen in combinations_with_replacement(range(size), degree)]
        for size, degree in zip(sizes, degrees, strict=True)
    ]  # fmt: skip
    return list(product(*powers_by_simplex))


def _bounded(sizes: Sequence[int], degrees: Sequence[int]) -> None:
    count = prod(comb(s + d - 1, d) for s, d in zip(sizes, degrees, strict=True))
    if count > MOST_TERMS:
        raise Refused(f"a polynomial of {count} terms; at most {MOST_TERMS} are checked")


@dataclass(frozen=True)
class Polynomial:
    """A polynomial; ``terms`` has X_a for each exponent a, a missing one is zero."""

    sizes: tuple[int, ...]
    degrees: tuple[int, ...]
    terms: Mapping[Exponent, Matrix]

    def __add__(self, other: Polynomial) -> Polynomial:
        """Return the sum, in the larger of the degrees."""
        degrees = tuple(map(max, self.degrees, other.degrees))
        total = dict(self.to(degrees).terms)
        for a, X in other.to(degrees).terms.items():
            total[a] = (total[a] + X).reduced() if a in total else X
        return Polynomial(self.sizes, degrees, total)

    def __neg__(self) -> Polynomial:
        return Polynomial(self.sizes, self.degrees, {a: -X for a, X in self.terms.items()})

    def __matmul__(self, other: Polynomial) -> Polynomial:
        products = len(self.terms) * len(other.terms)
        size = max(max(X.shape) for terms in (self.terms, other.terms) for X in terms.values())
        if products > MOST_PRODUCTS or products * size**3 > MOST_WORK:
            raise Refused(f"a product of {len(self.terms)} by {len(other.terms)} terms")
        total: dict[Exponent, Matrix] = {}
        degrees = tuple(d + e for d, e in zip(self.degrees, other.degrees, strict=True))
        _bounded(self.sizes, degrees)
        for (a, X), (b, Y) in product(self.terms.items(), other.terms.items()):
            exponent = _sum(a, b)
            Z = X @ Y
            total[exponent] = (total[exponent] + Z).reduced() if exponent in total else Z.reduced()
        return Polynomial(self.sizes, degrees, total)

    @property
    def T(self) -> Polynomial:
        return Polynomial(self.sizes, self.degrees, {a: X.T for a, X in self.terms.items()})

    def after(self, M: Matrix) -> Polynomial:
        """Return M X(w)."""
        return Polynomial(self.sizes, self.degrees, {a: M @ X for a, X in self.terms.items()})

    def scaled(self, factor: Fraction | int) -> Polynomial:
        """Return a number times the polynomial."""
        return Polynomial(self.sizes, self.degrees, {a: factor * X for a, X in self.terms.items()})

    def raised(self, by: Sequence[int]) -> Polynomial:
        """Return the same polynomial, multiplied by (sum_c w_kc)^by_k = 1."""
        terms: dict[Exponent, Matrix] = dict(self.terms)
        degrees = tuple(d + e for d, e in zip(self.degrees, by, strict=True))
        _bounded(self.sizes, degrees)
        for k, times in enumerate(by):
            for _ in range(times):
                terms = self._raised_once(terms, k)
        return Polynomial(self.sizes, degrees, terms)

    def _raised_once(self, terms: dict[Exponent, Matrix], k: int) -> dict[Exponent, Matrix]:
        raised: dict[Exponent, Matrix] = {}
        for a, X in terms.items():
            for c in range(self.sizes[k]):
                row = (*a[k][:c], a[k][c] + 1, *a[k][c + 1 :])
                exponent = (*a[:k], row, *a[k + 1 :])
                raised[exponent] = (raised[exponent] + X).reduced() if exponent in raised else X
        return raised

    def to(self, degrees: Sequence[int]) -> Polynomial:
        """Return the same polynomial in no smaller degrees."""
        return self.raised([d - e for d, e in zip(degrees, self.degrees, strict=True)])

    def derivative(self, speeds: Sequence[Sequence[Fraction]]) -> Polynomial:
        """Return sum_kc speeds_kc dX/dw_kc, in the degrees of X."""
        n = next(iter(self.terms.values())).shape[0]
        nothing = 0 * Matrix.identity(n)
        total = Polynomial(self.sizes, self.degrees, dict.fromkeys(self.terms, nothing))
        for k, degree in enumerate(self.degrees):
            if degree == 0:
                continue
            lower = tuple(d - (j == k) for j, d in enumerate(self.degrees))
            slopes: dict[Exponent, Matrix] = {}
            for a, X in self.terms.items():
                for c, power in enumerate(a[k]):
                    if power:
                        row = (*a[k][:c], power - 1, *a[k][c + 1 :])
                        exponent = (*a[:k], row, *a[k + 1 :])
                        term = power * speeds[k][c] * X
                        slopes[exponent] = slopes[exponent] + term if exponent in slopes else term
            total = total + Polynomial(self.sizes, lower, slopes)
        return total

    def halved(self, k: int, fixed_corner: int, moving_corner: int) -> Polynomial:
        """Return X on half of simplex k, where ``moving_corner`` is the middle of the two corners.

        w_fixed = t_fixed + t_moving / 2 and w_moving = t_moving / 2, multiplied out.
        """
        terms: dict[Exponent, Matrix] = {}
        for a, X in self.terms.items():
            p, q = a[k][fixed_corner], a[k][moving_corner]
            for j in range(p + 1):
                row = list(a[k])
                row[fixed_corner], row[moving_corner] = p - j, q + j
                exponent = (*a[:k], tuple(row), *a[k + 1 :])
                term = Fraction(comb(p, j), 2 ** (q + j)) * X
                terms[exponent] = (terms[exponent] + term).reduced() if exponent in terms else term
        return Polynomial(self.sizes, self.degrees, terms)

    def coefficients(self) -> Iterator[tuple[str, Matrix]]:
        """Yield the powers of every term, in words, and its X_a; 0 for a term that is missing."""
        missing = 0 * next(iter(self.terms.values()))
        for a in exponents(self.sizes, self.degrees):
            yield ", ".join(str(list(row)) for row in a), self.terms.get(a, missing)


def _sum(a: Exponent, b: Exponent) -> Exponent:
    return tuple(tuple(x + y for x, y in zip(p, q, strict=True)) for p, q in zip(a, b, strict=True))


def constant_polynomial(sizes: tuple[int, ...], X: Matrix) -> Polynomial:
    """Return the polynomial that is X at every w."""
    return Polynomial(sizes, (0,) * len(sizes), {tuple((0,) * size for size in sizes): X})


def blocks(grid: list[list[Polynomial | Matrix]], sides: tuple[int, ...]) -> Polynomial:
    """Return a block matrix of polynomials and of constants as one polynomial.

    Parameters
    ----------
    sides : the sizes of the blocks.
    """
    polynomials = [entry for row in grid for entry in row if isinstance(entry, Polynomial)]
    sizes = polynomials[0].sizes
    degrees = tuple(max(d) for d in zip(*(X.degrees for X in polynomials), strict=True))
    raised: list[list[dict[Exponent, Matrix]]] = []
    for row in grid:
        raised.append([])
        for entry in row:
            if isinstance(entry, Matrix):
                entry = constant_polynomial(sizes, entry)
            raised[-1].append(dict(entry.to(degrees).terms))
    terms = {
        a: Matrix.blocks(
            [
                [
                    cell[a] if a in cell else Matrix.zeros(sides[i], sides[j])
                    for j, cell in enumerate(row)
                ]
                for i, row in enumerate(raised)
            ]
        )
        for a in exponents(sizes, degrees)
    }
    return Polynomial(sizes, degrees, terms)


def corners_of_sum_zero(bounds: Sequence[Fraction]) -> Iterator[list[Fraction]]:
    """Yield the corners of {v : |v_c| <= bound_c, sum_c v_c = 0}: all but one entry at a bound."""
    for free in range(len(bounds)):
        other_bounds = [bound for c, bound in enumerate(bounds) if c != free]
        for signs in product((1, -1), repeat=len(other_bounds)):
            speeds = [sign * bound for sign, bound in zip(signs, other_bounds, strict=True)]
            last = -sum(speeds, Fraction(0))
            if abs(last) <= bounds[free]:
                yield [*speeds[:free], last, *speeds[free:]]
