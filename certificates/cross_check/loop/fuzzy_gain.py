r"""``fuzzy-l2-gain``: |y|_2 <= g |d|_2 from rest, by V = x'P(w)x with P a polynomial in weights w.

The storage of x' (or x+) = G x + E d, y = C x + D d, all of them polynomials in w, is shown by the
coefficients of the symmetric matrices

    continuous   [[-(P G + G'P + sum_kc v_kc dP/dw_kc), -P E, C'], [., g I, D'], [., ., g I]]
                 at each corner v of the rates,
    discrete     [[P, 0, C', G'P_b], [., g I, D', E'P_b], [., ., g I, 0], [., ., ., P_b]]
                 for each coefficient P_b of P,

and by those of P itself.  They are tested as ``fuzzy-decay`` does: after multiplication by
(sum_c w_kc)^polya = 1, on each piece of the weights.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from flint import fmpq_mat

from takagi.certificates.cross_check.kernel.exact import blocks, identity, scaled, transposed, zeros
from takagi.certificates.cross_check.kernel.obligation import Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, rational, whole
from takagi.certificates.cross_check.loop.disturbed import channel_of
from takagi.certificates.cross_check.loop.fuzzy import (
    HIGHEST,
    Simplexes,
    Terms,
    along,
    each,
    function_of,
    pieces_of,
    positive_on_pieces,
    speeds_of,
    times,
)
from takagi.certificates.cross_check.loop.loop import Stack, VertexLoop


def fuzzy_l2_gain(claim: Any, loop: VertexLoop) -> Obligations:
    """Yield the conditions of the module's text."""
    where = Simplexes(loop)
    g, polya = rational(claim, "gain"), whole(claim, "polya")
    if g <= 0 or not 0 <= polya <= HIGHEST:
        raise Refusal(f"gain: a positive number; polya: 0 to {HIGHEST}")
    if loop.averages and loop.rules > 1:
        raise Refusal("P depends on weights that are averages over a segment")
    if len(loop.K) > 1 and not loop.together:
        raise Refusal("a law with weights of its own")
    seen, entering, direct = channel_of(claim, loop)
    P, coefficients = function_of(claim, loop, where)
    G, C = (_closed(where, loop, X, Y) for X, Y in ((loop.A, loop.B), (seen.C, seen.D)))
    E = where.stack(entering)
    n, q, p = loop.n, entering[0].ncols(), seen.C[0].nrows()
    D: Terms = {where.none: zeros(p, q)}
    for one in direct:
        D = where.total(D, where.stack(one))
    cut = pieces_of(claim, loop, where)
    positive = partial(positive_on_pieces, where, cut, polya)
    yield from positive(P, "P", n)
    if loop.step is not None:
        room = _Room(where, (n, q, p, n))
        for k, Pb in enumerate(coefficients):
            left = room.total(
                (0, 0, P),
                (1, 1, {where.none: scaled(g, identity(q))}),
                (2, 2, {where.none: scaled(g, identity(p))}),
                (3, 3, {where.none: Pb}),
                (2, 0, C),
                (2, 1, D),
                (3, 0, {a: Pb * X for a, X in G.items()}),
                (3, 1, {a: Pb * X for a, X in E.items()}),
            )
            yield from positive(left, f"gain at the next sample {k + 1}", 2 * n + q + p)
        return
    room = _Room(where, (n, q, p))
    PG = times(P, G)
    still = where.total(PG, {a: transposed(X) for a, X in PG.items()})
    for k, speeds in enumerate(speeds_of(claim, where, P)):
        moved = along(where, P, speeds)
        left = room.total(
            (0, 0, each(where.total(still, moved) if moved else still, -1)),
            (1, 1, {where.none: scaled(g, identity(q))}),
            (2, 2, {where.none: scaled(g, identity(p))}),
            (0, 1, each(times(P, E), -1)),
            (2, 0, C),
            (2, 1, D),
        )
        yield from positive(left, f"gain at corner {k + 1}", n + q + p)


def _closed(where: Simplexes, loop: VertexLoop, X: Stack, Y: Stack) -> Terms:
    """Return X(w) - Y(w) K(w)."""
    if not loop.K or not Y:
        return where.stack(X)
    return where.total(where.stack(X), each(times(where.stack(Y), where.stack(loop.K)), -1))


class _Room:
    """Symmetric matrices of blocks of some sizes."""

    def __init__(self, where: Simplexes, sizes: tuple[int, ...]) -> None:
        self.where, self.sizes = where, sizes

    def total(self, *parts: tuple[int, int, Terms]) -> Terms:
        """Return the sum of polynomials (i, j, X), each at block (i, j) and mirrored."""
        return self.where.total(*self._placed(parts))

    def _placed(self, parts: tuple[tuple[int, int, Terms], ...]) -> Iterator[Terms]:
        for i, j, terms in parts:
            yield {a: self._whole(i, j, X) for a, X in terms.items()}

    def _whole(self, i: int, j: int, X: fmpq_mat) -> fmpq_mat:
        grid = [[zeros(r, c) for c in self.sizes] for r in self.sizes]
        grid[i][j] = X
        if i != j:
            grid[j][i] = transposed(X)
        return blocks(grid)
