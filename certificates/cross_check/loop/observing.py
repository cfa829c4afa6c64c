r"""``observer`` and ``observed-feedback``: the error of an observer, and the loop through it.

    e = x - xhat:    e' = sum h_i h_j (A_i - L_j C_i) e       (weights known to the observer)
                     e' = sum h_i g_k (A_i + S_k - L C_i) e   (a part f(x) by its secants S_k)
    z = (x, e):      z' = sum h_i h_j [[A_i - B_i K_j, B_i K_j], [0, A_i - L_j C_i]] z

The decay conditions are those of ``decay``.  The observer must know the weights: every variable on
which a premise depends must be an input, or a state that is an output by itself.  No observer can
know weights that are averages over a segment: such a claim is refused where a matrix of the plant
depends on them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from flint import fmpq_mat

from takagi.certificates.cross_check.kernel.exact import blocks, entries, mean, zeros
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, rational, stack, table
from takagi.certificates.cross_check.loop.decay import decrease, rate_of
from takagi.certificates.cross_check.loop.loop import Stack, VertexLoop, pick, single
from takagi.certificates.cross_check.loop.pieces import pieces


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
        found = (
            pick(loop.A, i) + S - L[0] * pick(loop.C, i) for i in range(loop.rules) for S in secants
        )
    else:
        plain = len(single(L)) == 1 or len(loop.C) == 1
        found = (
            mean(pick(one.A, i) - pick(one.beside[0], j) * pick(one.C, i) for i, j in pairs)
            for one in pieces(claim, replace(loop, K=(), together=True, beside=(L,)))
            for pairs in _pairs(one, plain)
        )
    yield from _falling(claim, loop, loop.n, found)


def observed_feedback(claim: Any, loop: VertexLoop) -> Obligations:
    """The state and the observer's error decay together."""
    L = _gains(claim, loop)
    if not loop.K or not loop.together:
        raise Refusal("gains with the weights of the model are needed")
    fixed = len(single(L)) == 1 and len(loop.K) == 1
    plain = fixed or (len(loop.C) == 1 and len(loop.B) == 1)

    def joint() -> Iterator[fmpq_mat]:
        for one in pieces(claim, replace(loop, beside=(L,))):
            for pairs in _pairs(one, plain):
                push = mean(pick(one.B, i) * pick(one.K, j) for i, j in pairs)
                state = mean(pick(one.A, i) for i, _ in pairs) - push
                L_at = one.beside[0]
                error = mean(pick(one.A, i) - pick(L_at, j) * pick(one.C, i) for i, j in pairs)
                yield blocks([[state, push], [zeros(loop.n, loop.n), error]])

    yield from _falling(claim, loop, 2 * loop.n, joint())


def _gains(claim: Any, loop: VertexLoop) -> Stack:
    if loop.averages and any(len(M) > 1 for M in (loop.A, loop.B, loop.C, loop.D)):
        raise Refusal("an observer cannot know weights that are averages over a segment")
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


def _falling(claim: Any, loop: VertexLoop, order: int, found: Iterator[fmpq_mat]) -> Obligations:
    a, P = rational(claim, "decay_rate"), table(claim, "P", (order, order))
    yield Fact("the rate is not negative", a >= 0)
    yield Fact("premises are measured", all(is_seen(loop, name) for name in loop.seen_by))
    yield Definite("P", P)
    rate = rate_of(loop, a)
    for k, G in enumerate(found):
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
