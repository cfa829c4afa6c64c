"""Covariances on pieces of the parameters' box, until a probability is shown.

The piece with the largest bound is halved, along the parameter whose halves differ most in what one
covariance for both pays to first order (``_best_cut``).  Nothing is proved here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates.checker.turbine.linear_loop.crossing_claim import LinearLoop
from takagi.certificates.checker.turbine.linear_loop.jacobian import noise_square
from takagi.certificates.checker.turbine.linear_loop.pieces import Box, corners, halves
from takagi.certificates.requests.loop.decimals import short
from takagi.certificates.requests.loop.exact_floats import floats, stack_of
from takagi.lmi.analysis.disturbance.covariance_bound import covariance_bound
from takagi.models.arrays import Floats

Path = tuple[tuple[int, str], ...]


@dataclass(slots=True, eq=False)
class Piece:
    """A piece of the box: the way to it in the tree, A at its corners, and C, None where none is.

    Attributes
    ----------
    path : the halvings that lead to it, each as (0 or 1, parameter).
    """

    box: Box
    path: Path
    A: Floats
    C: Floats | None


class Search:
    """The loop at one wind in floating point: its pieces, and the bounds that these show."""

    def __init__(self, linear: LinearLoop, horizon: float) -> None:
        self.linear, self.horizon = linear, horizon
        self.row = floats(linear.row)[0]
        self.S = np.sqrt(floats(noise_square(linear.wind, linear.machine)))

    def piece(self, box: Box, path: Path = ()) -> Piece:
        """Return the piece with its covariance."""
        A = stack_of(self.linear.at(box))
        S = np.broadcast_to(self.S, (len(A), *self.S.shape))
        noisy = np.flatnonzero(self.S.any(axis=0))
        return Piece(box, path, A, covariance_bound(A, S[:, :, noisy], self.row))

    def logarithm(self, piece: Piece, limit: float, C: Floats | None = None) -> float:
        """Return the logarithm of the bound at a limit [rad/s]; inf where there is none."""
        C = piece.C if C is None else C
        if C is None:
            return np.inf
        variance = float(self.row @ C @ self.row)
        rows = self.row @ piece.A
        rate = float(np.einsum("ij,jk,ik->i", rows, C, rows).max())
        ratio = limit**2 / (2 * variance) if variance > 0 else 0.0
        if ratio < 0.5 or rate < 0:
            return np.inf
        outside = 1 / np.sqrt(np.pi * ratio)
        return float(np.log(outside + self.horizon / np.pi * np.sqrt(rate / variance)) - ratio)

    def shown(self, pieces: list[Piece], limit: float, digits: int) -> float:
        """Return the largest bound with covariances of so many digits; above 1 where none is."""
        logs = [
            self.logarithm(one, limit, None if one.C is None else short(one.C, digits))
            for one in pieces
        ]
        return float(np.exp(min(max(logs), 1.0)))

    def pieces(
        self, first: Piece, limit: float, probability: float, most: int, depth: int = 0
    ) -> list[Piece]:
        """Return at most so many pieces, in the tree's order, for a probability.

        Parameters
        ----------
        first : the whole box.
        depth : pieces with fewer cuts are cut at once, without a covariance of their own: where
            many pieces are needed anyway this saves up to half of the time.
        """
        found, target = [first], float(np.log(probability))
        for level in range(depth if self.logarithm(first, limit) > target else 0):
            found = [half for one in found for half in self._cut(one, solve=level + 1 == depth)]
        while len(found) < most:
            worst = max(found, key=lambda one: self.logarithm(one, limit))
            if self.logarithm(worst, limit) <= target:
                break
            new = self._cut(worst)
            if len(new) == 1:
                break
            found = [one for one in found if one is not worst] + new
        return sorted(found, key=lambda one: [k for k, _ in one.path])

    def _cut(self, piece: Piece, *, solve: bool = True) -> list[Piece]:
        """Return the halves, or the piece itself if no parameter has a range.

        Parameters
        ----------
        solve : whether each half gets its own covariance, or else that of the piece.
        """
        name = self._best_cut(piece)
        found = []
        for k, half in enumerate(halves(piece.box, name) if name else ()):
            path = (*piece.path, (k, name))
            found.append(
                self.piece(half, path)
                if solve
                else Piece(half, path, stack_of(self.linear.at(half)), piece.C)
            )
        return found or [piece]

    def _best_cut(self, piece: Piece) -> str:
        """Return the parameter whose halving is likely to help most; empty if none has a range.

        With D half the difference of the mean matrices at the ends of its range, Y of
        A'Y + YA + h'h = 0, a covariance X and M = Y^(1/2) D X^(1/2), the variance of the signal
        differs by 2 tr M between the halves, to first order: this is in the worst corner, and no
        cut takes it away.  The sum of the singular values of M is what one covariance for both
        halves pays.  The difference of the two is compared.
        """
        mean, n = piece.A.mean(axis=0), piece.A.shape[1]
        X = np.eye(n) if piece.C is None else piece.C
        Y = np.eye(n)
        if np.linalg.eigvals(mean).real.max() < 0:
            Y = solve_continuous_lyapunov(mean.T, -np.outer(self.row, self.row))
        left, right = _root(Y), _root(X)
        places = list(corners(piece.box))
        effects = {}
        for name, (low, high) in piece.box.items():
            if low < high:
                upper = np.array([values[name] == high for values in places])
                apart = piece.A[upper].mean(axis=0) - piece.A[~upper].mean(axis=0)
                moved = left @ (apart / 2) @ right
                effects[name] = float(np.linalg.norm(moved, "nuc") - abs(np.trace(moved)))
        return max(effects, key=lambda name: effects[name]) if effects else ""


def tree(pieces: list[Piece], depth: int = 0) -> list[str]:
    """Return the tree's nodes, each before its halves; the pieces are in its order."""
    if len(pieces) == 1 and len(pieces[0].path) == depth:
        return [""]
    name = pieces[0].path[depth][1]
    sides = [[one for one in pieces if one.path[depth][0] == k] for k in (0, 1)]
    return [name, *tree(sides[0], depth + 1), *tree(sides[1], depth + 1)]


def _root(matrix: Floats) -> Floats:
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T)
