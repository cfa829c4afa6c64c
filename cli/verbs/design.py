"""`takagi design`: from a turbine or another plant to gains, certificate and report."""

from __future__ import annotations

import json
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from takagi.certificates.design.design import NoDesign
from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Model
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import StepLine, progress
from takagi.cli.runs.makers import DESIGN_OPTIONS, maker_of
from takagi.cli.terminal.rows import FOLDERS, PURPOSES, print_files, tell_none
from takagi.reports.output import write_folder


def design(
    model: Model,
    out: Path,
    *,
    as_json: bool = False,
    force: bool = False,
    no_report: bool = False,
    every_claim: bool = False,
    **options: Any,
) -> int:
    """Design a controller for MODEL, prove what is claimed of it, and report."""
    from takagi.reports.design_folder import (
        GAINS,
        REPORT,
        drawn_files,
        law_files,
        refuse_to_replace,
        unmeasured,
    )

    if not force:
        refuse_to_replace(out)
    require_folder_place(out, files=[n for n in PURPOSES if n not in FOLDERS], folders=FOLDERS)
    maker = maker_of(model, options)
    later = ("summary", "report") if no_report else ()
    line = StepLine([step for step in maker.steps if not step.words.startswith(later)])
    with progress(f"takagi design {model}", line=line) as tell:
        finished = maker.design(tell)
        if isinstance(finished, NoDesign):
            return tell_none(finished, as_json=as_json)
        tell(f"writing {out}")
        files = law_files(finished, source=maker.source)
        # A page beside the new law would be about the one before.
        (out / REPORT).unlink(missing_ok=True)
        write_folder(out, files)
        tell("summary")
        summary = import_module(maker.summary)
        answered = unmeasured(finished) if no_report else finished
        text = "" if as_json else summary.as_text(answered, every_claim=every_claim)
    if not as_json:
        print(text, flush=True)
    if not no_report:
        with progress(f"takagi design {model}", line=line) as tell:
            drawn = drawn_files(finished, source=maker.source, tell=tell)
            tell(f"writing {out}")
            write_folder(out, drawn)
            files |= drawn
    if as_json:
        written = [str(out / name) for name in files]
        print(json.dumps({**summary.as_data(answered), "files": written}, indent=2))
    else:
        print_files(out, files)
        verbs = [f"check {out}"]
        if GAINS in files:
            verbs += [f"simulate {out}", f"export {out} --to c --out {out / 'c'}"]
        print("\n  takagi ".join(["\nNext", *verbs]))
    return PROVED if finished.proved else UNPROVED


run = partial(run_command, "design", design, options=DESIGN_OPTIONS)
