"""`takagi report`: the report of a finished design, made again."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Folder
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import progress
from takagi.reports.output import write_folder


def report(folder: Folder, out: Path | None = None) -> int:
    """Write report.html and figures/ of the design in DIR; nothing is designed again."""
    from takagi.reports.design_folder import FIGURES, REPORT, read_design, report_files

    target = out or folder
    require_folder_place(target, files=[REPORT], folders=[FIGURES])
    with progress(f"takagi report {folder}") as tell:
        design = read_design(folder, tell=tell)
        write_folder(target, report_files(design, tell=tell))
    print(f"{target / REPORT}: {design.verdict_words}")
    return PROVED if design.proved else UNPROVED


run = partial(run_command, "report", report)
