r"""``observed-loop``: plant and observer as one system z, which stays in {z'Pz <= c}.

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
from dataclasses import dataclass, replace
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    blocks,
    entries,
    identity,
    mean,
    negative,
    zeros,
)
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    line,
    rational,
    rationals,
    stack,
    table,
)
from takagi.certificates.cross_check.loop.decay import decrease, rate_of
from takagi.certificates.cross_check.loop.disturbed import largest_extent, moves_states
from takagi.certificates.cross_check.loop.loop import Stack, VertexLoop, pick, single
from takagi.certificates.cross_check.loop.observing import is_seen
from takagi.certificates.cross_check.loop.pieces import mixtures, pieces


@dataclass(frozen=True, slots=True)
class Observer:
    """L of each rule, or one; with ``slopes`` (S_k, R_k) the weights are those at the estimate."""

    L: Stack
    slopes: tuple[tuple[fmpq_mat, fmpq_mat], ...] | None


def with_observer(
    loop: VertexLoop, model: Any, gains: Any, slopes: VertexLoop | None
) -> VertexLoop:
    """Return the loop with the observer of the gains and with its measured outputs.

    ``slopes`` : the vertices of the plant's slopes, if the model states them.
    """
    own = entry(gains, "observer")
    way = line(own, "weights")
    if way not in ("measured", "estimated"):
        raise Refusal("observer.weights: measured or estimated")
    names = _names_of_outputs(model)
    chosen = entry(own, "measured")
    if not isinstance(chosen, list) or not chosen:
        raise Refusal("observer.measured: names of outputs are needed")
    places = []
    for name in chosen:
        at = [k for k, one in enumerate(names) if type(name) is str and one == name]
        if len(at) != 1 or at[0] in places:
            raise Refusal("observer.measured: each an output of the model, once")
        places += at
    L = stack(own, "L")
    fits = (L[0].nrows(), L[0].ncols()) == (loop.n, len(places))
    if not fits or len(L) not in ({1} if way == "estimated" else {1, loop.rules}):
        raise Refusal("observer.L does not fit states, outputs and rules")
    found = None
    if way == "estimated":
        if slopes is None or slopes.n != loop.n or not slopes.C:
            raise Refusal("weights at the estimate: slopes of a plant are needed")
        found = tuple(
            (pick(slopes.A, k), _chosen(pick(slopes.C, k), places)) for k in range(slopes.rules)
        )
    C, D = ([_chosen(M, places) for M in given] for given in (loop.C, loop.D))
    return replace(loop, C=C, D=D, observer=Observer(L, found))


def _names_of_outputs(model: Any) -> list[Any]:
    if entry(model, "kind") != "plant":
        listed = entry(model, "output_names")
        return listed if isinstance(listed, list) else []
    listed = entry(model, "outputs")
    return [one.get("name") for one in listed if isinstance(one, dict)]


def _chosen(M: fmpq_mat, places: list[int]) -> fmpq_mat:
    return fmpq_mat([entries(M)[k] for k in places])


def observed_loop(claim: Any, loop: VertexLoop) -> Obligations:
    """The conditions of the module."""
    law, n = loop.observer, loop.n
    if law is None:
        raise Refusal("the gains have no observer")
    if loop.averages and any(len(M) > 1 for M in (loop.A, loop.B, loop.C, loop.D)):
        raise Refusal("an observer cannot know weights that are averages over a segment")
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
    yield Definite("P", P)
    rate = rate_of(loop, a)
    for k, G in enumerate(_systems(claim, loop, law)):
        yield Definite(f"decrease along matrix {k + 1}", decrease(loop, P, G, rate))
    for name, side in loop.other_sides.items():
        # Without disturbance 0 has to be in the range, but for a signal that only sets the weights.
        if moves_states(loop, name):
            yield Fact("no disturbance lies in the box", side[0] <= 0 <= side[1])
    most = rationals(claim, "input_limits", loop.K[0].nrows()) if "input_limits" in claim else []
    for label, row, side in _limited(loop, law, [(-one, one) for one in most]):
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
    for one in pieces(claim, replace(loop, beside=(law.L,))):
        together = replace(one, together=True)
        pairs = together.pairs(one.rules) if by_rule or acting else None
        for some in pairs or [((i, i),) for i in range(one.rules)]:
            push = mean(pick(one.B, i) * pick(one.K, j) for i, j in some)
            A = mean(pick(one.A, i) for i, _ in some)
            seen = mean(pick(one.beside[0], j) * pick(one.C, i) for i, j in some)
            yield blocks([[A - push, push], [nothing, A - seen]])


def _limited(
    loop: VertexLoop, law: Observer, most: list[tuple[fmpq, fmpq]]
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
    for k, side in [*ends, *enumerate(most)]:
        for j, K in enumerate(loop.K):
            row = fmpq_mat([entries(K)[k]])
            right = zeros(1, n) if law.slopes is not None else negative(row)
            yield f"input {k + 1} by gain {j + 1} within its limit", blocks([[row, right]]), side
