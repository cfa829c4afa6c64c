r"""``fuzzy-decay``: V = x'P(w)x decays, with P a polynomial in weights w of one or more simplexes.

    P(w) > 0
    continuous   -(P G + G'P + 2 a P + sum_kc v_kc dP/dw_kc)(w) > 0    at each corner v of the rates
    discrete     [[r P(w), G(w)'P_b], [P_b G(w), P_b]] > 0             for each coefficient P_b

with G(w) = A(w) - B(w) K(w) and P(w) = sum_b multinomial_b w^b P_b.  A polynomial that is
homogeneous in each simplex is positive on the simplexes if all its coefficients are positive
definite.  The coefficients tested here are those after multiplication by (sum_c w_kc)^polya = 1,
which makes more polynomials pass.  With ``halvings`` the test is made on each piece of the weights,
w_kc = sum_j t_kj e_kjc, where e_kj are the weights at the corners of the piece.

A polynomial is a dictionary {exponents: matrix}; its key is one flat tuple of the powers of all
w_kc.

``fuzzy-l2-gain``: |y|_2 <= g |d|_2 from rest, by V = x'P(w)x with P a polynomial in weights w.

The storage of x' (or x+) = G x + E d, y = C x + D d, all of them polynomials in w, is shown by the
coefficients of the symmetric matrices

    continuous   [[-(P G + G'P + sum_kc v_kc dP/dw_kc), -P E, C'], [., g I, D'], [., ., g I]]
                 at each corner v of the rates,
    discrete     [[P, 0, C', G'P_b], [., g I, D', E'P_b], [., ., g I, 0], [., ., ., P_b]]
                 for each coefficient P_b of P,

and by those of P itself.  They are tested as ``fuzzy-decay`` does: after multiplication by
(sum_c w_kc)^polya = 1, on each piece of the weights.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from math import factorial, prod
from typing import Any, TypeAlias

from flint import fmpq, fmpq_mat

from tests.certificates.oracle.decay import rate_of
from tests.certificates.oracle.disturbed import channel_of
from tests.certificates.oracle.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    identity,
    scaled,
    transposed,
    zeros,
)
from tests.certificates.oracle.loop import Ends, Stack, VertexLoop, leaves
from tests.certificates.oracle.reading import (
    Refusal,
    entry,
    integer,
    rational,
    rational_row,
    rationals,
    table,
)

Exponent: TypeAlias = tuple[int, ...]
Terms: TypeAlias = dict[Exponent, fmpq_mat]
MOST_TERMS, HIGHEST, MOST_CORNERS = 20_000, 8, 4096


class Simplexes:
    """The simplexes of the weights: one for each premise, or one for all rules.

    ``sizes`` : corners of each simplex; ``of_rule`` : the exponent of the weight h_i of each rule.
    """

    def __init__(self, loop: VertexLoop) -> None:
        if loop.corners is None:
            self.sizes = [loop.rules]
            rows: list[tuple[int, ...]] = [(i,) for i in range(loop.rules)]
        else:
            self.sizes = [max(column) + 1 for column in zip(*loop.corners, strict=True)]
            rows = [tuple(c) for c in loop.corners]
        if prod(self.sizes) != len(rows):
            raise Refusal("the rules leave out a combination of corners")
        starts = [sum(self.sizes[:k]) for k in range(len(self.sizes))]
        self.blocks = [range(s, s + n) for s, n in zip(starts, self.sizes, strict=True)]
        self.width = sum(self.sizes)
        self.of_rule = [self._monomial(row) for row in rows]

    def _monomial(self, row: tuple[int, ...]) -> Exponent:
        ones = {self.blocks[k][c] for k, c in enumerate(row)}
        return tuple(int(i in ones) for i in range(self.width))

    @property
    def none(self) -> Exponent:
        return (0,) * self.width

    def stack(self, matrices: Stack) -> Terms:
        """Return sum_i h_i X_i."""
        if len(matrices) == 1:
            return {self.none: matrices[0]}
        return dict(zip(self.of_rule, matrices, strict=True))

    def degrees(self, terms: Terms) -> list[int]:
        """Return the degree in each simplex; every term has the same."""
        a = next(iter(terms))
        return [sum(a[i] for i in block) for block in self.blocks]

    def raised(self, terms: Terms, degrees: list[int]) -> Terms:
        """Return the polynomial in higher degrees, multiplied by (sum_c w_kc) = 1."""
        for k, (now, wanted) in enumerate(zip(self.degrees(terms), degrees, strict=True)):
            for _ in range(wanted - now):
                sum_terms: Terms = {}
                for a, X in terms.items():
                    for i in self.blocks[k]:
                        _add(sum_terms, (*a[:i], a[i] + 1, *a[i + 1 :]), X)
                terms = sum_terms
        return terms

    def total(self, *parts: Terms) -> Terms:
        """Return the sum, in the highest of the degrees."""
        degrees = [max(d) for d in zip(*map(self.degrees, parts), strict=True)]
        sum_terms: Terms = {}
        for part in parts:
            for a, X in self.raised(part, degrees).items():
                _add(sum_terms, a, X)
        return sum_terms

    def exponents(self, degrees: list[int]) -> Iterator[Exponent]:
        """Yield every exponent of these degrees."""
        parts = [
            [p for p in product(range(d + 1), repeat=n) if sum(p) == d]
            for n, d in zip(self.sizes, degrees, strict=True)
        ]
        for chosen in product(*parts):
            yield tuple(power for part in chosen for power in part)

    def over(self, terms: Terms, ends: Ends) -> Terms:
        """Return the polynomial in the variables t of a piece, by multiplying out linear forms."""
        piece_terms: Terms = {}
        for a, X in terms.items():
            integer = {self.none: fmpq(1)}
            for block, rows in zip(self.blocks, ends, strict=True):
                for c, i in enumerate(block):
                    form = [(block[j], row[c]) for j, row in enumerate(rows) if row[c] != 0]
                    for _ in range(a[i]):
                        integer = _multiplied(integer, form)
            for b, share in integer.items():
                _add(piece_terms, b, scaled(share, X))
        return piece_terms

    def positive(self, terms: Terms, label: str, size: int) -> Obligations:
        """Yield that every coefficient is definite; one that is missing counts as 0 and fails."""
        degrees = self.degrees(terms)
        if prod((d + 1) ** n for n, d in zip(self.sizes, degrees, strict=True)) > 10**7:
            raise Refusal("degrees that are too high")
        nothing = fmpq_mat(size, size)
        for k, a in enumerate(self.exponents(degrees)):
            yield Definite(f"{label}, coefficient {k + 1}", terms.get(a, nothing))


def _add(terms: Terms, a: Exponent, X: fmpq_mat) -> None:
    terms[a] = terms[a] + X if a in terms else X
    if len(terms) > MOST_TERMS:
        raise Refusal(f"more than {MOST_TERMS} coefficients")


def _multiplied(
    integer: dict[Exponent, fmpq], form: list[tuple[int, fmpq]]
) -> dict[Exponent, fmpq]:
    """Return a polynomial of numbers times a linear form, a share for each variable."""
    product_terms: dict[Exponent, fmpq] = {}
    for b, share in integer.items():
        for i, slope in form:
            place = (*b[:i], b[i] + 1, *b[i + 1 :])
            product_terms[place] = product_terms.get(place, fmpq(0)) + share * slope
    return product_terms


def times(left: Terms, right: Terms) -> Terms:
    """Return the product of two polynomials."""
    product_terms: Terms = {}
    for (a, X), (b, Y) in product(left.items(), right.items()):
        _add(product_terms, tuple(map(sum, zip(a, b, strict=True))), X * Y)
    return product_terms


def each(terms: Terms, factor: fmpq | int) -> Terms:
    """Return a number times a polynomial."""
    return {a: scaled(factor, X) for a, X in terms.items()}


def positive_on_pieces(
    weights: Simplexes, cut: Sequence[Ends | None], polya: int, terms: Terms, label: str, size: int
) -> Obligations:
    """Yield that a polynomial is positive on every piece of the weights, by its coefficients."""
    for k, ends in enumerate(cut, 1):
        piece_terms = terms if ends is None else weights.over(terms, ends)
        piece_label = label if ends is None else f"piece {k}, {label}"
        yield from weights.positive(with_polya(weights, piece_terms, polya), piece_label, size)


def fuzzy_decay(claim: Any, loop: VertexLoop) -> Obligations:
    """Yield the conditions of the module's text."""
    weights = Simplexes(loop)
    a, polya = rational(claim, "decay_rate"), integer(claim, "polya")
    if not 0 <= polya <= HIGHEST:
        raise Refusal(f"polya: 0 to {HIGHEST} is needed")
    yield Fact("the rate is not negative", a >= 0)
    P, coefficients = function_of(claim, loop, weights)
    if loop.averages and loop.rules > 1 and any(weights.degrees(P)):
        raise Refusal("P depends on weights that are averages over a segment")
    if len(loop.K) > 1 and not loop.together:
        raise Refusal("a law with weights of its own")
    cut = pieces_of(claim, loop, weights)

    positive = partial(positive_on_pieces, weights, cut, polya)
    yield from positive(P, "P", loop.n)
    G = weights.stack(loop.A)
    if loop.K:
        G = weights.total(G, each(times(weights.stack(loop.B), weights.stack(loop.K)), -1))
    rate = rate_of(loop, a)
    if loop.step is not None:
        for k, Pb in enumerate(coefficients):
            yield from positive(_jump(weights, P, G, Pb, rate), f"next sample {k + 1}", 2 * loop.n)
        return
    PG = times(P, G)
    constant_part = weights.total(PG, {b: transposed(X) for b, X in PG.items()}, each(P, rate))
    for k, speeds in enumerate(speeds_of(claim, weights, P)):
        motion = along(weights, P, speeds)
        decrease_terms = each(weights.total(constant_part, motion) if motion else constant_part, -1)
        yield from positive(decrease_terms, f"corner {k + 1}", loop.n)


def pieces_of(claim: Any, loop: VertexLoop, weights: Simplexes) -> list[Ends | None]:
    """Return the corners of each piece; None for the whole."""
    if "halvings" not in claim:
        return [None]
    if loop.corners is not None and set(weights.sizes) != {2}:
        raise Refusal("halvings: the rules leave out a combination of corners")
    return list(leaves(claim, weights.sizes))


def with_polya(weights: Simplexes, terms: Terms, polya: int) -> Terms:
    """Return the polynomial in degrees that are higher by polya."""
    return weights.raised(terms, [d + polya for d in weights.degrees(terms)])


def function_of(claim: Any, loop: VertexLoop, weights: Simplexes) -> tuple[Terms, list[fmpq_mat]]:
    """Return P(w), and the list of its P_b."""
    given = rationals(claim, "degrees", len(weights.sizes))
    if any(d.q != 1 or not 0 <= d <= HIGHEST for d in given):
        raise Refusal(f"degrees: whole numbers from 0 to {HIGHEST}")
    degrees = [int(d.p) for d in given]
    listed, wanted = entry(claim, "P"), set(weights.exponents(degrees))
    if not isinstance(listed, list) or len(listed) != len(wanted):
        raise Refusal(f"P: {len(wanted)} coefficients are needed")
    terms: Terms = {}
    matrices = []
    for coefficient in listed:
        rows = entry(coefficient, "powers")
        if not isinstance(rows, list) or len(rows) != len(weights.sizes):
            raise Refusal("powers: a row for each simplex is needed")
        flat = [v for row, n in zip(rows, weights.sizes, strict=True)
                for v in rational_row(row, "powers", n)]  # fmt: skip
        a = tuple(int(v.p) if v.q == 1 else -1 for v in flat)
        if a not in wanted or a in terms:
            raise Refusal("powers: each exponent of the degrees once")
        matrices.append(table(coefficient, "matrix", (loop.n, loop.n)))
        count = prod(factorial(d) for d in degrees) // prod(factorial(v) for v in a)
        terms[a] = scaled(count, matrices[-1])
    return terms, matrices


def _jump(weights: Simplexes, P: Terms, G: Terms, Pb: fmpq_mat, rate: fmpq) -> Terms:
    """Return the discrete condition's matrix for one P_b, which stands for P at the next sample."""
    zero = scaled(0, Pb)
    moved = {a: Pb * X for a, X in G.items()}
    return weights.total(
        {a: blocks([[scaled(rate, X), zero], [zero, zero]]) for a, X in P.items()},
        {a: blocks([[zero, transposed(X)], [X, zero]]) for a, X in moved.items()},
        {weights.none: blocks([[zero, zero], [zero, Pb]])},
    )


def speeds_of(claim: Any, weights: Simplexes, P: Terms) -> Iterator[list[fmpq]]:
    """Yield the corners of all rates as one flat list; 0 where P does not depend on a simplex."""
    listed = entry(claim, "rates")
    if not isinstance(listed, list) or len(listed) != len(weights.sizes):
        raise Refusal("rates: a row for each simplex is needed")
    parts = []
    for row, n, degree in zip(listed, weights.sizes, weights.degrees(P), strict=True):
        if row is None:
            if degree:
                raise Refusal("rates: P depends on weights that have no bound")
            parts.append([[fmpq(0)] * n])
            continue
        bounds = rational_row(row, "rates", n)
        if min(bounds) < 0 or n << (n - 1) > 8 * MOST_CORNERS:
            raise Refusal("rates: not negative, and not of too many weights")
        parts.append(list(map(list, sorted(set(map(tuple, _corners(bounds)))))))
    if prod(map(len, parts)) > MOST_CORNERS:
        raise Refusal("rates: too many corners")
    for chosen in product(*parts):
        yield [speed for part in chosen for speed in part]


def _corners(bounds: list[fmpq]) -> Iterator[list[fmpq]]:
    """Yield the corners of {|v_c| <= bound_c, sum v_c = 0}, as the weights always sum to 1."""
    for free in range(len(bounds)):
        for signs in product((-1, 1), repeat=len(bounds) - 1):
            rest = iter(signs)
            speeds = [fmpq(0) if c == free else next(rest) * b for c, b in enumerate(bounds)]
            speeds[free] = -sum(speeds, fmpq(0))
            if abs(speeds[free]) <= bounds[free]:
                yield speeds


def along(weights: Simplexes, P: Terms, speeds: list[fmpq]) -> Terms:
    """Return sum v_kc dP/dw_kc, in the degrees of P; empty where it is zero."""
    derivative: Terms = {}
    degrees = weights.degrees(P)
    for i, v in enumerate(speeds):
        if v == 0:
            continue
        part: Terms = {
            (*a[:i], a[i] - 1, *a[i + 1 :]): scaled(v * a[i], X) for a, X in P.items() if a[i]
        }
        if part:
            for a, X in weights.raised(part, degrees).items():
                _add(derivative, a, X)
    return derivative


def fuzzy_l2_gain(claim: Any, loop: VertexLoop) -> Obligations:
    """Yield the conditions of the module's text."""
    weights = Simplexes(loop)
    g, polya = rational(claim, "gain"), integer(claim, "polya")
    if g <= 0 or not 0 <= polya <= HIGHEST:
        raise Refusal(f"gain: a positive number; polya: 0 to {HIGHEST}")
    if loop.averages and loop.rules > 1:
        raise Refusal("P depends on weights that are averages over a segment")
    if len(loop.K) > 1 and not loop.together:
        raise Refusal("a law with weights of its own")
    output_loop, entering, direct = channel_of(claim, loop)
    P, coefficients = function_of(claim, loop, weights)
    G, C = (
        _closed(weights, loop, X, Y) for X, Y in ((loop.A, loop.B), (output_loop.C, output_loop.D))
    )
    E = weights.stack(entering)
    n, q, p = loop.n, entering[0].ncols(), output_loop.C[0].nrows()
    D: Terms = {weights.none: zeros(p, q)}
    for matrices in direct:
        D = weights.total(D, weights.stack(matrices))
    cut = pieces_of(claim, loop, weights)
    positive = partial(positive_on_pieces, weights, cut, polya)
    yield from positive(P, "P", n)
    if loop.step is not None:
        grid_of = _Blocks(weights, (n, q, p, n))
        for k, Pb in enumerate(coefficients):
            dissipation = grid_of.total(
                (0, 0, P),
                (1, 1, {weights.none: scaled(g, identity(q))}),
                (2, 2, {weights.none: scaled(g, identity(p))}),
                (3, 3, {weights.none: Pb}),
                (2, 0, C),
                (2, 1, D),
                (3, 0, {a: Pb * X for a, X in G.items()}),
                (3, 1, {a: Pb * X for a, X in E.items()}),
            )
            yield from positive(dissipation, f"gain at the next sample {k + 1}", 2 * n + q + p)
        return
    grid_of = _Blocks(weights, (n, q, p))
    PG = times(P, G)
    constant_part = weights.total(PG, {a: transposed(X) for a, X in PG.items()})
    for k, speeds in enumerate(speeds_of(claim, weights, P)):
        motion = along(weights, P, speeds)
        dissipation = grid_of.total(
            (0, 0, each(weights.total(constant_part, motion) if motion else constant_part, -1)),
            (1, 1, {weights.none: scaled(g, identity(q))}),
            (2, 2, {weights.none: scaled(g, identity(p))}),
            (0, 1, each(times(P, E), -1)),
            (2, 0, C),
            (2, 1, D),
        )
        yield from positive(dissipation, f"gain at corner {k + 1}", n + q + p)


def _closed(weights: Simplexes, loop: VertexLoop, X: Stack, Y: Stack) -> Terms:
    """Return X(w) - Y(w) K(w)."""
    if not loop.K or not Y:
        return weights.stack(X)
    return weights.total(weights.stack(X), each(times(weights.stack(Y), weights.stack(loop.K)), -1))


class _Blocks:
    """Symmetric matrices of blocks of some sizes."""

    def __init__(self, weights: Simplexes, sizes: tuple[int, ...]) -> None:
        self.weights, self.sizes = weights, sizes

    def total(self, *parts: tuple[int, int, Terms]) -> Terms:
        """Return the sum of polynomials (i, j, X), each at block (i, j) and mirrored."""
        return self.weights.total(*self._placed(parts))

    def _placed(self, parts: tuple[tuple[int, int, Terms], ...]) -> Iterator[Terms]:
        for i, j, terms in parts:
            yield {a: self._whole(i, j, X) for a, X in terms.items()}

    def _whole(self, i: int, j: int, X: fmpq_mat) -> fmpq_mat:
        grid = [[zeros(r, c) for c in self.sizes] for r in self.sizes]
        grid[i][j] = X
        if i != j:
            grid[j][i] = transposed(X)
        return blocks(grid)
