"""`takagi study`: laws of one turbine over many winds and seeds, as tables and figures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NamedTuple

from takagi.cli.command import MISUSE


class Study(NamedTuple):
    """A study; its module ``verbs.study_<name>`` has ``run(arguments) -> int``."""

    name: str
    help: str  # one line, without a full stop


STUDIES = (
    Study("overlap", "Fatigue, energy and proof over how far torque and pitch overlap"),
    Study("controllers", "Laws, reference controller and ROSCO on the same plant and winds"),
)


def run(arguments: Sequence[str]) -> int:
    """Run the study that is named first; return its exit status."""
    first, following = (arguments[0], arguments[1:]) if arguments else ("", arguments)
    for study in STUDIES:
        if study.name == first:
            status: int = import_module(f"takagi.cli.verbs.study_{first}").run(following)
            return status
    if first in ("--help", "-h"):
        print(_help())
        return 0
    from takagi.models.errors import did_you_mean

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
