r"""Claims of kind ``tracking``: outputs follow references, for every reference in a range.

    x' = f(x, u, w),  xi_j' = h_j(x) - r_j,  u = u* - K (X - X*),   X = (x, xi)

The model is a secant embedding: differences between two points of the box at equal w are blends of
its vertices (A_i, B_i) times differences of (X, u), because the box is convex.  The claim has P,
a decay rate alpha, a matrix D, a radius R and rates rho.  Let

    Xhat(s) = X* + D (s - s*) + Q q,    uhat(s) = u* - K (Xhat(s) - X*),    |z|_P = sqrt(z'Pz),

where s are the signals with a range, as the model lists them: references r, and others w, uncertain
parameters among them; q has the products of two entries of s - s*, (1, 1), (1, 2), ..., (2, 2),
..., and Q is ``curvature``, 0 where the claim has none.  X* is the origin of the coordinates; the
plant need not rest there.  A law with measured outputs has a state of its own, its estimate: X is
then (x, xi, s) and K acts on it as ``constant_observer`` says.  The checker proves:

1. The secant embedding (``secant_embedding``).  xi_j' = h_j - r_j with the h_j that model and law
   write, an expression of the plant's own states; r_j is in no other equation, and no xi is in one.
2. P > 0 and (A_i - B_i K)'P + P (A_i - B_i K) + 2 alpha P <= 0 at every vertex; one gain K.
3. |F_k(s)| <= residual_k for the right sides F at (Xhat(s), uhat(s), s), for all s in their ranges;
   sum |P_kl| residual_k residual_l <= e^2 with e = ``residual_norm``.  A claim with
   ``residual_weights`` u has instead, at every vertex M = A_i - B_i K,
   [[-(M'P + PM + 2 alpha P), P], [P, diag(u)]] >= 0 and alpha sum u_k residual_k^2 <= 2 e^2.
4. g_j'P g_j <= d_j^2 with d = ``slope_norms`` and the slopes g_j of Xhat, at the corners of s.
5. alpha R >= e + sum_j d_j rho_j; rho_j is 0 for a signal that is assumed constant.
6. For all s in the ranges {z: |z|_P <= R} about Xhat(s) lies in the ranges of states, and the
   command on it in those of inputs: R^2 a P^-1 a' <= room^2 for a = e_i and a = K_k, as the matrix
   [[P, R a'], [R a, room^2]] >= 0.
7. C_ij P^-1 C_ij' <= c_j^2 for the rows C_ij of xi_j in A_i, with c = ``error_factors``.

Then, for z = X - Xhat(s(t)):

(a) At constant s the loop has exactly one equilibrium ("rest") in |z|_P <= R.  It satisfies
    |z|_P <= e/alpha and h(x) = r.  Every motion from the set stays in it and converges to the rest:
    |X - rest|_P falls as e^(-alpha t).
(b) While the signals move with |s_j'| <= rho_j, no motion leaves |z|_P <= R, and

        |h_j - r_j| <= c_j (e + sum d rho)/alpha + residual_xi_j + c_j R e^(-alpha t).

(c) After a jump of r from rest, |z|_P <= e/alpha + sum_j d_j |jump_j|.  The state is in the set if
    this bound is at most R.

Proof in ``docs/plant-theorems.md``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations_with_replacement, product
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix, read_stack
from takagi.certificates.checker.kernel.reader import (
    canonical,
    member,
    number,
    numbers,
    positive,
    text,
)
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded, closed_by
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, Variable, read_plant
from takagi.certificates.checker.plant.references import (
    Following,
    check_following,
    read_references,
)
from takagi.certificates.checker.plant.secant_embedding import prove_secants
from takagi.certificates.checker.plant.sector_embedding import KIND, plant_loop
from takagi.certificates.checker.plant.trim import compared_trim
from takagi.certificates.checker.plant.vertices import multi_affine_entries

if TYPE_CHECKING:
    from takagi.certificates.checker.plant.constant_observer import ConstantObserver

Side = tuple[Fraction, Fraction]
MOST_SIGNALS = 6  # of a claim with a curvature: the corners double with each


class Evidence:
    """The numbers of a claim, with their shapes checked."""

    def __init__(self, claim: Any, n: int, count: int, q: int, where: str) -> None:
        self.P = read_matrix(claim, "P", where, (n, n))
        self.D = read_matrix(claim, "slope", where, (n, count))
        self.rate = positive(claim, "decay_rate", where)
        self.radius = positive(claim, "radius", where)
        pairs = (n, count * (count + 1) // 2)
        self.Q = read_matrix(claim, "curvature", where, pairs) if "curvature" in claim else None
        self.residuals = numbers(claim, "residuals", where, n)
        self.weights = numbers(claim, "residual_weights", where, n) if (
            "residual_weights" in claim
        ) else None  # fmt: skip
        self.residual_norm = number(claim, "residual_norm", where)
        self.slope_norms = numbers(claim, "slope_norms", where, count)
        self.error_factors = numbers(claim, "error_factors", where, q)
        self.rates = numbers(claim, "rates", where, count)
        listed = (*self.residuals, self.residual_norm, *self.slope_norms, *self.rates)
        if min(*listed, *self.error_factors) < 0:
            raise CertificateError(f"{where}: norms, residuals and rates are not negative")

    @property
    def line(self) -> Matrix:
        """[D Q], the factors of the deviations of the signals and of their products."""
        return self.D if self.Q is None else Matrix.blocks([[self.D, self.Q]])

    @property
    def push(self) -> Fraction:
        """e + sum_j d_j rho_j."""
        moved = zip(self.slope_norms, self.rates, strict=True)
        return self.residual_norm + sum((d * rho for d, rho in moved), Fraction(0))


def check_tracking(claim: Any, model: Any, gains: Any, where: str) -> Outcome:
    """Return PROVED if the outputs follow the references as the claim says; else UNDECIDED.

    Raises
    ------
    CertificateError : the model is malformed, of another kind or form, or has no references; no
        gains, or a law with other references; a claim of another shape.
    """
    name = text(claim, "name", where)
    if text(model, "kind", "model") != KIND:
        raise CertificateError(f"{where}: a claim about a plant; model.kind is {model['kind']!a}")
    plant = read_plant(model, "model")
    if plant.form != "secant" or plant.mass is not None or plant.sample_time is not None:
        raise CertificateError(f"{where}: a secant embedding of x' = f(x, u, w) is needed")
    if plant.balls:
        raise CertificateError(f"{where}: rests and parameters that are decimals are needed")
    if gains is None:
        raise CertificateError(f"{where}: a claim about a law, and there are no gains")
    follow = read_references(model, plant, "model")
    if canonical(member(gains, "references", "gains")) != canonical(model["references"]):
        raise CertificateError("gains.references are not the model's: the law follows others")
    if compared_trim(plant, gains, "gains"):
        raise CertificateError(f"{where}: the law's trim has to be the plant's rest exactly")
    K = read_stack(gains, "K", "gains")
    loop = closed_by(plant_loop(model), gains, "gains")
    try:
        if any(one != K[0] for one in K):
            raise Refused("one gain is needed: the means of slopes are not known to a law")
        law = None
        if "observer" in gains:
            # Imported here: most laws have the states.
            from takagi.certificates.checker.plant.constant_observer import read_constant_observer

            law = read_constant_observer(model, gains, plant, follow, "gains.observer")
            loop = law.joint(loop)
        found = Evidence(claim, loop.order, len(ranged(plant)), len(follow), where)
        _prove(plant, follow, loop, law, found)
    except Refused as error:
        return Claim(name, Verdict.UNDECIDED, f"not proved: {error}")
    said = {"name": name, "plant": plant, "follow": follow, "found": found}
    return Found(Verdict.PROVED, "tracking", said)


def ranged(plant: PlantNodes) -> list[Variable]:
    """Return the signals with a range, in the model's order: the columns of D."""
    return [v for v in plant.disturbances if v.side is not None]


def _prove(
    plant: PlantNodes,
    follow: list[Following],
    loop: PolytopicLoop,
    law: ConstantObserver | None,
    found: Evidence,
) -> None:
    """Run the seven steps; Refused names the one that could not be proved."""
    K = loop.K[0]
    prove_secants(plant, multi_affine_entries(plant), resting=False)
    algebra = Algebra(plant.graph, plant.tables)
    check_following(plant, follow, algebra)
    if not found.P.is_positive_definite:
        raise Refused("P is not symmetric positive definite")
    blends = loop.blends()
    bounded(len(blends) * (1 + len(follow)), loop.order + 1)
    for blend in blends:
        falls = found.P @ blend.A
        falls = -(falls + falls.T + 2 * found.rate * found.P)
        if found.weights is not None:
            falls = Matrix.blocks([[falls, found.P], [found.P, _diagonal(found.weights)]])
        if not falls.is_positive_semidefinite:
            raise Refused(f"V does not fall at the rate that is claimed at {blend.label}")
    _check_norms(found, [v.side for v in ranged(plant) if v.side is not None])
    if found.rate * found.radius < found.push:
        raise Refused("the set is too small for the residuals and rates that are claimed")
    _check_residuals(plant, algebra, K, law, found)
    _check_room(plant, K, found)
    for j, one in enumerate(follow):
        c = Matrix.of([[found.error_factors[j] ** 2]])
        for k, A in enumerate(loop.A, start=1):
            C = Matrix([A.rows[one.row]], A.below)
            if not Matrix.blocks([[found.P, C.T], [C, c]]).is_positive_semidefinite:
                raise Refused(f"the error of {one.signal.name} is larger at rule {k}")


def _check_norms(found: Evidence, sides: list[Side]) -> None:
    n, e = len(found.residuals), found.residuals
    if found.weights is None:
        parts = (abs(found.P[k, m]) * e[k] * e[m] for k in range(n) for m in range(n))
    else:
        parts = (found.rate * u * e[k] ** 2 / 2 for k, u in enumerate(found.weights))
    total = sum(parts, Fraction(0))
    if total > found.residual_norm**2:
        raise Refused("the norm of the residuals is larger")
    # The slope g_j is affine in s, and its norm convex, so that the corners have the largest.
    if found.Q is not None and len(sides) > MOST_SIGNALS:
        raise CertificateError(f"curvature: at most {MOST_SIGNALS} signals have one")
    for j, d in enumerate(found.slope_norms):
        for corner in product(*sides) if found.Q is not None else [()]:
            column = Matrix.of([[g] for g in _slope(found, j, corner)])
            if (column.T @ found.P @ column)[0, 0] > d**2:
                raise Refused("the norm of a slope is larger")


def _diagonal(values: Sequence[Fraction]) -> Matrix:
    zero = Fraction(0)
    return Matrix.of(
        [[v if i == j else zero for j in range(len(values))] for i, v in enumerate(values)]
    )


def _slope(found: Evidence, j: int, corner: Sequence[Fraction]) -> list[Fraction]:
    """Return the derivative of Xhat by signal j at a corner of the signals' deviations."""
    slopes = [found.D[i, j] for i in range(found.D.shape[0])]
    if found.Q is not None:
        for k, (a, b) in enumerate(_pairs(len(corner))):
            factor = (corner[b] if a == j else 0) + (corner[a] if b == j else 0)
            slopes = [g + factor * found.Q[i, k] for i, g in enumerate(slopes)]
    return slopes


def _pairs(count: int) -> list[tuple[int, int]]:
    return list(combinations_with_replacement(range(count), 2))


def _check_residuals(
    plant: PlantNodes,
    algebra: Algebra,
    K: Matrix,
    law: ConstantObserver | None,
    found: Evidence,
) -> None:
    """Prove |F_k| <= residual_k where the state is Xhat(s) and the input uhat(s)."""
    g = plant.graph
    ranges = Ranges(plant.evaluator, algebra, plant.box)
    signals = [g.variable(v.symbol) for v in ranged(plant)]
    signals += [
        g.multiply(signals[a], signals[b])
        for a, b in (_pairs(len(signals)) if found.Q is not None else [])
    ]

    def at(line: Matrix) -> list[int]:
        return [
            g.total(g.multiply(g.constant(line[i, j]), node) for j, node in enumerate(signals))
            for i in range(line.shape[0])
        ]

    state, push = at(found.line), at(-(K @ found.line))
    places = {v.symbol: node for v, node in zip(plant.states, state, strict=False)}
    places |= {v.symbol: node for v, node in zip(plant.inputs, push, strict=True)}
    places |= {v.symbol: g.constant(0) for v in plant.disturbances if v.side is None}
    rows = [substituted(g, node, places) for node in plant.f]
    names = [v.name for v in plant.states]
    if law is not None:
        rows += law.rates(plant, places, state[len(plant.states) :], push)
        names += [f"the estimate of {names[k]}" for k in law.states]
    for name, there, most in zip(names, rows, found.residuals, strict=True):
        what = f"the residual of {name}"
        # Where terms cancel, bounds of the parts are too coarse; the parts have to be defined.
        ranges.prove_continuous(there, what)
        ranges.prove_within(algebra.collected(there), -most, most, what)


def _check_room(plant: PlantNodes, K: Matrix, found: Evidence) -> None:
    """Prove that the set about Xhat(s) lies in the ranges of states and inputs, for every s."""
    sides = [v.side for v in plant.disturbances if v.side is not None]
    if found.Q is not None:
        sides += [_product(sides[a], sides[b], same=a == b) for a, b in _pairs(len(sides))]
    line, n = found.line, len(found.residuals)
    one = Matrix.identity(n)
    rows = [
        (v, Matrix([one.rows[i]]), line.rows[i], line.below) for i, v in enumerate(plant.states)
    ]
    moved = -(K @ line)
    rows += [
        (v, Matrix([K.rows[i]], K.below), moved.rows[i], moved.below)
        for i, v in enumerate(plant.inputs)
    ]
    for variable, row, slopes, below in rows:
        if variable.side is None:
            continue
        low, high = _reach([Fraction(slope, below) for slope in slopes], sides)
        room = min(variable.side[1] - high, low - variable.side[0])
        if room < 0:
            raise Refused(f"{variable.name} leaves its range where the loop rests")
        side = Matrix.of([[room**2]])
        whole = Matrix.blocks([[found.P, found.radius * row.T], [found.radius * row, side]])
        if not whole.is_positive_semidefinite:
            raise Refused(f"the set leaves the range of {variable.name}")


def _product(one: Side, other: Side, *, same: bool) -> Side:
    """Return the range of the product of two deviations; ``same`` for a square."""
    ends = [a * b for a in one for b in other]
    return (Fraction(0) if same and one[0] <= 0 <= one[1] else min(ends)), max(ends)


def _reach(slopes: Sequence[Fraction], sides: Sequence[Side]) -> Side:
    """Return bounds of the sum of factors times deviations and products of the signals."""
    ends = [(s * a, s * b) for s, (a, b) in zip(slopes, sides, strict=True)]
    low = sum((min(pair) for pair in ends), Fraction(0))
    return low, sum((max(pair) for pair in ends), Fraction(0))


def plant_column(plant: PlantNodes, one: Following) -> int:
    """Return the column of D that belongs to a reference."""
    return ranged(plant).index(one.signal)


def bounds_of(plant: PlantNodes, found: Evidence, follow: Sequence[Following]) -> Mapping[str, Any]:
    """Return for each reference the bound of the final error, and the largest jump."""
    at_last = found.push / found.rate
    rest = found.residual_norm / found.rate
    errors = [
        c * at_last + found.residuals[one.row]
        for c, one in zip(found.error_factors, follow, strict=True)
    ]
    room = max(found.radius - rest, Fraction(0))
    own = [found.slope_norms[plant_column(plant, one)] for one in follow]
    jumps = [room / d if d else None for d in own]
    return {"errors": errors, "jumps": jumps, "rest": rest}
