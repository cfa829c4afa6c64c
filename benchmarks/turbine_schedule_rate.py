"""The claims about the loop around the trim at the schedule wind, over ranges of winds.

The theorem and the results are in docs/schedule-rate.md.

``python benchmarks/turbine_schedule_rate.py CERTIFICATE [LOW HIGH RATE] [--out FILE]`` searches for
the claim about the certificate's turbine and law with schedule winds from LOW to HIGH [m/s] and a
wind that moves by at most RATE [m/s^2], or for those of ``takagi certify
--moving-wind-above-rated``, and prints of each both checkers' verdicts, their times, and the sets'
half widths at every fourth schedule wind.
"""

from __future__ import annotations

import argparse
import json
import time
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.claims.turbine import schedule_claim, schedule_claims
from takagi.certificates.cross_check import judge_document

PARTS = ("model", "gains", "claims", "controller")


def of_claims(document: Any, claims: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the document with these claims alone, and the hashes of what it then says."""
    whole = document | {"claims": claims}
    read = read_text(json.dumps(whole), "document")
    return {**whole, "provenance": {"sha256": {part: digest(read.get(part)) for part in PARTS}}}


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("certificate", type=Path)
    reader.add_argument("range", nargs="*", metavar="LOW HIGH RATE")
    reader.add_argument("--out", type=Path, help="write a certificate with these claims alone")
    given = reader.parse_args()
    if len(given.range) not in (0, 3):
        reader.error("all of LOW, HIGH and RATE are needed, or none")
    document = json.loads(given.certificate.read_text(encoding="utf-8"))
    running = next(one for one in document["claims"] if one["kind"] == "running-loop")
    parts = document["model"], document["gains"], document["controller"]
    inertia = running["uncertainty"]["inertia"]
    started = time.process_time()
    if given.range:
        low, high = map(Fraction, given.range[:2])
        claims, why = schedule_claim(*parts, inertia, (low, high), float(given.range[2]), print)
    else:
        claims, why = schedule_claims(*parts, inertia, print)
    print(f"search: {time.process_time() - started:.0f} s of processor time {why or ''}")
    if claims and given.out is not None:
        whole = of_claims(document, claims)
        given.out.write_text(json.dumps(whole), encoding="utf-8")
    for claim in claims:
        shown(document, claim)


def shown(document: Any, claim: dict[str, Any]) -> None:
    """Print what both checkers say of one claim, and the widths of its sets."""
    whole = of_claims(document, [claim])
    print(f"claim: {len(json.dumps(claim)) / 1000:.0f} kB, {len(claim['cells'])} cells")
    started = time.process_time()
    said = check_document(whole).claims[0]
    middle = time.process_time()
    other = judge_document(whole)[0].verdict
    times = middle - started, time.process_time() - middle
    print(f"{said.verdict.name} in {times[0]:.1f} s, {other} in {times[1]:.1f} s: {said.text}")
    print("| v_s [m/s] | speed [%] | pitch [deg] | v - v_s [m/s] | vhat - v_s [m/s] |")
    rated = document["model"]["rated_rotor_speed"]
    for one in claim["functions"][::4]:
        e, p, lag, q = np.sqrt(np.diag(np.linalg.inv(np.array(one["P"]))))[[0, 1, 3, 6]]
        row = f"| {one['wind']:g} | {100 * e / rated:.1f} | {np.degrees(p):.1f}"
        print(f"{row} | {lag:.2f} | {q:.2f} |")


if __name__ == "__main__":
    main()
