r"""``crossing-probability``: |y| of a linear loop reaches b within T s with probability at most p.

    dx = A x dt + S dW,     x(0) = 0,     y = h x,     W of independent Brownian motions,

(A, S) constant, in the union of the pieces of the weights; S has the columns of the noise times the
roots of its intensities.  Let every piece have a C > 0 with, for each of its blends,

    A C + C A' + S S' < 0,     h S = 0,     s^2 = h C h',     m^2 = max h A C A' h',     b >= s.

A is then stable, and the stationary covariance at most C: the deviation of y is at most s, that of
its rate h A x at most m.  The probability outside at the start and the mean number of outward
crossings (Rice) give, with xi = b^2 / (2 s^2),

    P(|y| reaches b within T) <= erfc(sqrt xi) + T m / (pi s) exp(-xi)
                              <= exp(-xi) (1 / sqrt(pi xi) + T m / (pi s)) <= p

for the stationary process, hence from rest (Anderson's inequality).  It grows with s <= b and m.
The weights do not change with time, so that each piece may have its own C.  The loop must have no
box, which noise would drive it out of, no premise that is a signal, and no gains with weights of
their own.  Theorem and proof: docs/crossing-probability.md.

Evidence: ``disturbance`` as in ``disturbance_channel``; ``noise``, for each disturbance the root of
its intensity (two-sided spectral density); ``row`` = h; ``limit`` = b; ``C``, one matrix for each
piece of ``halvings``; ``horizon`` = T, ``probability`` = p.

Source: Rice (1945), Bell System Technical Journal 24; Anderson (1955), Proceedings of the American
Mathematical Society 6 (recalled).
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isqrt
from typing import Any

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix, read_stack
from takagi.certificates.checker.kernel.reader import number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.disturbance_channel import entrance
from takagi.certificates.checker.loop.halvings import pieces
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, bounded

PI_BELOW = Fraction(314159265358979, 10**14)
FINE = 10**24  # of square roots


@dataclass(frozen=True)
class Crossing:
    """The noise and the signal of the claim.

    ``way`` : "disturbances" or "inputs"; ``E`` : the matrices through which w enters.
    ``noise`` : for each w_k the root of its intensity, 0 for none; ``row`` : h; ``limit`` : b.
    """

    way: str
    E: Stack
    noise: list[Fraction]
    row: Matrix
    limit: Fraction


def check_crossing_probability(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with the module's evidence."""
    name = text(claim, "name", where)
    asked = _read(claim, loop, where)
    horizon, probability = (number(claim, key, where) for key in ("horizon", "probability"))
    if not (asked.limit > 0 and horizon > 0 and 0 < probability < 1):
        raise CertificateError(f"{where}: limit > 0, horizon > 0, 0 < probability < 1")
    if why := _moving(loop):
        return Claim(name, Verdict.UNDECIDED, why)
    parts = list(pieces(claim, replace(loop, more=(asked.E,)), where))
    covariances = read_stack(claim, "C", where)
    if covariances[0].shape != (loop.order, loop.order) or len(covariances) != len(parts):
        raise CertificateError(
            f"{where}.C: {len(parts)} matrices {loop.order} by {loop.order}, one for each piece"
        )
    bounded(sum(len(part.groups()) for part in parts), loop.order)
    for k, (part, C) in enumerate(zip(parts, covariances, strict=True)):
        place = f" of piece {k + 1}" if len(parts) > 1 else ""
        if why := _fails(asked, part, C, horizon, probability):
            return Claim(name, Verdict.UNDECIDED, why + place)
    said = {"name": name, "loop": loop, "asked": asked, "pieces": len(parts)}
    return Found(
        Verdict.PROVED,
        "crossing_probability",
        said | {"horizon": horizon, "probability": probability},
    )


def _fails(
    asked: Crossing, part: PolytopicLoop, C: Matrix, horizon: Fraction, probability: Fraction
) -> str:
    """Return which condition fails on one piece; empty if all hold."""
    if not C.is_positive_definite:
        return "C is not symmetric positive definite"
    kept = [k for k, size in enumerate(asked.noise) if size]
    noisy = Matrix.of([[size if i == k else Fraction(0) for k in kept]
                       for i, size in enumerate(asked.noise)])  # fmt: skip
    variance, of_rate = _square(asked.row, C), Fraction(0)
    if asked.limit**2 < variance:
        return "the limit is below the deviation"
    for blend in part.blends():
        S, AC = blend.of(part.more[0]) @ noisy, blend.A @ C
        if any((asked.row @ S).rows[0]):
            return f"noise reaches the signal directly at {blend.label}"
        if not (-(AC + AC.T) - S @ S.T).is_positive_definite:
            return f"the inequality fails at {blend.label}"
        of_rate = max(of_rate, _square(asked.row @ blend.A, C))
    bound = crossing_bound(
        ratio=asked.limit**2 / (2 * variance), rate=of_rate / variance, horizon=horizon
    )
    return "" if bound <= probability else "the bound of the probability is above the claim's"


def crossing_bound(*, ratio: Fraction, rate: Fraction, horizon: Fraction) -> Fraction:
    """Return exp(-xi) (1 / sqrt(pi xi) + T m / (pi s)), rounded up.

    Parameters
    ----------
    ratio : xi = b^2 / (2 s^2), positive.
    rate, horizon : (m / s)^2 in 1/s^2, and T in s.
    """
    outside = root_above(1 / (PI_BELOW * ratio))
    crossings = horizon * root_above(rate) / PI_BELOW
    return exp_above(ratio) * (outside + crossings)


def root_above(value: Fraction) -> Fraction:
    """Return a rational r > sqrt(value), value >= 0; r is at most 10^-24 larger."""
    return Fraction(isqrt(value.numerator * FINE * FINE // value.denominator) + 1, FINE)


def _square(row: Matrix, C: Matrix) -> Fraction:
    return (row @ C @ row.T)[0, 0]


def _read(claim: Any, loop: PolytopicLoop, where: str) -> Crossing:
    if loop.is_discrete:
        raise CertificateError(f"{where}: the claim is about loops in continuous time")
    way, E = entrance(claim, loop, where)
    noise = numbers(claim, "noise", where, E[0].shape[1])
    if any(size < 0 for size in noise) or not any(noise):
        raise CertificateError(f"{where}: noise >= 0, some of it above 0")
    row = numbers(claim, "row", where, loop.order)
    if not any(row):
        raise CertificateError(f"{where}.row: a row that is not zero is needed")
    return Crossing(way, E, noise, Matrix.of([row]), number(claim, "limit", where))


def _moving(loop: PolytopicLoop) -> str:
    """Return why the loop may not be linear with constant weights; empty if it may."""
    if loop.scheduled_by or loop.averaged:
        return "the weights are those of a plant, which are not constant"
    if any(side is not None for side in loop.box) or loop.other_box:
        return "the model has a box, which white noise drives every loop out of"
    if len(loop.K) > 1 and not loop.shared_weights:
        return "the gains have weights of their own, which nothing says to be constant"
    signals = {name.split(" ")[0] for name in (*loop.states, *loop.inputs, *loop.disturbances)}
    premises = json.loads(loop.weights)[0] if loop.weights else []
    if any(expression or one.split(" ")[0] in signals for one, _, _, expression in premises):
        return "a premise is a signal, which is not constant"
    return ""
