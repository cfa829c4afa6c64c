"""The claim about the loop around the trim at the schedule wind, over a range of winds.

The theorem and the results are in docs/schedule-rate.md.

``python benchmarks/turbine_schedule_rate.py CERTIFICATE [LOW HIGH RATE] [--out FILE]`` searches for
the claim about the certificate's turbine and law with schedule winds from LOW to HIGH [m/s] and a
wind that moves by at most RATE [m/s^2], and prints both checkers' verdicts, their times, and the
sets' half widths at every fourth schedule wind.
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
from takagi.certificates.claims.turbine import schedule_claim
from takagi.certificates.cross_check import judge_document

PARTS = ("model", "gains", "claims", "controller")


def of_one_claim(document: Any, claim: dict[str, Any]) -> dict[str, Any]:
    """Return the document with this claim alone, and the hashes of what it then says."""
    whole = document | {"claims": [claim]}
    read = read_text(json.dumps(whole), "document")
    return {**whole, "provenance": {"sha256": {part: digest(read.get(part)) for part in PARTS}}}


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("certificate", type=Path)
    reader.add_argument("low", type=Fraction, nargs="?", default=Fraction("15.0425"))
    reader.add_argument("high", type=Fraction, nargs="?", default=Fraction("24.0042"))
    reader.add_argument("rate", type=float, nargs="?", default=0.03)
    reader.add_argument("--out", type=Path, help="write a certificate with the claim alone")
    given = reader.parse_args()
    document = json.loads(given.certificate.read_text(encoding="utf-8"))
    running = next(one for one in document["claims"] if one["kind"] == "running-loop")
    parts = document["model"], document["gains"], document["controller"]
    started = time.process_time()
    claims, why = schedule_claim(
        *parts, running["uncertainty"]["inertia"], (given.low, given.high), given.rate
    )
    print(f"search: {time.process_time() - started:.0f} s of processor time {why or ''}")
    if not claims:
        return
    whole = of_one_claim(document, claims[0])
    if given.out is not None:
        given.out.write_text(json.dumps(whole), encoding="utf-8")
    print(f"claim: {len(json.dumps(claims[0])) / 1000:.0f} kB, {len(claims[0]['cells'])} cells")
    started = time.process_time()
    said = check_document(whole).claims[0]
    middle = time.process_time()
    other = judge_document(whole)[0].verdict
    times = middle - started, time.process_time() - middle
    print(f"{said.verdict.name} in {times[0]:.1f} s, {other} in {times[1]:.1f} s: {said.text}")
    print("| v_s [m/s] | speed [%] | pitch [deg] | v - v_s [m/s] | vhat - v_s [m/s] |")
    rated = document["model"]["rated_rotor_speed"]
    for one in claims[0]["functions"][::4]:
        e, p, lag, q = np.sqrt(np.diag(np.linalg.inv(np.array(one["P"]))))[[0, 1, 3, 6]]
        row = f"| {one['wind']:g} | {100 * e / rated:.1f} | {np.degrees(p):.1f}"
        print(f"{row} | {lag:.2f} | {q:.2f} |")


if __name__ == "__main__":
    main()
