"""The targets of `takagi export`, and what they get from the gain file's certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias, cast, get_args

from takagi.certificates.checker.kernel.reader import digest, member, read_json
from takagi.models.errors import ModelError, did_you_mean
from takagi.reports.code.controller_program import ControllerProgram

Precision: TypeAlias = Literal["double", "float"]


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """The choices of a user for an export, and the certificate that belongs to the law.

    precision : type of the code's numbers; a target with one precision refuses the other.
    sample_time : T [s] with which the code starts if the caller states none; None takes the law's
        own T, or the target's default.
    model : the certificate's model, for targets that write its vertices; None without one.
    claims : the certificate's claims, for targets that write their matrices.

    Raises ModelError: a precision that is not double or float, a sample time that is not positive.
    """

    precision: Precision = "double"
    sample_time: float | None = None
    model: Mapping[str, Any] | None = None
    claims: tuple[Mapping[str, Any], ...] = ()

    def __post_init__(self) -> None:
        if self.precision not in get_args(Precision):
            raise ModelError(f"--precision {self.precision!r} was given; it is double or float")
        time = self.sample_time
        if time is not None and not (isfinite(time) and time > 0):
            raise ModelError(f"--sample-time {time!r} was given; a positive time in s is needed")


@dataclass(frozen=True, slots=True)
class Exported:
    """The result of a target: files by their path in the output folder, and their use.

    use : file -> one line that says how it is used.
    """

    files: Mapping[str, bytes | str]
    use: Mapping[str, str]


class Target(NamedTuple):
    """A target; its module has the function ``export(program, settings) -> Exported``."""

    word: str
    module: str  # below ``takagi.reports.code``
    tools: str  # the tools that read its files, for the help


TARGETS = (
    Target("c", "c.target", "any C99 or C++ compiler: the law, with a self-test"),
    Target(
        "discon",
        "discon.library",
        "OpenFAST, Bladed, ROSCO's Python interface: a turbine's law as a Bladed-style library",
    ),
    Target("fmu", "fmu.target", "FMI tools (3.0 and 2.0): the law as a unit for co-simulation"),
    Target(
        "st",
        "structured_text.block",
        "PLCs: a function block in Structured Text (CODESYS, TwinCAT and others)",
    ),
    Target(
        "mat",
        "matlab.target",
        "MATLAB, Simulink and Octave: the law as functions, gains and matrices as a struct",
    ),
    Target("csv", "target_text", "spreadsheets: a file for each table, with units"),
)


def exported(word: str, program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the files of a target for a program.

    Raises ModelError: an unknown target, or a program or setting that the target does not support.
    """
    for target in TARGETS:
        if target.word == word:
            target_module: Any = import_module(f"takagi.reports.code.{target.module}")
            return cast(Exported, target_module.export(program, settings))
    words = [target.word for target in TARGETS]
    raise ModelError(
        f"--to {word!r} was given; the targets are {', '.join(words)}{did_you_mean(word, words)}"
    )


def certified(
    gains: Path, certificate: Path | None, program: ControllerProgram
) -> tuple[Mapping[str, Any] | None, tuple[Mapping[str, Any], ...]]:
    """Return model and claims of a gain file's certificate, with numbers as the file has them.

    Claims with another hash than the gain file states are left out.

    certificate : None takes ``certificate.json`` in the gain file's folder; without such a file, or
        with one about another model, None is returned as model.

    Raises ModelError: the given certificate is about another model than the gain file, or the law
        is not proved, so that no certificate is about it.
    Raises CertificateError: it cannot be read.
    """
    if not program.hashes:
        if certificate is None:
            return None, ()
        raise ModelError(
            f"{certificate} was given, and {gains} names no certificate: the law is not proved; "
            "leave --certificate out"
        )
    path = certificate or gains.parent / "certificate.json"
    if certificate is None and not path.is_file():
        return None, ()
    document = read_json(path)
    model: Mapping[str, Any] = member(document, "model", str(path))
    claims = member(document, "claims", str(path))
    claims = tuple(claims) if digest(claims) == program.hashes.get("claims") else ()
    if digest(model) == program.hashes.get("model"):
        return model, claims
    if certificate is None:
        return None, claims
    raise ModelError(
        f"{path} is about another model than {gains}: the gain file names the SHA-256 of its model"
    )
