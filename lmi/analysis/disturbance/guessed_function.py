r"""Lyapunov functions of single systems by Riccati and Lyapunov equations: no program is solved.

A loop of high gain has fast and slow parts. In balanced states the P of its norm has a condition
number of 1e8 and more, and no solver comes near the least gain. In states where P is |x|^2 every
solver does. The guess is the P of the mean of the vertices. It only gives coordinates; nothing is
claimed from it.

Source: Zhou, Doyle and Glover (1996), Robust and Optimal Control, chapter 13.

The energy gain of one vertex, and a P that nearly shows it, by a Riccati equation.

    A' P + P A + (P B + C' D / gamma) S^-1 (P B + C' D / gamma)' + C' C / gamma + R = 0,
    S = gamma I - D' D / gamma,

has a solution P > 0 for every gamma above the norm of the path from w to y and to the outputs that
R adds. With R > 0 the bounded real lemma holds with a margin, so P may be rounded. No program is
solved.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Zhou, Doyle, Glover (1996),
Robust and Optimal Control, section 13.4; Kleinman (1968), IEEE Trans. Automatic Control 13(1), for
the steps that mend what rounding left.

The output's variance of one vertex by a Lyapunov equation, with a margin for rounding its P.

The peak-to-peak gain of one vertex by a Lyapunov equation, with a margin for rounding its P.

With Q = P^-1 the least ellipsoid x' P x <= 1 that is invariant for |w| <= 1 at a decay rate alpha
needs no program: Q is least in every direction where

    continuous   A Q + Q A' + sigma Q + B B' / sigma = 0,                  sigma = 2 alpha
    discrete     A Q A' / (1 - sigma) - Q + B B' / sigma = 0,      sigma = 1 - e^(-2 alpha T)

and gamma^2 = min_t lambda_max(C Q C' / (1 - t) + D D' / t), with t = 0 where D = 0.

Source: Abedor, Nagpal, Poolla (1996), Int. J. Robust and Nonlinear Control 6.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import (
    solve_continuous_are,
    solve_continuous_lyapunov,
    solve_discrete_are,
    solve_discrete_lyapunov,
)

from takagi.lmi.analysis.disturbance.channel import DisturbanceChannel, largest_response
from takagi.lmi.analysis.disturbance.loop_norm import largest_gain
from takagi.lmi.cone.balance import state_units
from takagi.lmi.parameter_search.parameter_sweep import least_over_rate
from takagi.models.arrays import Floats

# R weighs each state by its size in the output, in P or in Q, but with at least this share of the
# largest size: some states hardly appear in the output, or hardly move.
SMALLEST_WEIGHT = 1e-6
# Newton's steps: with gains of 1e4 the error of the first solution is larger than the margin of R.
STEPS = 4
# The share of the tolerance that R may use.
SHARE = 0.5


def bounded_real(A: Floats, B: Floats, C: Floats, D: Floats, *, tolerance: float) -> Floats | None:
    """Return P that shows a gamma about the tolerance above the norm, relative.

    ``A``, ``B``, ``C``, ``D`` : (n, n), (n, q), (p, n), (p, q) of one vertex in continuous time.

    P > 0 but for rounding; None where A is not stable, or no such P was found in floating point.
    """
    s = state_units(A[None], None)
    A, B, C = A * s / s[:, None], B / s[:, None], C * s
    if not np.linalg.eigvals(A).real.max() < 0:
        return None
    norm = largest_gain(A, B, C, D).gain
    # The size of a state is that of its own effect on the output.
    size = np.diag(_quiet(solve_continuous_lyapunov, A.T, -C.T @ C))
    if not (np.isfinite(norm) and norm > 0 and np.isfinite(size).all() and size.max() > 0):
        return None
    root = np.diag(np.sqrt(np.maximum(size, SMALLEST_WEIGHT * size.max())))
    regularised_norm = largest_gain(A, B, root, np.zeros((len(A), B.shape[1]))).gain
    # The squares of the outputs' norms add up at most.
    root *= (
        np.sqrt(2.0 * SHARE * tolerance) * norm / regularised_norm if regularised_norm > 0 else 0.0
    )
    gamma = (1.0 + tolerance) * norm
    S = gamma * np.eye(B.shape[1]) - D.T @ D / gamma
    weight = (C.T @ C + root @ root) / gamma
    cross = C.T @ D / gamma
    try:
        P = _quiet(solve_continuous_are, A, B, weight, -S, s=cross)
        for _ in range(STEPS):
            P = (P + P.T) / 2.0
            F = np.linalg.solve(S, B.T @ P + cross.T)
            residual = A.T @ P + P @ A + (P @ B + cross) @ F + weight
            P = P + _quiet(solve_continuous_lyapunov, (A + B @ F).T, -(residual + residual.T) / 2.0)
    except (np.linalg.LinAlgError, ValueError):
        return None
    P = (P + P.T) / 2.0
    good = np.isfinite(P).all() and np.diag(P).min() > 0
    return P / s / s[:, None] if good else None


def _quiet(solve: Callable[..., Any], *arguments: Floats, **named: Floats) -> Floats:
    """Return a scipy solver's result in floats without its warnings: P is checked elsewhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(solve(*arguments, **named), dtype=np.float64)


def gramian_with_room(
    A: Floats, B: Floats, C: Floats, *, sample_time: float | None, tolerance: float
) -> Floats | None:
    """Return P with He(P A) + C'C < 0, or A' P A - P + C'C < 0, and tr B' P B near the least.

    P solves the equation with C'C + delta R in the place of C'C, R of the size of P in every state,
    and delta so that tr B' P B is ``tolerance`` above the least, relative.

    ``A``, ``B``, ``C`` : (n, n), (n, q), (p, n) of one vertex.
    ``sample_time`` : T in s; None for continuous time.

    P > 0 but for rounding; None where A is not stable, or no such P was found in floating point.
    """
    s = state_units(A[None], None, step=sample_time)
    A, B, C = A * s / s[:, None], B / s[:, None], C * s
    P = _solved(A, C.T @ C, sample_time)
    if P is None:
        return None
    size = np.diag(P)
    extra = _solved(A, np.diag(np.maximum(size, SMALLEST_WEIGHT * size.max())), sample_time)
    if extra is None:
        return None
    trace, added = float(np.sum(B * (P @ B))), float(np.sum(B * (extra @ B)))
    if not (trace > 0 and added > 0):
        return None
    P = P + tolerance * trace / added * extra
    # Floats cannot decide whether an ill-conditioned P is definite; the exact check decides later.
    return P / s / s[:, None] if np.isfinite(P).all() and np.diag(P).min() > 0 else None


def _solved(A: Floats, weight: Floats, sample_time: float | None) -> Floats | None:
    """Return P of the Lyapunov equation with -weight on its right; None where A is not stable."""
    poles = np.linalg.eigvals(A)
    stable = poles.real.max() < 0 if sample_time is None else np.abs(poles).max() < 1
    return _lyapunov(A, weight, sample_time) if stable else None


def _lyapunov(A: Floats, weight: Floats, sample_time: float | None) -> Floats | None:
    """Return P with A' P + P A + weight = 0, or A' P A - P + weight = 0; None where there is none.

    Nothing is claimed here: a later check of P shows whether it is accurate enough.
    """
    try:
        if sample_time is None:
            P = _quiet(solve_continuous_lyapunov, A.T, -weight)
        else:
            P = _quiet(solve_discrete_lyapunov, A.T, weight)
    except np.linalg.LinAlgError:
        return None
    return (P + P.T) / 2


# The Riccati equation is solved for a gamma above the norm, by this factor; the norm is estimated
# from a few frequencies.
ABOVE = (1.05, 2.0, 10.0)
# The weight that is added for every state to that of the observability Gramian, as a share of its
# largest weight.
EXTRA_WEIGHT = 1e-6


def guessed_of_energy(channel: DisturbanceChannel) -> Floats | None:
    """Return P of the Riccati equation for a gamma a little above the norm; None if not found."""
    solve = solve_continuous_are if channel.sample_time is None else solve_discrete_are
    A, B, C, D, s = _mean(channel)
    size = largest_response(channel)
    for factor in ABOVE:
        level = (factor * size) ** 2 * np.eye(B.shape[1])
        try:
            P = np.asarray(solve(A, B, C.T @ C, D.T @ D - level, s=C.T @ D), np.float64)
        except (np.linalg.LinAlgError, ValueError):
            continue
        P_guess = _in_plain_states(P, s)
        if P_guess is not None:
            return P_guess
    return guessed_of_variance(channel)


def guessed_of_variance(channel: DisturbanceChannel) -> Floats | None:
    """Return the observability Gramian with a small weight on every state; None if not found."""
    A, _, C, _, s = _mean(channel)
    weight = C.T @ C
    weight = weight + EXTRA_WEIGHT * (np.abs(weight).max() or 1.0) * np.eye(len(A))
    P = _solved(A, weight, channel.sample_time)
    return None if P is None else _in_plain_states(P, s)


def _mean(channel: DisturbanceChannel) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return the mean vertex in balanced states, and their units."""
    s = state_units(channel.A, None, step=channel.sample_time)
    A, B, C, D = (stack.mean(axis=0) for stack in (channel.A, channel.B, channel.C, channel.D))
    return A * s / s[:, None], B / s[:, None], C * s, D, s


def _in_plain_states(P: Floats, s: Floats) -> Floats | None:
    P = (P + P.T) / 2 / s / s[:, None]
    size = np.sqrt(np.abs(np.diag(P)))
    if not np.isfinite(P).all() or not size.all():
        return None
    shaped = P / size / size[:, None]
    return P if np.linalg.eigvalsh(shaped)[0] > 0 else None


# The grid over the rate is in the logarithm of sigma / (most - sigma), so that it is fine at both
# ends of the range.
ODDS = np.geomspace(1e-4, 1e6, 31)
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
        fastest = self.most
        if not fastest > 0:
            return None

        def value(odds: float) -> float:
            return self.gain_at(fastest * odds / (1.0 + odds))

        best = least_over_rate(value, [float(odds) for odds in ODDS])
        return None if best is None else self._rate(fastest * best / (1.0 + best))

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
        extra = self._solved(np.diag(np.maximum(size, SMALLEST_WEIGHT * size.max())), sigma)
        if extra is None:
            return None
        gain_squared, added = (_largest(self.C @ ellipsoid @ self.C.T) for ellipsoid in (Q, extra))
        if not (gain_squared > 0 and added > 0):
            return None
        # At the t of Q gamma^2 grows by 2 tolerance least / (1 - t), which is a share of it.
        Q = Q + 2.0 * tolerance * gain_squared / added * extra
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
        response, through = self.C @ Q @ self.C.T, self.D @ self.D.T
        if not self.D.any():
            return float(np.sqrt(max(_largest(response), 0.0)))
        from scipy.optimize import minimize_scalar

        def square(t: float) -> float:
            return _largest(response / (1.0 - t) + through / t)

        ends = (NARROWEST, 1.0 - NARROWEST)
        return float(np.sqrt(minimize_scalar(square, bounds=ends, method="bounded").fun))

    def _reached(self, sigma: float) -> Floats | None:
        """Return Q; None where the vertex decays more slowly, or Q is spoilt by rounding."""
        inside = 0 < sigma < self.most
        return self._solved(self.B @ self.B.T / sigma, sigma) if inside else None

    def _solved(self, weight: Floats, sigma: float) -> Floats | None:
        """Return Q of the equation with this weight; None where it is not positive."""
        if self.step is None:
            A = self.A + 0.5 * sigma * np.eye(len(self.A))
        else:
            A = self.A / np.sqrt(1.0 - sigma)
        Q = _lyapunov(A.T, weight, self.step)
        if Q is None:
            return None
        # A disturbance may reach some states only: then Q is singular, and rounding decides.
        good = np.isfinite(Q).all() and np.diag(Q).min() >= -SMALLEST_WEIGHT * np.abs(Q).max()
        return Q if good else None


def _largest(symmetric: Floats) -> float:
    return float(np.linalg.eigvalsh(symmetric)[-1])
