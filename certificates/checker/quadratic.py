r"""Replays claims about Takagi-Sugeno models with a common quadratic function.

``quadratic-decay``: A_i'P + PA_i + 2 alpha P < 0 at every vertex, P > 0; with gains, at every
blend: G_ij = A_i - B_i K_j, G_ii and G_ij + G_ji (i < j).  Then V = x'Px decays as
exp(-2 alpha t) for any memberships that are nonnegative and sum to one.

``no-common-quadratic``: Z_i = L_i L_i', not all zero, with sum_i (A_i Z_i + Z_i A_i') + 2 alpha
sum_i Z_i >= 0: then no P > 0 can satisfy the inequalities above with vertices A_i, for they would
give 0 > sum tr Z_i (A_i'P + PA_i + 2 alpha P) = tr P (...) >= 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1, and 2.2 for the alternatives.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.definite import is_positive_definite, is_positive_semidefinite
from takagi.certificates.checker.reader import matrix, member, number
from takagi.certificates.checker.refusal import CertificateError
from takagi.certificates.checker.result import Claim, Verdict
from takagi.certificates.checker.shown import at_least, at_most

__all__ = ["check_impossibility", "check_quadratic"]

Rows = list[list[Fraction]]
# Exact elimination beyond this would keep a reader waiting for minutes.
LARGEST = 80


def check_quadratic(claim: Any, where: str) -> Claim:
    """Return the verdict on a claim of kind ``quadratic-decay``."""
    name = str(member(claim, "name", where))
    A = _family(claim, "A", where)
    alpha, P = number(claim, "decay_rate", where), matrix(claim, "P", where)
    n = len(A[0])
    if any(len(M) != n or any(len(row) != n for row in M) for M in [*A, P]):
        raise CertificateError(f"{where}: every A and P must be {n} by {n}")
    if alpha < 0:
        return Claim(name, Verdict.UNDECIDED, "the decay rate is negative")
    if not is_positive_definite(P):
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    for label, G, times in _closed_loops(claim, A, where):
        if not is_positive_definite(_negated_lyapunov(G, P, times * alpha)):
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {label}")
    about = "every blend of the vertices" if "K" not in claim else "every blend of rules and gains"
    return Claim(
        name,
        Verdict.PROVED,
        f"V = x'Px decays as exp(-{at_least(2 * alpha, 6)} t) along {about} ({len(A)} vertices)",
    )


def check_impossibility(claim: Any, where: str) -> Claim:
    """Return DISPROVED when the multipliers show that no common P exists, else UNDECIDED."""
    name = str(member(claim, "name", where))
    A, L = _family(claim, "A", where), _family(claim, "multiplier_factors", where)
    alpha = number(claim, "decay_rate", where)
    n = len(A[0])
    if len(L) != len(A) or any(len(M) != n for M in [*A, *L]) or any(len(M[0]) != n for M in A):
        raise CertificateError(f"{where}: one factor with {n} rows per vertex is needed")
    total = [[Fraction(0)] * n for _ in range(n)]
    weight = Fraction(0)
    for vertex, factor in zip(A, L, strict=True):
        Z = _times(factor, _transposed(factor))
        AZ = _times(vertex, Z)
        weight += sum(Z[i][i] for i in range(n))
        for i in range(n):
            for j in range(n):
                total[i][j] += AZ[i][j] + AZ[j][i] + 2 * alpha * Z[i][j]
    if weight <= 0 or not is_positive_semidefinite(total):
        return Claim(name, Verdict.UNDECIDED, "the multipliers do not exclude a common P")
    return Claim(
        name,
        Verdict.DISPROVED,
        f"no common quadratic function with decay rate {at_most(alpha, 6)} 1/s exists for these "
        f"{len(A)} vertices",
    )


def _closed_loops(claim: Any, A: list[Rows], where: str) -> list[tuple[str, Rows, int]]:
    """Return (label, matrix, k) with matrix' P + P matrix + 2 k alpha P < 0 to be shown."""
    if "K" not in claim:
        return [(f"vertex {i + 1}", M, 1) for i, M in enumerate(A)]
    B, K = _family(claim, "B", where), _family(claim, "K", where)
    n, m = len(A[0]), len(B[0][0])
    if len(B) != len(A) or len(K) != len(A):
        raise CertificateError(f"{where}: one B and one K per rule are needed")
    if any(len(M) != n or len(M[0]) != m for M in B) or any(
        len(M) != m or len(M[0]) != n for M in K
    ):
        raise CertificateError(f"{where}: B must be {n} by {m} and K {m} by {n}")
    G = [[_minus(A[i], _times(B[i], K[j])) for j in range(len(A))] for i in range(len(A))]
    loops = [(f"rule {i + 1}", G[i][i], 1) for i in range(len(A))]
    for i in range(len(A)):
        for j in range(i + 1, len(A)):
            loops.append((f"rules {i + 1} and {j + 1}", _plus(G[i][j], G[j][i]), 2))
    return loops


def _negated_lyapunov(G: Rows, P: Rows, alpha: Fraction) -> Rows:
    PG = _times(P, G)
    n = range(len(P))
    return [[-PG[i][j] - PG[j][i] - 2 * alpha * P[i][j] for j in n] for i in n]


def _family(claim: Any, key: str, where: str) -> list[Rows]:
    family = member(claim, key, where)
    if not isinstance(family, list) or not family:
        raise CertificateError(f"{where}.{key}: a list of matrices is needed")
    holder = {str(i): item for i, item in enumerate(family)}
    found = [matrix(holder, i, f"{where}.{key}") for i in holder]
    if any(len(M) > LARGEST or len(M[0]) > LARGEST for M in found):
        raise CertificateError(f"{where}.{key}: matrices go to {LARGEST} by {LARGEST}")
    return found


def _times(left: Rows, right: Rows) -> Rows:
    columns = list(zip(*right, strict=True))
    zero = Fraction(0)
    return [
        [sum((a * b for a, b in zip(row, c, strict=True)), zero) for c in columns] for row in left
    ]


def _transposed(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def _plus(left: Rows, right: Rows) -> Rows:
    return [[a + b for a, b in zip(p, q, strict=True)] for p, q in zip(left, right, strict=True)]


def _minus(left: Rows, right: Rows) -> Rows:
    return [[a - b for a, b in zip(p, q, strict=True)] for p, q in zip(left, right, strict=True)]
