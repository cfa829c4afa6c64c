r"""The loop on pieces of the set of its weights; a piece is given by the weights at its corners.

    h = sum_k t_k v^k,    t >= 0, sum_k t_k = 1,    v^k the weights at corner k of a piece,

so that sum_i h_i X_i = sum_k t_k X(v^k): the piece is a loop with rules X(v^k) and weights t.
Where weights are products, v^k is the product of the weights at the ends of a range of each
premise.

``halvings`` lists the nodes of a tree, each node before its branches.  [premise, i, j] cuts at the
middle between corners i and j: in the first branch the middle replaces corner j, in the second
corner i.  [] is a leaf.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import prod
from typing import Any, TypeAlias

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import scaled
from takagi.certificates.cross_check.kernel.reading import Refusal, rational_row
from takagi.certificates.cross_check.loop.loop import Mixture, Stack, VertexLoop

# For each premise, or for the rules as the only one: the weights at the corners of a piece.
Ends: TypeAlias = tuple[tuple[tuple[fmpq, ...], ...], ...]
MOST_LEAVES = 20_000


def mixtures(claim: Any, loop: VertexLoop) -> Iterator[Mixture]:
    """Yield the mixtures of the loop on every piece."""
    for piece in pieces(claim, loop):
        yield from piece.mixtures()


def pieces(claim: Any, loop: VertexLoop) -> Iterator[VertexLoop]:
    """Yield the loop on every piece; the loop itself where the claim has no ``halvings``."""
    if "halvings" not in claim:
        yield loop
        return
    if not (loop.together or len(loop.K) <= 1):
        raise Refusal("halvings: of a law with weights of its own")
    sizes = [loop.rules] if loop.corners is None else [2] * len(loop.corners[0])
    if prod(sizes) != loop.rules:
        raise Refusal("halvings: the rules leave out a combination of corners")
    for ends in leaves(claim, sizes):
        h = corner_weights(loop, ends)
        yield replace(
            loop,
            A=combined(loop.A, h),
            B=combined(loop.B, h),
            C=combined(loop.C, h),
            D=combined(loop.D, h),
            E=combined(loop.E, h),
            K=combined(loop.K, h),
            beside=tuple(combined(one, h) for one in loop.beside),
        )


def corner_weights(loop: VertexLoop, ends: Ends) -> list[list[fmpq]]:
    """Return h at the corners of a piece, (rules, rules)."""
    rows = [(i,) for i in range(loop.rules)] if loop.corners is None else loop.corners
    return [
        [prod((ends[p][c][d] for p, (c, d) in enumerate(zip(at, rule, strict=True))), start=fmpq(1))
         for rule in rows]
        for at in rows
    ]  # fmt: skip


def combined(matrices: Stack, h: list[list[fmpq]]) -> Stack:
    """Return X(v^k) for every corner; a stack of one matrix is returned as it is."""
    if len(matrices) <= 1:
        return matrices
    found = []
    for row in h:
        total = scaled(row[0], matrices[0])
        for share, one in zip(row[1:], matrices[1:], strict=True):
            if share != 0:
                total = total + scaled(share, one)
        found.append(total)
    return found


def leaves(claim: Any, sizes: list[int]) -> Iterator[Ends]:
    """Yield the corners of every leaf of the tree."""
    nodes = claim["halvings"]
    if not isinstance(nodes, list) or not 0 < len(nodes) <= 2 * MOST_LEAVES:
        raise Refusal("halvings: a tree is needed")
    rest = iter(nodes)
    start = tuple(
        tuple(tuple(fmpq(int(i == j)) for j in range(n)) for i in range(n)) for n in sizes
    )
    waiting: list[Ends] = [start]
    while waiting:
        ends = waiting.pop()
        node = next(rest, None)
        if node is None:
            raise Refusal("halvings: the tree is not whole")
        if node == []:
            yield ends
            continue
        row = rational_row(node, "halvings", 3)
        p, i, j = (int(v.p) if v.q == 1 else -1 for v in row)
        if p not in range(len(sizes)) or i == j or {i, j} - set(range(sizes[p])):
            raise Refusal("halvings: a premise and two of its corners are needed")
        waiting += [_with_middle(ends, p, j, i), _with_middle(ends, p, i, j)]
    if next(rest, None) is not None:
        raise Refusal("halvings: more nodes than the tree has")


def _with_middle(ends: Ends, premise: int, other: int, place: int) -> Ends:
    """Return the piece in which the middle of two corners replaces the corner ``place``."""
    rows = ends[premise]
    middle = tuple((a + b) / 2 for a, b in zip(rows[place], rows[other], strict=True))
    changed = tuple(middle if k == place else row for k, row in enumerate(rows))
    return tuple(changed if p == premise else own for p, own in enumerate(ends))
