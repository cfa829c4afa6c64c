r"""The loop that claims are about, with exact numbers: vertices, gains, and what weighs them.

    x' = sum_i h_i (A_i x + B_i u + E_i w),   y = sum_i h_i (C_i x + D_i u),   u = -sum_j g_j K_j x

or x+ in the place of x' in discrete time, for any weights >= 0 that sum to one, however they move.
The loop is the double sum of h_i g_j (A_i - B_i K_j).  Pairs whose products of weights are equal
are added up: a matrix inequality that is affine in the matrices of a pair holds along the loop
when it holds for the mean of each such group, a ``Blend``.  Which products are equal:

    (i, j) and (j, i)        where the law has the weights of the model, g = h
    equal corners            where h_i = prod_k w_k,c_ik besides: the corners {c_ik, c_jk} agree
    a pair by itself         where the law has weights of its own

One gain for all rules, or one B and one D with g = h, makes the loop affine: its rules suffice.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.matrices import LARGEST, Matrix, mean, read_stack
from takagi.certificates.checker.reader import canonical, increasing, member, number, numbers
from takagi.certificates.checker.refusal import CertificateError

__all__ = ["Blend", "Family", "read_family"]

Stack = tuple[Matrix, ...]
Pairs = tuple[tuple[int, int], ...]
SHAPES = {"A": "nn", "B": "nm", "C": "pn", "D": "pm", "E": "nq"}
MOST_PAIRS, MOST_WORK = 1 << 21, 10**9


@dataclass(frozen=True)
class Family:
    """Vertices and gains; a stack of one matrix stands for all rules, an empty one for nothing.

    ``box`` : per state, its range in the coordinates of x, or None; ``other_box`` : the names of
    box variables that are not states.  ``corners`` : c_ik per rule, where weights are products.
    """

    A: Stack
    B: Stack = ()
    C: Stack = ()
    D: Stack = ()
    E: Stack = ()
    K: Stack = ()
    sample_time: Fraction | None = None
    states: tuple[str, ...] = ()
    box: tuple[tuple[Fraction, Fraction] | None, ...] = ()
    other_box: Mapping[str, tuple[Fraction, Fraction]] | None = None
    corners: tuple[tuple[int, ...], ...] | None = None
    premises: str = ""
    shared_weights: bool = True

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.A[0].rows)

    @property
    def rules(self) -> int:
        """The number of vertices."""
        return max(len(stack) for stack in (self.A, self.B, self.C, self.D, self.E))

    @property
    def is_discrete(self) -> bool:
        return self.sample_time is not None

    @property
    def about(self) -> str:
        """What a proof for every blend is about, in words."""
        if not self.K:
            return f"every blend of the {self.rules} vertices"
        if not self.shared_weights:
            return f"every blend of {self.rules} rules and every blend of {len(self.K)} gains"
        return f"every blend of {self.rules} rules with their gains"

    def groups(self) -> list[tuple[str, Pairs]]:
        """Return the pairs (vertex, gain) whose products of weights are equal, with a name."""
        r, s = self.rules, len(self.K)
        one_input = len(self.B) <= 1 and len(self.D) <= 1
        if s <= 1 or (one_input and self.shared_weights):
            return [(f"rule {i + 1}", ((i, i),)) for i in range(r)]
        if r * s > MOST_PAIRS:
            raise CertificateError(f"{r} vertices and {s} gains: at most {MOST_PAIRS} pairs")
        found: dict[object, list[tuple[int, int]]] = {}
        for i, j in product(range(r), range(s)):
            key: object = (i, j)
            if self.shared_weights:
                rows = [(i,), (j,)] if self.corners is None else [self.corners[i], self.corners[j]]
                key = tuple(tuple(sorted(both)) for both in zip(*rows, strict=True))
            found.setdefault(key, []).append((i, j))
        if len(found) * self.order**3 > MOST_WORK:
            raise CertificateError(f"{len(found)} inequalities of order {self.order}: too many")
        return [(f"rules {p[0][0] + 1} and {p[0][1] + 1}", tuple(p)) for p in found.values()]

    def blends(self) -> list[Blend]:
        """Return the groups of ``groups``; their matrices are made when they are asked for."""
        return [Blend(self, label, pairs) for label, pairs in self.groups()]


@dataclass(frozen=True)
class Blend:
    """A group of pairs; its matrices are means over the pairs, of the closed loop where A or C."""

    family: Family
    label: str
    pairs: Pairs

    @property
    def A(self) -> Matrix:
        """A_i - B_i K_j."""
        return self._closed(self.family.A, self.family.B)

    @property
    def C(self) -> Matrix:
        """C_i - D_i K_j."""
        return self._closed(self.family.C, self.family.D)

    @property
    def E(self) -> Matrix:
        return mean([_at(self.family.E, i) for i, _ in self.pairs])

    @property
    def K(self) -> Matrix:
        return mean([_at(self.family.K, j) for _, j in self.pairs])

    def _closed(self, X: Stack, Y: Stack) -> Matrix:
        K = self.family.K
        if not K or not Y:
            return mean([_at(X, i) for i, _ in self.pairs])
        return mean([_at(X, i) - _at(Y, i) @ _at(K, j) for i, j in self.pairs])


def _at(stack: Stack, i: int) -> Matrix:
    if not stack:
        raise CertificateError("the claim needs a matrix that the model does not have")
    return stack[i if len(stack) > 1 else 0]


def read_family(model: Any, gains: Any, where: str = "model") -> Family:
    """Return the loop of a certificate's ``model`` and ``gains``, every number as written.

    Raises
    ------
    CertificateError : a kind that is not known, shapes that do not fit, gains of another model.
    """
    kind = member(model, "kind", where)
    if kind == "takagi-sugeno":
        plain = _vertices(model, where)
    elif kind == "plant":
        from takagi.certificates.checker.plant_embedding import plant_family

        plain = plant_family(model, where)
    else:
        raise CertificateError(f"{where}.kind: {kind!a} has no vertices for this claim")
    return plain if gains is None else _closed_by(plain, gains, "gains")
