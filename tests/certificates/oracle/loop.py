r"""The closed loop of a model and a law, and the matrices of which it is a convex combination.

    x' (or x+) = sum_i sum_j h_i g_j (A_i - B_i K_j) x,     h, g >= 0, each with the sum one

Terms whose products of weights are always equal may be replaced by their mean.  These are (i, j)
and (j, i) where g = h; and where h_i = prod_k w_k,c(i,k), all pairs that have the same two corners
in each premise.  ``Mixture`` is such a set of pairs.  The loop is in the convex hull of its
mixtures.

The loop on pieces of the set of its weights; a piece is given by the weights at its corners.

    h = sum_k t_k v^k,    t >= 0, sum_k t_k = 1,    v^k the weights at corner k of a piece,

so that sum_i h_i X_i = sum_k t_k X(v^k): the piece is a loop with rules X(v^k) and weights t.
Where weights are products, v^k is the product of the weights at the ends of a range of each
premise.

``halvings`` lists the nodes of a tree, each node before its branches.  [premise, i, j] cuts at the
middle between corners i and j: in the first branch the middle replaces corner j, in the second
corner i.  [] is a leaf.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from fractions import Fraction
from math import prod
from typing import Any, TypeAlias

from flint import fmpq, fmpq_mat

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.model_loop import read_model_loop
from takagi.certificates.checker.loop.polytopic_loop import SECANTS, PolytopicLoop
from tests.certificates.oracle.exact import mean, scaled
from tests.certificates.oracle.reading import Refusal, rational_row

Stack = Sequence[fmpq_mat]
Side = tuple[fmpq, fmpq]
MOST_MIXTURES = 200_000


@dataclass(frozen=True, slots=True)
class VertexLoop:
    """The matrices of each rule; a stack of one matrix is the same for all rules, or empty.

    ``sides`` : the range of each state, None where it has none.
    ``other_sides`` : the ranges of the other variables that the box names.
    ``seen_by`` : the names on which premises depend; empty where the model does not state them.
    ``together`` : the gains have the weights of the model, g = h.
    ``stated`` : the model's count of rules, also where a claim leaves some matrices out.
    ``averages`` : the weights are means over the segment from rest to the state, as for a secant
    model; no law, observer or output can know them.
    ``beside`` : further stacks that a claim needs, by rule.
    ``extremes`` : the loop with its constants at the other ends of their bounds.
    """

    A: Stack
    _: KW_ONLY
    B: Stack = ()
    C: Stack = ()
    D: Stack = ()
    E: Stack = ()
    K: Stack = ()
    step: fmpq | None = None
    states: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    pushes: tuple[str, ...] = ()
    sides: tuple[Side | None, ...] = ()
    other_sides: dict[str, Side] = field(default_factory=dict)
    corners: tuple[tuple[int, ...], ...] | None = None
    seen_by: tuple[str, ...] = ()
    together: bool = True
    stated: int = 1
    averages: bool = False
    beside: tuple[Stack, ...] = ()
    extremes: tuple[VertexLoop, ...] = ()

    @property
    def n(self) -> int:
        return int(self.A[0].nrows())

    @property
    def rules(self) -> int:
        stacks = (self.A, self.B, self.C, self.D, self.E)
        return max(self.stated, *(len(matrices) for matrices in stacks))

    def mixtures(self) -> list[Mixture]:
        """Return the mixtures whose convex hull contains the loop."""
        r, s = self.rules, len(self.K)
        # With one gain, or one B and D for all rules, A - B K is affine in the weights: no product.
        straight = s <= 1 or (self.together and len(self.B) <= 1 and len(self.D) <= 1)
        if straight:
            return [Mixture(self, ((i, i),)) for i in range(r)]
        return [Mixture(self, pairs) for pairs in self.pairs(s)]

    def pairs(self, gains: int) -> list[tuple[tuple[int, int], ...]]:
        """Return all pairs (rule, gain), grouped by their product of weights."""
        if self.rules * gains > MOST_MIXTURES:
            raise Refusal(f"{self.rules} rules and {gains} gains: too many pairs")
        sets: dict[Any, list[tuple[int, int]]] = {}
        for i in range(self.rules):
            for j in range(gains):
                if not self.together:
                    key: Any = (i, j)
                elif self.corners is None:
                    key = (min(i, j), max(i, j))
                else:
                    key = tuple(
                        (min(p, q), max(p, q))
                        for p, q in zip(self.corners[i], self.corners[j], strict=True)
                    )
                sets.setdefault(key, []).append((i, j))
        return [tuple(members) for members in sets.values()]


@dataclass(frozen=True, slots=True)
class Mixture:
    """The mean of A_i - B_i K_j, and of other matrices, over some pairs (i, j)."""

    loop: VertexLoop
    pairs: tuple[tuple[int, int], ...]

    @property
    def label(self) -> str:
        i, j = self.pairs[0]
        return f"rules {i + 1}, {j + 1}"

    @property
    def A(self) -> fmpq_mat:
        return self.closed(self.loop.A, self.loop.B)

    @property
    def C(self) -> fmpq_mat:
        return self.closed(self.loop.C, self.loop.D)

    @property
    def K(self) -> fmpq_mat:
        return mean(pick(self.loop.K, j) for _, j in self.pairs)

    def of(self, matrices: Stack) -> fmpq_mat:
        """Return the mean of the matrices of the rules i."""
        return mean(pick(matrices, i) for i, _ in self.pairs)

    def closed(self, X: Stack, Y: Stack) -> fmpq_mat:
        """Return the mean of X_i - Y_i K_j."""
        K = self.loop.K
        if not K or not Y:
            return self.of(X)
        return mean(pick(X, i) - pick(Y, i) * pick(K, j) for i, j in self.pairs)


def pick(matrices: Stack, i: int) -> fmpq_mat:
    """Return matrix i of a stack, or its only matrix, which is that of all rules."""
    if not matrices:
        raise Refusal("a matrix that the model does not have is needed")
    return matrices[0] if len(matrices) == 1 else matrices[i]


def read_loop(model: Any, gains: Any) -> VertexLoop:
    """Return the loop that the checker reads, with the matrices of each rule.

    Raises
    ------
    CertificateError : model and gains do not fit.
    """
    return _converted(read_model_loop(model, gains))


def _converted(loop: PolytopicLoop) -> VertexLoop:
    return VertexLoop(
        _stack(loop.A),
        B=_stack(loop.B),
        C=_stack(loop.C),
        D=_stack(loop.D),
        E=_stack(loop.E),
        K=_stack(loop.K),
        step=None if loop.sample_time is None else _fmpq(loop.sample_time),
        states=loop.states,
        inputs=loop.inputs,
        pushes=loop.disturbances,
        sides=tuple(None if side is None else _side(side) for side in loop.box),
        other_sides={name: _side(side) for name, side in (loop.other_box or {}).items()},
        corners=loop.corners,
        seen_by=loop.scheduled_by or (),
        together=loop.shared_weights,
        stated=loop.stated_rules,
        averages=loop.weights == SECANTS,
        extremes=tuple(map(_converted, loop.at_other_ends)),
    )


def _stack(matrices: Sequence[Matrix]) -> Stack:
    return [_matrix(matrix) for matrix in matrices]


def _matrix(matrix: Matrix) -> fmpq_mat:
    return fmpq_mat([[fmpq(v, matrix.below) for v in row] for row in matrix.rows])


def _side(side: tuple[Fraction, Fraction]) -> Side:
    return _fmpq(side[0]), _fmpq(side[1])


def _fmpq(value: Fraction) -> fmpq:
    return fmpq(value.numerator, value.denominator)


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
            beside=tuple(combined(matrices, h) for matrices in loop.beside),
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
    combinations = []
    for row in h:
        total = scaled(row[0], matrices[0])
        for share, matrix in zip(row[1:], matrices[1:], strict=True):
            if share != 0:
                total = total + scaled(share, matrix)
        combinations.append(total)
    return combinations


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
    return tuple(changed if p == premise else corner_rows for p, corner_rows in enumerate(ends))
