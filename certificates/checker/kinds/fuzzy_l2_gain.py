r"""``fuzzy-l2-gain``: the energy gain of a loop by V = x'P(w)x, P a polynomial in the weights.

    x' = G(w) x + E(w) d,   y = C(w) x + D(w) d        (x+ in the place of x' in discrete time)

is the closed loop, d the disturbance, w the weights, as for ``fuzzy-decay``.  With gamma > 0 the
following polynomials are multiplied by the power ``polya`` of the sum of the weights, which is 1;
then every coefficient must be positive definite:

    P(w) > 0
    continuous   [ -(P G + G'P + sum_kc v_kc dP/dw_kc)(w)   -P(w) E(w)   C(w)'   ]
                 [ .                                        gamma I      D(w)'   ] > 0
                 [ .                                        .            gamma I ]
                 at every corner v of the speeds |v_kc| <= rate_kc, sum_c v_kc = 0
    discrete     [ P(w)   0         C(w)'     G(w)'P_b ]
                 [ .      gamma I   D(w)'     E(w)'P_b ]
                 [ .      .         gamma I   0        ]
                 [ .      .         .         P_b      ] > 0     for every P_b

with P_b the Bernstein coefficients of P.

Theorem.  Then |y|_2 <= gamma |d|_2 from x(0) = 0; in continuous time this holds for all weights
whose rates keep their bounds.  Proof: by a Schur complement with the last row and column, the
continuous inequality says V' < gamma |d|^2 - |y|^2 / gamma for (x, d) other than 0.  Here
V' = 2 x'P (G x + E d) + x'(dP/dt)x, and dP/dt = sum_kc w_kc' dP/dw_kc is affine in the speeds,
which lie in the hull of the corners.  The integral from 0, with V(0) = 0 and V >= 0, is the claim.
In discrete time P at the next sample is a convex combination of the P_b, and the inequality is
affine in P_b: the Schur complement with that combination gives
V(x+) - V < gamma |d|^2 - |y|^2 / gamma, and the sum over all samples is the claim.  The weights may
jump.

Evidence: ``degrees``, ``P``, ``rates``, ``polya`` and ``halvings`` as for ``fuzzy-decay``;
``gain``, and the channel, ``disturbance`` and ``output``, as for ``l2-gain``.  Refused for weights
that are averages, and for a law with weights of its own.

Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7), for polynomial P; Gahinet
and Apkarian (1994), Int. J. Robust and Nonlinear Control 4, for the bounded real lemma; recalled.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.disturbance_channel import (
    channel_stacks,
    scaled_identity,
    zero,
)
from takagi.certificates.checker.kinds.fuzzy_decay import (
    ScheduledFunction,
    closed_polynomial,
    constant_polynomial,
    scheduled_function,
)
from takagi.certificates.checker.kinds.simplex_polynomial import Exponent, Polynomial, exponents
from takagi.certificates.checker.loop.halvings import leaves
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

Asked = list[tuple[Polynomial, str]]


def check_fuzzy_l2_gain(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED if every coefficient is definite, else UNDECIDED with the first that fails."""
    name, gain = text(claim, "name", where), number(claim, "gain", where)
    if gain <= 0:
        raise CertificateError(f"{where}.gain: a positive number is needed")
    asked, function = gain_inequalities(claim, loop, where)
    for condition, words in asked:
        for piece in leaves(claim, loop, where, condition, Polynomial.halved):
            fault = piece.failing()
            if fault:
                return Claim(name, Verdict.UNDECIDED, f"{words} {fault}")
    said = {"name": name, "claim": claim, "loop": loop, "gain": gain}
    return Found(Verdict.PROVED, "fuzzy_l2_gain", said | {"rates": function.rates})


def gain_inequalities(
    claim: Any, loop: PolytopicLoop, where: str
) -> tuple[Asked, ScheduledFunction]:
    """Return the polynomials to be positive definite, each with a message, and P(w)."""
    gain = number(claim, "gain", where)
    whole, entering, direct = channel_stacks(claim, loop, where)
    n, q, p = loop.order, entering[0].shape[1], whole.C[0].shape[0]
    order = 2 * n + q + p if loop.is_discrete else n + q + p
    found = scheduled_function(claim, loop, where, order)
    G = closed_polynomial(loop, loop.A, loop.B, where)
    E = closed_polynomial(whole, entering, (), where)
    C = closed_polynomial(whole, whole.C, whole.D, where)
    D = constant_polynomial(loop, zero(p, q))
    for stack in direct:
        D = D + closed_polynomial(whole, stack, (), where)
    asked: Asked = [(found.P, "P is not shown to be positive:")]
    if loop.is_discrete:
        words = "the inequality at the next sample fails at"
        asked += [(_jump(found.P, b, G, E, C, D, gain), words) for b in found.coefficients]
    else:
        words = "the inequality at a corner of the rates fails at"
        PG, PE = found.P @ G, found.P @ E
        asked += [
            (_flow(-(PG + PG.T + found.P.derivative(v)), PE, C, D, gain), words)
            for v in found.speeds
        ]
    more = [found.polya] * len(found.P.sizes)
    return [(X.raised(more), words) for X, words in asked], found


def _flow(
    top: Polynomial, PE: Polynomial, C: Polynomial, D: Polynomial, gain: Fraction
) -> Polynomial:
    """Return the module's matrix of continuous time."""
    n, q = next(iter(PE.terms.values())).shape
    p = next(iter(C.terms.values())).shape[0]
    return blocks(
        [
            [top, -PE, C.T],
            [-PE.T, scaled_identity(q, gain), D.T],
            [C, D, scaled_identity(p, gain)],
        ],
        (n, q, p),
    )


def _jump(
    P: Polynomial,
    b: Matrix,
    G: Polynomial,
    E: Polynomial,
    C: Polynomial,
    D: Polynomial,
    gain: Fraction,
) -> Polynomial:
    """Return the module's matrix of discrete time, for one P_b at the next sample."""
    q, p = next(iter(E.terms.values())).shape[1], next(iter(C.terms.values())).shape[0]
    moved, driven = _times(b, G), _times(b, E)
    n = b.shape[0]
    return blocks(
        [
            [P, zero(n, q), C.T, moved.T],
            [zero(q, n), scaled_identity(q, gain), D.T, driven.T],
            [C, D, scaled_identity(p, gain), zero(p, n)],
            [moved, driven, zero(n, p), b],
        ],
        (n, q, p, n),
    )


def _times(b: Matrix, X: Polynomial) -> Polynomial:
    return Polynomial(X.sizes, X.degrees, {a: b @ M for a, M in X.terms.items()})


def blocks(grid: list[list[Polynomial | Matrix]], sides: tuple[int, ...]) -> Polynomial:
    """Return a block matrix of polynomials and of constants as one polynomial.

    Parameters
    ----------
    sides : the sizes of the blocks.
    """
    parts = [entry for row in grid for entry in row if isinstance(entry, Polynomial)]
    sizes = parts[0].sizes
    degrees = tuple(max(each) for each in zip(*(part.degrees for part in parts), strict=True))
    raised: list[list[dict[Exponent, Matrix]]] = []
    for row in grid:
        raised.append([])
        for entry in row:
            if isinstance(entry, Matrix):
                flat = tuple((0,) * size for size in sizes)
                entry = Polynomial(sizes, (0,) * len(sizes), {flat: entry})
            raised[-1].append(dict(entry.to(degrees).terms))
    terms = {
        a: Matrix.blocks(
            [
                [cell[a] if a in cell else zero(sides[i], sides[j]) for j, cell in enumerate(row)]
                for i, row in enumerate(raised)
            ]
        )
        for a in exponents(sizes, degrees)
    }
    return Polynomial(sizes, degrees, terms)
