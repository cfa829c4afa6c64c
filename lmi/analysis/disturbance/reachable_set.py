r"""The peak-to-peak gain of one vertex by a Lyapunov equation, with a margin for rounding its P.

With Q = P^-1 the least ellipsoid x' P x <= 1 that is invariant for |w| <= 1 at a decay rate alpha
needs no program: Q is least in every direction where

    continuous   A Q + Q A' + sigma Q + B B' / sigma = 0,                  sigma = 2 alpha
    discrete     A Q A' / (1 - sigma) - Q + B B' / sigma = 0,      sigma = 1 - e^(-2 alpha T)

and gamma^2 = min_t lambda_max(C Q C' / (1 - t) + D D' / t), with t = 0 where D = 0.

Source: Abedor, Nagpal, Poolla (1996), Int. J. Robust and Nonlinear Control 6.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov
from scipy.optimize import minimize_scalar

from takagi.lmi.cone.balance import state_units
from takagi.lmi.parameter_search.least_over_rate import least_over_rate
from takagi.models.arrays import Floats

# The grid over the rate is in the logarithm of sigma / (most - sigma), so that it is fine at both
# ends of the range.
ODDS = np.geomspace(1e-4, 1e6, 31)
# R weighs each state by its size in Q, but with at least this share of the largest size: some
# states hardly move.
LEAST = 1e-6
# The least share of gamma^2 for x, and for w, if w enters y directly.
NARROWEST = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class OneVertex:
    """x' = A x + B w or x+ = A x + B w, y = C x + D w, in balanced states.

    Attributes
    ----------
    units : (n,), x = units xhat; A, B, C are those of xhat.
    step : sample time T in s; None for continuous time.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    step: float | None
    units: Floats

    @classmethod
    def of(cls, A: Floats, B: Floats, C: Floats, D: Floats, *, step: float | None) -> OneVertex:
        """Return the vertex with these matrices, (n, n), (n, q), (p, n) and (p, q)."""
        s = state_units(A[None], None, step=step)
        return cls(A * s / s[:, None], B / s[:, None], C * s, D, step, s)

    @property
    def most(self) -> float:
        """The largest sigma: that of the slowest pole; not positive where the vertex is unstable.

        In discrete time it is at most 1, where every state rests at once.
        """
        poles = np.linalg.eigvals(self.A)
        if self.step is None:
            return float(-2.0 * poles.real.max())
        return float(1.0 - np.abs(poles).max() ** 2)

    def best_rate(self) -> float | None:
        """Return about the decay rate with the least gamma in 1/s; None where none exists."""
        most = self.most
        if not most > 0:
            return None

        def value(odds: float) -> float:
            return self.gain_at(most * odds / (1.0 + odds))

        best = least_over_rate(value, [float(odds) for odds in ODDS])
        return None if best is None else self._rate(most * best / (1.0 + best))

    def gain_at(self, sigma: float) -> float:
        """Return gamma; inf where nothing is shown at this sigma."""
        Q = self._reached(sigma)
        return np.inf if Q is None else self._gain(Q)

    def with_room(self, rate: float, tolerance: float) -> Floats | None:
        """Return P: x' P x <= 1 is invariant for |w| <= 1, with room.

        Q solves the equation with B B' / sigma + delta R in the place of B B' / sigma, R of the
        size of Q in every state, and delta so that gamma grows by the tolerance, relative.

        Returns
        -------
        P > 0 but for rounding, in the model's states; None where the vertex decays more slowly,
        or no such P was found in floating point.
        """
        sigma = self.sigma(rate)
        Q = self._reached(sigma)
        if Q is None:
            return None
        size = np.diag(Q)
        more = self._solved(np.diag(np.maximum(size, LEAST * size.max())), sigma)
        if more is None:
            return None
        least, added = (_largest(self.C @ one @ self.C.T) for one in (Q, more))
        if not (least > 0 and added > 0):
            return None
        # At the t of Q gamma^2 grows by 2 tolerance least / (1 - t), which is a share of it.
        Q = Q + 2.0 * tolerance * least / added * more
        if not np.diag(Q).min() > 0:
            return None
        s = 1.0 / np.sqrt(np.diag(Q))
        try:
            root = np.linalg.cholesky(Q * s * s[:, None])
        except np.linalg.LinAlgError:
            return None
        half = np.linalg.solve(root, np.diag(s / self.units))
        return np.asarray(half.T @ half) if np.isfinite(half).all() else None

    def sigma(self, rate: float) -> float:
        """Return what V falls by at a decay rate in 1/s: by time, or in one step."""
        return 2.0 * rate if self.step is None else -float(np.expm1(-2.0 * rate * self.step))

    def _rate(self, sigma: float) -> float:
        if self.step is None:
            return sigma / 2.0
        return -float(np.log1p(-sigma)) / (2.0 * self.step)

    def _gain(self, Q: Floats) -> float:
        shown, through = self.C @ Q @ self.C.T, self.D @ self.D.T
        if not self.D.any():
            return float(np.sqrt(max(_largest(shown), 0.0)))

        def square(t: float) -> float:
            return _largest(shown / (1.0 - t) + through / t)

        ends = (NARROWEST, 1.0 - NARROWEST)
        return float(np.sqrt(minimize_scalar(square, bounds=ends, method="bounded").fun))

    def _reached(self, sigma: float) -> Floats | None:
        """Return Q; None where the vertex decays more slowly, or Q is spoilt by rounding."""
        inside = 0 < sigma < self.most
        return self._solved(self.B @ self.B.T / sigma, sigma) if inside else None

    def _solved(self, weight: Floats, sigma: float) -> Floats | None:
        """Return Q of the equation with this weight; None where it is not positive."""
        with warnings.catch_warnings():
            # Nothing is claimed here: the later check of P shows whether Q is accurate enough.
            warnings.simplefilter("ignore", RuntimeWarning)
            try:
                if self.step is None:
                    shifted = self.A + 0.5 * sigma * np.eye(len(self.A))
                    Q = np.asarray(solve_continuous_lyapunov(shifted, -weight), dtype=np.float64)
                else:
                    left = self.A / np.sqrt(1.0 - sigma)
                    Q = np.asarray(solve_discrete_lyapunov(left, weight), dtype=np.float64)
            except np.linalg.LinAlgError:
                return None
        Q = (Q + Q.T) / 2.0
        # A disturbance may reach some states only: then Q is singular, and rounding decides.
        good = np.isfinite(Q).all() and np.diag(Q).min() >= -LEAST * np.abs(Q).max()
        return Q if good else None


def _largest(symmetric: Floats) -> float:
    return float(np.linalg.eigvalsh(symmetric)[-1])
