r"""How far does the lag v - v_s alone drive the rotor, if it is large and stays?

    python benchmarks/turbulence_exit_lag.py GAINS.json [--simulate]

FLOATING POINT, NOT PROVED.  The loop is that of ``turbulence_exit_about_schedule``.  Of the wind
only the lag D = v - v_s and the schedule wind v_s enter the equations of speed and pitch.  With a
perfect estimate S = v_s - U and D are independent stationary Gaussian processes, as
E[D S] = tau_f E[S' S] = 0, so that by Rice's formula all of the signals

    Z = cos(phi) D / s_D - sin(phi) S / s_S

stay below their bounds for ten minutes but for the probability p; at a schedule wind this leaves
D <= D_max(v_s).

For each mean wind: D_max at the mean wind; over all v_s the greatest speed that is an equilibrium
with D = D_max(v_s), once with x = 0 and once with the integral at its limit; and, for the loop
linearised at v_s, the greatest ratio of the integral of the impulse response's size from D to the
speed (what the worst signal D with |D| <= 1 reaches) to its gain at rest (what a constant D
reaches).
``--simulate``: how far v_s is from a schedule wind with a perfect estimate, and from one with an
estimate that lags by 1.5 s, at most in ten minutes; median and largest of 150 runs.
"""

from __future__ import annotations

import argparse
from math import erfc
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_continuous_lyapunov
from turbulence_exit_about_schedule import ETA, RATED, SEEN, D, E, Loop, M, N, P, R, X, Y
from turbulence_exit_loop import Law, Wind

Floats = NDArray[np.float64]
MEANS = (7.0, 9.0, 11.0, 13.0, 15.0, 18.0, 20.0)
HORIZON, ALTOGETHER = 600.0, 1e-3  # s; probability of all bounds together
ANGLES = np.radians(np.arange(-75, 76, 15))
SPREADS, WINDS = 4.8, 60  # of S on either side of the mean; schedule winds looked at
HIGHEST_SPEED = 2.2  # rad/s, of the equilibria sought
LAGS = (0.0, 1.5)  # s, of the estimate in the schedule winds that v_s is compared with


def greatest_lag(mean: float, tau: float, schedule: Floats) -> Floats:
    """Return D_max at the schedule winds [m/s]."""
    wind = Wind.of_class_b(mean)
    A = np.array([[0, 1, 0], [-wind.stiffness, -wind.damping, 0], [0, 1, -1 / tau]])
    noise = np.array([[0.0], [wind.noise], [0.0]])
    C = solve_continuous_lyapunov(A, -noise @ noise.T)
    lag, moved = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, -1.0])
    of_lag, of_moved = (float(np.sqrt(row @ C @ row)) for row in (lag, moved))
    found = np.full(len(schedule), np.inf)
    for phi in ANGLES:
        row = np.cos(phi) * lag / of_lag - np.sin(phi) * moved / of_moved
        s, m = np.sqrt(row @ C @ row), np.sqrt(row @ A @ C @ A.T @ row)
        bound = _seldom_left(float(s), float(m), ALTOGETHER / len(ANGLES))
        reached = bound + np.sin(phi) * (schedule - mean) / of_moved
        found = np.minimum(found, reached * of_lag / np.cos(phi))
    return found


def _seldom_left(s: float, m: float, probability: float) -> float:
    """Return b with erfc(b/(s sqrt 2))/2 + T m/(2 pi s) exp(-b^2/(2 s^2)) = probability."""
    low, high = 0.0, 12 * s
    for _ in range(60):
        b = (low + high) / 2
        left = erfc(b / s / 2**0.5) / 2
        left += HORIZON * m / (2 * np.pi * s) * np.exp(-((b / s) ** 2) / 2)
        low, high = (b, high) if left > probability else (low, b)
    return high


def equilibrium(loop: Loop, schedule: float, lag: float, integral: float) -> float:
    """Return the greatest speed at which e' = 0, pitch and wake at rest [rad/s]; nan for none."""
    law = loop.law
    speed, effort, gamma = (
        law.at(name, schedule) for name in ("rotor_speed", "trim_effort", "proportional")
    )
    e = np.linspace(-0.4 * speed, HIGHEST_SPEED - speed, 1200)
    z = np.zeros((N, len(e)))
    z[Y], z[D], z[X] = schedule - loop.mean + lag, lag, integral
    z[E] = z[M] = z[SEEN] = e
    z[P] = z[ETA] = loop.psi(effort + gamma * (e - integral)) - loop.psi(np.array([effort]))
    rate = loop.rates(z)[E]
    falls = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0))
    return float(speed + e[falls[-1]]) if len(falls) else float("nan")


def overshoot(loop: Loop, schedule: float) -> float:
    """Return the impulse response's integral from D to e over the gain at rest, v_s held."""
    z = np.zeros(N)
    z[Y] = schedule - loop.mean
    A, kept = loop.slope(z), [E, M, P, ETA]
    inner, enters, step = A[np.ix_(kept, kept)], A[kept, D] + A[kept, Y], 0.02
    ahead, state, size = expm(inner * step), enters.copy(), 0.0
    for _ in range(6000):
        size += abs(state[0]) * step
        state = ahead @ state
    return float(size / abs(np.linalg.solve(inner, enters)[0]))


def by_means(law: Law) -> None:
    for mean in MEANS:
        loop = Loop(law, mean)
        spread = Wind.of_class_b(mean).deviation
        winds = np.linspace(mean - SPREADS * spread, mean + SPREADS * spread, WINDS)
        nodes = law.tables["wind"]
        winds = winds[(winds > nodes[0]) & (winds < nodes[-1])]
        lags = greatest_lag(mean, law.filter, winds)
        met = lags > 0
        over = [
            100 * (np.nanmax([
                equilibrium(loop, wind, lag, share * law.integral_limit)
                for wind, lag in zip(winds[met], lags[met], strict=True)
            ]) / RATED - 1)
            for share in (0.0, 1.0)
        ]  # fmt: skip
        ratio = max(overshoot(loop, wind) for wind in winds[met][:: WINDS // 12])
        at_mean = float(np.interp(mean, winds, lags))
        print(f"| {mean:g} | {at_mean:.1f} | {over[0]:.0f} | {over[1]:.0f} | {ratio:.2f} |")


def simulated(law: Law) -> None:
    for mean in MEANS:
        loop, random, step, runs = Loop(law, mean), np.random.default_rng(1), 0.04, 150
        z, root = np.zeros((N, runs)), loop.wind.noise * np.sqrt(step)
        seen, ideal, largest = (np.zeros((len(LAGS), runs)) for _ in range(3))
        for _ in range(round(HORIZON / step)):
            for j, late in enumerate(LAGS):
                seen[j] = seen[j] + step * (z[Y] - seen[j]) / late if late else z[Y]
            ideal = ideal + step * (seen - ideal) / law.filter
            z = z + step * loop.rates(z)
            z[R] += root * random.standard_normal(runs)
            largest = np.maximum(largest, np.abs(z[Y] - z[D] - ideal))
        told = " | ".join(f"{np.median(row):.2f}, {row.max():.2f}" for row in largest)
        print(f"| {mean:g} | {told} |", flush=True)


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path)
    reader.add_argument("--simulate", action="store_true")
    given = reader.parse_args()
    print("FLOATING POINT, NOT PROVED; class B, ten minutes")
    law = Law.read(given.gains)
    if given.simulate:
        simulated(law)
    else:
        by_means(law)


if __name__ == "__main__":
    main()
