r"""The V = x'Px with the least bound on the probability of leaving a set under white noise.

dx = (A x + D d) dt + S dW with |d_k| <= 1 and (A, D, S) in the hull of the vertices.  At a rate
a > 0, with kappa = 1/(2k),

    [ He(P A_i) + a P   P D_i       P S_i    ]
    [ .                 -diag(b)    0        ]  < 0,   tr(S_i' P S_i) + sum b <= c,   P >= h_j h_j'
    [ .                 .           -kappa I ]

for every row h_j with |h_j x| <= 1 in the box.  The bound is then about exp(-k (1 - c/a)), and
k (1 - c/a) = (1 - c/a) / (2 kappa) is a quotient of affine functions: Dinkelbach's method poses
max (1 - c/a) - 2 r kappa for the best r so far, a few times.  The LMIs are affine in
(P, b, c, kappa) at a fixed rate a; a is found by a search along a line.

Source: the inequality is that of docs/plant-theorems.md; Dinkelbach (1967), Management Science
13, On nonlinear fractional programming.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.analysis.invariant_ellipsoid import diagonal_of
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.decision.rounds import optimise_by_rounds
from takagi.lmi.expressions.expression import He, added, block, matrix
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

# Dinkelbach's steps, and the relative gain at which they end.
STEPS, ENOUGH = 8, 1e-4
# Candidates of the rate a, as fractions of the slowest vertex' decay of V, and its refinement.
SHARES, REFINED = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7), 0.05
# Share added to the covariance, so that states without noise have a scale too.
PAD = 1e-9


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class NoisyVertices(ShortRepr):
    """dx = (A_i x + D_i d) dt + S_i dW, and the rows h of |h x| <= 1.

    Attributes
    ----------
    A, D, S : (N, n, n), (N, n, m), (N, n, q); m may be 0.
    rows : (J, n).
    """

    A: Floats
    D: Floats
    S: Floats
    rows: Floats

    def in_states(self, T: Floats) -> NoisyVertices:
        """Return the same in states xhat of x = T xhat."""
        A, D, S = (
            np.asarray(np.linalg.solve(T, stack), np.float64)
            for stack in (self.A @ T, self.D, self.S)
        )
        return NoisyVertices(A, D, S, self.rows @ T)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ExitFunction(ShortRepr):
    """P, k, a, b and c of the module; ``exponent`` is k (1 - c/a)."""

    P: Floats
    factor: float
    rate: float
    multipliers: Floats
    level: float

    @property
    def exponent(self) -> float:
        return self.factor * (1 - self.level / self.rate)

    def logarithm(self, horizon: float, start: float = 0.0) -> float:
        """Return the logarithm of the bound for T s from V = start; inf where there is none."""
        k, a, c = self.factor, self.rate, self.level
        if k * c > a * (1 + k):
            return np.inf
        drift = np.log(k * c) - k if k * c <= a else np.log(a) - 1 - self.exponent
        return float(np.logaddexp(-k * (1 - start), np.log(horizon) + drift))


def exit_condition(system: NoisyVertices, *, rate: float, price: float) -> Condition:
    """Pose the module's LMIs at one rate a; the objective is c / a + 2 price kappa.

    Parameters
    ----------
    rate : a in 1/s, positive.
    price : r of Dinkelbach's method, positive.

    Returns
    -------
    The condition with the unknowns ``P``, ``b`` (if d has entries), ``c`` and ``kappa``.  Nothing
    is solved.

    Raises
    ------
    ModelError : sizes that do not fit, no rows, or a rate or price that is not positive.
    """
    N, n, m, q = *system.A.shape[:2], system.D.shape[2], system.S.shape[2]
    if not len(system.rows) or system.rows.shape[1] != n or q == 0:
        raise ModelError(f"rows {system.rows.shape}, S {system.S.shape}: (J, {n}), (N, {n}, q)")
    if rate <= 0 or price <= 0:
        raise ModelError(f"rate = {rate:g}, price = {price:g}: positive numbers are needed")
    P = Unknown("P", n, n, symmetric=True)
    c, kappa = Unknown("c", 1, 1), Unknown("kappa", 1, 1, latex=r"\kappa")
    A, S, h = (
        matrix(system.A, "A_{i}"),
        matrix(system.S, "S_{i}"),
        matrix(system.rows[:, :, None], "h_{j}"),
    )
    s = matrix(system.S.transpose(0, 2, 1).reshape(N * q, n, 1), "s_{ik}")
    drift = He(P @ A) + matrix([[rate]], "a") * P
    noise = added(s.T @ P @ s, np.repeat(np.arange(N), q), count=N, latex=r"\sum_k")
    level, each = c - noise, rf"i = 1, \dots, {N}"
    rows: list[list[object]] = [[drift, P @ S], [None, -kappa * np.eye(q)]]
    unknowns = [P, c, kappa]
    if m:
        b = Unknown("b", 1, 1, count=m)
        D = matrix(system.D, "D_{i}")
        unknowns.append(b)
        rows = [
            [drift, P @ D, P @ S],
            [None, -diagonal_of(b), 0],
            [None, None, -kappa * np.eye(q)],
        ]
        for k in range(m):
            level -= b.member(k)
    return pose(
        (block(rows) << 0).named("drift", each),
        (level >= 0).named("level", each),
        (P >= h @ h.T).named("box", rf"j = 1, \dots, {len(system.rows)}"),
        minimise=c / rate + 2 * price * kappa,
        unknowns=unknowns,
        name="exit of noise from a set",
        source="docs/plant-theorems.md",
    )


def exit_function(
    system: NoisyVertices, horizon: float, *, start: float = 0.0, rate: float | None = None
) -> ExitFunction | None:
    """Return nearly the best function for T s from V = start; None if none is found.

    Parameters
    ----------
    system : every vertex stable, and rows that bound a set.
    horizon : T in s.
    rate : a in 1/s; None searches it.
    """
    from scipy.optimize import minimize_scalar

    slowest = -2 * float(np.linalg.eigvals(system.A).real.max())
    if slowest <= 0:
        return None
    T = _unit_states(system, slowest)
    scaled, back = system.in_states(T), np.linalg.inv(T)
    functions: dict[float, ExitFunction] = {}

    def bound(a: float) -> float:
        function = _at_rate(scaled, a, functions)
        if function is None:
            return np.inf
        functions[a] = function
        return function.logarithm(horizon, start)

    if rate is not None:
        bound(rate)
    else:
        tried = {share: bound(share * slowest) for share in SHARES}
        best = min(tried, key=lambda share: tried[share])
        if np.isfinite(tried[best]):
            log_rates = np.log([share * slowest for share in SHARES])
            k = SHARES.index(best)
            sides = log_rates[max(k - 1, 0)], log_rates[min(k + 1, len(SHARES) - 1)]
            minimize_scalar(
                lambda s: bound(float(np.exp(s))),
                bounds=sides,
                method="bounded",
                options={"xatol": REFINED, "maxiter": 8},
            )
    if not functions:
        return None
    function = min(functions.values(), key=lambda f: f.logarithm(horizon, start))
    return replace(function, P=back.T @ function.P @ back)


def _at_rate(
    system: NoisyVertices, rate: float, functions: dict[float, ExitFunction]
) -> ExitFunction | None:
    """Return the function with the largest k (1 - c/a) at this rate, by Dinkelbach's method."""
    price, best = max([f.exponent for f in functions.values()], default=1.0), None
    price = max(price, 0.05)
    for _ in range(STEPS):
        function = _solved(optimise_by_rounds(exit_condition(system, rate=rate, price=price)), rate)
        if function is None:
            break
        gained = best is None or function.exponent > best.exponent
        best = function if gained else best
        if function.exponent <= 0 or abs(function.exponent - price) <= ENOUGH * price:
            break
        price = max(function.exponent, 0.5 * price)
    return best


def _solved(outcome: Outcome, rate: float) -> ExitFunction | None:
    values = outcome.values or outcome.feasible
    if not values or float(values["kappa"].item()) <= 0:
        return None
    return ExitFunction(
        P=values["P"][0],
        factor=float(1 / (2 * values["kappa"].item())),
        rate=rate,
        multipliers=values["b"].ravel() if "b" in values else np.zeros(0),
        level=float(values["c"].item()),
    )


def _unit_states(system: NoisyVertices, slowest: float) -> Floats:
    """Return T of x = T xhat in which the noise has about unit covariance, scaled to the rows."""
    A, load = system.A.mean(axis=0), np.concatenate([system.S, system.D], axis=2)
    spread = (load @ load.transpose(0, 2, 1)).mean(axis=0)
    n = len(A)
    if np.linalg.eigvals(A).real.max() >= 0:
        A = A - (np.linalg.eigvals(A).real.max() + slowest) * np.eye(n)
    reach = np.abs(solve_continuous_lyapunov(A, -spread).diagonal())
    padded = spread + np.diag(PAD * (reach + reach.max() * PAD) * slowest)
    X = solve_continuous_lyapunov(A, -padded)
    try:
        T = np.linalg.cholesky((X + X.T) / 2)
    except np.linalg.LinAlgError:
        T = np.diag(np.sqrt(reach + PAD * reach.max()))
    return np.asarray(T / np.sqrt(((system.rows @ T) ** 2).sum(axis=1).max()))
