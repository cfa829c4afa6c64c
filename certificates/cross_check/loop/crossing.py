r"""The probability that a signal of a linear loop with constant parameters reaches a limit.

    dx = A x dt + S dW,     x = 0 at first,     y = h x,     (A, S) constant in a union of hulls

Let X > 0 on each hull with A X + X A' + S S' < 0 and h S = 0 at its corners.  S S' is convex in S
and the rest affine in A, so this is so in the hull.  The stationary covariance is then at most X.
y has the rate h A x.  With variances v >= h X h' and w >= h A X A' h' (convex in A) of both,
b^2 >= v, the share of time outside and the mean count of crossings of +-b bound

    Prob(|y| reaches b by T) <= exp(-b^2 / (2 v)) (sqrt(2 v / pi) / b + (T / pi) sqrt(w / v)).

The first term is erfc(z) <= exp(-z^2) / (z sqrt pi) at z = b / sqrt(2 v).

Source: the formula of docs/crossing-probability.md; Rice (1945), recalled.
"""

from __future__ import annotations

from ast import literal_eval
from dataclasses import replace
from typing import Any

from flint import arb, ctx, fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import negative, transposed
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, rational, rationals, stack
from takagi.certificates.cross_check.loop.disturbed import way_into
from takagi.certificates.cross_check.loop.loop import VertexLoop
from takagi.certificates.cross_check.loop.pieces import pieces

BITS = 256  # of the balls


def crossing_probability(claim: Any, loop: VertexLoop) -> Obligations:
    """Test that |y| reaches the limit within the horizon with at most the claim's probability."""
    if loop.step is not None:
        raise Refusal("noise of this kind enters loops in continuous time")
    b, T, p = (rational(claim, key) for key in ("limit", "horizon", "probability"))
    if b <= 0 or T <= 0 or p <= 0 or p >= 1:
        raise Refusal("limit and horizon: above 0; probability: between 0 and 1")
    _, E = way_into(claim, loop)
    noise = rationals(claim, "noise", E[0].ncols())
    if min(noise) < 0 or max(noise) == 0:
        raise Refusal("noise: not negative, and some")
    h = fmpq_mat([rationals(claim, "row", loop.n)])
    if h == h * 0:
        raise Refusal("row: not zero")
    yield Fact("the loop has no box, and its weights are no signals", _is_linear(loop))
    roots = fmpq_mat([[q if i == j else fmpq(0) for j in range(len(noise))]
                      for i, q in enumerate(noise)])  # fmt: skip
    parts = list(pieces(claim, replace(loop, beside=(E,))))
    covariances = stack(claim, "C")
    fits = (covariances[0].nrows(), covariances[0].ncols()) == (loop.n, loop.n)
    if len(covariances) != len(parts) or not fits:
        raise Refusal(f"C: {len(parts)} matrices of order {loop.n}, one for each piece")
    for k, (part, X) in enumerate(zip(parts, covariances, strict=True), 1):
        yield Definite(f"C of piece {k}", X)
        v = (h * X * transposed(h))[0, 0]
        yield Fact(f"the limit is a deviation or more in piece {k}", b * b >= v)
        w = fmpq(0)
        for mixture in part.mixtures():
            A, S = mixture.A, mixture.of(part.beside[0]) * roots
            yield Fact(f"no noise in the signal at {mixture.label}", not any((h * S).entries()))
            growth = A * X + transposed(A * X) + S * transposed(S)
            yield Definite(f"covariance of piece {k} at {mixture.label}", negative(growth))
            rate = h * A
            w = max(w, (rate * X * transposed(rate))[0, 0])
        yield Fact(f"probability in piece {k}", at_most(b, v, w, T, p))


def _is_linear(loop: VertexLoop) -> bool:
    """Return whether the model has no box, and no weight that is a function of a signal."""
    if loop.averages or loop.other_sides or any(side is not None for side in loop.sides):
        return False
    # Gains that are blended by other weights than the model's may be blended by a signal.
    if loop.seen_by or (len(loop.K) > 1 and not loop.together):
        return False
    moving = {name.partition(" ")[0] for name in (*loop.states, *loop.inputs, *loop.pushes)}
    stated = loop.premises[0] if loop.premises else ()
    # Each part is (whether it is a number, its text as Python writes it).
    return all(
        expression == (False, "None") and str(literal_eval(name)).partition(" ")[0] not in moving
        for (_, name), _, _, expression in stated
    )


def at_most(b: fmpq, v: fmpq, w: fmpq, T: fmpq, p: fmpq) -> bool:
    """Return whether the bound is certainly at most p; by balls that enclose it."""
    before, ctx.prec = ctx.prec, BITS
    try:
        pi = arb.pi()
        outside = (2 * arb(v) / pi).sqrt() / arb(b)
        crossings = arb(T) / pi * arb(w / v).sqrt()
        bound = arb(-b * b / (2 * v)).exp() * (outside + crossings)
        return bool(bound <= arb(p))
    finally:
        ctx.prec = before
