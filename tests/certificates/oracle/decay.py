r"""Claims that are matrix inequalities along the loop: decay, its absence, regions, overshoot.

With V = x'Px the decrease along G, to be positive definite, is

    continuous   -(P G + G'P) - 2 a P            discrete   r P - G'P G,    r close to e^(-2 a T)

A claim that V decays takes r <= e^(-2 a T), which asks for more than the claim says; a claim that
no V decays takes r >= e^(-2 a T).  The functions below give the formulas of the other claims.
Sources: Boyd, El Ghaoui, Feron, Balakrishnan (1994), chapters 2 and 5; Chilali and Gahinet (1996),
theorem 2.2; all recalled.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from flint import arb, ctx, fmpq, fmpq_mat

from tests.certificates.oracle.exact import (
    Definite,
    Fact,
    Obligations,
    blocks,
    diagonal,
    entries,
    is_definite,
    mean,
    negative,
    scaled,
    transposed,
    zeros,
)
from tests.certificates.oracle.loop import VertexLoop, combined, mixtures, pick
from tests.certificates.oracle.reading import (
    Refusal,
    entry,
    integer,
    rational,
    rational_row,
    rationals,
    table,
)

BITS = 240  # working precision: e^-x is known to far more digits than a certificate's numbers have
MOST_EXPONENT = 200  # beyond it e^-x is taken as between 0 and e^-200, without a large number


def exponential(x: fmpq, *, up: bool) -> fmpq:
    """Return the lower, or with ``up`` the upper, end of a ball that holds e^-x, for x >= 0."""
    if x > MOST_EXPONENT:
        return exponential(fmpq(MOST_EXPONENT), up=True) if up else fmpq(0)
    with ctx.workprec(BITS):
        ball = (-arb(x)).exp()
        mantissa, power = (ball.upper() if up else ball.lower()).man_exp()
    p, q = int(mantissa), int(power)
    return fmpq(p << q) if q >= 0 else fmpq(p, 1 << -q)


def rate_of(loop: VertexLoop, a: fmpq, *, up: bool = False) -> fmpq:
    """Return 2 a in continuous time, r in discrete time; ``up`` rounds r up, else it is down."""
    if loop.step is None:
        return 2 * a
    return fmpq(1) if a == 0 else exponential(2 * a * loop.step, up=up)


def decrease(loop: VertexLoop, P: fmpq_mat, G: fmpq_mat, rate: fmpq) -> fmpq_mat:
    """Return the matrix of the module's text, whose definiteness means that V decays along G."""
    if loop.step is not None:
        return scaled(rate, P) - transposed(G) * P * G
    half = P * G
    return negative(half + transposed(half)) - scaled(rate, P)


def _falls(claim: Any, loop: VertexLoop, P: fmpq_mat, a: fmpq) -> Obligations:
    rate = rate_of(loop, a)
    for mixture in mixtures(claim, loop):
        yield Definite(f"decrease at {mixture.label}", decrease(loop, P, mixture.A, rate))


def decay(claim: Any, loop: VertexLoop) -> Obligations:
    """P > 0 and the decrease along every mixture."""
    a, P = rational(claim, "decay_rate"), table(claim, "P", (loop.n, loop.n))
    yield Fact("the rate is not negative", a >= 0)
    yield Definite("P", P)
    yield from _falls(claim, loop, P, a)


def no_common_decay(claim: Any, loop: VertexLoop) -> Obligations:
    """No P > 0 decreases along every blend.  There are two ways to show it.

    Multipliers: Z_k >= 0, not all 0, with S = sum_k (G_k Z_k + Z_k G_k' + 2 a Z_k) >= 0
    (G Z G' - r Z in discrete time).  If such a P existed, the trace of P S would be negative, which
    contradicts S >= 0.  For a > 0 the decay in question is not strict, so that the trace would only
    be at most 0; the contradiction then needs S != 0 in addition.

    One blend: a symmetric P that decreases along G and is not positive definite.  Lyapunov's
    equation for G then has no positive definite solution.

    Every G is A(h) - B(h) K(h) for weights h that the loop really takes.  A mean of pairs (i, j),
    which is enough for a proof of decay, would not be enough here.
    """
    a = rational(claim, "decay_rate")
    yield Fact("the rate is not negative", a >= 0)
    yield Fact("which gain meets which rule is known", loop.together or len(loop.K) <= 1)
    rate = rate_of(loop, a, up=True)
    if "multipliers" not in claim:
        G = _blended(claim, loop)
        P = table(claim, "P", (loop.n, loop.n))
        yield Fact("P is not positive definite", not is_definite(P))
        yield Fact("P is symmetric", P == transposed(P))
        yield Definite("decrease along the one", decrease(loop, P, G, rate))
        return
    listed = entry(claim, "multipliers")
    if not isinstance(listed, list) or not listed:
        raise Refusal("multipliers: a list is needed")
    total, size = zeros(loop.n, loop.n), fmpq(0)
    for multiplier in listed:
        G, factor = _blended(multiplier, loop), table(multiplier, "factor")
        if factor.nrows() != loop.n:
            raise Refusal("factor: a row for each state is needed")
        # Z = F F' is semidefinite by construction, so that it needs no test.
        Z = factor * transposed(factor)
        size += sum((Z[k, k] for k in range(loop.n)), fmpq(0))
        GZ = G * Z
        if loop.step is None:
            part = GZ + transposed(GZ) + scaled(rate, Z)
        else:
            part = GZ * transposed(G) - scaled(rate, Z)
        total = total + part
    yield Fact("one multiplier is not zero", size > 0)
    yield Fact("the sum is not zero", a == 0 or total != zeros(loop.n, loop.n))
    yield Definite("the sum with multipliers", total, strict=False)


def _blended(owner: Any, loop: VertexLoop) -> fmpq_mat:
    """Return A(h) - B(h) K(h); ``blend`` is the number of a rule, or the shares of h."""
    given, r = entry(owner, "blend"), loop.rules
    if not isinstance(given, list):
        k = integer(owner, "blend")
        if not 0 <= k < r:
            raise Refusal(f"blend: 0 to {r - 1} is needed")
        h = [fmpq(int(i == k)) for i in range(r)]
    else:
        choices = loop.corners or [(i,) for i in range(r)]
        width = r if loop.corners is None else 2
        rows = [rational_row(row, "blend", width) for row in given]
        if len(rows) != len(choices[0]) or any(min(row) < 0 or sum(row) == 0 for row in rows):
            raise Refusal("blend: a row of shares for each premise, none negative, is needed")
        h = [fmpq(1)] * r
        for i, corners in enumerate(choices):
            for row, corner in zip(rows, corners, strict=True):
                h[i] = h[i] * row[corner] / sum(row, fmpq(0))
        if sum(h, fmpq(0)) != 1:
            raise Refusal("blend: the rules leave out a combination of corners")
    (G,) = combined(loop.A, [h])
    if not loop.K or not loop.B:
        return G
    (B,), (K,) = combined(loop.B, [h]), combined(loop.K, [h])
    return G - B * K


def region(claim: Any, loop: VertexLoop) -> Obligations:
    """-(L (x) P + M (x) P G + M' (x) G'P) > 0 for each part (L, M) and mixture; P > 0."""
    P = table(claim, "P", (loop.n, loop.n))
    listed = entry(claim, "parts")
    if not isinstance(listed, list) or not listed:
        raise Refusal("parts: a list is needed")
    parts = []
    for part in listed:
        L = table(part, "L")
        M = table(part, "M", (L.nrows(), L.nrows()))
        if transposed(L) != L:
            raise Refusal("L: a symmetric matrix is needed")
        parts.append((L, M))
    yield Definite("P", P)
    for mixture in mixtures(claim, loop):
        PG = P * mixture.A
        GP = transposed(PG)
        for k, (L, M) in enumerate(parts):
            size = range(L.nrows())
            decreasing = blocks(
                [[P * L[i, j] + PG * M[i, j] + GP * M[j, i] for j in size] for i in size]
            )
            yield Definite(f"part {k + 1} at {mixture.label}", negative(decreasing))


def transient(claim: Any, loop: VertexLoop) -> Obligations:
    """|S^-1 x(t)| <= k e^(-a t) |S^-1 x(0)|, and at most the share e of it from t_s on.

    The conditions are p S^-2 <= P <= k^2 p S^-2 with S = diag(scales), the decrease of ``decay``,
    and k e^(-a t_s) <= e.
    """
    n = loop.n
    P, scales = table(claim, "P", (n, n)), rationals(claim, "scales", n)
    names = ("decay_rate", "lower", "overshoot", "settled_share", "settling_time")
    a, p, k, share, time = (rational(claim, name) for name in names)
    if min(a, p, k, share, time, *scales) <= 0:
        raise Refusal("a transient's numbers are positive")
    if loop.step is not None and (time / loop.step).q != 1:
        raise Refusal("settling_time: a whole number of samples is needed")
    weight = diagonal([p / s**2 for s in scales])
    yield Definite("P", P)
    yield Definite("P from below", P - weight, strict=False)
    yield Definite("P from above", scaled(k**2, weight) - P, strict=False)
    yield from _falls(claim, loop, P, a)
    yield Fact("settled by then", k * exponential(a * time, up=True) <= share)


def gain_rounding(claim: Any, loop: VertexLoop) -> Obligations:
    """Decay while each entry of each gain K_j has an error d of at most absolute + relative |K_j|.

    Young's inequality: 2 |b_k'y d_k'x| <= t_k (b_k'y)^2 + (d_k'x)^2 / t_k, where b_k are the
    columns of P B_i and y = x (y = x+ in discrete time).  Cauchy and Schwarz give
    (d_k'x)^2 <= (sum_l e_kl) sum_l e_kl x_l^2 for |d_kl| <= e_kl.
    """
    if not loop.K:
        raise Refusal("no gains that could be rounded")
    m, n = loop.K[0].nrows(), loop.n
    a, relative = rational(claim, "decay_rate"), rational(claim, "relative")
    P, absolute = table(claim, "P", (n, n)), table(claim, "absolute", (m, n))
    tau = rationals(claim, "tau", m)
    steps_fine = min(a, relative, *(v for row in entries(absolute) for v in row)) >= 0
    yield Fact("rate and steps are not negative, tau is positive", steps_fine and min(tau) > 0)
    yield Definite("P", P)
    if min(tau) <= 0:
        return
    pushed = [P * B * diagonal(tau) * transposed(P * B) for B in loop.B]
    moved = [_spread(absolute, relative, K, tau) for K in loop.K]
    rate = rate_of(loop, a)
    for mixture in mixtures(claim, replace(loop, beside=(pushed, moved))):
        push = mixture.of(mixture.loop.beside[0])
        move = mean(pick(mixture.loop.beside[1], j) for _, j in mixture.pairs)
        PG = P * mixture.A
        if loop.step is None:
            decreasing = decrease(loop, P, mixture.A, rate) - push - move
        else:
            decreasing = blocks([[scaled(rate, P) - move, transposed(PG)], [PG, P - push]])
        yield Definite(f"decrease at {mixture.label}", decreasing)


def _spread(absolute: fmpq_mat, relative: fmpq, K: fmpq_mat, tau: list[fmpq]) -> fmpq_mat:
    """Return diag over l of sum_k (sum_i e_ki) e_kl / t_k, the bound of sum_k (d_k'x)^2 / t_k."""
    bounds = [fmpq(0)] * K.ncols()
    for k, t in enumerate(tau):
        e = [absolute[k, i] + relative * abs(K[k, i]) for i in range(K.ncols())]
        row_sum = sum(e, fmpq(0))
        bounds = [f + row_sum * error / t for f, error in zip(bounds, e, strict=True)]
    return diagonal(bounds)
