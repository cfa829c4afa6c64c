"""The law of a gain file as code that other tools run; every number is a decimal of the file.

formula             a formula of a program as a tree
controller_program  the programs of a gain file as one value, which every target reads
run                 that value run in Python: known answers for what is written
identifiers         names that a target's language can hold
fmu                 the law, and its closed loop, as functional mock-up units
certified_model     the plant of a gain file's certificate
targets             the targets of `takagi export`, and what each writes
tables              CSV
c                   C99
discon              the Bladed-style library around it
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.code.baseline import baseline_program
    from takagi.reports.code.controller_program import ControllerProgram, read_controller
    from takagi.reports.code.run import ProgramRun
    from takagi.reports.code.targets import ExportSettings, Precision

__all__ = [
    "ControllerProgram",
    "ExportSettings",
    "Precision",
    "ProgramRun",
    "baseline_program",
    "read_controller",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
