r"""Certificates that a linearised turbine's overspeed in turbulence is rare, by Rice's formula.

    python benchmarks/turbulence_crossing.py GAINS.json FOLDER [WIND ...]

The loop is that of ``turbulence_exit_loop`` at one mean wind, with its five uncertain parameters as
premises; they are constant in time.  The claim is ``crossing-probability``: |e| reaches
(1 + overspeed) rated - omega*(v) within ten minutes.  The set of parameters is cut into pieces,
each with its own covariance, until the probability of ``ASKED`` is shown.  Printed for each wind:
verdicts of both checkers, overspeed, the probability, that of Rice's formula for the worst of the
32 vertices (floating point), pieces, size of the file and time.  docs/turbulence-exit.md has the
results.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np
from scipy.linalg import solve_continuous_lyapunov
from turbulence_exit_loop import STATES, E, Law, R, Wind, room, system

from takagi.certificates import certify
from takagi.certificates.cross_check import judge
from takagi.certificates.requests import CrossingProbability
from takagi.models import Premise, TSModel

UNITS = ("rad/s", "rad", "rad/s", "m/s", "rad/s", "rad/s", "m/s", "rad", "m/s", "m/s", "m/s^2")
# The parameters as shares of their nominal values; 1/inertia is the first.
PARAMETERS = (
    ("inverse_inertia", 1 / 1.1, 1 / 0.9),
    ("speed_damping", 0.8, 1.2),
    ("pitch_effectiveness", 0.9, 1.1),
    ("wake_of_pitch", 0.8, 1.2),
    ("wake_of_wind", 0.8, 1.2),
)
HORIZON = 600.0  # s
# Wind [m/s] -> overspeed as a share of rated speed, the probability asked for (None: the least of
# one piece), and the most pieces.
ASKED: dict[float, tuple[float, float | None, int]] = {
    5.0: (0.15, None, 1),
    7.0: (0.15, None, 1),
    8.0: (0.15, None, 1),
    9.0: (0.15, None, 1),
    10.0: (0.2, 1e-3, 64),
    11.0: (0.15, None, 1),
    11.4: (0.15, 1e-3, 96),
    12.0: (0.15, 3e-3, 96),
    13.0: (0.15, 1e-3, 64),
    15.0: (0.15, 2e-3, 96),
    18.0: (0.2, 1e-3, 64),
    23.0: (0.3, 1e-3, 64),
}


def worst_vertex(law: Law, v: float, overspeed: float) -> float:
    """Return the largest of Rice's bounds of the vertices, in floating point."""
    found, limit = [], room(law, v, overspeed)
    one = system(law, v, overspeed, uncertain=True)
    for A, S in zip(one.A, one.S, strict=True):
        X = solve_continuous_lyapunov(A, -S @ S.T)
        variance, rate = X[E, E], (A @ X @ A.T)[E, E]
        ratio = limit**2 / (2 * variance)
        outside = 1 / np.sqrt(np.pi * ratio)
        found.append(np.exp(-ratio) * (outside + HORIZON / np.pi * np.sqrt(rate / variance)))
    return float(max(found))


def uncertain_model(law: Law, v: float) -> TSModel:
    """Return the loop at v with its parameters as premises, 32 rules."""
    noise = np.zeros((len(STATES), 1))
    noise[R] = float(f"{Wind.of_class_b(v).noise:.6g}")
    A = system(law, v, 0.15, uncertain=True).A  # A does not depend on the overspeed
    return TSModel(
        [[[float(f"{entry:.9g}") for entry in row] for row in vertex] for vertex in A],
        E=noise,
        states=[f"{name} [{unit}]" for name, unit in zip(STATES, UNITS, strict=True)],
        disturbances=["turbulence [m/s^2]"],
        premises=[
            Premise(name, float(f"{low:.9g}"), float(f"{high:.9g}"))
            for name, low, high in PARAMETERS
        ],
        name=f"NREL 5-MW, linear loop at {v:g} m/s",
    )


def certified(law: Law, v: float, folder: Path) -> str:
    """Write the certificate at v; return a row of the table."""
    overspeed, probability, pieces = ASKED[v]
    began = perf_counter()
    asked = CrossingProbability(
        noise=[1.0],
        horizon=HORIZON,
        signal="e",
        limit=float(f"{room(law, v, overspeed):.6g}"),
        probability=probability,
        pieces=pieces,
    )
    answer = certify(uncertain_model(law, v), claims=[asked])
    path = folder / f"crossing-{v:g}.json"
    answer.save(path)
    second = judge(path)[0].verdict
    claim = answer.document["claims"][0]
    both = f"{answer.verdict.name}, {second}"
    worst, size = worst_vertex(law, v, overspeed), path.stat().st_size / 1000
    return (
        f"| {v:g} | {100 * overspeed:g} % | {both} | {claim['probability']:g} | {worst:.2g} | "
        f"{len(claim['C'])} | {size:.0f} kB | {perf_counter() - began:.0f} s | {answer.tried[-1]}"
    )


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path)
    reader.add_argument("folder", type=Path)
    reader.add_argument("winds", type=float, nargs="*", default=list(ASKED))
    given = reader.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    law = Law.read(given.gains)
    for v in given.winds:
        print(certified(law, v, given.folder), flush=True)


if __name__ == "__main__":
    main()
