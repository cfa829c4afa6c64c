r"""Bounds of the rate of u = -sum_j h_j K_j x on an invariant set {x'Px <= c}, input by input.

Continuous time, with G_il = A_i - B_i K_l and the disturbance v = E_i w:

    u' = - sum_jil h_j h_i h_l K_j G_il x  -  sum_j h_j' K_j x  -  sum_ji h_j h_i K_j E_i w.

    motion        the first sum is a blend of the means of K_j G_il over the orders of (j, i, l);
                  |row k of each mean times x| is at most ``motion_k`` on the set
    memberships   the claim assumes |h_j'| <= phi_j (``membership_rates``); with sum_j h_j' = 0 the
                  second sum is largest at a corner d of these rates, and sum_j d_j K_j x there is
                  at most ``memberships_k``
    disturbance   the third sum is at most max_ji sum_l |K_j E_i|_kl b_l for |w_l| <= b_l; the
                  checker computes this bound

The three bounds together are at most ``rate_limits``_k.  If all rules share one gain, the first sum
is a blend of K G_i and the second is zero.  In discrete time memberships may jump to any h+:

    u(x+) - u(x) = - sum_lij h+_l h_i h_j (K_l G_ij - K_j) x  -  sum_li h+_l h_i K_l E_i w.

Evidence: ``rate_shares`` = {"motion": (m,), "memberships": (m,)}; the second, with
``membership_rates`` (r,), where gains differ in continuous time.  At most 24 rules with different
gains are allowed, and at most 10 where memberships move.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations_with_replacement, permutations, product
from math import comb

from takagi.certificates.checker.kernel.matrices import Matrix, mean
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative
from takagi.certificates.checker.kernel.reader import member, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.invariant_ellipsoid import Disturbance, InvariantSet
from takagi.certificates.checker.kinds.simplex_polynomial import corners_of_sum_zero
from takagi.certificates.checker.loop.box_of_validity import reaches_at_most
from takagi.certificates.checker.loop.halvings import pieces
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, at, bounded

MOST_RULES, MOST_MOVING = 24, 10


def rate_obligations(claim: InvariantSet, limits: Sequence[Fraction]) -> Obligations:
    """Yield what bounds the rate of every input, or its step, by ``limits``, (m,).

    Raises
    ------
    CertificateError : evidence that is missing or does not fit, too many rules.
    """
    loop, where, m = claim.loop, claim.where, len(limits)
    P, level = claim.P, claim.level
    shares = member(claim.claim, "rate_shares", where)
    motion = numbers(shares, "motion", f"{where}.rate_shares", m)
    for loop_piece in pieces(claim.claim, loop, where):
        for matrix in motion_rows(loop_piece, where, later=loop.K):
            for k in range(m):
                failure = f"input {k + 1} may move faster than its share with the state"
                yield reaches_at_most(P, level, matrix.row(k), motion[k], failure)
    total = [a + b for a, b in zip(motion, _pushed(loop, claim.disturbance, m), strict=True)]
    phi = assumed_rates(claim)
    if phi:
        moving = numbers(shares, "memberships", f"{where}.rate_shares", m)
        bounded(m * len(phi) << min(len(phi), MOST_MOVING), loop.order + 1)
        total = [a + b for a, b in zip(total, moving, strict=True)]
        for corner in membership_corners(phi, where):
            matrix = _combined(corner, loop.K)
            for k in range(m):
                failure = f"input {k + 1} may move faster than its share with memberships"
                yield reaches_at_most(P, level, matrix.row(k), moving[k], failure)
    for k in range(m):
        failure = f"the shares of input {k + 1} exceed its limit of rate"
        yield nonnegative(limits[k] - total[k], failure)


def assumed_rates(claim: InvariantSet) -> list[Fraction]:
    """Return the rates of memberships that the claim assumes; [] where it needs none."""
    if len(claim.loop.K) == 1 or claim.loop.is_discrete:
        return []
    return numbers(claim.claim, "membership_rates", claim.where, len(claim.loop.K))


def motion_rows(loop: PolytopicLoop, where: str, later: Stack | None = None) -> Iterator[Matrix]:
    """Yield matrices; for h' = 0 their blend times x is u', or u(x+) - u(x).

    Parameters
    ----------
    later : the gains K_l at the next sample if ``loop`` is a piece of the weights: the gains of
        all rules, because h+ may lie outside the piece of h.
    """
    r, (m, n) = loop.rules, loop.K[0].shape
    if len(loop.K) == 1:
        blends = loop.blends()
        bounded(m * len(blends), n + 1)
        for blend in blends:
            identity = Matrix.identity(loop.order)
            yield loop.K[0] @ (blend.A - identity if loop.is_discrete else blend.A)
        return
    if r > MOST_RULES:
        raise CertificateError(f"{where}: rates of more than {MOST_RULES} rules are not claimed")
    if loop.is_discrete:
        blends = loop.blends()
        later = later or loop.K
        bounded(m * len(later) * len(blends), n + 1)
        for gain in later:
            for blend in blends:
                yield gain @ blend.A - blend.K
        return
    if not loop.shared_weights:
        raise CertificateError(f"{where}: rates of a law with weights of its own are not claimed")
    bounded(m * comb(r + 2, 3), n + 1)
    loops = [[at(loop.A, i) - at(loop.B, i) @ K for K in loop.K] for i in range(r)]
    for chosen in combinations_with_replacement(range(r), 3):
        orders = sorted(set(permutations(chosen)))
        yield mean([loop.K[j] @ loops[i][k] for j, i, k in orders])


def _pushed(loop: PolytopicLoop, disturbance: Disturbance, m: int) -> list[Fraction]:
    """Return (m,): max_ji sum_l |K_j E_i|_kl b_l."""
    bounds = disturbance.each_bound
    largest = [Fraction(0)] * m
    for gain, entering in product(loop.K, disturbance.E):
        effect = gain @ entering
        for k in range(m):
            size = sum((abs(effect[k, i]) * b for i, b in enumerate(bounds)), Fraction(0))
            largest[k] = max(largest[k], size)
    return largest


def membership_corners(phi: Sequence[Fraction], where: str) -> Iterator[list[Fraction]]:
    """Yield the corners of {d : |d_j| <= phi_j, sum_j d_j = 0}: all but one entry are at a bound.

    Raises
    ------
    CertificateError : a negative rate, or more than ten.
    """
    if len(phi) > MOST_MOVING:
        raise CertificateError(
            f"{where}: at most {MOST_MOVING} memberships whose rates are bounded"
        )
    if any(rate < 0 for rate in phi):
        raise CertificateError(f"{where}.membership_rates: they are not negative")
    yield from corners_of_sum_zero(phi)


def _combined(weights: Sequence[Fraction], stack: Sequence[Matrix]) -> Matrix:
    total = weights[0] * stack[0]
    for weight, matrix in zip(weights[1:], stack[1:], strict=True):
        total = total + weight * matrix
    return total
