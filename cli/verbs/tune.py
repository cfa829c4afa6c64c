"""`takagi tune`: settings of the effort-sharing law that are best for the machine, each PROVED."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Model
from takagi.cli.output_place import kept_results, require_folder_place
from takagi.cli.runs.makers import turbine_file

if TYPE_CHECKING:
    from takagi.reports.study.tuning import Tuning


def tune(
    model: Model,
    out: Path,
    *,
    minimise: str = "tower-del",
    require: str = "energy >= -0.2 %, recovery 30s, shaft-del <= 1.0",
    tries: int = 120,
    seeds: int = 2,
    duration: float = 600.0,
    workers: int | None = None,
    scheduler: str | None = None,
    as_json: bool = False,
) -> int:
    """Tune the effort-sharing law of MODEL, a wind turbine, on the validation plant."""
    source = turbine_file(
        model, "tune tunes the law", "`takagi design --settle` sets how fast its law is"
    )
    from takagi.reports.study.tuning import tuned
    from takagi.reports.study.tuning_files import FILES, tuning_files

    require_folder_place(out, files=FILES, folders=("figures", "results"))
    asked: dict[str, Any] = {"minimise": minimise, "require": require, "tries": tries}
    asked |= {"seeds": seeds, "duration": duration, "workers": workers, "scheduler": scheduler}
    tuning, written = kept_results(
        f"takagi tune {model}",
        out,
        lambda tell: tuned(source, out, tell=tell, **asked),
        lambda finished: tuning_files(finished, model),
    )
    print(_as_json(tuning, written) if as_json else _as_text(tuning, model, written))
    best = tuning.best
    return PROVED if best is not None and best.missed == 0 else UNPROVED


run = partial(run_command, "tune", tune)


def _as_text(tuning: Tuning, model: str, written: list[str]) -> str:
    from takagi.reports.study.tuning_files import summary

    lines = [*summary(tuning, model)]
    if tuning.resumed:
        lines.append(f"{tuning.resumed} of {tuning.tasks} results were computed before")
    return "\n".join([*lines, "", *written])


def _as_json(tuning: Tuning, written: list[str]) -> str:
    best = tuning.best
    return json.dumps(
        {
            "tried": tuning.tried,
            "resumed": tuning.resumed,
            "best": None if best is None else {"settings": best.at, "values": best.values},
            "met": best is not None and best.missed == 0,
            "files": written,
        },
        indent=2,
    )
