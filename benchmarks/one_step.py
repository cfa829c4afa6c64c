"""Compares gains found with the function together with gains found before it, and with others.

    python benchmarks/one_step.py [--steps N] [--data FILE]

writes a table into docs/benchmarks.md and the figures with the gains into a JSON file.  Every row
is judged by the same analysis on the NREL 5-MW loop, at the box, the uncertainty and the wind class
that a certificate takes by default: one function for all winds, its wind errors in each cell as
large as it bears.  The set lies in the same box in every row, so the overspeed bound is the same.

Rows:

- two-step: gains by wind (``effort_gains``), then the analysis;
- one-step: from those gains, by ``one_step_gains``, for several objectives;
- reference PI: the pitch controller's own design, natural frequency 0.6 rad/s and damping 0.7, read
  as gamma = 2 zeta omega_n and nu = omega_n / (2 zeta), times the share of the frozen-wake pitch
  effectiveness that the schedule assumes, so that pitch moves as much; where torque alone acts the
  two-step gains stay, for the reference has no speed control there.  Source: Jonkman, Butterfield,
  Musial, Scott (2009), NREL/TP-500-38060, section 7.3.

Nothing is asserted, and nothing here is a proof.
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

from takagi.certificates.coherent import (  # noqa: E402
    DEFAULT_BOX,
    DEFAULT_UNCERTAINTY,
    WindClass,
)
from takagi.certificates.wind_class import asked_rates  # noqa: E402
from takagi.lmi.turbine.effort import effort_gains  # noqa: E402
from takagi.lmi.turbine.one_step import effort_loop_reach, one_step_gains  # noqa: E402
from takagi.lmi.turbine.one_step_family import LoopFamily  # noqa: E402
from takagi.lmi.turbine.one_step_motion import motion  # noqa: E402
from takagi.lmi.turbine.one_step_objective import Objective  # noqa: E402
from takagi.models.embedding.coherent import CellLoop  # noqa: E402
from takagi.models.errors import ModelError  # noqa: E402
from takagi.models.law.coherent import CoherentLaw, EffortGains  # noqa: E402
from takagi.models.law.schedule import effort_schedule  # noqa: E402
from takagi.models.turbine.loader import nrel5mw  # noqa: E402

NATURAL_FREQUENCY, DAMPING = 0.6, 0.7  # rad/s, -
FULL_LOAD_FROM = 13.0  # m/s
NODES = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")

OBJECTIVES: Mapping[str, Objective] = {
    "one-step, wind class": Objective(),
    "one-step, wind class and decay": Objective(decay=0.5),
    "one-step, wind class, calm pitch and tower": Objective(wind_class=0.2, pitch=1.0, tower=1.0),
}


def main() -> None:
    """Design, analyse, and write table and data."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--data", type=Path, default=PAGE.parent / "figures" / "one-step.json")
    parser.add_argument("--resume", action="store_true", help="keep the gains of the data file")
    given = parser.parse_args()
    family = default_family()
    rows: dict[str, dict[str, Any]] = {}
    if given.resume and given.data.is_file():
        rows = json.loads(given.data.read_text(encoding="utf-8"))
        # Gains are kept; what they reach is judged anew, so that all rows stand on one analysis.
        for name, row in rows.items():
            gains = EffortGains(np.array(row["proportional"]), np.array(row["integral_rate"]))
            spent = {key: row[key] for key in ("seconds", "steps", "refused") if key in row}
            rows[name] = judged(family, gains) | spent
    for name, gains in (
        ("two-step", family.law.gains),
        ("reference PI", reference_gains(family.law)),
    ):
        if name not in rows:
            rows[name] = judged(family, gains)
    for name, objective in OBJECTIVES.items():
        if name in rows:
            continue
        began = time.perf_counter()
        found = one_step_gains(family, objective=objective, steps=given.steps)
        spent = time.perf_counter() - began
        rows[name] = judged(family, found.gains) | {
            "seconds": spent,
            "steps": len(found.history) - 1,
            "refused": found.refused,
        }
        print(name, rows[name], flush=True)
        given.data.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    content = written(rows, family)
    print(content)
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "one-step", content), encoding="utf-8")


def default_family() -> LoopFamily:
    """Return the NREL 5-MW loop at its two-step gains, with the defaults of a certificate."""
    turbine = nrel5mw()
    schedule = effort_schedule(turbine)
    law = CoherentLaw.of(turbine, schedule, effort_gains(turbine, schedule).gains)
    shape = WindClass()
    loops = [
        CellLoop(turbine, law, DEFAULT_BOX, DEFAULT_UNCERTAINTY, k)
        for k in range(len(schedule.wind) - 1)
    ]
    middle = (schedule.wind[1:] + schedule.wind[:-1]) / 2
    return LoopFamily(
        turbine=turbine,
        law=law,
        box=DEFAULT_BOX,
        uncertainty=DEFAULT_UNCERTAINTY,
        error=np.interp(middle, shape.wind, shape.error),
        rate=asked_rates(loops, DEFAULT_BOX, shape),
    )


def reference_gains(law: CoherentLaw) -> EffortGains:
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


def judged(family: LoopFamily, gains: EffortGains) -> dict[str, Any]:
    """Return what gains reach over all winds, or why nothing."""
    law = replace(family.law, gains=gains)
    above = from_wind(replace(family, law=law), FULL_LOAD_FROM)
    moved = motion(family.turbine, law)
    widths = np.diff(law.schedule.wind)
    share = widths / widths.sum()
    row: dict[str, Any] = {
        "proportional": gains.proportional.tolist(),
        "integral_rate": gains.integral_rate.tolist(),
        "pitch_rate": float(share @ moved.pitch_rate),
        "tower_speed": float(share @ moved.tower_speed),
        "speed": float(share @ moved.speed),
    }
    for part, each in (("", replace(family, law=law)), ("full_load_", above)):
        try:
            reached = effort_loop_reach(each)
            row |= {
                f"{part}{name}": getattr(reached, name) for name in ("wind_error", "decay_rate")
            }
        except ModelError as error:
            row[f"{part}why"] = str(error)
    return row


def from_wind(family: LoopFamily, wind: float) -> LoopFamily:
    """Return the loop of the cells above a wind, with one function for them alone."""
    law = family.law
    kept = law.schedule.wind >= wind
    cells = kept[:-1]
    ahead = law.feedforward
    part = replace(
        law,
        schedule=replace(
            law.schedule, **{name: getattr(law.schedule, name)[kept] for name in NODES}
        ),
        gains=EffortGains(law.gains.proportional[kept], law.gains.integral_rate[cells]),
        feedforward=replace(
            ahead, inertia=ahead.inertia[cells], effort_limit=ahead.effort_limit[cells]
        ),
    )
    rates = [rate for rate, each in zip(family.rate, cells, strict=True) if each]
    return replace(family, law=part, error=family.error[cells], rate=rates)


def written(rows: Mapping[str, Mapping[str, Any]], family: LoopFamily) -> str:
    """Return the table."""
    bound = 100.0 * float(DEFAULT_BOX.speed_error) / family.turbine.rated_rotor_speed
    heads = (
        "gains",
        f"mean wind error borne, overspeed <= {bound:.1f} % [m/s]",
        "common decay rate [1/s]",
        f"the same from {FULL_LOAD_FROM:g} m/s on [m/s]",
        "[1/s]",
        "pitch rate per m/s of turbulence [deg/s]",
        "tower speed per m/s of turbulence [mm/s]",
        "steps taken",
        "time",
    )
    return table(heads, [_row(name, row) for name, row in rows.items()])


def _row(name: str, row: Mapping[str, Any]) -> tuple[str, ...]:
    def shown(key: str, form: str, factor: float = 1.0) -> str:
        value = row.get(key)
        return "none" if value is None else f"{factor * float(value):{form}}"

    spent = f"{row['seconds']:.0f} s" if "seconds" in row else ""
    return (
        name,
        shown("wind_error", ".4f"),
        shown("decay_rate", ".4f"),
        shown("full_load_wind_error", ".4f"),
        shown("full_load_decay_rate", ".4f"),
        shown("pitch_rate", ".4f", float(np.rad2deg(1.0))),
        shown("tower_speed", ".3f", 1e3),
        str(row.get("steps", "")),
        spent,
    )


if __name__ == "__main__":
    main()
