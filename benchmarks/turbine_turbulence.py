"""The rotor speed that the nonlinear loop seldom reaches in class B turbulence of a low mean wind.

The theorem and the results are in docs/turbulence-speed.md.

``python benchmarks/turbine_turbulence.py CERTIFICATE MEAN PROBABILITY [--least-estimate 3]
[--excess 0] [--class-a] [--out FILE]`` searches for the claim about the certificate's turbine and
law with the least speed, for ten minutes, and prints both checkers' verdicts and times.

``... CERTIFICATE MEAN --simulate`` prints the largest speed in 400 runs of the nonlinear loop, with
the wake that the claim leaves out (``turbulence_exit_about_schedule``); CERTIFICATE is then the
gain file.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
from turbine_schedule_rate import of_claims

from takagi.certificates.checker import check_document
from takagi.certificates.claims.turbine import SpeedAsked, speed_claim
from takagi.certificates.cross_check import judge_document
from takagi.models.turbine import RotorWind

HORIZON, RUNS = 600.0, 400


def simulated(gains: Path, mean: float) -> None:
    """Print quantiles over runs of the largest speed, over rated."""
    from turbulence_exit_about_schedule import RATED, Loop
    from turbulence_exit_loop import Law

    largest = Loop(Law.read(gains), mean).simulated(HORIZON, RUNS) / RATED
    told = ", ".join(f"{q:g}: {100 * np.quantile(largest, q):.1f}" for q in (0.5, 0.9, 0.99, 1))
    print(f"{mean:g} m/s, largest speed of {RUNS} runs [% of rated], quantiles {told}")


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("certificate", type=Path)
    reader.add_argument("mean", type=float)
    reader.add_argument("probability", type=float, nargs="?", default=1e-3)
    reader.add_argument("--least-estimate", type=float, default=3.0)
    reader.add_argument("--excess", type=float, default=0.0)
    reader.add_argument("--class-a", action="store_true", help="16/14 of class B's wind")
    reader.add_argument("--out", type=Path, help="write a certificate with the claim alone")
    reader.add_argument("--simulate", action="store_true")
    given = reader.parse_args()
    if given.simulate:
        simulated(given.certificate, given.mean)
        return
    document = json.loads(given.certificate.read_text(encoding="utf-8"))
    running = next(one for one in document["claims"] if one["kind"] == "running-loop")
    wind = RotorWind.of_class("A" if given.class_a else "B", given.mean)
    started = time.process_time()
    claims, why = speed_claim(
        document["model"],
        document["gains"],
        document["controller"],
        running["uncertainty"]["inertia"],
        SpeedAsked(
            mean=given.mean,
            deviation=wind.deviation,
            rate=wind.rate,
            probability=given.probability,
            horizon=HORIZON,
            least_estimate=given.least_estimate,
            excess=given.excess,
        ),
    )
    print(f"search: {time.process_time() - started:.0f} s of processor time {why or ''}")
    if not claims:
        return
    whole = of_claims(document, claims)
    if given.out is not None:
        given.out.write_text(json.dumps(whole), encoding="utf-8")
    started = time.process_time()
    said = check_document(whole).claims[0]
    middle = time.process_time()
    other = judge_document(whole)[0].verdict
    times = middle - started, time.process_time() - middle
    print(f"{said.verdict.name} in {times[0]:.1f} s, {other} in {times[1]:.1f} s: {said.text}")


if __name__ == "__main__":
    main()
