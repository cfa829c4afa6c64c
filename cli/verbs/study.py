"""`takagi study`: laws of one turbine over many winds and seeds, as tables and figures."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from takagi.cli.command import MISUSE, PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Model
from takagi.cli.output_place import kept_results, require_folder_place
from takagi.cli.runs.makers import turbine_file
from takagi.models.errors import ModelError, did_you_mean

if TYPE_CHECKING:
    from takagi.reports.study.controllers import ControllersStudy
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
    from takagi.reports.study.overlap import run_overlap_study, study_axes
    from takagi.reports.study.overlap_files import FILES, study_files

    axes = study_axes(over or [])
    require_folder_place(out, files=FILES, folders=("figures", "results"))
    asked: dict[str, Any] = {"seeds": seeds, "duration": duration}
    asked |= {"workers": workers, "scheduler": scheduler}
    study, written = kept_results(
        f"takagi study overlap {model}",
        out,
        lambda tell: run_overlap_study(source, axes, out, tell=tell, **asked),
        study_files,
    )
    _print(study, {"points": len(study.points)}, study.runs, written, as_json=as_json)
    return UNPROVED if study.failed else PROVED


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
    from takagi.reports.study.controllers import run_controllers_study
    from takagi.reports.study.controllers_files import FILES, Weibull, study_files

    year = Weibull.read(weibull)
    asked: dict[str, Any] = {"laws": law or [], "rosco": rosco or [], "means": _means(winds)}
    asked |= {"seeds": seeds, "duration": duration, "workers": workers, "scheduler": scheduler}
    require_folder_place(out, files=FILES, folders=("figures", "results"))
    study, written = kept_results(
        f"takagi study controllers {model}",
        out,
        lambda tell: run_controllers_study(source, out, tell=tell, **asked),
        lambda finished: study_files(finished, year),
    )
    runs = [study.runs[name] for name in study.laws]
    _print(study, {"laws": study.laws}, runs, written, as_json=as_json)
    return UNPROVED if study.failed else PROVED


def _means(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError as error:
        raise ModelError(
            f"--winds {text} was given; mean winds in m/s are needed, such as 8,12,16"
        ) from error


def _print(
    study: OverlapStudy | ControllersStudy,
    subject: dict[str, Any],
    runs: Sequence[Sequence[object]],
    written: list[str],
    *,
    as_json: bool,
) -> None:
    if as_json:
        counted = {**subject, "results": study.tasks, "resumed": study.resumed}
        print(json.dumps({**counted, "failed": study.failed, "files": written}, indent=2))
        return
    lines = [f"{len(runs)} laws, {sum(map(len, runs))} runs of {study.duration:g} s"]
    if study.resumed:
        lines.append(f"{study.resumed} of {study.tasks} results were computed before")
    lines += [f"FAILED: {words}" for words in study.failed[:3]]
    print("\n".join([*lines, "", *written]))


class Study(NamedTuple):
    """A study: its name, its help in one line without a full stop, and what runs it."""

    name: str
    help: str
    function: Callable[..., int]


STUDIES = (
    Study("overlap", "Fatigue, energy and proof over how far torque and pitch overlap", overlap),
    Study("controllers", "Laws, reference controller and ROSCO on the same plant and winds",
          controllers),
)  # fmt: skip


def run(arguments: Sequence[str]) -> int:
    """Run the study that is named first; return its exit status."""
    first, following = (arguments[0], arguments[1:]) if arguments else ("", arguments)
    for study in STUDIES:
        if study.name == first:
            return run_command(f"study {first}", study.function, following)
    if first in ("--help", "-h"):
        print(_help())
        return 0
    names = [study.name for study in STUDIES]
    given = f"{first!r} is not a study{did_you_mean(first, names)}" if first else "none was named"
    print(f"{_help()}\nError: {given}; known: {', '.join(names)}", file=sys.stderr)
    return MISUSE


def _help() -> str:
    listed = "\n".join(f"  {study.name:<12}  {study.help}" for study in STUDIES)
    return (
        "Usage: takagi study NAME MODEL --out DIR [OPTIONS]\n\n"
        "Compare laws of MODEL, a wind turbine, in many winds. A study that was stopped goes on\n"
        f"where it was when the same command is given again.\n\nStudies:\n{listed}\n\n"
        "`takagi study NAME --help` explains a study."
    )
