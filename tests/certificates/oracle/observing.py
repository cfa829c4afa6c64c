r"""``observer`` and ``observed-feedback``: the error of an observer, and the loop through it.

    e = x - xhat:    e' = sum h_i h_j (A_i - L_j C_i) e       (weights known to the observer)
                     e' = sum h_i g_k (A_i + S_k - L C_i) e   (a part f(x) by its secants S_k)
    z = (x, e):      z' = sum h_i h_j [[A_i - B_i K_j, B_i K_j], [0, A_i - L_j C_i]] z

The decay conditions are those of ``decay``.  The observer must know the weights: every variable on
which a premise depends must be an input, or a state that is an output by itself.  No observer can
know weights that are averages over a segment: such a claim is refused where a matrix of the plant
depends on them.

``observed-loop``: plant and observer as one system z, which stays in {z'Pz <= c}.

The law measures p outputs y, not the states: u = -sum h_j K_j s with the estimate s of the state,

    s' = sum h_i (A_i s + B_i u + L_i (y - sum h_i (C_i s + D_i u))).

Weights of the plant, functions of the outputs only.  With z = (x, x - s):

    [ A_i - B_i K_j   B_i K_j       ]        mixed over the pairs (i, j) of equal weights
    [ 0               A_i - L_j C_i ]

Weights evaluated at (s, u).  Then s' is the plant's own f(s, u) + L (y - g(s, u)) on the box, and
d = x - s obeys d' = (S - L R) d, where (S, R) is a mean of slopes of (f, g) between s and x.  With
z = (s, d):

    [ A_i - B_i K_j   L R_k       ]          mixed over (i, j), for every vertex k of the slopes
    [ 0               S_k - L R_k ]

Conditions: P > 0, the decrease of ``decay``, and on the set x_m and u_m within their ranges; for
weights at (s, u) also s_m.  The slopes are proved by another claim.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from flint import fmpq, fmpq_mat

from tests.certificates.oracle.decay import decrease, rate_of
from tests.certificates.oracle.disturbed import disturbances_in_box, largest_extent
from tests.certificates.oracle.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    entries,
    identity,
    mean,
    negative,
    zeros,
)
from tests.certificates.oracle.loop import (
    Observer,
    Stack,
    VertexLoop,
    mixtures,
    pick,
    pieces,
    single,
)
from tests.certificates.oracle.reading import (
    Refusal,
    rational,
    rationals,
    stack,
    table,
)


def observer(claim: Any, loop: VertexLoop) -> Obligations:
    """The observer's error decays along every combination of rules."""
    L = _gains(claim, loop)
    if "secants" in claim:
        if loop.of_plant:
            raise Refusal("secants: the model is a whole plant, and has no part f besides")
        secants = stack(claim, "secants")
        if (secants[0].nrows(), secants[0].ncols()) != (loop.n, loop.n):
            raise Refusal("secants: square matrices of the states are needed")
        if len(L) != 1:
            raise Refusal("L: one matrix is needed beside secants")
        systems = (
            pick(loop.A, i) + S - L[0] * pick(loop.C, i) for i in range(loop.rules) for S in secants
        )
    else:
        plain = len(single(L)) == 1 or len(loop.C) == 1
        systems = (
            mean(pick(piece.A, i) - pick(piece.beside[0], j) * pick(piece.C, i) for i, j in pairs)
            for piece in pieces(claim, replace(loop, K=(), together=True, beside=(L,)))
            for pairs in _pairs(piece, plain)
        )
    yield from _falling(claim, loop, loop.n, systems)


def observed_feedback(claim: Any, loop: VertexLoop) -> Obligations:
    """The state and the observer's error decay together."""
    L = _gains(claim, loop)
    if not loop.K or not loop.together:
        raise Refusal("gains with the weights of the model are needed")
    fixed = len(single(L)) == 1 and len(loop.K) == 1
    plain = fixed or (len(loop.C) == 1 and len(loop.B) == 1)

    def joint() -> Iterator[fmpq_mat]:
        for piece in pieces(claim, replace(loop, beside=(L,))):
            for pairs in _pairs(piece, plain):
                push = mean(pick(piece.B, i) * pick(piece.K, j) for i, j in pairs)
                state = mean(pick(piece.A, i) for i, _ in pairs) - push
                L_at = piece.beside[0]
                error = mean(pick(piece.A, i) - pick(L_at, j) * pick(piece.C, i) for i, j in pairs)
                yield blocks([[state, push], [zeros(loop.n, loop.n), error]])

    yield from _falling(claim, loop, 2 * loop.n, joint())


def _refuse_averages(loop: VertexLoop) -> None:
    if loop.averages and any(len(M) > 1 for M in (loop.A, loop.B, loop.C, loop.D)):
        raise Refusal("an observer cannot know weights that are averages over a segment")


def _gains(claim: Any, loop: VertexLoop) -> Stack:
    _refuse_averages(loop)
    if not loop.C:
        raise Refusal("there is no output to observe from")
    L = stack(claim, "L")
    if (L[0].nrows(), L[0].ncols()) != (loop.n, loop.C[0].nrows()):
        raise Refusal("L does not fit states and outputs")
    if len(L) not in (1, loop.rules):
        raise Refusal(f"L: one or {loop.rules} matrices are needed")
    return L


def _pairs(loop: VertexLoop, plain: bool) -> list[tuple[tuple[int, int], ...]]:
    if plain:
        return [((i, i),) for i in range(loop.rules)]
    return replace(loop, together=True).pairs(loop.rules)


def _falling(claim: Any, loop: VertexLoop, order: int, systems: Iterator[fmpq_mat]) -> Obligations:
    a, P = rational(claim, "decay_rate"), table(claim, "P", (order, order))
    yield Fact("the rate is not negative", a >= 0)
    yield Fact("premises are measured", all(is_seen(loop, name) for name in loop.seen_by))
    yield from _decreasing(loop, P, a, systems)


def _decreasing(loop: VertexLoop, P: fmpq_mat, a: fmpq, systems: Iterator[fmpq_mat]) -> Obligations:
    yield Definite("P", P)
    rate = rate_of(loop, a)
    for k, G in enumerate(systems):
        yield Definite(f"decrease along matrix {k + 1}", decrease(loop, P, G, rate))


def is_seen(loop: VertexLoop, name: str) -> bool:
    """Return whether the observer knows a variable: an input, or a state that is an output."""
    if name in loop.inputs:
        return True
    if name not in loop.states or not loop.C:
        return False
    k = loop.states.index(name)
    for i in range(loop.C[0].nrows()):
        # The same factor in every rule, and no other state or input in this output.
        rows = [entries(C)[i] for C in loop.C]
        alone = all([j for j, v in enumerate(row) if v != 0] == [k] for row in rows)
        fed = any(v != 0 for D in loop.D for v in entries(D)[i])
        if alone and not fed and all(row[k] == rows[0][k] for row in rows):
            return True
    return False


def observed_loop(claim: Any, loop: VertexLoop) -> Obligations:
    """The conditions of the module."""
    law, n = loop.observer, loop.n
    if law is None:
        raise Refusal("the gains have no observer")
    _refuse_averages(loop)
    if not loop.K or not loop.together or not loop.C:
        raise Refusal("gains with the weights of the model, and outputs, are needed")
    a, c, P = (
        rational(claim, "decay_rate"),
        rational(claim, "level"),
        table(claim, "P", (2 * n,) * 2),
    )
    if a < 0 or c <= 0:
        raise Refusal("decay_rate >= 0 and level > 0 are needed")
    if law.slopes is None:
        known = all(is_seen(loop, name) for name in loop.seen_by)
    else:
        known = set(loop.seen_by) <= {*loop.states}
    # An input is known after the premises have been evaluated, not before.
    commanded = set(loop.seen_by) & {*loop.inputs}
    yield Fact("the observer knows its weights", known and not commanded)
    yield from _decreasing(loop, P, a, _systems(claim, loop, law))
    yield from disturbances_in_box(loop, "", [])
    limits = rationals(claim, "input_limits", loop.K[0].nrows()) if "input_limits" in claim else []
    for label, row, side in _limited(loop, law, [(-limit, limit) for limit in limits]):
        yield from largest_extent(P, c, row, min(-side[0], side[1]), label)


def _systems(claim: Any, loop: VertexLoop, law: Observer) -> Iterator[fmpq_mat]:
    nothing = zeros(loop.n, loop.n)
    if law.slopes is not None:
        errors = [(law.L[0] * R, S - law.L[0] * R) for S, R in law.slopes]
        for mixture in mixtures(claim, replace(loop, C=(), D=())):
            for push, error in errors:
                yield blocks([[mixture.A, push], [nothing, error]])
        return
    by_rule = len(single(law.L)) > 1 and len(loop.C) > 1
    acting = len(loop.K) > 1 and len(loop.B) > 1
    for piece in pieces(claim, replace(loop, beside=(law.L,))):
        together = replace(piece, together=True)
        pairs = together.pairs(piece.rules) if by_rule or acting else None
        for group in pairs or [((i, i),) for i in range(piece.rules)]:
            push = mean(pick(piece.B, i) * pick(piece.K, j) for i, j in group)
            A = mean(pick(piece.A, i) for i, _ in group)
            seen = mean(pick(piece.beside[0], j) * pick(piece.C, i) for i, j in group)
            yield blocks([[A - push, push], [nothing, A - seen]])


def _limited(
    loop: VertexLoop, law: Observer, limits: list[tuple[fmpq, fmpq]]
) -> Iterator[tuple[str, fmpq_mat, tuple[fmpq, fmpq]]]:
    n = loop.n
    if set(loop.states) & set(loop.inputs):
        raise Refusal("a state and an input have one name")
    for k, side in enumerate(loop.sides):
        if side is None:
            continue
        row = fmpq_mat([entries(identity(n))[k]])
        if law.slopes is None:
            yield f"state {k + 1} in the box", blocks([[row, zeros(1, n)]]), side
        else:
            yield f"state {k + 1} in the box", blocks([[row, row]]), side
            yield f"estimate {k + 1} in the box", blocks([[row, zeros(1, n)]]), side
    ends = [(loop.inputs.index(u), s) for u, s in loop.other_sides.items() if u in loop.inputs]
    for k, side in [*ends, *enumerate(limits)]:
        for j, K in enumerate(loop.K):
            row = fmpq_mat([entries(K)[k]])
            right = zeros(1, n) if law.slopes is not None else negative(row)
            yield f"input {k + 1} by gain {j + 1} within its limit", blocks([[row, right]]), side
