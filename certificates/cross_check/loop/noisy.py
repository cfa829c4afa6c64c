r"""The probability that a loop with white noise leaves an ellipsoid within a time.

    dx = (A x + D v) dt + S dW,     |v_k| <= 1 each,        V = x'Px,     the set is V <= 1

Suppose that for every mixture and every x, v

    2 x'P(A x + D v) + 2 k |S'Px|^2 <= -a V + sum b_k v_k^2.                                 (1)

The first term and tr(S'PS) are the drift of V, and 4 |S'Px|^2 dt is its quadratic variation.  So
exp(kV) drifts by at most g(V) = k exp(kV) (c - aV), with c = sum b_k + max tr(S'PS).  On [0, 1]

    max g = k c at V = 0 for k c <= a;      max g <= a exp(k c/a - 1), the value where g' = 0.

(1) is decided without Schur's complement: its left side less its right is a form in (x, v),

    [[PA + A'P + a P + 2 k P S S' P,  P D], [D'P, -diag(b)]],

convex in (A, D, S), so mixtures suffice.  From V = v0 the maximal inequality gives

    Prob(V reaches 1 by T) <= (exp(k v0) + T max g) / exp(k).

Source: derived from the formulas of docs/plant-theorems.md; Kushner (1967), recalled.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from flint import arb, ctx, fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    blocks,
    diagonal,
    entries,
    negative,
    scaled,
    transposed,
)
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, rational, rationals, table
from takagi.certificates.cross_check.loop.disturbed import (
    disturbances_in_box,
    way_into,
    within_box,
)
from takagi.certificates.cross_check.loop.loop import VertexLoop
from takagi.certificates.cross_check.loop.pieces import mixtures

BITS = 256  # of the balls


def exit_probability(claim: Any, loop: VertexLoop) -> Obligations:
    """Test that V reaches 1 within the horizon with at most the claim's probability."""
    if loop.step is not None:
        raise Refusal("noise of this kind enters loops in continuous time")
    P = table(claim, "P", (loop.n, loop.n))
    a, k, v0, T, p = (
        rational(claim, key) for key in ("rate", "exponent", "start", "horizon", "probability")
    )
    if min(a, k, T, p) <= 0 or v0 < 0 or v0 >= 1 or p >= 1:
        raise Refusal("rate, exponent, horizon > 0; start from 0 to 1; probability between")
    way, E = way_into(claim, loop)
    width = E[0].ncols()
    noise = rationals(claim, "noise", width)
    held = [fmpq(0)] * width
    if "disturbance_bounds" in claim:
        held = rationals(claim, "disturbance_bounds", width)
    if min(*noise, *held) < 0 or max(noise) == 0:
        raise Refusal("noise and bounds: not negative, and some noise")
    moving = [j for j in range(width) if held[j] > 0]
    b = rationals(claim, "multipliers", len(moving)) if moving else []
    if any(one < 0 for one in b):
        raise Refusal("multipliers: not negative")
    yield Definite("P", P)
    names = loop.pushes if way == "disturbances" else loop.inputs
    for j, name in enumerate(names):
        free = name not in loop.other_sides and name not in (loop.seen_by or ())
        yield Fact("noise has no range and is in no premise", noise[j] == 0 or free)
    most = fmpq(0)
    for mixture in mixtures(claim, replace(loop, beside=(E,))):
        whole = mixture.of(mixture.loop.beside[0])
        S = _times(whole, [(j, size) for j, size in enumerate(noise) if size > 0])
        PS, PA = P * S, P * mixture.A
        form = PA + transposed(PA) + scaled(a, P) + scaled(2 * k, PS * transposed(PS))
        if moving:
            PD = P * _times(whole, [(j, held[j]) for j in moving])
            form = blocks([[form, PD], [transposed(PD), negative(diagonal(b))]])
        yield Definite(f"drift at {mixture.label}", negative(form), strict=False)
        variation = transposed(S) * PS
        most = max(most, sum((variation[j, j] for j in range(S.ncols())), fmpq(0)))
    c = sum(b, most)
    yield Fact("the maximum of the drift lies below the level", k * c <= a * (1 + k))
    yield Fact("probability", _at_most(a, k, c, v0, T, p))
    yield from disturbances_in_box(loop, way, held)
    yield from within_box(loop, P, fmpq(1), held if way == "inputs" else None)


def _times(matrix: fmpq_mat, kept: list[tuple[int, fmpq]]) -> fmpq_mat:
    """Return these columns of a matrix, each times its factor."""
    return fmpq_mat([[row[j] * size for j, size in kept] for row in entries(matrix)])


def _at_most(a: fmpq, k: fmpq, c: fmpq, v0: fmpq, T: fmpq, p: fmpq) -> bool:
    """Return whether the bound is certainly at most p; by balls that enclose exp."""
    before, ctx.prec = ctx.prec, BITS
    try:
        drift = arb(k * c) if k * c <= a else arb(a) * (arb(k * c / a) - 1).exp()
        bound = arb(k * (v0 - 1)).exp() + arb(T) * drift * arb(-k).exp()
        return bool(bound <= arb(p))
    finally:
        ctx.prec = before
