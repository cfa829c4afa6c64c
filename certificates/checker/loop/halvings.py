r"""Subdivision of the weights into pieces; the claim is proved on each piece separately.

The loop is sum_ij h_i h_j G_ij.  On a piece of the weights with corners v^1, ..., v^r it is the
same sum with A(v^k), B(v^k), K(v^k) in the place of A_i, B_i, K_i: a proof for the means of its
pairs holds for every weight of the piece.  On the whole simplex (G_ij + G_ji)/2 may fail though
no blend does; on pieces of size d the means are within d^2 of blends.

A halving cuts between two corners i and j: the one piece has the middle in the place of j, the
other in that of i, and together they are the whole.  Where weights are products it is the range of
one premise that is halved.

Evidence: ``halvings``, a tree in preorder: [premise, i, j] is a halving, whose first piece has the
middle in the place of j, [] a piece to be shown.  Rules are the corners of premise 0 where weights
are no products.  Left out: one piece.  The law has the model's weights, or one gain.
``fuzzy-decay`` puts the weights of a piece into its polynomials.

Proof and alternatives: docs/blends.md.  Source: the Bernstein form under subdivision, Leroy (2012),
Reliable Computing 17, recalled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, TypeVar

from takagi.certificates.checker.kernel.matrices import mean
from takagi.certificates.checker.kernel.reader import numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, bounded

T = TypeVar("T")


def pieces(claim: Any, loop: PolytopicLoop, where: str) -> Iterator[PolytopicLoop]:
    """Yield the loop on every piece of its weights.

    Raises
    ------
    CertificateError : not a whole tree, weights that are not the law's, rules without all corners.
    """
    return leaves(claim, loop, where, loop, halved)


def leaves(
    claim: Any, loop: PolytopicLoop, where: str, undivided: T, halve: Callable[..., T]
) -> Iterator[T]:
    """Yield ``undivided`` on every piece; ``halve(piece, premise, fixed, moving)`` halves a piece.

    Raises
    ------
    CertificateError : as ``pieces``.
    """
    if "halvings" not in claim:
        yield undivided
        return
    listed, corners = claim["halvings"], loop.corners
    if not loop.shared_weights and len(loop.K) > 1:
        raise CertificateError(f"{where}.halvings: the law has weights of its own")
    premises, sides = (len(corners[0]), 2) if corners else (1, loop.rules)
    if sides**premises != loop.rules:
        raise CertificateError(f"{where}.halvings: the rules leave out corners")
    if not isinstance(listed, list):
        raise CertificateError(f"{where}.halvings: a list is needed")
    bounded(len(listed) * len(loop.groups()), loop.order)
    remaining = [undivided]
    for entry in listed:
        if not remaining:
            raise CertificateError(f"{where}.halvings: more entries than pieces")
        current = remaining.pop()
        if entry == []:
            yield current
            continue
        premise, i, j = (int(v) if v.denominator == 1 else -1 for v in
                         numbers({"halvings": entry}, "halvings", where, 3))  # fmt: skip
        if not 0 <= premise < premises or not 0 <= min(i, j) < max(i, j) < sides:
            raise CertificateError(f"{where}.halvings: a premise and two corners are needed")
        remaining += [halve(current, premise, j, i), halve(current, premise, i, j)]
    if remaining:
        raise CertificateError(f"{where}.halvings: {len(remaining)} pieces are left out")


def halved(loop: PolytopicLoop, premise: int, fixed: int, moving: int) -> PolytopicLoop:
    """Return the loop on half of its weights: corner ``moving`` goes to the middle of the two."""
    corners = loop.corners or tuple((i,) for i in range(loop.rules))
    index = {corner: i for i, corner in enumerate(corners)}
    partner = [index[(*c[:premise], fixed, *c[premise + 1 :])] if c[premise] == moving else i
               for i, c in enumerate(corners)]  # fmt: skip

    def half(stack: Stack) -> Stack:
        if len(stack) <= 1:
            return stack
        return tuple(stack[i] if i == j else mean([stack[i], stack[j]]).reduced()
                     for i, j in enumerate(partner))  # fmt: skip

    A, B, C, D, E, K = map(half, (loop.A, loop.B, loop.C, loop.D, loop.E, loop.K))
    return replace(
        loop, A=A, B=B, C=C, D=D, E=E, K=K, extra_stacks=tuple(map(half, loop.extra_stacks))
    )
