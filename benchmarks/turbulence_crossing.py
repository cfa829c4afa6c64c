r"""Certificates that the turbine's linear loop rarely leaves its reference speed in turbulence.

    python benchmarks/turbulence_crossing.py CERTIFICATE FOLDER [WIND ...]

CERTIFICATE is that of ``takagi design nrel5mw``: turbine, law, observer and filters are its own.
At each mean wind the claim ``turbine-crossing`` is sought, with as many pieces of the parameters'
ranges as the probability of ``ROWS`` needs.  Printed for each wind: verdicts of both checkers,
overspeed, the probability of Rice's formula for the worst corner of the ranges (floating point: no
certificate can have less), that of the claim, pieces, size of the claim and time.
docs/turbulence-exit.md has the results.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Row:
    """What is sought at a mean wind [m/s].

    ``overspeed`` as a share of rated speed; ``probability`` asked for, None for the least of one
    piece; ``pieces`` at most; ``depth``: cuts before covariances are sought.
    """

    wind: float
    overspeed: float
    probability: float | None = None
    pieces: int = 1
    depth: int = 0


ROWS = (
    Row(5.2, 0.15),
    Row(7.0, 0.2),
    Row(8.0, 0.2),
    Row(9.0, 0.2, 1e-3, 16),
    Row(10.0, 0.25),
    Row(11.0, 0.15),
    Row(11.4, 0.2),
    Row(11.4, 0.15, 1.5e-3, 109, 5),
    Row(12.0, 0.2),
    Row(12.0, 0.15, 3e-3, 109, 5),
    Row(13.0, 0.2),
    Row(13.0, 0.15, 1e-3, 64, 3),
    Row(15.0, 0.2),
    Row(15.0, 0.15, 3e-3, 109, 4),
    Row(18.0, 0.25),
    Row(18.0, 0.2, 1e-3, 96, 3),
    Row(23.0, 0.35),
    Row(23.0, 0.3, 1e-3, 64, 1),
)


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


def certified(source: Any, row: Row, folder: Path) -> str:
    """Write the certificate of a row; return the row of the table."""
    began = perf_counter()
    asked = CrossingAsked(
        wind=row.wind,
        turbulence=RotorWind.of_class("B", row.wind),
        probability=1e-3 if row.probability is None else row.probability,
        overspeed=row.overspeed,
        horizon=HORIZON,
        pieces=row.pieces,
        depth=row.depth,
        least=row.probability is None,
    )
    head = f"| {row.wind:g} | {100 * row.overspeed:g} % |"
    given = source["model"], source["gains"], source["controller"], INERTIA
    claims, why = crossing_claim(*given, asked)
    if not claims:
        return f"{head} {why} | {perf_counter() - began:.0f} s"
    document = certificate_document(
        model=source["model"],
        gains=source["gains"],
        claims=claims,
        provenance={},
    )
    claim = claims[0]
    path = folder / f"crossing-{row.wind:g}-{100 * row.overspeed:g}.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    both = f"{check(path).verdict.name}, {judge(path)[0].verdict}"
    size = len(json.dumps(claim)) / 1000
    return (
        f"{head} {worst_corner(source, claim):.2g} | {both} | "
        f"{claim['probability']:g} | {len(claim['C'])} | {size:.0f} kB | "
        f"{perf_counter() - began:.0f} s |"
    )


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("certificate", type=Path)
    reader.add_argument("folder", type=Path)
    reader.add_argument("winds", type=float, nargs="*", default=[])
    given = reader.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    source = json.loads(given.certificate.read_text(encoding="utf-8"))
    for row in ROWS:
        if not given.winds or row.wind in given.winds:
            print(certified(source, row, given.folder), flush=True)


if __name__ == "__main__":
    main()
