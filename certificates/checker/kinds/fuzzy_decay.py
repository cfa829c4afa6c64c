r"""``fuzzy-decay``: V = x'P(w)x decays, with P a polynomial in the weights.

w are the weights of the premises if the rules are products of them, else the weights of the rules.
G(w) is the closed loop. These polynomials are multiplied by the sum of the weights, which is 1, to
the power ``polya``; then every coefficient must be positive definite:

    P(w) > 0
    continuous   -(P(w) G(w) + G(w)'P(w) + 2 alpha P(w) + sum_kc v_kc dP/dw_kc) > 0
                 at every corner v of the speeds |v_kc| <= rate_kc, sum_c v_kc = 0
    discrete     [ rho^2 P(w)   G(w)'P_b ]
                 [ P_b G(w)     P_b      ] > 0     for every P_b

with rho^2 <= e^(-2 alpha T).  In discrete time the weights may jump freely: P at the next sample is
a convex combination of the P_b, the Bernstein coefficients of P.  In continuous time the claim
assumes that the weights keep the rates [1/s].  A rate that is null is not a bound, and P must not
depend on these weights.  The weights of a secant embedding are averages that cannot be evaluated:
there P must not depend on any weight.

Evidence: ``decay_rate``, ``degrees`` of P in each simplex, ``P`` [{powers, matrix}] with its
Bernstein coefficients, P(w) = sum_b multinomial_b w^b P_b, ``rates`` (continuous time), ``polya``,
and ``halvings`` where the condition is shown on pieces of the weights: the polynomials are then
written in the weights of each piece's corners.

Source: Tanaka, Hori and Wang (2003), IEEE Trans. Systems, Man and Cybernetics B 33(4); Oliveira
and Peres (2007), IEEE Trans. Automatic Control 52(7); Daafouz and Bernussou (2001), Systems and
Control Letters 43; recalled.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import factorial, prod
from typing import Any, NamedTuple

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.reader import integer, member, numbers, read_matrix
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.decay import decrease_factor, falls_as
from takagi.certificates.checker.kinds.loop_claim import LoopClaim, number
from takagi.certificates.checker.kinds.simplex_polynomial import (
    Exponent,
    Polynomial,
    blocks,
    constant_polynomial,
    corners_of_sum_zero,
    exponents,
)
from takagi.certificates.checker.loop.averages import refuse_averages
from takagi.certificates.checker.loop.halvings import leaves
from takagi.certificates.checker.loop.polytopic_loop import MOST_WORK, PolytopicLoop
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least

Speeds = tuple[tuple[Fraction, ...], ...]
Rates = list[list[Fraction] | None]
# Polynomials that must be positive definite, each with the words for its failure.
Conditions = list[tuple[Polynomial, str]]
HIGHEST, MOST_CORNERS = 8, 4096


@dataclass(frozen=True)
class WeightedFunctionClaim(LoopClaim):
    """A claim by V = x'P(w)x; a subclass has the polynomials that must be positive definite."""

    def __post_init__(self) -> None:
        rates = None if self.loop.is_discrete else self.claim.get("rates")
        if isinstance(rates, list) and any(row is not None for row in rates):
            object.__setattr__(self, "assumes", ("the weights keep to the rates of the claim",))

    @property
    @abstractmethod
    def function(self) -> ScheduledFunction:
        """P(w) of the claim."""

    @abstractmethod
    def conditions(self) -> Conditions:
        """Return the polynomials that must be positive definite, each with a message."""

    def obligations(self) -> Obligations:
        for condition, failure in self.conditions():
            for leaf in leaves(self.claim, self.loop, self.where, condition, Polynomial.halved):
                for powers, coefficient in leaf.coefficients():
                    yield positive(coefficient, f"{failure} weights to the powers {powers}")

    def figures(self) -> Iterator[Figure | WindProfile]:
        yield from super().figures()
        for k, bounds in enumerate(self.function.rates, start=1):
            slowest = None if bounds is None else min(bounds)
            yield Figure(f"rates of weights {k}", "1/s", slowest)

    @property
    def motion_of_weights(self) -> str:
        """How the weights may move."""
        if self.loop.is_discrete:
            return "however the weights move"
        rates = self.function.rates
        rows = ("any" if row is None else ", ".join(at_least(v, 6) for v in row) for row in rates)
        return f"while the weights keep to their rates: {'; '.join(rows)} 1/s"


@dataclass(frozen=True)
class FuzzyDecay(WeightedFunctionClaim):
    """V = x'P(w)x decays at the rate ``decay_rate``; see the module."""

    decay_rate: Fraction = number("1/s", better="larger")

    @cached_property
    def loop_polynomial(self) -> Polynomial:
        """G(w)."""
        return closed_polynomial(self.loop, self.loop.A, self.loop.B, self.where)

    @cached_property
    def function(self) -> ScheduledFunction:
        order = (2 if self.loop.is_discrete else 1) * self.loop.order
        degrees = self.loop_polynomial.degrees
        return scheduled_function(self.claim, self.loop, self.where, order, degrees)

    def obligations(self) -> Obligations:
        yield nonnegative(self.decay_rate, "the decay rate is negative")
        yield from super().obligations()

    def conditions(self) -> Conditions:
        P, G = self.function.P, self.loop_polynomial
        factor = decrease_factor(self.loop, self.decay_rate)
        required: Conditions = [(P, "P is not shown to be positive:")]
        if self.loop.is_discrete:
            words = "the inequality at the next sample fails at"
            required += [(_next(P, G, b, factor), words) for b in self.function.coefficients]
        else:
            PG = P @ G
            fixed = PG + PG.T + P.scaled(factor)
            words = "the inequality at a corner of the rates fails at"
            required += [(-(fixed + P.derivative(v)), words) for v in self.function.speeds]
        return [(X.raised(self.function.polya), words) for X, words in required]

    def sentence(self) -> str:
        loop = self.loop
        return (
            f"V = x'P(h)x {falls_as(loop, self.decay_rate)} along {words.about(loop)}, "
            f"{self.motion_of_weights}{words.while_valid(loop)}{words.deviations(loop, 'x')}"
        )


class ScheduledFunction(NamedTuple):
    """P(w) of a claim, its Bernstein coefficients, and how fast the weights may move.

    ``speeds`` are the corners of all speeds; in discrete time there are none, and no ``rates``.
    ``polya`` : by how much each condition is raised, by simplex.
    """

    P: Polynomial
    coefficients: list[Matrix]
    rates: Rates
    speeds: list[Speeds]
    polya: list[int]


def scheduled_function(
    claim: Any, loop: PolytopicLoop, where: str, order: int, degrees: Sequence[int]
) -> ScheduledFunction:
    """Return P(w) and the speeds of its weights.

    Parameters
    ----------
    order, degrees : order of the inequalities, and their degrees beyond those of P, by simplex.

    Raises
    ------
    CertificateError : a polynomial or rates that do not fit, weights that cannot be evaluated, or
        more than can be checked.
    """
    polya = _small(claim, "polya", where)
    P, coefficients = _scheduled(claim, loop, where)
    if any(P.degrees):
        refuse_averages(loop, "function", where)
    # An empty list of pieces is refused later; until then the work is bounded as for one piece.
    piece_count = max(1, len(claim["halvings"])) if isinstance(claim.get("halvings"), list) else 1
    _bounded(piece_count * len(exponents(P.sizes, [d + polya for d in P.degrees])), order, where)
    rates = [] if loop.is_discrete else _rates(claim, P, where)
    speeds = [] if loop.is_discrete else _corners(rates, where)
    terms = exponents(P.sizes, [d + e + polya for d, e in zip(P.degrees, degrees, strict=True)])
    several = len(coefficients) if loop.is_discrete else len(speeds)
    _bounded(piece_count * len(terms) * several, order, where)
    return ScheduledFunction(P, coefficients, rates, speeds, [polya] * len(P.sizes))


def closed_polynomial(
    loop: PolytopicLoop, X: tuple[Matrix, ...], Y: tuple[Matrix, ...], where: str
) -> Polynomial:
    """Return X(w) - Y(w) K(w); X(w) where there are no gains or no Y."""
    first = _stack(loop, X)
    if not loop.K or not Y:
        return first
    if len(loop.K) > 1 and not loop.shared_weights:
        raise CertificateError(f"{where}: a law with weights of its own has no P(h) for both")
    return first + -(_stack(loop, Y) @ _stack(loop, loop.K))


def _next(P: Polynomial, G: Polynomial, b: Matrix, factor: Fraction) -> Polynomial:
    """Return the module's Schur complement for one P_b."""
    PG, n = G.after(b), b.shape[0]
    return blocks([[P.scaled(factor), PG.T], [PG, b]], (n, n))


def sizes_of(loop: PolytopicLoop) -> tuple[int, ...]:
    """Return the corners of each simplex: of every premise, or of the rules alone."""
    if loop.corners is None:
        return (loop.rules,)
    sizes = tuple(max(column) + 1 for column in zip(*loop.corners, strict=True))
    if len(exponents(sizes, (1,) * len(sizes))) != loop.rules:
        raise CertificateError("the rules leave out a combination of corners")
    return sizes


def _stack(loop: PolytopicLoop, stack: tuple[Matrix, ...]) -> Polynomial:
    """Return sum_i h_i X_i as a polynomial; it has degree 0 where all rules share one matrix."""
    sizes = sizes_of(loop)
    if len(stack) == 1:
        return constant_polynomial(sizes, stack[0])
    rows = loop.corners or tuple((i,) for i in range(len(stack)))
    terms = {
        tuple(_unit(size, corner) for size, corner in zip(sizes, row, strict=True)): X
        for row, X in zip(rows, stack, strict=True)
    }
    return Polynomial(sizes, (1,) * len(sizes), terms)


def _unit(size: int, corner: int) -> tuple[int, ...]:
    return tuple(int(c == corner) for c in range(size))


def _scheduled(claim: Any, loop: PolytopicLoop, where: str) -> tuple[Polynomial, list[Matrix]]:
    """Return P(w), and its Bernstein coefficients."""
    sizes, n = sizes_of(loop), loop.order
    stated_degrees = numbers(claim, "degrees", where, len(sizes))
    if any(d.denominator != 1 or not 0 <= d <= HIGHEST for d in stated_degrees):
        raise CertificateError(f"{where}.degrees: whole numbers from 0 to {HIGHEST} are needed")
    degrees = tuple(map(int, stated_degrees))
    listed = member(claim, "P", where)
    needed = exponents(sizes, degrees)
    if not isinstance(listed, list) or len(listed) != len(needed):
        raise CertificateError(f"{where}.P: {len(needed)} entries are needed")
    terms: dict[Exponent, Matrix] = {}
    coefficients = []
    for i, entry in enumerate(listed):
        at = f"{where}.P[{i}]"
        powers = member(entry, "powers", at)
        if not isinstance(powers, list) or len(powers) != len(sizes):
            raise CertificateError(f"{at}.powers: one row for each simplex is needed")
        rows = [numbers({"powers": row}, "powers", at, s)
                for row, s in zip(powers, sizes, strict=True)]  # fmt: skip
        a = tuple(tuple(int(v) for v in row) for row in rows)
        exact = all(v == w for r, s in zip(rows, a, strict=True) for v, w in zip(r, s, strict=True))
        if not exact or a not in needed or a in terms:
            raise CertificateError(f"{at}.powers: every exponent of the degrees once is needed")
        coefficients.append(read_matrix(entry, "matrix", at, (n, n)))
        multinomial = prod(factorial(sum(row)) // prod(map(factorial, row)) for row in a)
        terms[a] = multinomial * coefficients[-1]
    return Polynomial(sizes, degrees, terms), coefficients


def _rates(claim: Any, P: Polynomial, where: str) -> Rates:
    listed = member(claim, "rates", where)
    if not isinstance(listed, list) or len(listed) != len(P.sizes):
        raise CertificateError(f"{where}.rates: one row for each simplex is needed")
    rates: Rates = []
    for row, size, degree in zip(listed, P.sizes, P.degrees, strict=True):
        if row is None:
            if degree:
                raise CertificateError(f"{where}.rates: P depends on weights without a bound")
            rates.append(None)
            continue
        bounds = numbers({"rates": row}, "rates", where, size)
        if min(bounds) < 0:
            raise CertificateError(f"{where}.rates: bounds >= 0 are needed")
        rates.append(bounds)
    return rates


def _corners(rates: Rates, where: str) -> list[Speeds]:
    """Return the corners of all speeds; weights on which P does not depend have no speed."""
    simplex_corners = [
        [()] if bounds is None else _simplex_corners(bounds, where) for bounds in rates
    ]
    count = prod(map(len, simplex_corners))
    if count > MOST_CORNERS:
        raise CertificateError(f"{where}.rates: {count} corners; at most {MOST_CORNERS}")
    return list(product(*simplex_corners))


def _simplex_corners(bounds: list[Fraction], where: str) -> list[tuple[Fraction, ...]]:
    """Return the corners of |v_c| <= bound_c, sum_c v_c = 0."""
    size = len(bounds)
    if size << max(size - 1, 0) > 8 * MOST_CORNERS:
        raise CertificateError(f"{where}.rates: a simplex of {size} corners is too large")
    return sorted(set(map(tuple, corners_of_sum_zero(bounds))))


def _bounded(count: int, order: int, where: str) -> None:
    if count * order**4 > MOST_WORK:
        raise CertificateError(f"{where}: too many rules, corners of rates, or too high degrees")


def _small(claim: Any, key: str, where: str) -> int:
    value = integer(claim, key, where)
    if not 0 <= value <= HIGHEST:
        raise CertificateError(f"{where}.{key}: 0 to {HIGHEST} is needed")
    return value
