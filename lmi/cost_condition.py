r"""The LMIs of guaranteed quadratic cost under parallel distributed compensation.

With Y = P^-1, M_j = K_j Y, u = -sum_j h_j K_j x, weights Q = F' F and R = G' G,

    Theta_ij = [ He(A_i Y - B_i M_j)   Y F'   M_j' G' ]
               [ F Y                   -I     0       ],     sum_ij h_i h_j Theta_ij < 0,
               [ G M_j                 0      -I      ]

gives V' <= -(x' Q x + u' R u) for V = x' P x, so the cost is at most x(0)' P x(0); and
[[W, X], [X, Y]] > 0 with X = diag(d) gives trace W > sum_k d_k^2 P_kk, its mean where the x_k(0)
are uncorrelated with standard deviations d_k.

Theta is the plain closed loop of taller matrices, so every relaxation of the double sum serves:

    Theta_ij = He(Ahat_i Y E' - Bhat_i M_j E') - diag(0, I, I),
    Ahat_i = [A_i; F; 0],  Bhat_i = [B_i; 0; -G],  E = [I; 0; 0].

Source: Tanaka, Ikeda and Wang (1998), IEEE Trans. Fuzzy Systems 6(2), for the relaxations; Tanaka and
Wang (2001), chapter 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.compensation_condition import Controlled
from takagi.lmi.double_sum import ClosedLoop, Summand
from takagi.lmi.intake import input_stack, positive_vector, symmetric, vertex_stack
from takagi.lmi.relaxations import relaxation_named
from takagi.lmi.term import LMI, Array, Condition, Constant, Term, Unknown

__all__ = ["CostLoop", "largest_lmi", "lqr_pdc_condition"]

# Largest Y in states where P is about 1: keeps Y finite where a state costs nothing, at a price of
# this much of the cost.
LARGEST_Y = 1e6


@dataclass(frozen=True, slots=True, eq=False)
class CostLoop(ClosedLoop):
    """Theta_ij in the place of Gamma_ij: A is Ahat (r, N, n), B is Bhat (r, N, m), Q is Y (n, n).

    A closed loop in what the relaxations read of one: ``rules``, ``states`` (N, the size of their
    slack), ``weight`` and ``lmi``.
    """

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
        total = np.zeros(count)
        for summand in summands:
            np.add.at(
                total, np.arange(count) if summand.item is None else summand.item, summand.weight
            )
        unit = np.diag((np.arange(self.states) >= self.Q.rows).astype(np.float64))
        return LMI(
            name=name,
            blocks=(self.states,),
            terms=(*(term for one in summands for term in self.terms(one)), *slack),
            constants=(
                Constant(
                    value=-total[:, None, None] * unit,
                    latex=rf"-{total[0]:.4g} \, \mathrm{{diag}}(0, I, I)",
                ),
            ),
            sign=-1,
            count=count,
            weight=self.weight,
            labels=labels,
            index=index,
        )

    def terms(self, summand: Summand) -> tuple[Term, Term]:
        """Return the summand's He(Ahat_i Y E') and -He(Bhat_i M_j E')."""
        select = np.eye(self.Q.rows, self.states)[None]
        w = summand.weight[:, None, None]
        i, j = summand.names
        shared = self.M.count == 1
        return (
            Term(
                unknown=self.Q,
                left=w * self.A[summand.i],
                right=select,
                plus_transpose=True,
                items=summand.item,
                latex=(rf"{summand.factor}\hat A_{{{i}}}", r"E^\top"),
            ),
            Term(
                unknown=self.M,
                left=-w * self.B[summand.i],
                right=select,
                plus_transpose=True,
                items=summand.item,
                members=None if shared else summand.j,
                latex=(rf"-{summand.factor}\hat B_{{{i}}}", r"E^\top"),
                symbol=self.M.symbol if shared else f"{self.M.symbol}_{{{j}}}",
            ),
        )


def lqr_pdc_condition(
    model: Controlled,
    Q: ArrayLike,
    R: ArrayLike,
    *,
    relaxation: str = "wang-tanaka-griffin",
    deviations: ArrayLike = 1.0,
) -> Condition:
    """Pose the module's LMIs; the objective is trace W, the mean cost from random x(0).

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    Q, R : (n, n) positive semidefinite and (m, m) positive definite, symmetric.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    deviations : d, (n,) or one number: standard deviation of each state of x(0).

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``Y``, ``M``, ``W`` and
    those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, weights that are not symmetric or not
        definite, an unknown relaxation.

    Source: Tanaka and Wang (2001), chapter 6.
    """
    pose = relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    F = _factor(symmetric("Q", Q, n, definite=False))
    G = _factor(symmetric("R", R, m, definite=True))
    Y = Unknown("Y", n, n, symmetric=True)
    M = Unknown("M", m, n, count=1 if relaxation == "common-gain" else r)
    W = Unknown("W", n, n, symmetric=True)
    tall_A = np.concatenate([A, np.tile(F, (r, 1, 1)), np.zeros((r, m, n))], axis=1)
    tall_B = np.concatenate([B, np.zeros((r, len(F), m)), np.tile(-G, (r, 1, 1))], axis=1)
    slack, double_sum = pose(CostLoop(tall_A, tall_B, Y, M, 1.0))
    return Condition(
        name=f"guaranteed quadratic cost, {relaxation}",
        unknowns=(Y, M, W, *slack),
        lmis=(_cost_bound(W, Y, positive_vector("deviations", deviations, n)), *double_sum),
        objective={"W": np.eye(n)[None]},
        source="Tanaka and Wang (2001), chapter 6",
    )


def _cost_bound(W: Unknown, Y: Unknown, deviations: Array) -> LMI:
    """Pose [[W, X], [X, Y]] > 0, which is Y > 0 and W > X Y^-1 X, X = diag(deviations)."""
    one = np.eye(Y.rows)[None]
    return LMI(
        name="bound of the cost",
        blocks=(Y.rows, Y.rows),
        terms=(
            Term(unknown=W, left=one, right=one),
            Term(unknown=Y, left=one, right=one, at=(1, 1)),
        ),
        constants=(Constant(value=np.diag(deviations)[None], at=(0, 1), latex="X"),),
    )


def largest_lmi(Y: Unknown) -> LMI:
    """Pose Y <= 1e6 I, in states where P is about 1: keeps Y finite where a state costs nothing."""
    one = np.eye(Y.rows)[None]
    return LMI(
        name="scale of Y",
        blocks=(Y.rows,),
        terms=(Term(unknown=Y, left=one, right=one),),
        constants=(Constant(value=-LARGEST_Y * one, latex=rf"-{LARGEST_Y:g} I"),),
        sign=-1,
        weight=0.0,
    )


def _factor(weight: Array) -> Array:
    """Return F, (rank, size), with F' F = weight."""
    eigenvalues, vectors = np.linalg.eigh(weight)
    keep = eigenvalues > 1e-14 * np.abs(eigenvalues).max()
    return np.asarray((vectors[:, keep] * np.sqrt(eigenvalues[keep])).T)
