"""`takagi study overlap`: fatigue, energy and proof over the overlap of torque and pitch."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Model
from takagi.cli.output_place import finished_results_kept, require_folder_place
from takagi.cli.progress import progress
from takagi.cli.runs.makers import turbine_file

if TYPE_CHECKING:
    from takagi.reports.study.overlap import OverlapStudy


# What both studies do, and what there is for a plant.
COMPARED = ("study compares the laws", "`takagi simulate` shows how its law moves it")


def overlap(
    model: Model,
    out: Path,
    *,
    over: list[str] | None = None,
    seeds: int = 6,
    duration: float = 600.0,
    workers: int | None = None,
    scheduler: str | None = None,
    as_json: bool = False,
) -> int:
    """Measure fatigue, energy and proof of MODEL's laws over how far torque and pitch overlap."""
    source = turbine_file(model, *COMPARED)
    from takagi.reports.output import write_folder
    from takagi.reports.study.overlap import run_overlap_study, study_axes
    from takagi.reports.study.overlap_files import FILES, study_files

    axes = study_axes(over or [])
    require_folder_place(out, files=FILES, folders=("figures", "results"))
    with progress(f"takagi study overlap {model}") as tell:
        with finished_results_kept(out):
            study = run_overlap_study(
                source,
                axes,
                out,
                seeds=seeds,
                duration=duration,
                workers=workers,
                scheduler=scheduler,
                tell=tell,
            )
        tell("figures and tables")
        files = study_files(study)
        write_folder(out, files)
    written = [str(out / name) for name in files]
    print(_as_json(study, written) if as_json else _as_text(study, written))
    return UNPROVED if study.failed else PROVED


run = partial(run_command, "study overlap", overlap)


def _as_text(study: OverlapStudy, written: list[str]) -> str:
    runs = sum(map(len, study.runs))
    lines = [f"{len(study.points)} laws, {runs} runs of {study.duration:g} s"]
    if study.resumed:
        lines.append(f"{study.resumed} of {study.tasks} results were computed before")
    lines += [f"FAILED: {words}" for words in study.failed[:3]]
    return "\n".join([*lines, "", *written])


def _as_json(study: OverlapStudy, written: list[str]) -> str:
    counted = {"points": len(study.points), "results": study.tasks, "resumed": study.resumed}
    return json.dumps({**counted, "failed": study.failed, "files": written}, indent=2)
