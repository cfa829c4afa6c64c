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

Proof.  Let X be in the set at s.  The segment from (Xhat, uhat) to (X, u) lies in the box, which is
convex, and u - uhat = -K z.  By the mean value theorem in its integral form F(X, u, s) -
F(Xhat, uhat, s) = M z with M in the hull of A_i - B_i K, since an entry that is affine in the
premises has its value at the premises' means.  So, where |z|_P > 0,

    z' = M z + F(Xhat, uhat, s) - sum_j g_j s_j',
    d/dt |z|_P <= -alpha |z|_P + e + sum_j d_j |s_j'|,

by 2, 3, 4 and the Cauchy-Schwarz inequality of P.  At |z|_P = R the right side is at most 0 by 5,
so the set is not left.  Gronwall's inequality gives the bound on |z|_P in
(b); the error h(x) - r is h(x) - h(xhat), which is C z with C in the hull of the C_i, and
h(xhat) - r, the residual of xi.

At constant s two motions in the set differ by a z with z' = M z, so their distance falls as
e^(-alpha t).  The motion over a time t > 0 maps the complete set into itself and contracts it; its
one fixed point is the same for all t, because the motions commute.  This is a rest.  There
0 = M z + F(Xhat, uhat, s), so alpha |z|_P <= e, and xi' = 0 is h(x) = r.  For (c) the rest before
the jump is within e/alpha of Xhat at the old r, and Xhat moves by at most sum_j d_j |jump_j|.

With ``residual_weights`` 2 z'PF <= z'P diag(u)^-1 P z + sum u_k F_k^2, and the matrix of 3 gives

    (|z|_P^2)' <= -2 alpha |z|_P^2 + sum u_k F_k^2 + 2 |z|_P sum_j d_j |s_j'|.

With p = sum d_j rho_j and |z|_P >= (e + p)/alpha then d/dt |z|_P <= -alpha |z|_P + e^2/(e + p) + p,
which is at most -alpha |z|_P + e + p: all holds as before.

Source: the norm of P as a measure of contraction, Demidovich (1961), and Lohmiller and Slotine
(1998), Automatica 34(6):683-696; slopes in a hull, Boyd, El Ghaoui, Feron, Balakrishnan (1994),
section 4.3; all recalled.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations_with_replacement, product
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.reader import (
    canonical,
    member,
    number,
    numbers,
    read_matrix,
    read_stack,
)
from takagi.certificates.checker.kernel.reader import positive as positive_number
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.loop.model_loop import closed_by
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded
from takagi.certificates.checker.plant.derivative import substituted
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import Enclosure, PlantClaim
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.reading import PlantNodes, Variable
from takagi.certificates.checker.plant.references import (
    Following,
    check_following,
    read_references,
)
from takagi.certificates.checker.plant.secant_embedding import secants
from takagi.certificates.checker.plant.sector_embedding import plant_loop
from takagi.certificates.checker.plant.trim import compared_trim
from takagi.certificates.checker.plant.vertices import multi_affine_entries
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, at_most

if TYPE_CHECKING:
    from takagi.certificates.checker.plant.constant_observer import ConstantObserver

Side = tuple[Fraction, Fraction]
MOST_SIGNALS = 6  # of a claim with a curvature: the corners double with each


class Evidence:
    """The numbers of a claim, with their shapes checked."""

    def __init__(self, claim: Any, n: int, count: int, q: int, where: str) -> None:
        self.P = read_matrix(claim, "P", where, (n, n))
        self.D = read_matrix(claim, "slope", where, (n, count))
        self.rate = positive_number(claim, "decay_rate", where)
        self.radius = positive_number(claim, "radius", where)
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
        slopes_and_rates = zip(self.slope_norms, self.rates, strict=True)
        return self.residual_norm + sum((d * rho for d, rho in slopes_and_rates), Fraction(0))


@dataclass(frozen=True)
class Tracking(PlantClaim):
    """Outputs follow references; see the module."""

    form: ClassVar[str] = "secant"

    @cached_property
    def follow(self) -> list[Following]:
        """The references of the model."""
        return read_references(self.model, self.plant, "model")

    @cached_property
    def law(self) -> ConstantObserver | None:
        """The observer of the law; None for a law with the states."""
        if "observer" not in self.gains:
            return None
        # Imported here: most laws have the states.
        from takagi.certificates.checker.plant.constant_observer import read_constant_observer

        where = "gains.observer"
        return read_constant_observer(self.model, self.gains, self.plant, self.follow, where)

    @cached_property
    def loop(self) -> PolytopicLoop:
        """Model and law in the coordinates X.

        Raises
        ------
        CertificateError : a model that is no secant embedding of x' = f, numbers that are no
            decimals, no gains, a law with other references or another trim.
        Refused : gains that differ between rules.
        """
        plant, gains, where = self.plant, self.gains, self.where
        if plant.mass is not None or plant.sample_time is not None:
            raise CertificateError(f"{where}: a secant embedding of x' = f(x, u, w) is needed")
        if plant.balls:
            raise CertificateError(f"{where}: rests and parameters that are decimals are needed")
        if gains is None:
            raise CertificateError(f"{where}: a claim about a law, and there are no gains")
        if canonical(member(gains, "references", "gains")) != canonical(self.model["references"]):
            raise CertificateError("gains.references are not the model's: the law follows others")
        if compared_trim(plant, gains):
            raise CertificateError(f"{where}: the law's trim has to be the plant's rest exactly")
        K = read_stack(gains, "K", "gains")
        loop = closed_by(plant_loop(self.model), gains, "gains")
        if any(gain != K[0] for gain in K):
            raise Refused("one gain is needed: the means of slopes are not known to a law")
        return loop if self.law is None else self.law.joint(loop)

    @cached_property
    def evidence(self) -> Evidence:
        """The numbers of the claim."""
        sizes = self.loop.order, len(ranged(self.plant)), len(self.follow)
        return Evidence(self.claim, *sizes, self.where)

    def obligations(self) -> Obligations:
        """Yield the seven steps of the module."""
        plant, follow = self.plant, self.follow
        loop, evidence = self.loop, self.evidence
        P, K = evidence.P, loop.K[0]
        yield from secants(plant, multi_affine_entries(plant), self.removable, resting=False)
        algebra = Algebra(plant.graph, plant.tables)
        check_following(plant, follow, algebra)
        yield positive(P, "P is not symmetric positive definite")
        blends = loop.blends()
        bounded(len(blends) * (1 + len(follow)), loop.order + 1)
        for blend in blends:
            PM = P @ blend.A
            falling = -(PM + PM.T + 2 * evidence.rate * P)
            if evidence.weights is not None:
                falling = Matrix.blocks([[falling, P], [P, Matrix.diagonal(evidence.weights)]])
            failure = f"V does not fall at the rate that is claimed at {blend.label}"
            yield nonnegative(falling, failure)
        yield from _norms(evidence, [v.side for v in ranged(plant) if v.side is not None])
        failure = "the set is too small for the residuals and rates that are claimed"
        yield nonnegative(evidence.rate * evidence.radius - evidence.push, failure)
        yield from _residuals(plant, algebra, K, self.law, evidence)
        yield from _room(plant, K, evidence)
        for j, following in enumerate(follow):
            c = Matrix.of([[evidence.error_factors[j] ** 2]])
            for k, A in enumerate(loop.A, start=1):
                C = A.row(following.row)
                failure = f"the error of {following.signal.name} is larger at rule {k}"
                yield nonnegative(Matrix.blocks([[P, C.T], [C, c]]), failure)

    def sentence(self) -> str:
        plant, follow, evidence = self.plant, self.follow, self.evidence
        bounds = self.bounds
        signals = ", ".join(
            f"{f.signal.name} in {_range(plant, f.signal)} {f.signal.unit}" for f in follow
        )
        rate = at_least(evidence.rate, 6)
        words = f"for every constant {signals}{_others(plant, follow)} the loop has one equilibrium"
        words += (
            f" with no error in a stated set, and settles there as exp(-{rate} t) from all of it"
        )
        jumps = [
            f"{at_least(jump, 4)} {f.signal.unit} in {f.signal.name}"
            for f, jump in zip(follow, bounds.jumps, strict=True)
            if jump is not None
        ]
        if jumps:
            alone = "" if len(follow) == 1 else ", one at a time,"
            words += f", also from rest after jumps{alone} of up to {', '.join(jumps)}"
        words += "; states and inputs keep their ranges"
        if any(evidence.rates):
            moving = ", ".join(
                f"|{v.name}'| <= {at_least(rho, 6)}"
                for v, rho in zip(ranged(plant), evidence.rates, strict=True)
                if rho
            )
            errors = ", ".join(
                f"{at_most(error, 4)} {f.signal.unit} for {f.signal.name}"
                for error, f in zip(bounds.errors, follow, strict=True)
            )
            constant = [
                v.name for v, rho in zip(ranged(plant), evidence.rates, strict=True) if not rho
            ]
            constant_clause = f" and {', '.join(constant)} constant" if constant else ""
            words += f"; while {moving}{constant_clause} the error settles to at most {errors}"
        return words + _still(plant, follow)

    def figures(self) -> Iterator[Figure | WindProfile]:
        yield Figure("decay rate", "1/s", self.evidence.rate)
        bounds = zip(self.follow, self.bounds.errors, self.bounds.jumps, strict=True)
        for following, error, jump in bounds:
            name, unit = following.signal.name, following.signal.unit
            yield Figure(f"jump of {name}", unit, jump)
            if any(self.evidence.rates):
                yield Figure(f"error of {name} while it moves", unit, error, larger=False)

    @property
    def bounds(self) -> Bounds:
        """What the evidence bounds, for each reference."""
        evidence = self.evidence
        final = evidence.push / evidence.rate
        residual_bound = evidence.residual_norm / evidence.rate
        errors = [
            c * final + evidence.residuals[following.row]
            for c, following in zip(evidence.error_factors, self.follow, strict=True)
        ]
        room = max(evidence.radius - residual_bound, Fraction(0))
        signals = ranged(self.plant)
        norms = [evidence.slope_norms[signals.index(f.signal)] for f in self.follow]
        return Bounds(errors, [room / d if d else None for d in norms])


class Bounds(NamedTuple):
    """For each reference the bound of the final error, and the largest jump; None for any."""

    errors: list[Fraction]
    jumps: list[Fraction | None]


def ranged(plant: PlantNodes) -> list[Variable]:
    """Return the signals with a range, in the model's order: the columns of D."""
    return [v for v in plant.disturbances if v.side is not None]


def _norms(evidence: Evidence, sides: list[Side]) -> Obligations:
    """Yield the bounds of the norm of the residuals, and of the slopes of Xhat."""
    n, e = len(evidence.residuals), evidence.residuals
    if evidence.weights is None:
        terms = (abs(evidence.P[k, m]) * e[k] * e[m] for k in range(n) for m in range(n))
    else:
        terms = (evidence.rate * u * e[k] ** 2 / 2 for k, u in enumerate(evidence.weights))
    total = sum(terms, Fraction(0))
    yield nonnegative(evidence.residual_norm**2 - total, "the norm of the residuals is larger")
    # The slope g_j is affine in s, and its norm convex, so that the corners have the largest.
    if evidence.Q is not None and len(sides) > MOST_SIGNALS:
        raise CertificateError(f"curvature: at most {MOST_SIGNALS} signals have one")
    for j, d in enumerate(evidence.slope_norms):
        for corner in product(*sides) if evidence.Q is not None else [()]:
            column = Matrix.of([[g] for g in _slope(evidence, j, corner)])
            squared = (column.T @ evidence.P @ column)[0, 0]
            yield nonnegative(d**2 - squared, "the norm of a slope is larger")


def _slope(evidence: Evidence, j: int, corner: Sequence[Fraction]) -> list[Fraction]:
    """Return the derivative of Xhat by signal j at a corner of the signals' deviations."""
    slopes = [evidence.D[i, j] for i in range(evidence.D.shape[0])]
    if evidence.Q is not None:
        for k, (a, b) in enumerate(_pairs(len(corner))):
            factor = (corner[b] if a == j else 0) + (corner[a] if b == j else 0)
            slopes = [g + factor * evidence.Q[i, k] for i, g in enumerate(slopes)]
    return slopes


def _pairs(count: int) -> list[tuple[int, int]]:
    return list(combinations_with_replacement(range(count), 2))


def _residuals(
    plant: PlantNodes,
    algebra: Algebra,
    K: Matrix,
    law: ConstantObserver | None,
    evidence: Evidence,
) -> Obligations:
    """Yield |F_k| <= residual_k where the state is Xhat(s) and the input uhat(s)."""
    g = plant.graph
    ranges = Ranges(plant.evaluator, algebra, plant.box)
    signals = [g.variable(v.symbol) for v in ranged(plant)]
    signals += [
        g.multiply(signals[a], signals[b])
        for a, b in (_pairs(len(signals)) if evidence.Q is not None else [])
    ]

    def at(line: Matrix) -> list[int]:
        return [
            g.total(g.multiply(g.constant(line[i, j]), node) for j, node in enumerate(signals))
            for i in range(line.shape[0])
        ]

    state, push = at(evidence.line), at(-(K @ evidence.line))
    values = {v.symbol: node for v, node in zip(plant.states, state, strict=False)}
    values |= {v.symbol: node for v, node in zip(plant.inputs, push, strict=True)}
    values |= {v.symbol: g.constant(0) for v in plant.disturbances if v.side is None}
    rows = [substituted(g, node, values) for node in plant.f]
    names = [v.name for v in plant.states]
    if law is not None:
        rows += law.rates(plant, values, state[len(plant.states) :], push)
        names += [f"the estimate of {names[k]}" for k in law.states]
    for name, there, largest in zip(names, rows, evidence.residuals, strict=True):
        subject = f"the residual of {name}"
        # Where terms cancel, bounds of the parts are too coarse; the parts have to be defined.
        ranges.prove_continuous(there, subject)
        yield Enclosure(ranges, algebra.collected(there), -largest, largest, subject)


def _room(plant: PlantNodes, K: Matrix, evidence: Evidence) -> Obligations:
    """Yield obligations: for every s the set about Xhat(s) lies in the ranges of x and u."""
    sides = [v.side for v in plant.disturbances if v.side is not None]
    if evidence.Q is not None:
        sides += [_product(sides[a], sides[b], same=a == b) for a, b in _pairs(len(sides))]
    line, n = evidence.line, len(evidence.residuals)
    eye = Matrix.identity(n)
    rows = [
        (v, Matrix([eye.rows[i]]), line.rows[i], line.below) for i, v in enumerate(plant.states)
    ]
    input_line = -(K @ line)
    rows += [
        (v, Matrix([K.rows[i]], K.below), input_line.rows[i], input_line.below)
        for i, v in enumerate(plant.inputs)
    ]
    for variable, row, slopes, below in rows:
        if variable.side is None:
            continue
        low, high = _reach([Fraction(slope, below) for slope in slopes], sides)
        room = min(variable.side[1] - high, low - variable.side[0])
        yield nonnegative(room, f"{variable.name} leaves its range where the loop rests")
        side, reach = Matrix.of([[room**2]]), evidence.radius * row
        failure = f"the set leaves the range of {variable.name}"
        yield nonnegative(Matrix.blocks([[evidence.P, reach.T], [reach, side]]), failure)


def _product(first: Side, second: Side, *, same: bool) -> Side:
    """Return the range of the product of two deviations; ``same`` for a square."""
    ends = [a * b for a in first for b in second]
    return (Fraction(0) if same and first[0] <= 0 <= first[1] else min(ends)), max(ends)


def _reach(slopes: Sequence[Fraction], sides: Sequence[Side]) -> Side:
    """Return bounds of the sum of factors times deviations and products of the signals."""
    ends = [(s * a, s * b) for s, (a, b) in zip(slopes, sides, strict=True)]
    low = sum((min(pair) for pair in ends), Fraction(0))
    return low, sum((max(pair) for pair in ends), Fraction(0))


def _others(plant: PlantNodes, follow: list[Following]) -> str:
    signals = _other_signals(plant, follow)
    if not signals:
        return ""
    return " and constant " + ", ".join(f"{v.name} in {_range(plant, v)} {v.unit}" for v in signals)


def _still(plant: PlantNodes, follow: list[Following]) -> str:
    refs = {f.column for f in follow}
    names = [v.name for k, v in enumerate(plant.disturbances) if k not in refs and v.side is None]
    return f"; with {', '.join(names)} at rest" if names else ""


def _other_signals(plant: PlantNodes, follow: list[Following]) -> list[Variable]:
    refs = {f.column for f in follow}
    return [v for k, v in enumerate(plant.disturbances) if k not in refs and v.side is not None]


def _range(plant: PlantNodes, variable: Variable) -> str:
    rest = plant.graph.value(variable.rest) or Fraction(0)
    assert variable.side is not None  # asked for such variables alone
    return f"[{at_most(rest + variable.side[0], 9)}, {at_least(rest + variable.side[1], 9)}]"
