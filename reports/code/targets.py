"""The targets of `takagi export`: the word, who takes what is written, and where it is made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from math import isfinite
from typing import Any, Literal, NamedTuple, TypeAlias, cast, get_args

from takagi.models.errors import ModelError, did_you_mean
from takagi.reports.code.controller_program import ControllerProgram

Precision: TypeAlias = Literal["double", "float"]


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """What a user may choose of an export.

    Attributes
    ----------
    precision : of the code's numbers; targets of one precision refuse the other.
    sample_time : T [s] that the code starts with where its user names none; None takes the law's
        own, or the target's usual one.
    model : the certificate's model, for targets that write the plant too; None without one.
    claims : the certificate's, for targets that write its matrices.
    """

    precision: Precision = "double"
    sample_time: float | None = None
    model: Mapping[str, Any] | None = None
    claims: tuple[Mapping[str, Any], ...] = ()


@dataclass(frozen=True, slots=True)
class Exported:
    """What a target made: files by their path in the output folder, and what to do with them.

    Attributes
    ----------
    use : file -> one line that says how it is used.
    """

    files: Mapping[str, bytes | str]
    use: Mapping[str, str]


class Target(NamedTuple):
    """A target: its module has ``export(program, settings) -> Exported``."""

    word: str
    module: str
    tools: str  # who takes it, for the help


TARGETS = (
    Target(
        "c", "takagi.reports.code.c.target", "any C99 or C++ compiler: the law, with a self-test"
    ),
    Target(
        "discon",
        "takagi.reports.code.discon.library",
        "OpenFAST, Bladed, ROSCO's Python interface: a turbine's law as a Bladed-style library",
    ),
    Target(
        "fmu",
        "takagi.reports.code.fmu.target",
        "FMI tools (3.0 and 2.0): the law, and its closed loop with the certificate's plant",
    ),
    Target(
        "st",
        "takagi.reports.code.structured_text.block",
        "PLCs: a function block in Structured Text (CODESYS, TwinCAT and others)",
    ),
    Target(
        "mat",
        "takagi.reports.code.matlab.target",
        "MATLAB, Simulink and Octave: the law as functions, gains and matrices as a struct",
    ),
    Target("csv", "takagi.reports.code.tables", "spreadsheets: a file for each table, with units"),
)


def export_settings(precision: str, sample_time: float | None) -> ExportSettings:
    """Return the settings of the command line's words.

    Raises
    ------
    ModelError : a precision that is not double or float, a sample time that is not positive.
    """
    if precision not in get_args(Precision):
        raise ModelError(f"--precision {precision!r} was given; it is double or float")
    if sample_time is not None and not (isfinite(sample_time) and sample_time > 0):
        raise ModelError(f"--sample-time {sample_time!r} was given; a positive time in s is needed")
    return ExportSettings(cast(Precision, precision), sample_time)


def exported(word: str, program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return what a target makes of a program.

    Raises
    ------
    ModelError : an unknown target, or a program or setting that the target cannot hold.
    """
    for target in TARGETS:
        if target.word == word:
            made: Any = import_module(target.module)
            return cast(Exported, made.export(program, settings))
    words = [target.word for target in TARGETS]
    raise ModelError(
        f"--to {word!r} was given; the targets are {', '.join(words)}{did_you_mean(word, words)}"
    )
