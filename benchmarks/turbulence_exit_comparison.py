r"""Linear loops driven by the same wind: Rice's bound of them, and the nonlinear loop beside them.

    python benchmarks/turbulence_exit_comparison.py GAINS.json [--linear | --simulate]

FLOATING POINT AND SAMPLED, NOT PROVED.  The loop is that of ``turbulence_exit_about_schedule``,
without the integral: its signal x, |x| <= its limit, is an input.  For schedule winds v_k let xi_k
be the state of the loop linearised at v_k, driven by the same wind.  Each xi_k is a Gaussian
process, so Rice's formula bounds its maximum, without the loss of a quadratic function.  With
weights w_k(v_s) that are linear between the v_k and xibar = sum w_k xi_k the rest rho = xi - xibar
has

    rho' = J rho + g,   g = f(xibar, v_s) - sum w_k A_k xi_k - v_s' sum (dw_k/dv_s) xi_k,

J a mean Jacobian between xibar and xi.  Printed for each v_s, in % of rated speed:

    deviation   of the speed error of the linear loop
    Rice        the speed error that it exceeds with probability 1e-3 in ten minutes
    at v_s      the largest e of rho by the integral of the impulse response at this v_s, from the
                torque's curvature, the observer's, the integral's limit, the wake's; g is the
                largest over xibar at ``RADIUS`` deviations
    comparison  e by one comparison system of norms of the modes (vector Lyapunov function) with
                v_s held, for Jacobians 0, 1, 2, 3 and ``RADIUS`` deviations away; "-" where the
                comparison system is unstable

``--linear``: Rice's bound for the loop of ``turbulence_exit_loop``, linearised at the mean wind.
``--simulate``: the largest |e| of the loop, of xibar and of rho in 100 runs, mean over the runs and
most; here the linear loops have the integral too, without its limit.
"""

from __future__ import annotations

import argparse
from math import erfc
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_continuous_lyapunov
from turbulence_exit_about_schedule import ETA, RATED, SEEN, D, E, Loop, M, N, P, Q, R, Reach, X, Y
from turbulence_exit_loop import Law, room, system
from turbulence_exit_nonlinear import trim

Floats = NDArray[np.float64]
KEPT = np.array([E, P, D, M, SEEN, Q, ETA])  # states of the loop without the integral
SPEED, PITCH, OBSERVED, WAKE = (list(KEPT).index(i) for i in (E, P, SEEN, ETA))
HORIZON, PROBABILITY = 600.0, 1e-3  # s
RADIUS, DRAWN, JACOBIANS = 4.6, 8000, 150
MEANS, WINDS = (13.0, 18.0), np.arange(10.5, 24.0, 1.5)  # m/s
LINEAR = (5.0, 8.0, 10.0, 11.0, 11.4, 12.0, 13.0, 15.0, 18.0, 20.0, 23.0)  # m/s
OVERSPEEDS = (0.10, 0.15, 0.20, 0.30)
STEP, LONG = 0.02, 200.0  # s, of impulse responses


def crossed(b: float, s: float, moved: float) -> float:
    """Return Rice's bound of leaving [-b, b]: s and moved the deviations of process and rate."""
    return erfc(b / s / 2**0.5) + HORIZON * moved / (np.pi * s) * float(np.exp(-((b / s) ** 2) / 2))


class Local:
    """The loop at one schedule wind: its matrix, its spread in turbulence, and its curvature g."""

    def __init__(self, loop: Loop, schedule: float) -> None:
        self.loop, self.schedule = loop, schedule
        whole = loop.slope(trim(loop, schedule))[:8, :8]
        self.A, self.integral = whole[np.ix_(KEPT, KEPT)], whole[KEPT, X]
        n, wind = len(KEPT), loop.wind
        self.driven = np.zeros((n + 2, n + 2))
        self.driven[:n, :n] = self.A
        self.driven[list(KEPT).index(D), n + 1] = self.driven[n, n + 1] = 1
        self.driven[n + 1, n:] = -wind.stiffness, -wind.damping
        noise = np.zeros((n + 2, 1))
        noise[-1] = wind.noise
        self.spread = solve_continuous_lyapunov(self.driven, -noise @ noise.T)

    def rare(self) -> float:
        """Return the speed error that the linear loop exceeds with ``PROBABILITY`` [rad/s]."""
        rates = self.driven @ self.spread @ self.driven.T
        s, moved = (float(np.sqrt(matrix[SPEED, SPEED])) for matrix in (self.spread, rates))
        low, high = 0.0, 10 * s
        for _ in range(50):
            b = (low + high) / 2
            low, high = (b, high) if crossed(b, s, moved) > PROBABILITY else (low, b)
        return high

    def drawn(self, random: np.random.Generator, radius: float, count: int) -> Floats:
        """Return whole states whose linear part is ``radius`` deviations away, (10, count)."""
        n = len(KEPT)
        way = random.standard_normal((n, count))
        root = np.linalg.cholesky(self.spread[:n, :n] + 1e-12 * np.eye(n))
        z = np.zeros((N, count))
        z[KEPT] = radius * root @ (way / np.linalg.norm(way, axis=0))
        z[Y] = self.schedule - self.loop.mean + z[D]
        return z

    def jacobian(self, z: Floats) -> Floats:
        """Return the Jacobian at one state with v_s fixed: D moves the wind, not the schedule."""
        whole = self.loop.slope(z)
        matrix = whole[:8, :8].copy()
        matrix[:, D] += whole[:8, Y]
        return np.asarray(matrix[np.ix_(KEPT, KEPT)])

    def inputs(self, z: Floats) -> Floats:
        """Return the columns of g at their largest over the states: the four causes, and pitch."""
        g = self.loop.rates(z)[KEPT] - self.A @ z[KEPT]
        found = np.zeros((len(KEPT), 5))
        found[[SPEED, OBSERVED], 0] = np.abs(g[SPEED]).max()
        found[OBSERVED, 1] = np.abs(g[OBSERVED] - g[SPEED]).max()
        found[:, 2] = self.integral * self.loop.law.integral_limit
        found[WAKE, 3] = np.abs(g[WAKE]).max()
        found[PITCH, 4] = np.abs(g[PITCH]).max()
        return found

    def peaks(self, columns: Floats) -> Floats:
        """Return the integral of |e| of the impulse response to each column."""
        onward, state = expm(self.A * STEP), columns.copy()
        total = np.zeros(columns.shape[1])
        for _ in range(round(LONG / STEP)):
            total += np.abs(state[SPEED]) * STEP
            state = onward @ state
        return total

    def modes(self) -> tuple[Floats, list[list[int]]]:
        """Return the real modal matrix, and its blocks of one or two columns."""
        values, vectors = np.linalg.eig(self.A)
        columns: list[Floats] = []
        blocks = []
        for i in np.lexsort((values.imag, values.real)):
            place = len(columns)
            if abs(values[i].imag) < 1e-9:
                columns.append(vectors[:, i].real)
                blocks.append([place])
            elif values[i].imag > 0:
                columns += [vectors[:, i].real, vectors[:, i].imag]
                blocks.append([place, place + 1])
        return np.array(columns).T, blocks

    def compared(self, columns: Floats, matrices: list[Floats]) -> float | None:
        """Return the bound of |e| by the comparison system of the modes' norms; None: unstable."""
        back, blocks = self.modes()
        T = np.linalg.inv(back)
        bounds = np.full((len(blocks), len(blocks)), -np.inf)
        for matrix in matrices:
            Z = T @ matrix @ back
            for i, rows in enumerate(blocks):
                for j, side in enumerate(blocks):
                    part = Z[np.ix_(rows, side)]
                    if i == j:
                        size = float(np.linalg.eigvalsh((part + part.T) / 2).max())
                    else:
                        size = float(np.linalg.norm(part, 2))
                    bounds[i, j] = max(bounds[i, j], size)
        if np.linalg.eigvals(bounds).real.max() >= 0:
            return None
        pushed = np.array([np.linalg.norm((T @ columns)[rows], axis=0).sum() for rows in blocks])
        seen = np.array([np.linalg.norm(back[SPEED, rows]) for rows in blocks])
        return float(seen @ np.linalg.solve(-bounds, pushed))


def table(loop: Loop, random: np.random.Generator) -> None:
    reach = Reach.of(loop.mean, loop.law.filter, HORIZON, PROBABILITY)
    for schedule in WINDS[np.abs(WINDS - loop.mean) <= reach.schedule + 0.3]:
        here = Local(loop, float(schedule))
        z = here.drawn(random, RADIUS, DRAWN)
        columns = here.inputs(z)
        told = []
        for radius in (0.0, 1.0, 2.0, 3.0, RADIUS):
            near = here.drawn(random, radius, JACOBIANS if radius else 1)
            bound = here.compared(columns, [here.jacobian(one) for one in near.T])
            told.append("-" if bound is None else f"{100 * bound / RATED:.0f}")
        peaks = 100 * here.peaks(columns) / RATED
        deviation = 100 * np.sqrt(here.spread[SPEED, SPEED]) / RATED
        print(
            f"| {loop.mean:g} | {schedule:g} | {deviation:.1f} | {100 * here.rare() / RATED:.0f} | "
            f"{', '.join(f'{one:.1f}' for one in peaks[:4])} | {', '.join(told)} |",
            flush=True,
        )


def linear(law: Law) -> None:
    """Print Rice's bound for the loop linearised at each wind, by overspeed."""
    for wind in LINEAR:
        one = system(law, wind, 0.1, uncertain=False)
        A, S = one.A[0], one.S[0]
        spread = solve_continuous_lyapunov(A, -S @ S.T)
        s, moved = (float(np.sqrt(m[E, E])) for m in (spread, A @ spread @ A.T))
        found = (np.log10(max(crossed(room(law, wind, x), s, moved), 1e-99)) for x in OVERSPEEDS)
        told = " | ".join("1" if p >= 0 else f"10^{p:.1f}" for p in found)
        print(f"| {wind:g} | {100 * s / RATED:.2f} | {told} |")


def simulated(loop: Loop, runs: int = 100, step: float = 0.04) -> None:
    """Print the largest |e| of the loop, of the weighted linear loops and of the rest."""
    random, nodes = np.random.default_rng(1), np.arange(3.5, 25.0)
    onward = np.array([np.eye(8) + step * loop.slope(trim(loop, v))[:8, :8] for v in nodes])
    z, linear = np.zeros((N, runs)), np.zeros((len(nodes), 8, runs))
    largest, root, each = np.zeros((3, runs)), loop.wind.noise * np.sqrt(step), np.arange(runs)
    for _ in range(round(HORIZON / step)):
        moved = z[R].copy()
        linear = onward @ linear
        linear[:, D] += step * moved
        z = z + step * loop.rates(z)
        z[R] += root * random.standard_normal(runs)
        schedule = loop.mean + z[Y] - z[D]
        k = np.clip(np.searchsorted(nodes, schedule, side="right") - 1, 0, len(nodes) - 2)
        share = np.clip(schedule - nodes[k], 0, 1)
        bar = (1 - share) * linear[k, E, each] + share * linear[k + 1, E, each]
        largest = np.maximum(largest, np.abs([z[E], bar, z[E] - bar]))
    mean, most = (100 * found / RATED for found in (largest.mean(axis=1), largest.max(axis=1)))
    told = " | ".join(f"{a:.1f}, {b:.1f}" for a, b in zip(mean, most, strict=True))
    print(f"| {loop.mean:g} | {told} |", flush=True)


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path)
    reader.add_argument("--linear", action="store_true")
    reader.add_argument("--simulate", action="store_true")
    given = reader.parse_args()
    law = Law.read(given.gains)
    print("FLOATING POINT, SAMPLED, NOT PROVED; ten minutes, % of rated speed")
    if given.linear:
        linear(law)
        return
    for mean in (11.0, *MEANS, 15.0, 20.0) if given.simulate else MEANS:
        loop = Loop(law, mean)
        if given.simulate:
            simulated(loop)
        else:
            table(loop, np.random.default_rng(0))


if __name__ == "__main__":
    main()
