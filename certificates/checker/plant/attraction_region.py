r"""Claims of kind ``attraction-region``: every motion from {V <= c}, V a polynomial, comes to rest.

    x' = f(x, u),   u = -sum_i h_i(z(x)) K_i x,   x and u as deviations from rest, w = 0

The sector embedding proves on the model's box that the equations are defined and that the premises
z stay in their bounds.  There the weights are products of (upper - z)/(upper - lower) and
(z - lower)/(upper - lower), so that the loop x' = F(x) is polynomial where f and the z that the
gains depend on are.  The checker substitutes the law in the equations and multiplies out, in
rational numbers; a loop that is no polynomial is refused.  The claim states V as text, c > 0, a
``box`` [a_k, b_k] of states, and symmetric matrices S and Lambda for

    decrease      -V'                     = z'S z + (y'Lambda y) (c - V),   z, y without the 1
    each state    (b_k - x_k)(x_k - a_k)  = z'S z + (y'Lambda y) (c - V)
    each input    (b_k - u_k)(u_k - a_k)  = z'S z + (y'Lambda y) (c - V)    with the range of u_k

z and y have all monomials up to the degrees that the claim states.  S is stated in decimals, which
need not satisfy the identity: its coefficients are compared with those of the left side less the
product, the gap of each is shared among the entries of S that make this monomial, and the matrix
S that results is the one that is decided.  The checker proves:

1. The box lies in the ranges of the states, 0 inside; V has no terms below degree 2; F(0) = 0.
2. S > 0 and Lambda >= 0 in each identity.

Then D = {V <= c} is compact, every motion from it stays in it and tends to 0, states and inputs
keep their ranges, and V > 0 on D except at 0.

Proof.  z'S z > 0 for z != 0; z has the 1 in the identities of states and inputs, and all x_k in
that of the decrease.  So on D: a_k < x_k < b_k, D is bounded and inside the box, where x' = F(x) is
the loop, and the inputs keep their ranges; and V' < 0 except at 0.  Let a motion start in D.  While
it is in D it is inside the box and V does not rise.  It cannot leave: at the last instant in D it
would be at rest, or V would fall just after; both keep V <= c, and the state is inside the box.  So
it exists for all t, in a compact set.  By LaSalle's theorem it tends to the largest invariant set
with V' = 0 in D, which is {0}.  V falls along it to V(0) = 0, so it was positive.

There is no version for discrete time: V(F(x)) has the degree of V times that of F.

Source: Khalil (2002), Nonlinear Systems, theorems 4.4 and 3.3; Parrilo (2000), thesis, sections 4.2
and 7.3 (squares, the multiplier of c - V); Tan and Packard (2008), IEEE Trans. Automatic Control
53; Peyrl and Parrilo (2008), Theoretical Computer Science 409 (projection of S on the identity).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations_with_replacement
from math import comb
from typing import Any, ClassVar, NamedTuple

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.reader import (
    LARGEST_MATRIX,
    integer,
    listed,
    member,
    read_matrix,
)
from takagi.certificates.checker.kernel.reader import positive as positive_number
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.loop.model_loop import closed_by
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import PlantClaim
from takagi.certificates.checker.plant.polynomial import Monomial, Polynomial, Ring
from takagi.certificates.checker.plant.quotient_form import jumps, with_signs
from takagi.certificates.checker.plant.reading import PlantNodes, Premise
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.checker.plant.trim import compared_trim
from takagi.certificates.checker.plant.vertices import corners_of
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly

HALVINGS = 60  # of the length of an axis, for a figure


Side = tuple[Fraction, Fraction]


class Squares(NamedTuple):
    """S and Lambda of an identity, with the degrees of z and y and the words for its left side."""

    S: Matrix
    degree: int
    Lambda: Matrix
    multiplier_degree: int
    subject: str


class PolynomialLoop(NamedTuple):
    """x' = F(x) and u(x) as polynomials in the states' deviations, numbered 0, 1, ..., n - 1."""

    F: list[Polynomial]
    u: list[Polynomial]


@dataclass(frozen=True)
class AttractionRegion(PlantClaim):
    """Every motion from {V <= c} comes to rest; see the module."""

    form: ClassVar[str] = "sector"

    @cached_property
    def loop(self) -> PolynomialLoop:
        """The closed loop, derived from the equations and the gains."""
        return polynomial_loop(self.plant, self.model, self.gains)

    @cached_property
    def level(self) -> Fraction:
        return positive_number(self.claim, "level", self.where)

    @cached_property
    def V(self) -> Polynomial:
        """V of the claim's text.

        Raises
        ------
        CertificateError : no expression in the states' deviations.
        Refused : no polynomial, or one with a term below degree 2.
        """
        plant = self.plant
        scope = Scope({v.symbol: plant.graph.variable(v.symbol) for v in plant.states})
        written = member(self.claim, "function", self.where)
        node = read_expression(written, plant.graph, scope, f"{self.where}.function")
        V = _polynomial(plant, node, "the function V")
        if not V or min(map(_degree, V)) < 2:
            raise Refused("the function V has terms below degree 2, or none")
        return V

    @cached_property
    def box(self) -> list[Side]:
        """The interval of each state that the set keeps."""
        n = len(self.plant.states)
        rows = read_matrix(self.claim, "box", self.where, (n, 2))
        return [(rows[k, 0], rows[k, 1]) for k in range(n)]

    def obligations(self) -> Obligations:
        plant, loop, c, V = self.plant, self.loop, self.level, self.V
        n = len(plant.states)
        for variable, (low, high) in zip(plant.states, self.box, strict=True):
            failure = f"the box of {variable.name} does not lie in its range, around rest"
            side = variable.side or (low, high)
            for room in (low - side[0], side[1] - high):
                yield nonnegative(room, failure)
            yield positive(min(-low, high), failure)
        if any(() in F for F in loop.F):
            raise Refused("the loop does not rest at 0")
        ring = Ring()
        slope: Polynomial = {}
        for k, F in enumerate(loop.F):
            slope = ring.plus(slope, ring.times(_derivative(V, k), F))
        below = ring.plus({(): c}, ring.scaled(V, Fraction(-1)))  # c - V
        (falling,) = self._squares("decrease", ["V does not fall"], n, 1)
        yield from _identity(ring.scaled(slope, Fraction(-1)), below, falling, n, 1)
        states: list[tuple[str, Polynomial, Side]] = [
            (v.name, {((k, 1),): Fraction(1)}, self.box[k]) for k, v in enumerate(plant.states)
        ]
        inputs: list[tuple[str, Polynomial, Side]] = [
            (v.name, u, v.side) for v, u in zip(plant.inputs, loop.u, strict=True) if v.side
        ]
        for key, limited in (("states", states), ("inputs", inputs)):
            subjects = [f"{name} may leave its range" for name, _, _ in limited]
            squares = self._squares(key, subjects, n, 0)
            for (_, q, side), sums in zip(limited, squares, strict=True):
                yield from _identity(_room(q, side), below, sums, n, 0)

    def _squares(self, key: str, subjects: list[str], n: int, least: int) -> list[Squares]:
        """Return the matrices of the identities of a group.

        Raises
        ------
        CertificateError : another number of identities, or a matrix that does not have the size of
            its monomials.
        """
        count, squares = len(subjects), []
        for k, entry in enumerate(listed(self.claim, key, self.where, count, count)):
            where = f"{self.where}.{key}[{k}]"
            matrices, degrees = [], []
            for name, of_degree in (("squares", "degree"), ("multiplier", "multiplier_degree")):
                degree = integer(entry, of_degree, where)
                if not least <= degree <= LARGEST_MATRIX:
                    raise CertificateError(
                        f"{where}.{of_degree}: {least} to {LARGEST_MATRIX} is needed"
                    )
                size = comb(n + degree, n) - least
                degrees.append(degree)
                matrices.append(read_matrix(entry, name, where, (size, size)))
            squares.append(Squares(matrices[0], degrees[0], matrices[1], degrees[1], subjects[k]))
        return squares

    def sentence(self) -> str:
        box = ", ".join(
            f"{v.label} in [{at_least(low, 6)}, {at_most(high, 6)}]"
            for v, (low, high) in zip(self.plant.states, self.box, strict=True)
        )
        rest = [
            *(["disturbances"] if self.plant.disturbances else []),
            *(["inputs"] if self.plant.inputs and self.gains is None else []),
        ]
        start = f"with {' and '.join(rest)} at rest, every" if rest else "every"
        degree = max(map(_degree, self.V))
        inputs = "; inputs keep their ranges" if any(v.side for v in self.plant.inputs) else ""
        return (
            f"{start} motion that starts where V <= {exactly(self.level)} stays there and comes to "
            f"rest, with the claim's polynomial V of degree {degree} in the deviations of the "
            f"states from rest; the set lies inside {box}{inputs}"
        )

    def figures(self) -> Iterator[Figure | WindProfile]:
        """Yield how far each state may start with the others at rest, to either side."""
        for k, v in enumerate(self.plant.states):
            low, high = self.box[k]
            start = min(
                safe_length(self.V, k, self.level, Fraction(sign), length)
                for sign, length in ((-1, -low), (1, high))
            )
            yield Figure(f"safe start of {v.symbol}, others at rest", v.unit, start)


def _room(q: Polynomial, side: Side) -> Polynomial:
    """Return (b - q)(q - a) for the limits a and b."""
    ring = Ring()
    above = ring.plus(ring.scaled(q, Fraction(-1)), {(): side[1]} if side[1] else {})
    return ring.times(above, ring.plus(q, {(): -side[0]} if side[0] else {}))


def polynomial_loop(plant: PlantNodes, model: Any, gains: Any) -> PolynomialLoop:
    """Return the loop of a plant and its law, or of the plant with its inputs at rest for None.

    Raises
    ------
    CertificateError : gains that are no law, or one of another model, or with another trim.
    Refused : the loop is no polynomial with rational coefficients on the box.
    """
    if plant.sample_time is not None or plant.mass is not None:
        raise Refused("a plant in continuous time without a mass matrix is needed")
    if plant.balls or any(v.unknown for v in plant.disturbances):
        raise Refused("parameters and rests that are decimals are needed, and none is uncertain")
    if compared_trim(plant, gains):
        raise Refused("the law's trim has to be the plant's rest exactly")
    if gains is not None and {"observer", "blending", "references"} & gains.keys():
        raise Refused("a law of the states alone is needed, without a state of its own")
    g = plant.graph
    at_rest = {v.symbol: g.constant(0) for v in plant.disturbances}
    commands = [g.constant(0)] * len(plant.inputs)
    if gains is not None and plant.inputs:
        closed = closed_by(plant_loop(model), gains, "gains")
        if not closed.shared_weights:
            raise Refused("the law's gains go by other weights than the model's rules")
        rules = len(corners_of(plant.premises))
        K = closed.K if len(closed.K) > 1 else closed.K * rules
        if len(K) != rules:
            raise Refused("another number of gains than of rules")
        for r in range(len(plant.inputs)):
            for s, state in enumerate(plant.states):
                gain = _blended(plant, plant.premises, [matrix[r, s] for matrix in K])
                term = g.multiply(g.negative(gain), g.variable(state.symbol))
                commands[r] = g.add(commands[r], term)
    commands = [substituted(g, node, at_rest) for node in commands]
    values = at_rest | {v.symbol: u for v, u in zip(plant.inputs, commands, strict=True)}
    F = [
        _polynomial(plant, substituted(g, node, values), f"the equation of {v.name} under the law")
        for v, node in zip(plant.states, plant.f, strict=True)
    ]
    u = [
        _polynomial(plant, node, f"the command of {v.name}")
        for v, node in zip(plant.inputs, commands, strict=True)
    ]
    return PolynomialLoop(F, u)


def _blended(plant: PlantNodes, premises: Sequence[Premise], values: Sequence[Fraction]) -> int:
    """Return the node of sum_i h_i values_i; the last premise changes first.

    A premise on which the values do not depend does not occur in it.

    Raises
    ------
    Refused : another premise jumps, as |v|/v: where v = 0 the law has any value of it, and a
        product of such premises, which algebra takes for 1 or v^2, has others.
    """
    g = plant.graph
    if not premises:
        return g.constant(values[0])
    first, others = premises[0], premises[1:]
    if first.lower == first.upper:
        return _blended(plant, others, values)
    half = len(values) // 2
    low, high = (_blended(plant, others, part) for part in (values[:half], values[half:]))
    if low == high:
        return low
    if jumps(g, with_signs(g, first.node)):
        raise Refused(f"the gains depend on premise {first.name}, which jumps")
    width = g.constant(first.upper - first.lower)
    weight = g.divide(g.subtract(first.node, g.constant(first.lower)), width)
    return g.add(low, g.multiply(weight, g.subtract(high, low)))


def _polynomial(plant: PlantNodes, node: int, subject: str) -> Polynomial:
    """Return a node as a polynomial in the states' numbers.

    Raises
    ------
    Refused : it is none, or another variable stands in it.
    """
    numbers = {v.symbol: k for k, v in enumerate(plant.states)}
    try:
        terms = Algebra(plant.graph, plant.tables).polynomial(node)
    except Refused as error:
        raise Refused(f"{subject} is no polynomial in the states: {error}") from error
    if not {name for monomial in terms for name, _ in monomial} <= numbers.keys():
        raise Refused(f"{subject} is no polynomial in the states alone")
    return {tuple(sorted((numbers[a], k) for a, k in m)): c for m, c in terms.items()}


def monomials(n: int, least: int, largest: int) -> list[Monomial]:
    """Return all monomials of these degrees in n variables, by degree, then x1 before x2."""
    rows = []
    for degree in range(least, largest + 1):
        for chosen in combinations_with_replacement(range(n), degree):
            rows.append(tuple((k, chosen.count(k)) for k in sorted(set(chosen))))
    return rows


def _identity(
    left: Polynomial, below: Polynomial, squares: Squares, n: int, least: int
) -> Obligations:
    """Yield S > 0 and Lambda >= 0 for left = z'S z + (y'Lambda y) below, z and y from ``least``."""
    ring = Ring()
    y = monomials(n, least, squares.multiplier_degree)
    multiplier: Polynomial = {}
    for i, a in enumerate(y):
        for j, b in enumerate(y):
            entry = ring.scaled(_product(ring, a, b), squares.Lambda[i, j])
            multiplier = ring.plus(multiplier, entry)
    yield nonnegative(squares.Lambda, f"{squares.subject}: a multiplier may be negative")
    needed = ring.plus(left, ring.scaled(ring.times(multiplier, below), Fraction(-1)))
    z = monomials(n, least, squares.degree)
    yield positive(_gram(ring, needed, z, squares), f"{squares.subject}: no sum of squares")


def _gram(ring: Ring, p: Polynomial, z: Sequence[Monomial], squares: Squares) -> Matrix:
    """Return the matrix S nearest to the stated one with z'S z = p.

    Raises
    ------
    Refused : p has a monomial that is no product of two in z.
    """
    cells: dict[Monomial, list[tuple[int, int]]] = {}
    for i, a in enumerate(z):
        for j, b in enumerate(z):
            cells.setdefault(next(iter(_product(ring, a, b))), []).append((i, j))
    if not p.keys() <= cells.keys():
        raise Refused(f"{squares.subject}: a term of the identity is in no square")
    rows = [[squares.S[i, j] for j in range(len(z))] for i in range(len(z))]
    for monomial, places in cells.items():
        gap = p.get(monomial, Fraction(0)) - sum((rows[i][j] for i, j in places), Fraction(0))
        for i, j in places:
            rows[i][j] += gap / len(places)
    return Matrix.of(rows)


def _product(ring: Ring, a: Monomial, b: Monomial) -> Polynomial:
    return ring.times({a: Fraction(1)}, {b: Fraction(1)})


def _derivative(p: Polynomial, k: int) -> Polynomial:
    """Return dp/dx_k."""
    slope: Polynomial = {}
    for monomial, c in p.items():
        powers = dict(monomial)
        if k in powers:
            power = powers.pop(k)
            lower = {**powers, **({k: power - 1} if power > 1 else {})}
            slope[tuple(sorted(lower.items()))] = c * power
    return slope


def _degree(monomial: Monomial) -> int:
    return sum(power for _, power in monomial)


def safe_length(V: Polynomial, k: int, c: Fraction, sign: Fraction, length: Fraction) -> Fraction:
    """Return t <= length with V(sign s e_k) <= c for 0 <= s <= t; near the largest such t.

    Every piece [s, t] that is counted has sum_a max(c_a s^a, c_a t^a) <= c.
    """
    powers = {_degree(m): v for m, v in V.items() if all(atom == k for atom, _ in m)}
    reached, step = Fraction(0), length
    for _ in range(HALVINGS):
        end = min(reached + step, length)
        most = sum(
            (max(v * sign**a * end**a, v * sign**a * reached**a) for a, v in powers.items()),
            Fraction(0),
        )
        if end > reached and most <= c:
            reached = end
        else:
            step /= 2
    return reached
