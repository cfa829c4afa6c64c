r"""Certificates that the turbine's linear loop rarely leaves its reference speed in turbulence.

    python benchmarks/turbulence_crossing.py CERTIFICATE FOLDER [WIND ...]

CERTIFICATE is that of ``takagi design nrel5mw``: turbine, law, observer and filters are its own.
At each mean wind the claim ``turbine-crossing`` is sought, with as many pieces of the parameters'
ranges as the probability of ``ASKED`` needs.  Printed for each wind: verdicts of both checkers,
overspeed, the probability of Rice's formula for the worst corner of the ranges (floating point: no
certificate can have less), that of the claim, pieces, size of the claim and time.
docs/turbulence-exit.md has the results.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.certificates import check
from takagi.certificates.claims.turbine import CrossingAsked, crossing_claim
from takagi.certificates.claims.turbine.linear_loop.turbine_crossing_claim import linear_loop
from takagi.certificates.cross_check import judge
from takagi.certificates.document import certificate_document
from takagi.certificates.requests.loop.exact_floats import floats
from takagi.models.turbine import RotorWind

HORIZON, INERTIA = 600.0, [0.9, 1.1]
# Wind [m/s] -> overspeed as a share of rated speed, the probability asked for (None: the least of
# one piece), the most pieces, and the cuts before covariances are sought.
ASKED: dict[float, tuple[float, float | None, int, int]] = {
    5.2: (0.15, None, 1, 0),
    7.0: (0.2, None, 1, 0),
    8.0: (0.2, None, 1, 0),
    9.0: (0.2, 1e-3, 16, 0),
    10.0: (0.25, None, 1, 0),
    11.0: (0.15, None, 1, 0),
    11.4: (0.15, 1e-3, 128, 5),
    12.0: (0.15, 3e-3, 128, 5),
    13.0: (0.15, 1e-3, 64, 3),
    15.0: (0.15, 3e-3, 128, 4),
    18.0: (0.2, 1e-3, 64, 3),
    23.0: (0.3, 1e-3, 64, 1),
}


def worst_corner(source: Any, claim: Any) -> float:
    """Return the largest of Rice's bounds of the corners, in floating point."""
    linear, box = linear_loop(source["model"], source["gains"], claim)
    h = floats(linear.row)[0]
    S = np.zeros((len(h), len(h)))
    S[10, 10] = float(linear.wind.intensity)
    limit, found = claim["overspeed"] * source["model"]["rated_rotor_speed"], []
    for A in map(floats, linear.at(box)):
        X = solve_continuous_lyapunov(A, -S)
        variance, rate = h @ X @ h, h @ A @ X @ A.T @ h
        ratio = limit**2 / (2 * variance)
        outside = 1 / np.sqrt(np.pi * ratio)
        found.append(np.exp(-ratio) * (outside + HORIZON / np.pi * np.sqrt(rate / variance)))
    return float(max(found))


def certified(source: Any, v: float, folder: Path) -> str:
    """Write the certificate at v; return a row of the table."""
    overspeed, probability, pieces, depth = ASKED[v]
    began = perf_counter()
    asked = CrossingAsked(
        wind=v,
        turbulence=RotorWind.of_class("B", v),
        probability=1e-3 if probability is None else probability,
        overspeed=overspeed,
        horizon=HORIZON,
        pieces=pieces,
        depth=depth,
        least=probability is None,
    )
    given = source["model"], source["gains"], source["controller"], INERTIA
    claims, why = crossing_claim(*given, asked)
    if not claims:
        return f"| {v:g} | {100 * overspeed:g} % | {why} | {perf_counter() - began:.0f} s"
    document = certificate_document(
        model=source["model"],
        gains=source["gains"],
        claims=claims,
        provenance={},
    )
    path, claim = folder / f"crossing-{v:g}.json", claims[0]
    path.write_text(json.dumps(document), encoding="utf-8")
    both = f"{check(path).verdict.name}, {judge(path)[0].verdict}"
    size = len(json.dumps(claim)) / 1000
    return (
        f"| {v:g} | {100 * overspeed:g} % | {worst_corner(source, claim):.2g} | {both} | "
        f"{claim['probability']:g} | {len(claim['C'])} | {size:.0f} kB | "
        f"{perf_counter() - began:.0f} s |"
    )


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("certificate", type=Path)
    reader.add_argument("folder", type=Path)
    reader.add_argument("winds", type=float, nargs="*", default=list(ASKED))
    given = reader.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    source = json.loads(given.certificate.read_text(encoding="utf-8"))
    for v in given.winds:
        print(certified(source, v, given.folder), flush=True)


if __name__ == "__main__":
    main()
