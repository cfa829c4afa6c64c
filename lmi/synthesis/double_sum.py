"""Sums of h_i h_j Gamma_ij, the closed loop of a PDC law, as terms of an LMI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.term import LMI, Array, Indices, Term, Unknown

__all__ = ["ClosedLoop", "Summand", "selections"]

Weights: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Summand:
    """weight_t Gamma_(i_t, j_t), added to item item_t, for t = 1 ... T.

    Attributes
    ----------
    i, j : (T,) rule of the vertex, rule of the gain.
    weight : (T,).
    item : (T,); None means one to each item.
    names : the two indices in LaTeX, e.g. ``("i", "j")``.
    factor : the weight in LaTeX; empty for 1.
    """

    i: Indices
    j: Indices
    weight: Weights
    item: Indices | None = None
    names: tuple[str, str] = ("i", "j")
    factor: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ClosedLoop:
    """Gamma_ij = He(A_i Q - B_i M_j) + 2 alpha Q with Q = P^-1, M_j = K_j Q, u = -sum h_j K_j x.

    Attributes
    ----------
    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns; M has r members, or one for a gain that all rules share.
    weight : margin of Gamma for a margin 1 of Q.
    """

    A: Array
    B: Array
    Q: Unknown
    M: Unknown
    weight: float

    @property
    def rules(self) -> int:
        return len(self.A)

    @property
    def states(self) -> int:
        return int(self.A.shape[1])

    def lmi(
        self,
        name: str,
        summands: Sequence[Summand],
        slack: Sequence[Term] = (),
        *,
        count: int,
        labels: tuple[str, ...],
        index: str,
    ) -> LMI:
        """Return: sum of the summands + slack < 0, for each of ``count`` items."""
        terms = [term for summand in summands for term in self.terms(summand)]
        terms.append(self._decay(summands, count))
        return LMI(
            name=name,
            blocks=(self.states,),
            terms=(*terms, *slack),
            sign=-1,
            count=count,
            weight=self.weight,
            labels=labels,
            index=index,
        )

    def terms(self, summand: Summand) -> tuple[Term, Term]:
        """Return the summand's He(A_i Q) and -He(B_i M_j)."""
        one = np.eye(self.states)[None]
        w = summand.weight[:, None, None]
        i, j = summand.names
        shared = self.M.count == 1
        return (
            Term(
                unknown=self.Q,
                left=w * self.A[summand.i],
                right=one,
                plus_transpose=True,
                items=summand.item,
                latex=(f"{summand.factor}A_{{{i}}}", ""),
            ),
            Term(
                unknown=self.M,
                left=-w * self.B[summand.i],
                right=one,
                plus_transpose=True,
                items=summand.item,
                members=None if shared else summand.j,
                latex=(f"-{summand.factor}B_{{{i}}}", ""),
                symbol=self.M.symbol if shared else f"{self.M.symbol}_{{{j}}}",
            ),
        )

    def _decay(self, summands: Sequence[Summand], count: int) -> Term:
        """Return 2 alpha Q times the sum of the weights in each item."""
        total = np.zeros(count)
        for summand in summands:
            item = np.arange(count) if summand.item is None else summand.item
            np.add.at(total, item, summand.weight)
        one = np.eye(self.states)[None]
        factor = 2.0 * float(total[0])
        return Term(
            unknown=self.Q,
            left=2.0 * total[:, None, None] * one,
            right=one,
            parameter="alpha",
            latex=(rf"{factor:.4g}\alpha", ""),
        )


def selections(rules: int, states: int) -> Array:
    """Return E, (rules, rules states, states): E_i' X E_j is block (i, j) of X."""
    E = np.zeros((rules, rules * states, states))
    block = np.arange(rules)[:, None] * states + np.arange(states)
    E[np.arange(rules)[:, None], block, np.arange(states)] = 1.0
    return E
