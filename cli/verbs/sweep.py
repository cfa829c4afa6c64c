"""`takagi sweep`: where a law is proved, over a grid of its parameters."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import IN_FILES, Model, law_in_files, typed_name
from takagi.cli.output_place import kept_results, require_folder_place
from takagi.cli.runs.makers import turbine_file
from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from takagi.certificates.sweep.sweep import Axis, Sweep


def sweep(
    model: Model,
    out: Path,
    over: list[str] | None = None,
    *,
    law: str | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    as_json: bool = False,
) -> int:
    """Map where a law of MODEL, a wind turbine, is proved, over a grid of its parameters."""
    source = turbine_file(model, "sweep maps the laws", "`takagi design` proves a plant's law")
    named = _law(law_in_files(law) or "paper")
    axes = _axes(named, over or [])
    require_folder_place(out)
    from takagi.certificates.sweep.sweep import run_sweep
    from takagi.reports.sweep.campaigns import sweep_files

    result, written = kept_results(
        f"takagi sweep {model}",
        out,
        lambda tell: run_sweep(
            named, source, axes, out, workers=workers, scheduler=scheduler, tell=tell
        ),
        sweep_files,
        what="points",
    )
    print(_as_json(result, written) if as_json else _as_text(result, out, written))
    return UNPROVED if "FAILED" in result.counted() else PROVED


run = partial(run_command, "sweep", sweep)


def _law(name: str) -> str:
    if name not in IN_FILES.values():
        raise ModelError(
            f"--law {name}: this law cannot be swept{did_you_mean(name, IN_FILES)}; known: "
            + ", ".join(IN_FILES)
        )
    return name


def _axes(law: str, over: Sequence[str]) -> Sequence[Axis]:
    from takagi.certificates.sweep.sweep import LAWS, parse_axes

    if not over:
        raise ModelError(
            f"no axis was given: add --over NAME=LOW:HIGH:COUNT for --law {typed_name(law)}; known "
            "here: " + ", ".join(kind.name for kind in LAWS[law])
        )
    return parse_axes(over, LAWS[law])


def _as_text(result: Sweep, out: Path, written: list[str]) -> str:
    counted = ", ".join(f"{number} {verdict}" for verdict, number in result.counted().items())
    axes = " x ".join(f"{axis.name} ({len(axis.values)})" for axis in result.axes) or "1 point"
    lines = [f"{typed_name(result.law)} over {axes}: {counted}"]
    if result.resumed:
        lines.append(f"{result.resumed} of {len(result.rows)} points were computed before")
    for row in [row for row in result.rows if row["verdict"] == "FAILED"][:3]:
        at = ", ".join(f"{axis.name} {row[axis.label]:g}" for axis in result.axes)
        lines.append(f"FAILED at {at}: {row['reason']}")
    return "\n".join(
        [*lines, "", str(out), *(f"  {Path(name).relative_to(out)}" for name in written)]
    )


def _as_json(result: Sweep, written: list[str]) -> str:
    return json.dumps(
        {
            "law": result.law,
            "axes": [
                {"name": axis.name, "unit": axis.unit, "values": list(axis.values)}
                for axis in result.axes
            ],
            "points": len(result.rows),
            "resumed": result.resumed,
            "verdicts": result.counted(),
            "files": written,
        },
        indent=2,
    )
