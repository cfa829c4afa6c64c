"""The targets of `takagi export`, what they get from the gain file, and a law's numbers as CSV."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from importlib import import_module
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, cast, get_args

from takagi.certificates.checker.kernel.reader import digest, member, read_json
from takagi.certificates.controller.longest_sample import LongestSample, longest_of_turbine
from takagi.models.errors import ModelError, did_you_mean
from takagi.reports.code.controller_program import Constant, ControllerProgram, Spline
from takagi.reports.output import csv_text

if TYPE_CHECKING:
    from jinja2 import Environment

Precision: TypeAlias = Literal["double", "float"]


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """The choices of a user for an export, and the certificate that belongs to the law.

    Attributes
    ----------
    precision : type of the code's numbers; a target with one precision refuses the other.
    sample_time : T [s] with which the code starts if the caller states none; None takes the law's
        own T, or the target's default.
    model : the certificate's model, for targets that write its vertices; None without one.
    claims : the certificate's claims, for targets that write their matrices.

    Raises
    ------
    ModelError : a precision that is not double or float, a sample time that is not positive.
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

    Attributes
    ----------
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
    Target("c", "c.source", "any C99 or C++ compiler: the law, with a self-test"),
    Target("discon", "discon.library",
           "OpenFAST, Bladed, ROSCO's Python interface: a turbine's law as a Bladed-style library"),
    Target("fmu", "fmu.target", "FMI tools (3.0 and 2.0): the law as a unit for co-simulation"),
    Target("st", "structured_text.block",
           "PLCs: a function block in Structured Text (CODESYS, TwinCAT and others)"),
    Target("mat", "matlab.target",
           "MATLAB, Simulink and Octave: the law as functions, gains and matrices as a struct"),
    Target("csv", "targets", "spreadsheets: a file for each table, with units"),
)  # fmt: skip


def exported(word: str, program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the files of a target for a program.

    Raises
    ------
    ModelError : an unknown target, or a program or setting that the target does not support.
    """
    targets = {target.word: target for target in TARGETS}
    if word not in targets:
        raise ModelError(
            f"--to {word!r} was given; the targets are {', '.join(targets)}"
            f"{did_you_mean(word, targets)}"
        )
    target_module: Any = import_module(f"takagi.reports.code.{targets[word].module}")
    return cast(Exported, target_module.export(program, settings))


def certified(
    gains: Path, certificate: Path | None, program: ControllerProgram
) -> tuple[Mapping[str, Any] | None, tuple[Mapping[str, Any], ...]]:
    """Return model and claims of a gain file's certificate, with numbers as the file has them.

    Claims with another hash than the gain file states are left out.

    Parameters
    ----------
    certificate : None takes ``certificate.json`` in the gain file's folder; without such a file, or
        with one about another model, None is returned as model.

    Raises
    ------
    ModelError : the given certificate is about another model than the gain file, or the law is not
        proved, so that no certificate is about it.
    CertificateError : it cannot be read.
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


def proof_lines(program: ControllerProgram) -> tuple[str, ...]:
    """Return one sentence a line: verdict, in which time, in which ranges, and each claim's name.

    The gain file's word; nothing is checked here, and the first line says how to check it.
    """
    if not program.hashes:
        return (f"Proved: nothing; {program.verdict}.",)
    sampled = program.sample_time
    time = (
        "in exact arithmetic and continuous time; the samples of this code are covered only by a "
        "claim that names a sample time"
        if sampled is None
        else f"in exact arithmetic and discrete time, with a sample every {sampled} s and no other"
    )
    claims = program.document["certificate"].get("claims", ())
    return (
        f"The gain file says {program.verdict}. Confirm it with: takagi check CERTIFICATE --gains "
        "GAINS",
        f"What is proved holds {time}.",
        f"What is proved holds in these ranges: {', '.join(_ranges(program)) or 'all values'}.",
        *(f"Claim {k}, {claim['verdict']}: {claim['name']}" for k, claim in enumerate(claims, 1)),
    )


def shared_context(
    program: ControllerProgram, settings: ExportSettings, reported: Collection[str] | None = None
) -> dict[str, Any]:
    """Return what the templates of all languages are filled with.

    reported : words of the status bits that the target reports; None for all.

    Raises ModelError: a sample time that is not the law's own, or too long.
    """
    return {
        "program": program,
        "time": start_sample_time(program, settings.sample_time),
        "proof": proof_lines(program),
        "status": status_bits(program, reported),
        "BIT": BIT,
        "longest": longest_sample(program),
        "reported_range": reported_range,
        "as_list": as_list,
    }


def as_list(lines: Iterable[str]) -> str:
    """Return the lines as a list of Markdown."""
    return "\n".join(f"- {line}" for line in lines)


def _ranges(program: ControllerProgram) -> Iterator[str]:
    document = program.document
    if program.kind == "turbine":
        winds = [float(wind) for wind in document["trim"]["wind"]]
        yield f"wind {min(winds):g} to {max(winds):g} m/s, and what each claim assumes of the wind"
        return
    signals: list[Mapping[str, Any]] = [*document.get("states", ()), *document.get("inputs", ())]
    for signal in signals:
        if signal.get("range") is not None:
            low, high = (f"{float(end):.6g}" for end in signal["range"])
            yield f"{signal['name']} {low} to {high} {signal['unit']}"


def filled(room: str, name: str, context: Mapping[str, Any]) -> str:
    """Return ``name.jinja`` of a folder below ``reports/code``, filled; nothing is escaped.

    Raises
    ------
    jinja2.UndefinedError : the template has a name that the context does not have.
    """
    return _environment(room).get_template(f"{name}.jinja").render(context)


@cache
def _environment(room: str) -> Environment:
    # Imported here: most verbs write no code.
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = files(f"takagi.reports.code.{room}")
    return Environment(
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
    )


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return the tables: ``numbers.csv``, and one file for each row, matrix or spline.

    The first line has the names with their units; numbers are the gain file's decimals.
    """
    single = [c for c in program.constants if isinstance(c.value, Decimal)]
    head = ("name", "value", "unit", "place in gains.json")
    files = {"numbers.csv": csv_text(head, ((c.name, c.value, c.unit, c.path) for c in single))}
    use = {"numbers.csv": f"{len(single)} single numbers with units"}
    for constant in program.constants:
        for name, text, what in _tables(constant):
            files[name], use[name] = text, what
    return Exported(files, use)


def _tables(constant: Constant) -> Iterable[tuple[str, str, str]]:
    """Yield file name, text and description for each table of a constant."""
    value, name = constant.value, constant.name
    if isinstance(value, Decimal):
        return
    if isinstance(value, Spline):
        for k, knots in enumerate(value.knots, start=1):
            text = csv_text((f"knots of argument {k}",), ((knot,) for knot in knots))
            yield f"{name}_knots_{k}.csv", text, f"knots of the cubic spline {name}"
        yield _matrix(name, f"coefficients of {name} [{constant.unit}]", value.coefficients)
    elif isinstance(value[0], tuple):
        yield _matrix(name, f"{name} [{constant.unit}]", value)
    else:
        text = csv_text((f"{name} [{constant.unit}]",), ((number,) for number in value))
        yield f"{name}.csv", text, f"{len(value)} numbers, {constant.path} of the gain file"


def _matrix(name: str, title: str, rows: Sequence[Sequence[Decimal]]) -> tuple[str, str, str]:
    head = (f"{title}, column 0", *(f"column {k}" for k in range(1, len(rows[0]))))
    text = csv_text(head, rows)
    return f"{name}.csv", text, f"{len(rows)} rows of {len(rows[0])}: {title}"


USUAL_SAMPLE_TIME = Decimal("0.01")  # s, where neither law nor user states one


def longest_sample(program: ControllerProgram) -> LongestSample | None:
    """Return the longest sample time of a program; None where none is known.

    A turbine's follows from the programs that are not left out; a plant's is in its gain file.

    Raises
    ------
    ModelError : the file states one that is no positive time.
    """
    if program.kind == "turbine":
        names = {stage.name for stage in program.stages}
        longest: LongestSample | None = longest_of_turbine(program.document, names)
        return longest
    stated = program.document.get("sampling", {})
    time = stated.get("longest") if isinstance(stated, Mapping) else stated
    if program.sample_time is not None or time is None:
        return None
    if not (isinstance(time, Decimal) and time.is_finite() and time > 0):
        raise ModelError(f"sampling.longest is {time}; a positive time in s is needed")
    return LongestSample(time, str(stated.get("reason", "its gain file says so")))


def start_sample_time(program: ControllerProgram, requested: float | None) -> Decimal:
    """Return T [s] to start with: that of the law, else of the user, else a usual one.

    Raises
    ------
    ModelError : the user's T differs from that of a law in discrete time, or is longer than the
        longest of the program.
    """
    fixed_time = program.sample_time
    if fixed_time is not None:
        if requested is not None and abs(requested - float(fixed_time)) > 1e-6 * float(fixed_time):
            raise ModelError(
                f"--sample-time {requested} was given; the law is one in discrete time with "
                f"{fixed_time} s"
            )
        return fixed_time
    longest = longest_sample(program)
    if requested is None:
        return USUAL_SAMPLE_TIME if longest is None else min(USUAL_SAMPLE_TIME, longest.time)
    if longest is not None and requested > float(longest.time):
        raise ModelError(
            f"--sample-time {requested:g} s was given; at most {longest.time} s is needed, since "
            f"{longest.reason}; "
            + (
                "a turbine controller runs every 0.01 to 0.02 s"
                if program.kind == "turbine"
                else "'takagi design --sample-time' proves a sampled loop"
            )
        )
    return Decimal(repr(requested))


# (bit, word, meaning), the most serious first: ``W_message`` of C reports the first that is set.
STATUS_BITS = (
    (4, "RESULT_NOT_FINITE", "a result was not finite; the last good one was sent"),
    (8, "NOT_STARTED", "a step before init, or a damaged state; the law started anew"),
    (1, "INPUT_NOT_FINITE", "an input was not finite; the last good one stood in"),
    (16, "SAMPLE_TIME_REFUSED", "a sample time was refused; the one before is kept"),
    (2, "INPUT_OUTSIDE", "an input lies outside the range where the model holds"),
    (64, "ESTIMATE_HELD", "the wind estimate is held at a limit, or at the end of a table"),
    (32, "AT_LIMIT", "a command is held at a limit"),
)
BIT = {word: bit for bit, word, _ in STATUS_BITS} | {"SAMPLE_TIME_LONG": 128}
# Structured Text and MATLAB report these, and a sample time that is too long.
REPORTED = ("INPUT_NOT_FINITE", "INPUT_OUTSIDE", "RESULT_NOT_FINITE", "SAMPLE_TIME_REFUSED")


def status_bits(
    program: ControllerProgram, words: Collection[str] | None = None
) -> tuple[tuple[int, str, str], ...]:
    """Return (bit, word, meaning), the most serious first; a long sample where there is one.

    Parameters
    ----------
    words : those that a target reports; None for all.
    """
    longest = longest_sample(program)
    bits = [bit for bit in STATUS_BITS if words is None or bit[1] in words]
    if longest is not None:
        index = sum(bit not in (2, 32, 64) for bit, *_ in bits)
        bits.insert(index, (BIT["SAMPLE_TIME_LONG"], "SAMPLE_TIME_LONG", longest.words))
    return tuple(bits)


def reported_range(limits: tuple[Decimal, Decimal]) -> tuple[Decimal, Decimal]:
    """Return the ends beyond which an input is reported as outside of its range.

    An input outside by less than 1e-5 of the range is noise of a measurement or of a float.
    """
    tolerance = Decimal("1e-5") * (limits[1] - limits[0])
    return limits[0] - tolerance, limits[1] + tolerance
