r"""Polynomials V with ever larger {V <= 1} in a region of attraction, within limits.

For x' = f(x), f(0) = 0, and quantities q_k(x) with limits a_k < 0 < b_k, all polynomials,

    -V'                    = z'S_0 z + m_0 (1 - V),   m_0 = y'Lambda_0 y,   z and y without the 1
    (b_k - q_k)(q_k - a_k) = z'S_k z + m_k (1 - V),   m_k = y'Lambda_k y

with S > 0 and Lambda >= 0: V falls on {V <= 1} except at 0, and every q_k is within its limits
there.  For a given V these are LMIs in S and Lambda, one for each line (``multipliers``).  About a
V = U with multipliers m they are LMIs in S, Lambda and V together, where the product of what
changes of V and of m is left out:

    -V' = z'S_0 z + m_0 (1 - U) - (m_0 at U) (V - U),   and so for q_k.

The volume of {V <= 1} grows by int r^n (U - V) / (r dU/dr) over all directions, where r is the
distance of the border.  ``larger_function`` maximises this integral, of V - U at points slightly
outside of the border, with (1 - d) U <= V <= (1 + d) U as sums of squares.  Then the largest share
of the step is taken with which multipliers exist and the volume is larger (``largest_set``).  No
set is smaller than the one before; none need be the largest.

The entries of S that are free beside the identity are the solver's variables: no equality is left.

Source: Tan and Packard (2008), IEEE Transactions on Automatic Control 53, section III; Topcu,
Packard and Seiler (2008), Automatica 44 (search in V and multipliers); Parrilo (2000), thesis, for
Gram matrices.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide, optimise
from takagi.lmi.solver.solve import number_of_solvers
from takagi.lmi.sums_of_squares.polynomial import Exponent, StatePolynomial, monomials
from takagi.models.arrays import Floats

SOURCE = "Tan and Packard (2008), IEEE Transactions on Automatic Control 53, section III"
# Directions of the border, and how far outside of it V is made small.
DIRECTIONS, OUTSIDE = 200, 1.1
DIGITS = 9  # of coefficients between the steps
SHARES = (1.0, 0.5, 0.2, 0.05)  # of a step
TRUST = 0.4  # |V - U| is at most this share of U
MOST_STEPS = 30
LEAST_GROWTH = 5e-3  # of the volume in a step that is worth another
LEVELS = 0.7 ** np.arange(25)  # of the first function
ROUND = 0.02  # of |x|^degree in the first function, whose top degree must not vanish


@dataclass(frozen=True, slots=True)
class Limited:
    """A quantity q(x) with limits low < 0 < high on the set."""

    q: StatePolynomial
    low: Fraction
    high: Fraction

    @property
    def room(self) -> StatePolynomial:
        """(high - q)(q - low)."""
        one = self.q.power(0)
        return (one.times(self.high) + self.q.times(-1)) * (self.q + one.times(-self.low))


@dataclass(frozen=True, slots=True, eq=False)
class Squares:
    """left = z'S z + (y'Lambda y)(1 - V), z and y of degrees least to these.

    S (N, N) and Lambda (M, M) in floating point; ``multiplier`` is y'Lambda y.
    """

    S: Floats
    degree: int
    Lambda: Floats
    multiplier_degree: int
    multiplier: StatePolynomial


def multipliers(
    field: Sequence[StatePolynomial],
    limited: Sequence[Limited],
    V: StatePolynomial,
    *,
    spare: bool = False,
) -> list[Squares] | None:
    """Return S and Lambda of every line for {V <= 1}; None where a solver finds none for one.

    ``spare`` : whether Lambda too needs a margin, so that it may be rounded.
    """
    squares = []
    below = V.power(0) + V.times(-1)
    for left, least in _lines(field, limited, V):
        y = max(1, -(-(left.degree - V.degree) // 2)) + (V.degree > 2)
        z = V.degree // 2 + y
        entries = _entries(monomials(V.n, range(least, y + 1)))
        parts = [(p * below).times(-1) for p in entries]
        pencil = _Pencil(len(parts))
        pencil.semidefinite("Lambda", entries, strict=spare)
        pencil.squares("S", monomials(V.n, range(least, z + 1)), left, parts)
        outcome = decide(pencil.condition({}), most=number_of_solvers())
        if outcome.status != "candidate":
            return None
        S, Lambda = pencil.values(outcome.values, "S"), pencil.values(outcome.values, "Lambda")
        multiplier = V.times(0)
        for p, t in zip(entries, outcome.values["free"].ravel(), strict=False):
            multiplier += p.times(Fraction(float(t)))
        squares.append(Squares(S, z, Lambda, y, multiplier))
    return squares


def larger_function(
    field: Sequence[StatePolynomial],
    limited: Sequence[Limited],
    U: StatePolynomial,
    squares: Sequence[Squares],
    degree: int,
) -> StatePolynomial | None:
    """Return V of a degree with a larger set to first order about U; None where none is found."""
    n = U.n
    v = monomials(n, range(2, degree + 1))
    powers = [StatePolynomial(n, {a: Fraction(1)}) for a in v]
    below = U.power(0) + U.times(-1)
    lines = list(zip(_lines(field, limited, U), squares, strict=True))
    multiplier_entries = [
        _entries(monomials(n, range(least, known.multiplier_degree + 1)))
        for (_, least), known in lines
    ]
    pencil = _Pencil(len(v) + sum(map(len, multiplier_entries)))
    place = len(v)
    for k, ((left, least), known) in enumerate(lines):
        entries = multiplier_entries[k]
        parts = [known.multiplier * power for power in powers]
        constant = (known.multiplier * U).times(-1)
        if k == 0:
            parts = [p + q.along(field).times(-1) for p, q in zip(parts, powers, strict=True)]
        else:
            constant = constant + left
        columns = [*range(len(v)), *range(place, place + len(entries))]
        parts += [(p * below).times(-1) for p in entries]
        pencil.semidefinite(f"Lambda {k}", entries, strict=False, first=place)
        z = monomials(n, range(least, known.degree + 1))
        pencil.squares(f"S {k}", z, constant, parts, columns)
        place += len(entries)
    half = monomials(n, range(1, degree // 2 + 1))
    for sign, name in ((1, "least"), (-1, "most")):
        constant = U.times(Fraction(TRUST - sign))
        pencil.squares(name, half, constant, [power.times(sign) for power in powers])
    points, weights = _outside(U)
    cost = {j: float(weights @ np.prod(points ** np.array(a), axis=1)) for j, a in enumerate(v)}
    outcome = optimise(pencil.condition(cost), slack=1e-2, inside=1e-5, most=number_of_solvers())
    values = outcome.values if outcome.status == "candidate" else outcome.feasible
    if not values:
        return None
    found = zip(v, values["free"].ravel().tolist(), strict=False)
    return _rounded(StatePolynomial(n, {a: Fraction(c) for a, c in found}))


def largest_set(
    field: Sequence[StatePolynomial],
    limited: Sequence[Limited],
    first: StatePolynomial,
    degree: int,
) -> Iterator[StatePolynomial]:
    """Yield V of a degree, each with a larger set than the one before; none where none is found.

    ``field``, ``limited`` : in coordinates in which the set is about as large as the unit ball.
    ``first`` : a positive function whose sets {V <= c} are tried for c = 1, 0.7, 0.49, ...
    """
    squares = None
    for level in LEVELS:
        V = first.times(Fraction(1 / level))
        if V.degree < degree:
            V = V + StatePolynomial.quadratic(np.eye(V.n)).power(degree // 2).times(Fraction(ROUND))
        V = _rounded(V)
        squares = multipliers(field, limited, V)
        if squares is not None:
            break
    for _ in range(MOST_STEPS):
        if squares is None:
            return
        yield V
        full_step = larger_function(field, limited, V, squares, degree)
        if full_step is None:
            return
        U, squares = V, None
        for share in SHARES:
            mixture = full_step.times(Fraction(share)) + U.times(Fraction(1 - share))
            V = _rounded(mixture)
            squares = multipliers(field, limited, V) if volume(V) > volume(U) else None
            if squares is not None:
                break
        if squares is not None and volume(V) < (1 + LEAST_GROWTH) * volume(U):
            yield V
            return


def volume(V: StatePolynomial) -> float:
    """Return about the volume of {V <= 1} over that of the unit ball; inf where it is unbounded."""
    return float(np.mean(_border(V)[1] ** V.n))


def _border(V: StatePolynomial) -> tuple[Floats, Floats]:
    """Return directions d (N, n), always the same, and the least r > 0 with V(r d) = 1, (N,)."""
    directions = np.random.default_rng(0).normal(size=(DIRECTIONS // 2, V.n))
    directions = np.concatenate([directions, -directions])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    powers = np.zeros((len(directions), V.degree + 1))
    powers[:, -1] = -1.0
    for a, c in V.terms.items():
        powers[:, V.degree - sum(a)] += float(c) * np.prod(directions ** np.array(a), axis=1)
    distances = []
    for row in powers:
        roots = np.roots(row)
        real = roots[np.abs(roots.imag) < 1e-9 * np.maximum(1, np.abs(roots))].real
        distances.append(min(real[real > 0], default=np.inf))
    return directions, np.array(distances)


def _outside(U: StatePolynomial) -> tuple[Floats, Floats]:
    """Return points (N, n) outside of the border, and the weights (N,) of V there."""
    directions, r = _border(U)
    step = 1e-6
    ends = [U((1 + s * step) * r[:, None] * directions) for s in (1, -1)]
    weights = r**U.n * 2 * step / (ends[0] - ends[1])
    return OUTSIDE * r[:, None] * directions, weights / weights.sum()


def _lines(
    field: Sequence[StatePolynomial], limited: Sequence[Limited], V: StatePolynomial
) -> Iterator[tuple[StatePolynomial, int]]:
    """Yield (left side, least degree of z) of every line."""
    yield V.along(field).times(-1), 1
    for quantity in limited:
        yield quantity.room, 0


class _Pencil:
    """LMIs D_0 + sum_k t_k D_k > 0 in numbers t: the caller's first, then the free entries of S."""

    def __init__(self, shared: int) -> None:
        self.count = shared
        self.blocks: dict[str, tuple[Floats, list[int], list[Floats], bool]] = {}

    def semidefinite(
        self, name: str, entries: Sequence[StatePolynomial], *, strict: bool, first: int = 0
    ) -> None:
        """Add Lambda >= 0; its entries on and above the diagonal are the numbers from ``first``."""
        size = int((2 * len(entries)) ** 0.5)
        cells = [(i, j) for i in range(size) for j in range(i, size)]
        columns = list(range(first, first + len(cells)))
        self.blocks[name] = (
            np.zeros((size, size)),
            columns,
            [_cell(size, i, j) for i, j in cells],
            strict,
        )

    def squares(
        self,
        name: str,
        z: Sequence[Exponent],
        constant: StatePolynomial,
        parts: Sequence[StatePolynomial],
        columns: Sequence[int] | None = None,
    ) -> None:
        """Add S > 0 with z'S z = constant + sum_k t_k parts_k, k in ``columns``; all without."""
        cells: dict[Exponent, list[tuple[int, int]]] = {}
        for i, a in enumerate(z):
            for j in range(i, len(z)):
                cells.setdefault(_sum(a, z[j]), []).append((i, j))
        N = len(z)

        def gram(p: StatePolynomial) -> Floats:
            S = np.zeros((N, N))
            for monomial, c in p.terms.items():
                for i, j in cells[monomial]:
                    share = float(c) / len(cells[monomial])
                    S[i, j] += share if i == j else share / 2
                    S[j, i] += 0 if i == j else share / 2
            return S

        matrices = [gram(p) for p in parts]
        numbers = list(range(len(parts))) if columns is None else list(columns)
        for places in cells.values():
            (p, q), *others = places
            pivot = _cell(N, p, q) / (1 if p == q else 2)
            for i, j in others:
                matrices.append(_cell(N, i, j) / (1 if i == j else 2) - pivot)
                numbers.append(self.count)
                self.count += 1
        self.blocks[name] = (gram(constant), numbers, matrices, True)

    def condition(self, cost: Mapping[int, float]) -> Condition:
        """Return the LMIs in the unknown ``free``."""
        free = Unknown("free", 1, 1, count=self.count, latex="t")
        lmis = []
        for name, (constant, numbers, matrices, strict) in self.blocks.items():
            term = Term(
                unknown=free,
                left=np.array(matrices),
                at=None,
                items=np.zeros(len(numbers), dtype=np.intp),
                members=np.array(numbers, dtype=np.intp),
                symbol="t_k",
                latex=("", "D_k"),
            )
            lmis.append(
                LMI(
                    name=name,
                    blocks=(len(constant),),
                    terms=(term,),
                    constants=(Constant(value=constant[None], at=None, latex="D_0"),)
                    if constant.any()
                    else (),
                    strict=strict,
                )
            )
        objective = np.zeros((self.count, 1, 1))
        for number, value in cost.items():
            objective[number] = value
        return Condition(
            name="sums of squares on a set",
            unknowns=(free,),
            lmis=tuple(lmis),
            objective={"free": objective} if cost else {},
            source=SOURCE,
        )

    def values(self, solution: Mapping[str, Floats], name: str) -> Floats:
        """Return the matrix of a block."""
        constant, numbers, matrices, _ = self.blocks[name]
        t = solution["free"].ravel()[numbers]
        return np.asarray(constant + np.tensordot(t, np.array(matrices), axes=1))


def _cell(size: int, i: int, j: int) -> Floats:
    D = np.zeros((size, size))
    D[i, j] = D[j, i] = 1.0
    return D


def _entries(y: Sequence[Exponent]) -> list[StatePolynomial]:
    """Return what each entry of Lambda, on and above the diagonal, adds to y'Lambda y."""
    pairs = ((i, j) for i in range(len(y)) for j in range(i, len(y)))
    return [StatePolynomial(len(y[0]), {_sum(y[i], y[j]): Fraction(1 + (i < j))}) for i, j in pairs]


def _sum(a: Exponent, b: Exponent) -> Exponent:
    return tuple(p + q for p, q in zip(a, b, strict=True))


def _rounded(V: StatePolynomial) -> StatePolynomial:
    """Return the polynomial with coefficients of a few digits; what is rounding is left out."""
    terms = {a: float(c) for a, c in V.terms.items()}
    least = 1e-12 * max(map(abs, terms.values()), default=0.0)
    return StatePolynomial(
        V.n, {a: Fraction(f"{c:.{DIGITS}g}") for a, c in terms.items() if abs(c) > least}
    )
