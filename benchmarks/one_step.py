"""Compares gains found with the function together, gains found before it, and the reference's.

    python benchmarks/one_step.py [--steps N] [--resume] [--only NAME ...]

writes a table into docs/benchmarks.md and the figures with the gains into a JSON file, a row at a
time; ``--resume`` keeps the rows that are there.  Every row is a certificate of the NREL 5-MW loop
at the default box and uncertainty, made in the same way and judged by the checker; its wind errors
in each cell are as large as the function allows.

Rows:

- two-step: gains by wind (``effort_gains``), then the functions;
- one-step: from those gains, gains and functions together, for each objective that has a name;
- reference PI: the pitch controller's own design, natural frequency 0.6 rad/s and damping 0.7, read
  as gamma = 2 zeta omega_n and nu = omega_n / (2 zeta), times the share of the frozen-wake pitch
  effectiveness that the schedule assumes, so that pitch moves as much; where torque alone acts the
  two-step gains stay, for the reference has no speed control there.  Source: Jonkman, Butterfield,
  Musial, Scott (2009), NREL/TP-500-38060, section 7.3.  It has no function for all winds: what is
  certified is the claim about its winds from 13 m/s on.

Nothing is asserted.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402  the threads are counted when numpy is loaded
from measure import PAGE, placed, table  # noqa: E402

from takagi.certificates.checker.replay.certificate import check_document  # noqa: E402
from takagi.certificates.claims.turbine.effort_sharing import (  # noqa: E402
    DEFAULT_BOX,
    DEFAULT_UNCERTAINTY,
    effort_sharing_claim,
)
from takagi.certificates.claims.turbine.largest_wind_error import (  # noqa: E402
    EffortSharingCandidate,
)
from takagi.certificates.design.turbine.effort_sharing_gains import effort_sharing_gain_design  # noqa: E402
from takagi.certificates.document.certificate_file import (  # noqa: E402
    certificate_document,
    effort_sharing_law_data,
    turbine_data,
)
from takagi.lmi.turbine.effort import effort_gains  # noqa: E402
from takagi.lmi.turbine.one_step.design import STEPS  # noqa: E402
from takagi.lmi.turbine.one_step.motion import motion  # noqa: E402
from takagi.lmi.turbine.one_step.objective import OBJECTIVES  # noqa: E402
from takagi.models.errors import ModelError  # noqa: E402
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw  # noqa: E402
from takagi.models.laws.effort_sharing.schedule import effort_schedule  # noqa: E402
from takagi.models.turbine.data import Turbine  # noqa: E402
from takagi.models.turbine.loader import nrel5mw  # noqa: E402
from takagi.reports.page.rounded_bounds import at_least_to, at_most_to  # noqa: E402

NATURAL_FREQUENCY, DAMPING = 0.6, 0.7  # rad/s, -
FULL_LOAD_FROM = 13.0  # m/s
DATA = PAGE.parent / "figures" / "one-step.json"
Row = dict[str, Any]


def main() -> None:
    """Design, certify, and write table and data."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--resume", action="store_true", help="keep the rows of the data file")
    parser.add_argument("--only", action="append", choices=[*OBJECTIVES, "two-step", "reference"])
    given = parser.parse_args()
    turbine = nrel5mw()
    law = two_step_law(turbine)
    rows: dict[str, Row] = {}
    if given.resume and given.data.is_file():
        rows = json.loads(given.data.read_text(encoding="utf-8"))
    for name in given.only or ["two-step", "reference", *OBJECTIVES]:
        if name in rows:
            continue
        rows[name] = (
            reference_row(turbine, law)
            if name == "reference"
            else row_of(turbine, law, name, given.steps)
        )
        shown = {k: v for k, v in rows[name].items() if not isinstance(v, list)}
        print(name, shown, flush=True)
        given.data.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    content = written(rows)
    print(content)
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "one-step", content), encoding="utf-8")


def two_step_law(turbine: Turbine) -> EffortSharingLaw:
    """Return the law with the gains found wind by wind."""
    schedule = effort_schedule(turbine)
    return EffortSharingLaw.of(turbine, schedule, effort_gains(turbine, schedule).gains)


def row_of(turbine: Turbine, law: EffortSharingLaw, name: str, steps: int) -> Row:
    """Return the row of a synthesis: two-step, or one-step with a named objective."""
    began = time.process_time()
    found = effort_sharing_gain_design(
        turbine,
        law,
        box=DEFAULT_BOX,
        uncertainty=DEFAULT_UNCERTAINTY,
        synthesis="two-step" if name == "two-step" else "one-step",
        objective=OBJECTIVES.get(name),
        steps=steps,
    )
    row = certified(turbine, found.law, found.candidate)
    row["seconds"] = time.process_time() - began
    if found.joint is not None:
        row |= {"steps": len(found.joint.history) - 1, "refused": found.joint.refused}
    return row | ({"kept": found.kept} if found.kept else {})


def reference_row(turbine: Turbine, law: EffortSharingLaw) -> Row:
    """Return what is certified of the reference's gains, and why not at all winds."""
    own = replace(law, gains=reference_gains(law))
    wind = own.schedule.wind
    part = law_from(own, int(np.argmax(wind >= FULL_LOAD_FROM)))
    asked: dict[str, Any] = {
        "box": DEFAULT_BOX,
        "uncertainty": DEFAULT_UNCERTAINTY,
        "synthesis": "two-step",
    }
    try:
        return certified(turbine, own, effort_sharing_gain_design(turbine, own, **asked).candidate)
    except ModelError as error:
        row = certified(turbine, part, effort_sharing_gain_design(turbine, part, **asked).candidate)
        return row | {"why": str(error)}


def law_from(law: EffortSharingLaw, first: int) -> EffortSharingLaw:
    """Return the law with its tables from a node on: the same commands at those winds."""
    columns = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")
    ahead = law.feedforward
    return replace(
        law,
        schedule=replace(
            law.schedule, **{name: getattr(law.schedule, name)[first:] for name in columns}
        ),
        gains=EffortGains(law.gains.proportional[first:], law.gains.integral_rate[first:]),
        feedforward=replace(
            ahead, inertia=ahead.inertia[first:], effort_limit=ahead.effort_limit[first:]
        ),
    )


def certified(turbine: Turbine, law: EffortSharingLaw, candidate: EffortSharingCandidate) -> Row:
    """Return the checker's verdict on a certificate of the candidate, and what it states."""
    claim = effort_sharing_claim(candidate)
    document = certificate_document(
        model=turbine_data(turbine, []),
        gains=effort_sharing_law_data(law),
        claims=[claim],
        provenance={},
    )
    checked = check_document(document)
    moved = motion(turbine, law)
    share = np.diff(law.schedule.wind) / np.ptp(law.schedule.wind)
    full = law.schedule.wind[:-1] >= FULL_LOAD_FROM
    top = float(law.schedule.rotor_speed.max()) + claim["peaks"]["speed_error"]
    error = candidate.wind_error
    return {
        "verdict": checked.verdict.name,
        "winds": [float(law.schedule.wind[0]), float(law.schedule.wind[-1])],
        "overspeed": top / turbine.rated_rotor_speed - 1,
        "wind_error_mean": float(np.exp(share @ np.log(error))),
        "wind_error_least": float(error.min()),
        "full_load_error": float(error[full].min()),
        "full_load_rate": float(candidate.wind_rate[full].min()),
        "decay_rate": candidate.common_rate,
        "pitch_rate": float(share @ moved.pitch_rate),
        "tower_speed": float(share @ moved.tower_speed),
        "full_load_pitch_rate": float(share[full] @ moved.pitch_rate[full] / share[full].sum()),
        "full_load_tower_speed": float(share[full] @ moved.tower_speed[full] / share[full].sum()),
        "wind_error": error.tolist(),
        "wind_rate": candidate.wind_rate.tolist(),
        "proportional": law.gains.proportional.tolist(),
        "integral_rate": law.gains.integral_rate.tolist(),
    }


def reference_gains(law: EffortSharingLaw) -> EffortGains:
    """Return the reference pitch controller's gains where the trim effort is above zero."""
    table_ = law.schedule
    share = table_.effectiveness / table_.effectiveness_limit
    pitch = table_.trim_effort > 0
    gamma = np.where(pitch, 2 * DAMPING * NATURAL_FREQUENCY * share, law.gains.proportional)
    inside = pitch[:-1] & pitch[1:]
    nu = np.where(inside, NATURAL_FREQUENCY / (2 * DAMPING), law.gains.integral_rate)
    return EffortGains(
        np.asarray(np.round(gamma, 5), dtype=np.float64),
        np.asarray(np.round(nu, 6), dtype=np.float64),
    )


def written(rows: Mapping[str, Row]) -> str:
    """Return the table."""
    heads = (
        "gains",
        "certificate",
        "overspeed at most",
        "wind error allowed, mean (least) [m/s]",
        f"least from {FULL_LOAD_FROM:g} m/s on, schedule wind moving at [m/s^2]",
        "common decay rate [1/s]",
        f"pitch rate from {FULL_LOAD_FROM:g} m/s on, per m/s of turbulence [deg/s]",
        "tower speed there [mm/s]",
        "steps taken",
        "processor time",
    )
    return table(heads, [_row(name, row) for name, row in rows.items()])


def _row(name: str, row: Row) -> tuple[str, ...]:
    title = {"two-step": "two-step", "reference": "reference PI"}.get(name, f"one-step, {name}")
    low, high = row["winds"]
    return (
        title,
        f"{row['verdict']}, {low:g} to {high:g} m/s",
        f"{at_most_to(100 * row['overspeed'], 2)} %",
        f"{at_least_to(row['wind_error_mean'], 4)} ({at_least_to(row['wind_error_least'], 4)})",
        f"{at_least_to(row['full_load_error'], 4)}, {row['full_load_rate']:g}",
        at_least_to(row["decay_rate"], 4),
        f"{np.rad2deg(row['full_load_pitch_rate']):.4f}",
        f"{1e3 * row['full_load_tower_speed']:.2f}",
        str(row.get("steps", "")),
        f"{row['seconds']:.0f} s" if "seconds" in row else "",
    )


if __name__ == "__main__":
    main()
