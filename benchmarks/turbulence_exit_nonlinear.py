r"""Is there a quadratic function for the nonlinear loop in turbulence, and what limits it?

    python benchmarks/turbulence_exit_nonlinear.py GAINS.json [--ranges | --simulate]

FLOATING POINT AND SAMPLED, NOT PROVED.  The loop is that of ``turbulence_exit_about_schedule``.
V = xi'P(v_s) xi, P linear in the schedule wind between nodes.  With S the column of the noise and f
the loop's rates,

    drift(xi) = 2 xi'P f(xi) + v_s' xi'(dP/dv_s) xi + 2 k (S'P xi)^2,     c = max S'P S.

If drift <= -min(a V, c) on the set then, as in docs/exit-probability.md, V reaches 1 in ten minutes
with probability at most (1 + m T) exp(-k) from rest, m = a exp(k c/a - 1) or k c, unless the wind
alone leaves its ``Reach`` before.  P is sought so that the condition holds at the points found so
far; the worst of 20,000 drawn points, moved uphill, are added, and so on.  The last column is the
largest (drift + min(a V, c)) / V left: points with a value above 0 refute the function that is
shown, and only a proof excludes that there are more.

``--ranges``: the bound if the loop may have, at all times, every matrix of secants that it has
between the trim and the states of some ranges of v_s, D and e: what a proof by pieces gives that
uses the pieces' matrices everywhere in the set.
``--simulate``: the share of 400 runs of ten minutes beyond each overspeed.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov
from turbulence_exit_about_schedule import ETA, NAMES, RATED, D, E, Loop, M, N, P, Q, Reach, X, Y
from turbulence_exit_loop import Law

Floats = NDArray[np.float64]
HORIZON, SPACING, EACH = 600.0, 2.0, 2e-3  # s; of the nodes [m/s]; p of each bound of the wind
OVER = 0.3  # m/s by which D may exceed its reach, since vhat is not v
# tau_f [s], mean wind [m/s], a [1/s], overspeed.
CASES = (
    (12.0, 18.0, 0.03, 0.30), (12.0, 20.0, 0.03, 0.30), (12.0, 18.0, 0.03, 0.20),
    (12.0, 15.0, 0.03, 0.30), (12.0, 13.0, 0.03, 0.50),
)  # fmt: skip
# tau_f [s], mean wind [m/s], a [1/s].
LAWS = (
    (12.0, 13.0, 0.03), (12.0, 15.0, 0.03), (12.0, 17.0, 0.03), (5.0, 15.0, 0.04),
    (5.0, 18.0, 0.04), (1.0, 15.0, 0.06), (1.0, 18.0, 0.06),
)  # fmt: skip
SIMULATED, OVERSPEEDS = (8.0, 11.0, 13.0, 15.0, 18.0), (0.05, 0.10, 0.15, 0.20)
ROUNDS, DRAWN, KEPT, UPHILL = 8, 20_000, 300, 20
MARGIN = 0.004  # 1/s, by which the condition is asked to hold at the points found
ENOUGH = 1.1  # the drift is asked to be at most -min(a V, ENOUGH c)
SIDES = (0.1, 6.0)  # of m - e [rad/s] and vhat - v [m/s] on the set
LOWEST, HIGHEST = 3.0, 25.0


@dataclass(frozen=True)
class Function:
    """V = xi'P(v_s) xi by its values at nodes of v_s; the exponent k, and a."""

    nodes: Floats
    tables: Floats
    exponent: float
    rate: float

    def place(self, schedule: Floats) -> tuple[NDArray[np.intp], Floats]:
        j = np.clip(np.searchsorted(self.nodes, schedule, side="right") - 1, 0, len(self.nodes) - 2)
        return j, (schedule - self.nodes[j]) / np.diff(self.nodes)[j]

    def at(self, schedule: Floats) -> tuple[Floats, Floats]:
        """Return P and dP/dv_s, (n, 10, 10) each."""
        j, share = self.place(schedule)
        turn = (self.tables[j + 1] - self.tables[j]) / np.diff(self.nodes)[j][:, None, None]
        return self.tables[j] + (share * np.diff(self.nodes)[j])[:, None, None] * turn, turn

    def level(self, loop: Loop) -> float:
        return float(np.max(loop.S.T @ self.tables @ loop.S))

    def logarithm(self, loop: Loop) -> float:
        """Return log10 of the bound from rest, without the wind's part; at most 0."""
        k, a, c = self.exponent, self.rate, self.level(loop)
        grown = np.log(k * c) if k * c <= a else np.log(a) + k * c / a - 1
        return min(0.0, float((np.logaddexp(0, np.log(HORIZON) + grown) - k) / np.log(10)))

    def value(self, loop: Loop, z: Floats) -> tuple[Floats, Floats]:
        """Return V and the drift at states (10, n)."""
        at, turn = self.at(loop.mean + z[Y] - z[D])
        Px, f = np.einsum("nij,jn->in", at, z), loop.rates(z)
        grown = 2 * (Px * f).sum(axis=0)
        grown += (f[Y] - f[D]) * np.einsum("in,nij,jn->n", z, turn, z)
        return (z * Px).sum(axis=0), grown + 2 * self.exponent * (loop.S[:, 0] @ Px) ** 2


def inside(one: Function, loop: Loop, reach: Reach, z: Floats) -> NDArray[np.bool_]:
    schedule = loop.mean + z[Y] - z[D]
    V = np.einsum("in,nij,jn->n", z, one.at(schedule)[0], z)
    return np.asarray(
        (V <= 1)
        & (V > 1e-4)
        & (np.abs(z[X]) <= loop.law.integral_limit)
        & (np.abs(z[D]) <= reach.lag + OVER)
        & (np.abs(z[Y]) <= reach.wind)
        & (schedule >= one.nodes[0])
        & (schedule <= one.nodes[-1])
    )


def drawn(one: Function, loop: Loop, reach: Reach, random: np.random.Generator) -> Floats:
    """Return states of the set with the wind inside its reach, (10, n).

    v_s is drawn first; of the states with this v_s the nearest to 0 by V is the centre.
    """
    h = np.zeros(N)
    h[Y], h[D] = 1, -1
    schedule = random.uniform(one.nodes[0], one.nodes[-1], DRAWN)
    P = one.at(schedule)[0]
    spread = np.linalg.inv(P)
    along = spread @ h
    size, off = along @ h, schedule - loop.mean
    push = random.standard_normal((DRAWN, N))
    push[::2] *= random.random(push[::2].shape) ** 6  # directions along few states
    w = np.einsum("nij,nj->ni", np.linalg.cholesky(spread), push)
    w -= along * ((w @ h) / size)[:, None]
    left = np.maximum(random.choice((0.05, 0.3, 0.6, 1.0, 1.0), DRAWN) - off**2 / size, 0)
    w *= np.sqrt(left / np.einsum("ni,nij,nj->n", w, P, w))[:, None]
    z = held((along * (off / size)[:, None] + w).T, loop)
    return np.asarray(z[:, inside(one, loop, reach, z)])


def held(z: Floats, loop: Loop) -> Floats:
    """Return the states with the integral within its limit."""
    z = z.copy()
    z[X] = np.clip(z[X], -loop.law.integral_limit, loop.law.integral_limit)
    return z


def worst(one: Function, loop: Loop, reach: Reach, seed: int) -> tuple[Floats, Floats]:
    """Return states with the largest (drift + min(aV, ENOUGH c)) / V, and these numbers."""
    random, least = np.random.default_rng(seed), ENOUGH * one.level(loop)

    def excess(z: Floats) -> Floats:
        V, drift = one.value(loop, z)
        return np.asarray((drift + np.minimum(one.rate * V, least)) / V)

    z = drawn(one, loop, reach, random)
    found = excess(z)
    best = np.argsort(found)[-KEPT:]
    z, found = z[:, best], found[best]
    scale = np.sqrt(np.diag(np.linalg.inv(one.tables.mean(axis=0))))[:, None]
    for step in np.geomspace(0.2, 0.01, UPHILL):
        tried = held(z + step * scale * random.standard_normal(z.shape), loop)
        gained = np.full(len(found), -np.inf)
        allowed = inside(one, loop, reach, tried)
        if allowed.any():
            gained[allowed] = excess(tried[:, allowed])
        better = gained > found
        z[:, better], found[better] = tried[:, better], gained[better]
    return z, found


@dataclass(frozen=True)
class Piece:
    """A matrix of the loop between two nodes, and v_s' there [m/s^2]."""

    j: int
    A: Floats
    moved: float


class Search:
    """P(v_s), or one P, for pieces and for points."""

    def __init__(
        self,
        loop: Loop,
        nodes: Floats,
        overspeed: float,
        rate: float,
        *,
        same: bool = False,
        pad: float = 1e-9,
    ) -> None:
        # ``pad`` of the nominal spread is added in the scale: the solver fails without it if there
        # are few conditions.
        self.loop, self.nodes, self.rate, self.same = loop, nodes, rate, same
        # Of P at a node: the least room between its neighbours, so that P(v_s) has it everywhere.
        self.rows = [
            np.eye(N)[E] / loop.room(nodes[min(j + 1, len(nodes) - 1)], overspeed)
            for j in range(len(nodes))
        ]
        A = loop.slope(trim(loop, loop.mean))
        A -= max(float(np.linalg.eigvals(A).real.max()) + 0.02, 0) * np.eye(N)
        spread = solve_continuous_lyapunov(A, -loop.S @ loop.S.T)
        T = np.linalg.cholesky(spread + pad * np.diag(spread.diagonal() + 1e-6))
        self.T = T / max(np.abs(h @ T).max() for h in self.rows)
        self.back = np.linalg.inv(self.T)
        self.points, self.rates = np.zeros((N, 0)), np.zeros(0)
        self.pieces = [
            Piece(j, loop.slope(trim(loop, (low + high) / 2)), 0.0)
            for j, (low, high) in enumerate(pairwise(nodes))
        ]

    def add(self, points: Floats, rates: Floats) -> None:
        """Ask the drift at the points to be at most -rates V."""
        self.points = np.concatenate([self.points, points], axis=1)
        self.rates = np.concatenate([self.rates, rates])

    def best(self, guess: float, steps: int) -> Function | None:
        """Return the function with the largest k (1 - c/a), by Dinkelbach's method."""
        cp: Any = import_module("cvxpy")
        T, back, S = self.T, self.back, self.back @ self.loop.S
        free = [
            cp.Variable((N, N), symmetric=True)
            for _ in (self.nodes[:1] if self.same else self.nodes)
        ]
        Ps = free * len(self.nodes) if self.same else free
        c, kappa, price = (make(nonneg=True) for make in (cp.Variable, cp.Variable, cp.Parameter))
        fast = np.zeros((2, N))
        fast[0, [M, E]] = np.array([1, -1]) / SIDES[0]
        fast[1, [Q, D]] = np.array([1, -1]) / SIDES[1]
        terms = [
            one - np.outer(T.T @ h, T.T @ h) >> 1e-8 * np.eye(N)
            for one, row in zip(Ps, self.rows, strict=True)
            for h in (row, *fast)
        ]
        terms += [cp.trace(S.T @ one @ S) <= c for one in Ps]
        corner = -cp.reshape(kappa, (1, 1), order="C")
        for piece in self.pieces:
            A, ends = back @ piece.A @ T, Ps[piece.j : piece.j + 2]
            turn = (ends[1] - ends[0]) * (piece.moved / np.diff(self.nodes)[piece.j])
            for one in ends[: 1 if self.same else 2]:
                top = one @ A + A.T @ one + self.rate * one + turn + 1e-8 * np.eye(N)
                terms.append(cp.bmat([[top, one @ S], [(one @ S).T, corner]]) << 0)
        if len(self.rates):
            stacked = cp.hstack([cp.reshape(one, (N * N,), order="C") for one in Ps])
            drift, noise = self._forms(S)
            reached = drift @ stacked
            pushed = cp.vstack([2 * (noise @ stacked), kappa + reached])
            terms.append(cp.SOC(kappa - reached, pushed, axis=0))
        problem = cp.Problem(cp.Minimize(c / self.rate + 2 * price * kappa), terms)
        found, exponent = None, -np.inf
        price.value = max(guess, 0.1)
        for _ in range(steps):
            try:
                problem.solve(solver=cp.CLARABEL)
            except cp.error.SolverError:
                price.value *= 0.7
                continue
            if Ps[0].value is None or kappa.value <= 0:
                break
            k = 1 / (2 * float(kappa.value))
            gained = k * (1 - float(c.value) / self.rate)
            if gained > exponent:
                tables = [back.T @ (one.value + one.value.T) @ back / 2 for one in Ps]
                found = Function(self.nodes, np.array(tables), k, self.rate)
                exponent = gained
            if abs(gained - price.value) <= 0.03 * price.value:
                break
            price.value = gained if gained > 0.1 else price.value / 5
        return found

    def _forms(self, S: Floats) -> tuple[Floats, Floats]:
        """Return rows r, s of each point: r P + (s P)^2 / kappa <= 0 is the drift's condition."""
        z, loop = self.points, self.loop
        f = loop.rates(z)
        place = Function(self.nodes, np.zeros((len(self.nodes), N, N)), 1.0, 1.0).place
        j, share = place(loop.mean + z[Y] - z[D])
        x, g = self.back @ z, self.back @ f
        scale = (x * x).sum(axis=0)

        def outer(left: Floats, right: Floats, size: Floats) -> Floats:
            return np.asarray(
                np.einsum("in,jn->nij", left, right).reshape(-1, N * N) / size[:, None]
            )

        xx, xg = outer(x, x, scale), outer(x, g, scale)
        xs = outer(x, np.repeat(S, len(scale), axis=1), np.sqrt(scale))
        moved = ((f[Y] - f[D]) / np.diff(self.nodes)[j])[:, None] * xx
        drift, noise = (np.zeros((len(scale), len(self.nodes) * N * N)) for _ in range(2))
        block, rows = np.arange(N * N), np.arange(len(scale))[:, None]
        for side, weight, sign in ((0, 1 - share, -1), (1, share, 1)):
            at, part = (j + side)[:, None] * N * N + block, weight[:, None]
            drift[rows, at] += part * (2 * xg + (self.rates + MARGIN)[:, None] * xx) + sign * moved
            noise[rows, at] += part * xs
        return drift, noise


def trim(loop: Loop, schedule: float) -> Floats:
    """Return the state at the trim with this schedule wind."""
    z = np.zeros(N)
    z[Y] = schedule - loop.mean
    return z


def schedule_nodes(loop: Loop, reach: Reach) -> Floats:
    low = max(LOWEST, loop.mean - reach.schedule - OVER)
    high = min(HIGHEST, loop.mean + reach.schedule + OVER)
    return np.linspace(low, high, 2 + int((high - low) / SPACING))


def of_points(loop: Loop, overspeed: float, rate: float) -> tuple[Function | None, float]:
    """Return the function, and the largest excess that is left; None where there is none."""
    reach = Reach.of(loop.mean, loop.law.filter, HORIZON, EACH)
    search = Search(loop, schedule_nodes(loop, reach), overspeed, rate)
    first = np.repeat([search.back.T @ search.back], len(search.nodes), axis=0)
    start = Function(search.nodes, first, 1.0, rate)
    points = drawn(start, loop, reach, np.random.default_rng(0))[:, :300]
    search.add(points, np.full(points.shape[1], rate))
    one, left = search.best(10.0, 2), np.inf
    for turn in range(ROUNDS):
        if one is None:
            break
        z, found = worst(one, loop, reach, turn)
        left, bad = float(found.max()), found > 1e-4
        if not bad.any() or turn == ROUNDS - 1:
            break
        V = one.value(loop, z[:, bad])[0]
        search.add(z[:, bad], np.minimum(rate, ENOUGH * one.level(loop) / V))
        one = search.best(max(one.exponent * (1 - one.level(loop) / rate), 0.5), 2)
    return one, left


def extents(one: Function) -> str:
    reach = np.sqrt(np.linalg.inv(one.tables).diagonal(axis1=1, axis2=2)).max(axis=0)
    return ", ".join(f"{name} {size:.2g}" for name, size in zip(NAMES, reach, strict=True))


def by_ranges(loop: Loop, overspeed: float, rate: float) -> None:
    """Print the bound for matrices of secants over ranges of v_s, D and e."""
    reach = Reach.of(loop.mean, loop.law.filter, HORIZON, EACH)
    whole = schedule_nodes(loop, reach)
    point, half = loop.mean + np.array([-0.01, 0.01]), reach.schedule / 2
    middle = np.linspace(loop.mean - half, loop.mean + half, 4)
    lags, none = np.linspace(-1, 1, 3) * reach.lag, (0.0,)
    other = tuple(Loop(loop.law, loop.mean, inertia) for inertia in (0.9, 1.1))
    for told, nodes, winds, errors, plants, same in (
        ("v_s at the mean, D = 0", point, none, none, (loop,), True),
        ("v_s at the mean, D in its reach", point, lags, none, (loop,), True),
        ("half the reach of v_s, D = 0, one P", middle, none, none, (loop,), True),
        ("v_s in its reach, D = 0, one P", whole, none, none, (loop,), True),
        ("v_s in its reach, D = 0, P(v_s)", whole, none, none, (loop,), False),
        ("both in their reach, one P", whole, lags, none, (loop,), True),
        ("both in their reach, P(v_s)", whole, lags, none, (loop,), False),
        ("both, e to 0.1 rad/s, P(v_s)", whole, lags, (-0.1, 0.0, 0.1), (loop,), False),
        ("both, e to 0.2 rad/s, P(v_s)", whole, lags, (-0.2, 0.0, 0.2), (loop,), False),
        ("both, e to 0.38 rad/s, P(v_s)", whole, lags, (-0.38, 0.0, 0.38), (loop,), False),
        ("both, inertia 0.9 to 1.1, P(v_s)", whole, lags, none, other, False),
    ):
        search = Search(loop, nodes, overspeed, rate, same=same, pad=3e-4)
        search.pieces = of_pieces(search, reach, product(plants, winds, errors))
        one = search.best(10.0, 8)
        print(f"| {told} | {_told(one, loop)} |", flush=True)


def of_pieces(
    search: Search, reach: Reach, corners: Iterable[tuple[Loop, float, float]]
) -> list[Piece]:
    """Return the matrices at the middle of each interval, for corners of plant, D and e."""
    return [
        Piece(j, _secant(plant, (low + high) / 2, lag, e), moved)
        for plant, lag, e in corners
        for j, (low, high) in enumerate(pairwise(search.nodes))
        if abs((low + high) / 2 + lag - plant.mean) <= reach.wind
        for moved in ((0.0,) if search.same else (lag / plant.law.filter,))
    ]


def by_laws(gains: Path) -> None:
    """Print the bound for v_s and D in their reach, P(v_s), by wind filter and mean wind."""
    for tau, mean, rate in LAWS:
        loop, told = Loop(Law.read(gains, tau), mean), []
        reach = Reach.of(mean, tau, HORIZON, EACH)
        for overspeed in (0.15, 0.20, 0.30, 0.50):
            search = Search(loop, schedule_nodes(loop, reach), overspeed, rate, pad=3e-4)
            lags = np.linspace(-1, 1, 3) * reach.lag
            search.pieces = of_pieces(search, reach, product((loop,), lags, (0.0,)))
            one = search.best(10.0, 8)
            log = 0.0 if one is None else one.logarithm(loop)
            told.append("1" if log >= 0 else f"10^{log:.1f}")
        print(f"| {tau:g} | {mean:g} | {' | '.join(told)} |", flush=True)


def _secant(loop: Loop, schedule: float, lag: float, e: float) -> Floats:
    """Return the mean Jacobian from the trim at v_s to the state with D = lag and the error e.

    On this way v_s is fixed, so that y and D move together: the column of y is added to that of D.
    """
    steps = [loop.slope(_away(loop, schedule, t * lag, t * e)) for t in np.linspace(0.1, 0.9, 5)]
    A = np.asarray(np.mean(steps, axis=0))
    A[:Y, D] += A[:Y, Y]
    A[:Y, Y] = 0
    return A


def _away(loop: Loop, schedule: float, lag: float, e: float) -> Floats:
    """Return the state with D = lag, the error e, and the pitch that the law asks for then."""
    z = trim(loop, schedule + lag)
    effort, gamma = (loop.law.at(name, schedule) for name in ("trim_effort", "proportional"))
    asked = loop.psi(np.array([effort + gamma * e, effort]))
    z[D], z[Q], z[E], z[M], z[P], z[ETA] = lag, lag, e, e, *([asked[0] - asked[1]] * 2)
    return z


def _told(one: Function | None, loop: Loop) -> str:
    if one is None:
        return "none | | 1"
    log = one.logarithm(loop)
    share = one.level(loop) / one.rate
    return f"{one.exponent:.1f} | {share:.2f} | {'1' if log >= 0 else f'10^{log:.1f}'}"


def simulated(law: Law, means: Sequence[float]) -> None:
    for mean in means:
        over = Loop(law, mean).simulated(HORIZON, 400) / RATED - 1
        shares = " | ".join(f"{(over > x).mean():.4f}" for x in OVERSPEEDS)
        print(f"| {law.filter:g} | {mean:g} | {shares} | {100 * over.max():.1f} % |", flush=True)


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path)
    reader.add_argument("--ranges", action="store_true")
    reader.add_argument("--simulate", action="store_true")
    reader.add_argument("--only", type=int, help="number of the case, from 0", default=None)
    given = reader.parse_args()
    print("FLOATING POINT, SAMPLED, NOT PROVED; ten minutes from rest")
    if given.simulate:
        simulated(Law.read(given.gains), SIMULATED)
        return
    if given.ranges:
        by_ranges(Loop(Law.read(given.gains), 18.0), 0.30, 0.03)
        by_laws(given.gains)
        return
    for tau, mean, rate, overspeed in CASES if given.only is None else [CASES[given.only]]:
        loop = Loop(Law.read(given.gains, tau), mean)
        one, left = of_points(loop, overspeed, rate)
        told = f"| {tau:g} | {mean:g} | {100 * overspeed:g} % | {_told(one, loop)} | {left:.2g} |"
        print(told, one and extents(one), flush=True)


if __name__ == "__main__":
    main()
