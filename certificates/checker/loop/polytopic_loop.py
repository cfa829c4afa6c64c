r"""The loop that claims are about, with exact numbers: vertices, gains and their weights.

    x' = sum_i h_i (A_i x + B_i u + E_i w),   y = sum_i h_i (C_i x + D_i u),   u = -sum_j g_j K_j x

or x+ in place of x' in discrete time, for any weights >= 0 with sum one that may vary freely.
The loop is the double sum of h_i g_j (A_i - B_i K_j).  Pairs whose products of weights are equal
are added up: a matrix inequality that is affine in the matrices of a pair holds along the loop
when it holds for the mean of each such group, a ``Blend``.  Which products are equal:

    (i, j) and (j, i)        where the law has the weights of the model, g = h
    equal corners            where h_i = prod_k w_k,c_ik besides: the corners {c_ik, c_jk} agree
    a pair by itself         where the law has its own weights, or the model's weights depend
                             on the command; and where the weights are averages

One gain for all rules, or one B and one D with g = h, makes the loop affine in the weights. Then it
suffices to check the rules.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

from takagi.certificates.checker.kernel.matrices import Matrix, mean
from takagi.certificates.checker.kernel.refusal import CertificateError

if TYPE_CHECKING:
    # Most laws have no observer: its module is not loaded for them.
    from takagi.certificates.checker.loop.observer_law import ObserverLaw

Stack = tuple[Matrix, ...]
Pairs = tuple[tuple[int, int], ...]
Side = tuple[Fraction, Fraction]
Box = tuple[Side | None, ...]
# Weights that are mean slopes from the equilibrium to the state: see ``averaged``.
SECANTS = "secants"
# The time of exact elimination grows as the fourth power of the order: at most two minutes.
MOST_PAIRS, MOST_WORK = 1 << 20, 10**8


@dataclass(frozen=True)
class PolytopicLoop:
    """Vertices and gains; a stack of one matrix applies to all rules, an empty stack means none.

    x and u are deviations from the equilibrium. For a ``plant`` this is the law's trim, which the
    claim ``sector-embedding`` compares; for matrices alone it is the point they refer to.

    ``box`` : per state, its range in the coordinates of x, or None; ``other_box`` : the ranges of
    box variables that are not states.  ``corners`` : c_ik per rule, where weights are products;
    ``weights`` : see ``weights_of``.  ``scheduled_by`` : the variables that the premises depend
    on, or None where the model does not say.  ``stated_rules`` : the number of rules of the model,
    also when a claim leaves some stacks out. ``extra_stacks`` : stacks of a claim, by rule.
    ``resting_elsewhere`` : which of x, u, y, w are deviations from an equilibrium value other than
    0.  ``observer`` : of a law that has outputs alone; C and D then have the measured rows.
    ``at_other_ends`` : the same loop where numbers that are no fractions, which are constant, are
    at the other ends of their bounds; a claim about the loop is shown for each.
    """

    A: Stack
    _: KW_ONLY
    B: Stack = ()
    C: Stack = ()
    D: Stack = ()
    E: Stack = ()
    K: Stack = ()
    sample_time: Fraction | None = None
    states: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()
    box: Box = ()
    other_box: Mapping[str, Side] | None = None
    corners: tuple[tuple[int, ...], ...] | None = None
    weights: str = ""
    scheduled_by: tuple[str, ...] | None = None
    shared_weights: bool = True
    stated_rules: int = 1
    extra_stacks: tuple[Stack, ...] = ()
    resting_elsewhere: str = field(default="", repr=False)
    observer: ObserverLaw | None = field(default=None, repr=False)
    at_other_ends: tuple[PolytopicLoop, ...] = field(default=(), repr=False)

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.A[0].rows)

    @property
    def rules(self) -> int:
        """The number of vertices."""
        return max(self.stated_rules, *map(len, (self.A, self.B, self.C, self.D, self.E)))

    @property
    def is_discrete(self) -> bool:
        return self.sample_time is not None

    @property
    def averaged(self) -> bool:
        """Whether the weights are averages along a segment, which no law can evaluate."""
        return self.weights == SECANTS and self.rules > 1

    def groups(self) -> list[tuple[str, Pairs]]:
        """Return the pairs (vertex, gain) whose products of weights are equal, with a name."""
        r, s, c = self.rules, len(self.K), self.corners
        if r * max(s, 1) > MOST_PAIRS:
            raise CertificateError(f"{r} vertices and {s} gains: at most {MOST_PAIRS} pairs")
        affine = s <= 1 or (len(self.B) <= 1 and len(self.D) <= 1 and self.shared_weights)
        groups: dict[object, list[tuple[int, int]]] = {}
        for i, j in zip(range(r), range(r), strict=True) if affine else product(range(r), range(s)):
            key: object = (i, j)
            if self.shared_weights and not affine:
                first, second = (c[i], c[j]) if c else ((i,), (j,))
                key = tuple(tuple(sorted(ends)) for ends in zip(first, second, strict=True))
            groups.setdefault(key, []).append((i, j))
        bounded(len(groups), self.order)
        return [(f"rules {i + 1} and {j + 1}" if i != j else f"rule {i + 1}", tuple(pairs))
                for pairs in groups.values() for i, j in pairs[:1]]  # fmt: skip

    def blends(self) -> list[Blend]:
        """Return the groups of ``groups``; their matrices are made when they are asked for."""
        return [Blend(self, label, pairs) for label, pairs in self.groups()]


@dataclass(frozen=True)
class Blend:
    """A group of pairs with the mean matrices over the pairs; A and C are of the closed loop."""

    loop: PolytopicLoop
    label: str
    pairs: Pairs

    @property
    def A(self) -> Matrix:
        """A_i - B_i K_j."""
        return self._closed(self.loop.A, self.loop.B)

    @property
    def C(self) -> Matrix:
        """C_i - D_i K_j."""
        return self._closed(self.loop.C, self.loop.D)

    @property
    def E(self) -> Matrix:
        return self.of(self.loop.E)

    @property
    def K(self) -> Matrix:
        return self.of(self.loop.K, 1)

    def of(self, stack: Stack, side: int = 0) -> Matrix:
        """Return the mean of the matrices of the vertices, or of the gains for ``side`` = 1."""
        return mean([at(stack, pair[side]) for pair in self.pairs])

    def _closed(self, X: Stack, Y: Stack) -> Matrix:
        K = self.loop.K
        if not K or not Y:
            return self.of(X)
        return mean([at(X, i) - at(Y, i) @ at(K, j) for i, j in self.pairs])


def bounded(count: int, order: int) -> None:
    """Refuse a number of inequalities that would take too long to check."""
    if count * order**4 > MOST_WORK:
        raise CertificateError(f"{count} inequalities of order {order}: too many")


def at(stack: Stack, i: int) -> Matrix:
    """Return the matrix of rule i; a stack of one matrix has the same for all rules."""
    if not stack:
        raise CertificateError("the claim needs a matrix that the model does not have")
    return stack[i if len(stack) > 1 else 0]
