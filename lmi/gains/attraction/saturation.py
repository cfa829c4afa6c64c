r"""Saturating actuators, u = -sat(K(h) x) at |u_k| <= ubar_k, as double sums: three ways.

With K_j = M_j Q^-1, on the set where |v_k| <= ubar_k / s_k, v = K(h) x, or |H(h) x|_k <= ubar_k:

    secant      sat(v)_k lies between s_k v_k and v_k, so sat(v) is a blend of the 2^m vectors
                theta v with theta_k in {s_k, 1}:
                    Theta_ij = He(A_i Q - B_i theta M_j) + 2 alpha Q        for every corner theta.
    polytope    sat(v)_k lies between (H x)_k and v_k for any H: with E the 2^m diagonal matrices
                of zeros and ones and Z_j = H_j Q,
                    Theta_ij = He(A_i Q - B_i (E M_j + (I - E) Z_j)) + 2 alpha Q      for every E.
                The secant is the case H = s K; here H is sought, and convexly.
    dead zone   psi = v - sat(v) has psi' T (psi - (K - H) x) <= 0 for every diagonal T = S^-1 > 0:
                    Theta_ij = [ He(A_i Q - B_i M_j) + 2 alpha Q   B_i S + (M_j - Z_j)' ]
                               [ *                                 -2 S                 ],
                one double sum whatever m.  For one input it is as good as the polytope.

In each case V' <= -2 alpha V on the ellipsoid {x' P x <= 1} when it lies in the set: ``input_lmis``
for M with ubar / s, or for Z with ubar.  alpha may be smaller where an input saturates than where
none does.  It has to be, for saturation to buy anything when K is sought: with one alpha for all,
K = H serves as well and never saturates (Hu and Lin); it buys a larger ellipsoid for
gains that are given, or that must be fast near 0.  Discrete time: the same with Theta_ij of
``closed_loop`` there, V(x+) <= e^(-2 alpha T) V(x).

Source: Hu and Lin (2001), Control Systems with Actuator Saturation (polytope); Gomes da Silva and
Tarbouriech (2005), IEEE Trans. Automatic Control 50(1) (dead zone), in each case for one rule; the
secant is the sector with slopes s and 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.expressions.expression import (
    Expression,
    He,
    Parameter,
    block,
    matrix,
)
from takagi.lmi.expressions.piece import turned
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError

# Inputs whose corners, 2^m double sums, are still listed.
MOST_INPUTS = 6


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SaturatedLoop:
    """The loop of the module's double sums.

    Attributes
    ----------
    A, B : (r, n, n), (r, n, m).
    Q : P^-1.
    gain : the unknown M, or known gains K, (r, m, n), or (1, m, n) for a gain that all rules share.
    rate, saturated_rate : alpha, or e^(-2 alpha T), where no input saturates, and where one does.
    weight, discrete, corners : as in ``closed_loop``.
    """

    A: Array
    B: Array
    Q: Unknown
    gain: Unknown | Array
    rate: Parameter
    saturated_rate: Parameter
    weight: float
    discrete: bool
    corners: Indices | None

    @property
    def M(self) -> Expression:
        """Return M_j, or K_j Q for known gains."""
        if isinstance(self.gain, Unknown):
            return self.gain.over("j")
        if len(self.gain) == 1:
            return matrix(self.gain[0], "K") @ self.Q
        return matrix(self.gain, "K_{j}", over="j") @ self.Q

    def theta(self, fed: Expression, rate: Parameter) -> Expression:
        """Return Theta_ij for what the inputs add to A_i Q."""
        free = matrix(self.A, "A_{i}", over="i") @ self.Q
        if self.discrete:
            return block([[-rate * self.Q, None], [free + fed, -self.Q]])
        return He(free) + 2 * rate * self.Q + He(fed)

    def posed(self, theta: Expression, name: str) -> DoubleSum:
        """Return the double sum of a Theta_ij."""
        statement = (theta << 0).named(name, weight=self.weight)
        return double_sum_of(statement, rules=len(self.A), corners=self.corners)

    def through(self, share: Array) -> Expression:
        """Return -B_i diag(share)."""
        name = "B_{i}"
        if not np.all(share == 1):
            values = [f"{value:.4g}" for value in share]
            factor = rf"\mathrm{{diag}}({', '.join(values)})"
            name = f"{values[0]} {name}" if len(values) == 1 else f"{name} {factor}"
        return -matrix(self.B * share, name, over="i")

    def secant_sums(self, smallest_secants: Array) -> tuple[DoubleSum, ...]:
        """Return the 2^m double sums of the secants between s_k and 1, one for each corner.

        Parameters
        ----------
        smallest_secants : s, (m,), in (0, 1]; 1 for an input that does not saturate.

        Raises
        ------
        ModelError : too many inputs.
        """
        sums = []
        for theta in _corners([(1.0,) if s == 1 else (1.0, float(s)) for s in smallest_secants]):
            rate = self.rate if np.all(theta == 1) else self.saturated_rate
            fed = self.through(theta) @ self.M
            sums.append(self.posed(self.theta(fed, rate), _named("secants", theta)))
        return tuple(sums)

    def polytope_sums(self, auxiliary: Unknown) -> tuple[DoubleSum, ...]:
        """Return the 2^m double sums with each input at (K x)_k or at (H x)_k.

        Parameters
        ----------
        auxiliary : the unknown Z_j = H_j Q, with as many members as there are gains.

        Raises
        ------
        ModelError : too many inputs.
        """
        sums = []
        for linear in _corners([(1.0, 0.0)] * self.B.shape[2]):
            if linear.all():
                fed = self.through(linear) @ self.M
            elif linear.any():
                fed = self.through(linear) @ self.M + self.through(1 - linear) @ auxiliary.over("j")
            else:
                fed = self.through(1 - linear) @ auxiliary.over("j")
            rate = self.rate if linear.all() else self.saturated_rate
            sums.append(self.posed(self.theta(fed, rate), _named("unsaturated", linear)))
        return tuple(sums)

    def dead_zone_sum(self, auxiliary: Unknown) -> tuple[DoubleSum, tuple[Unknown, ...]]:
        """Return the double sum of the dead zone, and diag S, positive by the LMI itself.

        Parameters
        ----------
        auxiliary : as for ``polytope_sums``.
        """
        m = self.B.shape[2]
        # Rows of psi measured so that S weighs as much as the rest.
        unit = float(nearest_power(np.abs(self.B).max()))
        S = tuple(Unknown(f"S{k}", 1, 1, latex=f"S_{{{k}}}") for k in range(1, m + 1))
        psi, entering, own = unit * self.M - unit * auxiliary.over("j"), [], []
        for k, row in enumerate(np.eye(m)):
            name = rf"e_{{{k + 1}}} e_{{{k + 1}}}^\top"
            entered = turned(unit * self.B @ np.outer(row, row))
            entering.append(S[k] * matrix(entered, rf"{name} B_{{i}}^\top", over="i"))
            own.append(-2 * S[k] * matrix(unit**2 * np.outer(row, row), name))
        free = matrix(self.A, "A_{i}", over="i") @ self.Q
        fed, rate = self.through(np.ones(m)) @ self.M, self.saturated_rate
        if self.discrete:
            theta = block(
                [
                    [-rate * self.Q, None, None],
                    [free + fed, -self.Q, None],
                    [psi, sum(entering), sum(own)],
                ]
            )
        else:
            moved = He(free) + 2 * rate * self.Q + He(fed)
            theta = block([[moved, None], [sum(entering, psi), sum(own)]])
        return self.posed(theta, "dead zone"), S


def _corners(choices: Sequence[tuple[float, ...]]) -> list[Array]:
    free = sum(len(choice) > 1 for choice in choices)
    if free > MOST_INPUTS:
        raise ModelError(
            f"{free} inputs saturate, with {2**free} corners; at most {MOST_INPUTS} are listed: "
            "take the dead zone, which has no corners"
        )
    return [np.array(corner) for corner in product(*choices)]


def _named(name: str, corner: Array) -> str:
    return f"{name} ({', '.join(f'{value:.4g}' for value in corner)})"
