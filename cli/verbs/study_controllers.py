"""`takagi study controllers`: a turbine's laws, its reference controller and ROSCO side by side."""

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
from takagi.cli.verbs.study_overlap import COMPARED
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.reports.study.controllers import ControllersStudy


def controllers(
    model: Model,
    out: Path,
    *,
    law: list[str] | None = None,
    rosco: list[str] | None = None,
    winds: str = "4,6,8,10,12,14,16,18,20,22,24",
    seeds: int = 6,
    duration: float = 600.0,
    weibull: str = "8.5:2",
    workers: int | None = None,
    scheduler: str | None = None,
    as_json: bool = False,
) -> int:
    """Compare MODEL's laws, its reference controller and ROSCO on the same plant and winds."""
    source = turbine_file(model, *COMPARED)
    from takagi.reports.output import write_folder
    from takagi.reports.study.controllers import run_controllers_study
    from takagi.reports.study.controllers_files import FILES, Weibull, study_files

    year, means = Weibull.read(weibull), _means(winds)
    require_folder_place(out, files=FILES, folders=("figures", "results"))
    with progress(f"takagi study controllers {model}") as tell:
        with finished_results_kept(out):
            study = run_controllers_study(
                source,
                out,
                laws=law or [],
                rosco=rosco or [],
                means=means,
                seeds=seeds,
                duration=duration,
                workers=workers,
                scheduler=scheduler,
                tell=tell,
            )
        tell("figure and tables")
        files = study_files(study, year)
        write_folder(out, files)
    written = [str(out / name) for name in files]
    print(_as_json(study, written) if as_json else _as_text(study, written))
    return UNPROVED if study.failed else PROVED


run = partial(run_command, "study controllers", controllers)


def _means(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError as error:
        raise ModelError(
            f"--winds {text} was given; mean winds in m/s are needed, such as 8,12,16"
        ) from error


def _as_text(study: ControllersStudy, written: list[str]) -> str:
    runs = sum(map(len, study.runs.values()))
    lines = [f"{len(study.laws)} laws, {runs} runs of {study.duration:g} s"]
    if study.resumed:
        lines.append(f"{study.resumed} of {study.tasks} results were computed before")
    lines += [f"FAILED: {words}" for words in study.failed[:3]]
    return "\n".join([*lines, "", *written])


def _as_json(study: ControllersStudy, written: list[str]) -> str:
    counted = {"laws": study.laws, "results": study.tasks, "resumed": study.resumed}
    return json.dumps({**counted, "failed": study.failed, "files": written}, indent=2)
