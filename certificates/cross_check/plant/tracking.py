r"""``tracking``: an output converges to its reference, for every reference in a range.

With X = (x, xi), xi_j' = h_j(x) - r_j, u = u* - K (X - X*) and signals s with ranges, let

    Xhat(s) = X* + D (s - s*) + sum_ab Q_ab (s - s*)_a (s - s*)_b,    uhat = u* - K (Xhat - X*),

with Q = 0 unless the claim has a ``curvature``.  Where the law measures outputs y, it keeps an
estimate s of the plant's own states, s' = A s + B (u - u*) + L (y - y* - C s); X gets the rows of s
behind it, and the columns of K for own states belong to these rows.

On a convex box over which [f_X f_u] is in the hull of (A_i, B_i), and where V = z'Pz falls at alpha
for every A_i - B_i K, the distance v = |X - Xhat(s)|_P has

    v' <= -alpha v + |F(Xhat, uhat, s)|_P + sum_j |D_j|_P |s_j'|.

With weights u_k of the residuals, [[-(M'P + PM + 2 alpha P), P], [P, diag(u)]] >= 0 gives

    (v^2)' <= -2 alpha v^2 + sum u_k residual_k^2 + 2 v sum_j |D_j|_P |s_j'|,

so that e with 2 e^2 >= alpha sum u_k residual_k^2 stands for the norm of F: where alpha v is at
least e and the other bounds together, v falls.  So {v <= R} is invariant if alpha R is at least the
sum of the bounds.  The loop contracts inside, so by Banach's theorem it has one rest, and h = r
there.  Decided in this order:

1. the facts of ``secant``; the equation of xi_j is h_j - r_j, as written in the model and in the
   law, h_j of states that are no integrals; r_j and xi_j are in no other equation
2. P is definite, A_i - B_i K falls at the rate, for all vertices
3. the bounds of F, of its norm and of the norms of the slopes of Xhat, convex in s
4. alpha R >= e + sum d_j rho_j
5. the set about Xhat(s) is in the ranges of states and inputs, at every corner of s
6. the rows of xi_j have at most the norm that is claimed

Written from ``docs/plant-theorems.md``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    diagonal,
    entries,
    identity,
    negative,
    scaled,
    transposed,
    zeros,
)
from takagi.certificates.cross_check.kernel.reading import (
    NotReplayed,
    Refusal,
    entry,
    line,
    rational,
    rationals,
    stack,
    table,
)
from takagi.certificates.cross_check.loop.loop import Side, VertexLoop, close, pick
from takagi.certificates.cross_check.loop.observing import outputs_of
from takagi.certificates.cross_check.plant.algebra import Algebra, identical
from takagi.certificates.cross_check.plant.embedding import MOST_BOXES
from takagi.certificates.cross_check.plant.expression import (
    Tree,
    minus,
    names_in,
    number,
    plus,
    put,
    times,
    value_of,
)
from takagi.certificates.cross_check.plant.interval import Undefined, range_of
from takagi.certificates.cross_check.plant.law_fits import integrals, references_of
from takagi.certificates.cross_check.plant.plant import (
    TreePlant,
    Variable,
    plant_loop,
    read_plant,
    require_decimals,
)
from takagi.certificates.cross_check.plant.secant import lies_in_secants, slope_of

MOST_SIGNALS = 6  # of a claim with a curvature


def tracking(claim: Any, model: Any, gains: Any) -> Obligations:
    """Yield the facts of the module, in its order."""
    if entry(model, "kind") != "plant" or gains is None:
        raise Refusal("a claim about a plant under a law, and one of them is missing")
    plant = read_plant(model)
    require_decimals(plant)
    if plant.form != "secant" or plant.step is not None or plant.mass is not None:
        raise Refusal("a secant embedding of x' = f(x, u, w) is needed")
    if entry(gains, "references") != entry(model, "references"):
        raise Refusal("the law has other references than the model")
    yield from lies_in_secants(model, gains, at_rest=False)
    yield Fact("the law's trim is the rest exactly", _exact_trim(plant, gains))
    found = stack(gains, "K")
    yield Fact("there is one gain", all(one == found[0] for one in found))
    loop = close(plant_loop(model), gains)
    follow = references_of(model, plant)
    yield from integrals(plant, follow)
    system = _of_states(loop, found[0])
    if "observer" in gains:
        law = _estimator(model, gains, plant, [row for _, row, _ in follow])
        yield Fact("what follows is measured", _seen(plant, follow, law))
        system = _of_outputs(loop, found[0], law)
    n = system.K.ncols()
    signals = [v for v in plant.pushes if v.side is not None]
    P, D = table(claim, "P", (n, n)), table(claim, "slope", (n, len(signals)))
    curve = Curve(D, [v.side for v in signals if v.side is not None])
    if "curvature" in claim:
        if len(signals) > MOST_SIGNALS:
            raise Refusal("curvature: too many signals")
        count = len(signals) * (len(signals) + 1) // 2
        curve = replace(curve, Q=table(claim, "curvature", (n, count)))
    alpha, R = rational(claim, "decay_rate"), rational(claim, "radius")
    yield Fact("rate and radius are positive", alpha > 0 and R > 0)
    yield Definite("P", P)
    weights = rationals(claim, "residual_weights", n) if "residual_weights" in claim else []
    for k, (A, _) in enumerate(system.vertices):
        M = P * A
        falls = negative(M + transposed(M) + scaled(2 * alpha, P))
        if weights:
            falls = blocks([[falls, P], [P, diagonal(weights)]])
        yield Definite(f"decay at vertex {k + 1}", falls, strict=False)
    e, residuals = rational(claim, "residual_norm"), rationals(claim, "residuals", n)
    d = rationals(claim, "slope_norms", len(signals))
    rho = rationals(claim, "rates", len(signals))
    c = rationals(claim, "error_factors", len(follow))
    yield Fact("no bound is negative", min([e, *residuals, *d, *rho, *c]) >= 0)
    if weights:
        squares = [u * r * r for u, r in zip(weights, residuals, strict=True)]
        yield Fact("the weighted residuals", alpha * sum(squares, fmpq(0)) <= 2 * e * e)
    else:
        yield from _norm_of_rest(P, residuals, e)
    yield from _norms(P, curve, d)
    yield Fact(
        "the set is kept",
        alpha * R >= e + sum((a * b for a, b in zip(d, rho, strict=True)), fmpq(0)),
    )
    yield from _on_the_line(plant, signals, system, curve, residuals)
    yield from _in_the_ranges(plant, system.K, curve, P, R)
    for (_, row, _), most in zip(follow, c, strict=True):
        for k, (_, open_) in enumerate(system.vertices):
            C = fmpq_mat([entries(open_)[row]])
            corner = fmpq_mat([[most * most]])
            whole = blocks([[P, transposed(C)], [C, corner]])
            yield Definite(f"error at vertex {k + 1}", whole, strict=False)


@dataclass(frozen=True)
class Estimator:
    """The matrices of s', the measured outputs, and the states that s estimates, by places."""

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    L: fmpq_mat
    outputs: list[int]
    states: list[int]


@dataclass(frozen=True)
class System:
    """(closed, open) matrices of each vertex, K of u - u* = -K z, and the rows of s'."""

    vertices: list[tuple[fmpq_mat, fmpq_mat]]
    K: fmpq_mat
    law: Estimator | None = None


@dataclass(frozen=True)
class Curve:
    """Xhat: D, Q or None, and the ranges of the deviations of the signals."""

    D: fmpq_mat
    sides: list[Side]
    Q: fmpq_mat | None = None

    @property
    def pairs(self) -> list[tuple[int, int]]:
        count = len(self.sides)
        known = [] if self.Q is None else range(count)
        return [(a, b) for a in known for b in range(a, count)]

    def of(self, K: fmpq_mat) -> Curve:
        """Return K (Xhat - X*)."""
        return replace(self, D=K * self.D, Q=None if self.Q is None else K * self.Q)

    def tree(self, i: int, signals: list[Variable]) -> Tree:
        """Return row i in the deviations of the signals."""
        names: list[Tree] = [("name", v.symbol) for v in signals]
        total = number(0)
        for j, name in enumerate(names):
            total = plus(total, times(number(self.D[i, j]), name))
        for k, (a, b) in enumerate(self.pairs):
            assert self.Q is not None  # it has pairs
            total = plus(total, times(number(self.Q[i, k]), times(names[a], names[b])))
        return total

    def slope(self, j: int, at: tuple[fmpq, ...]) -> fmpq_mat:
        """Return the derivative by signal j, a column."""
        rows = [self.D[i, j] for i in range(self.D.nrows())]
        for k, (a, b) in enumerate(self.pairs):
            assert self.Q is not None  # it has pairs
            by = (at[b] if a == j else fmpq(0)) + (at[a] if b == j else fmpq(0))
            rows = [row + by * self.Q[i, k] for i, row in enumerate(rows)]
        return fmpq_mat([[row] for row in rows])

    def reach(self, i: int) -> Side:
        """Return bounds of row i over all signals."""
        terms = [(self.D[i, j], side) for j, side in enumerate(self.sides)]
        for k, (a, b) in enumerate(self.pairs):
            assert self.Q is not None  # it has pairs
            ends = [x * y for x in self.sides[a] for y in self.sides[b]]
            crosses = a == b and self.sides[a][0] <= 0 <= self.sides[a][1]
            terms.append((self.Q[i, k], (fmpq(0) if crosses else min(ends), max(ends))))
        sums = [fmpq(0), fmpq(0)]
        for factor, side in terms:
            ends = [factor * end for end in side]
            sums = [sums[0] + min(ends), sums[1] + max(ends)]
        return sums[0], sums[1]


def _of_states(loop: VertexLoop, K: fmpq_mat) -> System:
    vertices = []
    for k in range(loop.rules):
        A, B = pick(loop.A, k), pick(loop.B, k)
        vertices.append((A - B * K, A))
    return System(vertices, K)


def _estimator(model: Any, gains: Any, plant: TreePlant, integrals_at: list[int]) -> Estimator:
    own = entry(gains, "observer")
    if line(own, "weights") != "constant":
        raise Refusal("observer.weights: constant ones are needed with references")
    outputs = outputs_of(own, model)
    states = [k for k in range(len(plant.states)) if k not in integrals_at]
    n, m, p = len(states), len(plant.inputs), len(outputs)
    A, B = table(own, "A", (n, n)), table(own, "B", (n, m))
    return Estimator(A, B, table(own, "C", (p, n)), table(own, "L", (n, p)), outputs, states)


def _seen(plant: TreePlant, follow: list[tuple[Variable, int, Tree]], law: Estimator) -> bool:
    """Return whether each h is a measured output, or of states that are measured outputs."""
    measured = [plant.outputs[k] for k in law.outputs]
    box = {v.symbol: v.side for v in plant.variables}
    alone = [plus(v.rest, ("name", v.symbol)) for v in plant.states]
    gaps = [
        [plus(tree, minus(y)) for y in measured] for tree in (*alone, *(h for _, _, h in follow))
    ]
    algebra = Algebra([gap for row in gaps for gap in row])
    shown = [any(identical(algebra, gap, box, "an output") for gap in row) for row in gaps]
    known = {v.symbol for v, found in zip(plant.states, shown, strict=False) if found}
    return all(
        found or set(names_in(h)) <= known
        for (_, _, h), found in zip(follow, shown[len(alone) :], strict=True)
    )


def _of_outputs(loop: VertexLoop, K: fmpq_mat, law: Estimator) -> System:
    """Return the system of z = (X, s)."""
    if any(value != 0 for D in loop.D for row in entries(D) for value in row):
        raise Refusal("a measured output has an input")
    n, k = loop.n, len(law.states)
    whole = zeros(K.nrows(), n + k)
    for row in range(K.nrows()):
        for column in range(n):
            at = n + law.states.index(column) if column in law.states else column
            whole[row, at] = K[row, column]
    vertices = []
    for i in range(loop.rules):
        seen = fmpq_mat([entries(pick(loop.C, i))[p] for p in law.outputs])
        lower = [law.L * seen, law.A - law.L * law.C]
        free = blocks([[pick(loop.A, i), zeros(n, k)], lower])
        vertices.append((free - blocks([[pick(loop.B, i)], [law.B]]) * whole, free))
    return System(vertices, whole, law)


def _exact_trim(plant: TreePlant, gains: Any) -> bool:
    trim = entry(gains, "trim")
    return all(
        [value_of(v.rest) for v in variables] == rationals(trim, key, len(variables))
        for key, variables in (("state", plant.states), ("input", plant.inputs))
        if variables
    )


def _norm_of_rest(P: fmpq_mat, residuals: list[fmpq], e: fmpq) -> Obligations:
    corners = sum(
        (abs(value) * residuals[i] * residuals[j]
         for i, row in enumerate(entries(P)) for j, value in enumerate(row)),
        fmpq(0),
    )  # fmt: skip
    yield Fact("the norm of what is left", corners <= e * e)


def _norms(P: fmpq_mat, curve: Curve, d: list[fmpq]) -> Obligations:
    places = list(product(*curve.sides)) if curve.pairs else [()]
    for j, most in enumerate(d):
        slopes = [curve.slope(j, place) for place in places]
        squares = [(transposed(g) * P * g)[0, 0] for g in slopes]
        yield Fact("the norms of slopes", max(squares) <= most * most)


def _on_the_line(
    plant: TreePlant, signals: list[Variable], system: System, curve: Curve, residuals: list[fmpq]
) -> Obligations:
    """Yield that each right side is at most its residual at (Xhat(s), uhat(s), s)."""
    n, push = len(plant.states), curve.of(negative(system.K))
    places: dict[str, Tree] = {v.symbol: number(0) for v in plant.pushes if v.side is None}
    for variables, line_ in ((plant.states, curve), (plant.inputs, push)):
        for i, v in enumerate(variables):
            places[v.symbol] = line_.tree(i, signals)
    rows = [put(tree, places) for tree in plant.f]
    if system.law is not None:
        law = system.law
        still = {v.symbol: number(0) for v in plant.variables}
        measured = [plant.outputs[p] for p in law.outputs]
        gaps = [plus(put(y, places), minus(put(y, still))) for y in measured]
        inner = law.A - law.L * law.C
        for i in range(len(law.states)):
            total = number(0)
            for matrix, values in (
                (inner, [curve.tree(n + j, signals) for j in range(len(law.states))]),
                (law.B, [push.tree(j, signals) for j in range(len(plant.inputs))]),
                (law.L, gaps),
            ):
                for factor, value in zip(entries(matrix)[i], values, strict=True):
                    total = plus(total, times(number(factor), value))
            rows.append(total)
    sides = {v.symbol: v.side for v in signals if v.side is not None}
    for k, (there, most) in enumerate(zip(rows, residuals, strict=True)):
        yield Fact(f"what is left of equation {k + 1}", _stays_below(there, sides, most))


def _stays_below(tree: Tree, sides: dict[str, Side], most: fmpq) -> bool:
    """Return True where |tree| <= most on the box, False where it is not at some point.

    A part of the box passes by the range of f, or by the range of f(m) + sum_j f_j(box) (s_j - m_j)
    about its middle m.

    Raises
    ------
    NotReplayed : neither was found in ``MOST_BOXES`` parts.
    """
    slopes = {name: slope_of(tree, name) for name in sides}
    waiting = [sides]
    for _ in range(MOST_BOXES):
        if not waiting:
            return True
        box = waiting.pop()
        if _below(_range(tree, box), most):
            continue
        middle = {name: (low + high) / 2 for name, (low, high) in box.items()}
        at = _range(tree, {name: (m, m) for name, m in middle.items()})
        if at is None:
            raise NotReplayed("a right side that is not defined where the loop rests")
        if at[0] > most or at[1] < -most:
            return False
        spread: Side | None = at
        for name, (low, high) in box.items():
            slope = _range(slopes[name], box)
            if slope is None or spread is None:
                spread = None
                break
            ends = [f * (end - middle[name]) for f in slope for end in (low, high)]
            spread = (spread[0] + min(ends), spread[1] + max(ends))
        if _below(spread, most):
            continue
        wide = max(box, key=lambda name: (box[name][1] - box[name][0]) / _width(sides[name]))
        low, high = box[wide]
        halves = (low, middle[wide]), (middle[wide], high)
        waiting += [{**box, wide: half} for half in halves]
    raise NotReplayed("a bound of what is left that this search does not settle")


def _width(side: Side) -> fmpq:
    return side[1] - side[0]


def _range(tree: Tree, box: dict[str, Side]) -> Side | None:
    try:
        return range_of(tree, dict(box), lambda *_: False)
    except Undefined:
        return None


def _below(found: Side | None, most: fmpq) -> bool:
    return found is not None and -most <= found[0] and found[1] <= most


def _in_the_ranges(
    plant: TreePlant, K: fmpq_mat, curve: Curve, P: fmpq_mat, R: fmpq
) -> Obligations:
    """Yield that the set about Xhat(s) is in the ranges, for all s."""
    unit, push = entries(identity(K.ncols())), curve.of(negative(K))
    rows = [(v, unit[i], curve.reach(i)) for i, v in enumerate(plant.states)]
    rows += [(v, entries(K)[i], push.reach(i)) for i, v in enumerate(plant.inputs)]
    for v, a, (low, high) in rows:
        if v.side is None:
            continue
        room = min(v.side[1] - high, low - v.side[0])
        yield Fact("a variable rests in its range", room >= 0)
        own = scaled(R, fmpq_mat([a]))
        whole = blocks([[P, transposed(own)], [own, fmpq_mat([[room * room]])]])
        yield Definite("the set is in a range", whole, strict=False)
