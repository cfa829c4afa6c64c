r"""``tracking``: an output converges to its reference, for every reference in a range.

With X = (x, xi), xi_j' = h_j(x) - r_j, u = u* - K (X - X*) and signals s with ranges, let

    Xhat(s) = X* + D (s - s*),    uhat(s) = u* - K D (s - s*).

On a convex box over which [f_X f_u] is in the hull of (A_i, B_i), and where V = z'Pz falls at alpha
for every A_i - B_i K, the distance v = |X - Xhat(s)|_P has

    v' <= -alpha v + |F(Xhat, uhat, s)|_P + sum_j |D_j|_P |s_j'|.

So {v <= R} is invariant if alpha R is at least the sum of the bounds.  The loop contracts inside,
so by Banach's theorem it has one rest, and h = r there.  Decided in this order:

1. the facts of ``secant``; the equation of xi_j is h_j - r_j, as written in the model and in the
   law, h_j of states that are no integrals; r_j and xi_j are in no other equation
2. P is definite, A_i - B_i K falls at the rate, for all vertices
3. the bounds of F, of its norm and of the norms of the D_j
4. alpha R >= e + sum d_j rho_j
5. the set about Xhat(s) is in the ranges of states and inputs, at every corner of s
6. the rows of xi_j have at most the norm that is claimed

Written from ``docs/plant-theorems.md``.
"""

from __future__ import annotations

from itertools import product
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    entries,
    negative,
    scaled,
    transposed,
)
from takagi.certificates.cross_check.kernel.reading import (
    NotReplayed,
    Refusal,
    entry,
    rational,
    rationals,
    stack,
    table,
)
from takagi.certificates.cross_check.loop.loop import Side, VertexLoop, close
from takagi.certificates.cross_check.plant.embedding import MOST_BOXES
from takagi.certificates.cross_check.plant.expression import (
    Tree,
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
    yield from lies_in_secants(model, gains)
    yield Fact("the law's trim is the rest exactly", _exact_trim(plant, gains))
    found = stack(gains, "K")
    yield Fact("there is one gain", all(one == found[0] for one in found))
    K, loop = found[0], close(plant_loop(model), gains)
    follow = references_of(model, plant)
    yield from integrals(plant, follow)
    n = len(plant.states)
    signals = [v for v in plant.pushes if v.side is not None]
    P, D = table(claim, "P"), table(claim, "slope")
    fits = (P.nrows(), P.ncols(), D.nrows(), D.ncols()) == (n, n, n, len(signals))
    if not fits:
        raise Refusal("P or slope: another shape is needed")
    alpha, R = rational(claim, "decay_rate"), rational(claim, "radius")
    yield Fact("rate and radius are positive", alpha > 0 and R > 0)
    yield Definite("P", P)
    yield from _falls(loop, K, P, alpha)
    e, residuals = rational(claim, "residual_norm"), rationals(claim, "residuals", n)
    d = rationals(claim, "slope_norms", len(signals))
    rho = rationals(claim, "rates", len(signals))
    c = rationals(claim, "error_factors", len(follow))
    yield Fact("no bound is negative", min([e, *residuals, *d, *rho, *c]) >= 0)
    yield from _norms(P, D, residuals, e, d)
    yield Fact(
        "the set is kept",
        alpha * R >= e + sum((a * b for a, b in zip(d, rho, strict=True)), fmpq(0)),
    )
    yield from _on_the_line(plant, signals, K, D, residuals)
    yield from _in_the_ranges(plant, signals, K, D, P, R)
    for (_, row, _), most in zip(follow, c, strict=True):
        for k in range(len(loop.A)):
            C = fmpq_mat([entries(loop.A[k])[row]])
            corner = fmpq_mat([[most * most]])
            whole = blocks([[P, transposed(C)], [C, corner]])
            yield Definite(f"error at vertex {k + 1}", whole, strict=False)


def _exact_trim(plant: TreePlant, gains: Any) -> bool:
    trim = entry(gains, "trim")
    return all(
        [value_of(v.rest) for v in variables] == rationals(trim, key, len(variables))
        for key, variables in (("state", plant.states), ("input", plant.inputs))
        if variables
    )


def _falls(loop: VertexLoop, K: fmpq_mat, P: fmpq_mat, alpha: fmpq) -> Obligations:
    """Yield that -(M'P + PM + 2 alpha P) is semidefinite for M = A_i - B_i K."""
    for k in range(loop.rules):
        A = loop.A[k if len(loop.A) > 1 else 0]
        B = loop.B[k if len(loop.B) > 1 else 0]
        M = P * (A - B * K)
        yield Definite(
            f"decay at vertex {k + 1}",
            negative(M + transposed(M) + scaled(2 * alpha, P)),
            strict=False,
        )


def _norms(P: fmpq_mat, D: fmpq_mat, residuals: list[fmpq], e: fmpq, d: list[fmpq]) -> Obligations:
    corners = sum(
        (abs(value) * residuals[i] * residuals[j]
         for i, row in enumerate(entries(P)) for j, value in enumerate(row)),
        fmpq(0),
    )  # fmt: skip
    yield Fact("the norm of what is left", corners <= e * e)
    squares = transposed(D) * P * D
    yield Fact("the norms of slopes", all(squares[j, j] <= d[j] * d[j] for j in range(len(d))))


def _affine(row: list[fmpq], signals: list[Variable]) -> Tree:
    """Return sum_j row_j s_j in the deviations s_j."""
    total = number(0)
    for factor, v in zip(row, signals, strict=True):
        total = plus(total, times(number(factor), ("name", v.symbol)))
    return total


def _on_the_line(
    plant: TreePlant,
    signals: list[Variable],
    K: fmpq_mat,
    D: fmpq_mat,
    residuals: list[fmpq],
) -> Obligations:
    """Yield that each right side is at most its residual at (Xhat(s), uhat(s), s)."""
    U = negative(K * D)
    places: dict[str, Tree] = {v.symbol: number(0) for v in plant.pushes if v.side is None}
    for variables, slopes in ((plant.states, D), (plant.inputs, U)):
        for v, row in zip(variables, entries(slopes), strict=True):
            places[v.symbol] = _affine(row, signals)
    sides = {v.symbol: v.side for v in signals if v.side is not None}
    for k, (tree, most) in enumerate(zip(plant.f, residuals, strict=True)):
        there = put(tree, places)
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
    plant: TreePlant,
    signals: list[Variable],
    K: fmpq_mat,
    D: fmpq_mat,
    P: fmpq_mat,
    R: fmpq,
) -> Obligations:
    """Yield that the set about Xhat(s) is in the ranges, for s at every corner."""
    n = len(plant.states)
    rows = [[fmpq(int(i == j)) for j in range(n)] for i in range(n)]
    slopes = entries(D)
    rows += entries(K)
    slopes += entries(negative(K * D))
    for v, a, slope in zip([*plant.states, *plant.inputs], rows, slopes, strict=True):
        if v.side is None:
            continue
        corners = product(*(s.side for s in signals if s.side is not None))
        values = [
            sum((p * q for p, q in zip(slope, corner, strict=True)), fmpq(0)) for corner in corners
        ]
        room = min(v.side[1] - max(values), min(values) - v.side[0])
        yield Fact("a variable rests in its range", room >= 0)
        own = fmpq_mat([a])
        whole = blocks(
            [[P, transposed(scaled(R, own))], [scaled(R, own), fmpq_mat([[room * room]])]]
        )
        yield Definite("the set is in a range", whole, strict=False)
