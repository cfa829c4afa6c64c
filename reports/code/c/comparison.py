"""Decides whether a C file is the law of a gain file.

The law is written again from the gain file, with the options that the C file names, and the two
texts are compared word by word.  Spaces, comments, and digits that do not change the value of a
number are ignored.  This is not the trusted checker, which compares the gain file with the
certificate.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

from takagi.models.errors import ModelError
from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.targets import export_settings

SHOWN = 10  # differences in a message
_WORD = re.compile(
    r"""(?P<comment>/\*.*?\*/|//[^\n]*)|(?P<end>\n)|(?P<space>[ \t\r\f\v]+)|(?P<text>"[^"\n]*")
    |(?P<number>\.?[0-9](?:[eEpP][+-]|[A-Za-z0-9_.])*)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)
    |(?P<sign>->|\+\+|--|<<=|>>=|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|<<|>>|.)""",
    re.DOTALL | re.VERBOSE,
)
_DECIMAL = re.compile(r"(-?(?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))(?:[eE][+-]?[0-9]+)?)(F?)")


@dataclass(frozen=True, slots=True)
class SourceComparison:
    """The differences, one sentence for each; and the count of numbers that were compared."""

    differences: tuple[str, ...]
    numbers: int


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    line: int


def compared_source(path: Path, gains: Path) -> SourceComparison:
    """Compare a C file and the header beside it with what follows from a gain file.

    Raises
    ------
    ModelError : a file that cannot be read, or that `takagi export` did not write.
    """
    text = _read(path)
    program, c = _written_again(path, text, gains)
    header = path.with_name(f"{c.word}.h")
    if not header.is_file():
        raise ModelError(
            f"{path}: its header {header.name} must be in the same folder, to be compared"
        )
    places = _places(program, c)
    differences: list[str] = []
    numbers = 0
    for file, found, wanted in ((path, text, c.source), (header, _read(header), c.header)):
        ours, theirs = _signed(_tokens(wanted, file)), _signed(_tokens(found, file))
        numbers += sum(one.kind == "number" for one in theirs)
        differences += _differences(file, theirs, ours, wanted, found, places)
    return SourceComparison(tuple(differences), numbers)


def require_readable(path: Path) -> None:
    """Return if the C file can be read; ModelError says why not."""
    _read(path)


def _read(path: Path) -> str:
    try:
        return path.read_bytes().decode("latin-1").replace("\r\n", "\n")
    except OSError as error:
        raise ModelError(
            f"{path}: cannot be read ({error.strerror}); give a C file of `takagi export --to c`, "
            "with its header beside it"
        ) from error


def _written_again(path: Path, text: str, gains: Path) -> tuple[ControllerProgram, CSource]:
    programs = re.search(r"^ \* Programs: (.*)$", text, re.MULTILINE)
    options = re.search(r"^ \* Numbers: (double|float); starts with (\S+) s$", text, re.MULTILINE)
    if programs is None or options is None:
        raise ModelError(
            f"{path}: its first comment does not name programs and numbers, as one of "
            "`takagi export --to c` does"
        )
    whole = read_controller(gains)
    there = programs[1].split(", ")
    absent = [stage.name for stage in whole.stages if stage.name not in there]
    program = read_controller(gains, without=absent)
    try:
        settings = export_settings(options[1], float(options[2]))
    except ValueError as error:
        raise ModelError(f"{path}: sample time {options[2]!r} is no number") from error
    return program, c_source(program, settings)


def _tokens(text: str, file: Path) -> Iterator[_Token]:
    """Yield the words of a C text.

    A directive ends with its line, so that this end is a word.  Backslashes and trigraphs are
    refused: they could join lines, and `takagi export` writes neither.
    """
    if "\\" in text or "??" in text:
        raise ModelError(f"{file}: it has a backslash or ??, which no exported file has")
    line, directive = 1, False
    for found in _WORD.finditer(text):
        kind, word = str(found.lastgroup), found[0]
        if kind in ("text", "number", "name", "sign"):
            directive = directive or word == "#"
            yield _Token(kind, word, line)
        elif kind == "end" and directive:
            directive = False
            yield _Token("end", "\n", line)
        line += word.count("\n")


def _signed(tokens: Iterator[_Token]) -> list[_Token]:
    """Return the words; a minus sign before a constant becomes a part of its number."""
    found: list[_Token] = []
    for one in tokens:
        before = [part.text for part in found[-2:]]
        if one.kind == "number" and before[1:] == ["-"] and before[0] in ("=", "{", ","):
            one = _Token("number", f"-{one.text}", one.line)
            found.pop()
        found.append(one)
    return found


def _same(one: _Token, other: _Token) -> bool:
    if one.text == other.text:
        return True
    numbers = _DECIMAL.fullmatch(one.text), _DECIMAL.fullmatch(other.text)
    if numbers[0] is None or numbers[1] is None or numbers[0][2] != numbers[1][2]:
        return False
    values = Decimal(numbers[0][1]), Decimal(numbers[1][1])
    return values[0] == values[1] and values[0].is_signed() == values[1].is_signed()


def _places(program: ControllerProgram, c: CSource) -> dict[str, str]:
    """Return the place in the gain file of each constant of the C file."""
    found: dict[str, str] = {}
    for one in program.constants:
        name = c.constants.get(one.name)
        if name is not None:
            found[name] = one.place
            for k in (1, 2):
                found[f"{name}_knots_{k}"] = f"{one.place}.knots.{k - 1}"
    return found


def _differences(
    file: Path,
    theirs: list[_Token],
    ours: list[_Token],
    wanted: str,
    found: str,
    places: dict[str, str],
) -> Iterator[str]:
    """Yield the numbers that differ; the first other word that differs ends the comparison."""
    shown = 0
    constant, index = "", 0
    for k, (there, here) in enumerate(zip(theirs, ours, strict=False)):
        if here.text in places and "const" in (ours[k - 2].text, ours[k - 3].text):
            constant, index = here.text, 0
        elif here.text == ";":
            constant = ""
        elif here.text == "," and constant:
            index += 1
        if not _same(there, here):
            if not {there.kind, here.kind} <= {"number"}:
                yield _line_differs(file, there, here, wanted, found)
                return
            shown += 1
            if shown > SHOWN:
                yield f"{file}: and more numbers"
                return
            name = constant
            if constant and (index or ours[k + 1].text != ";"):
                name = f"{constant}[{index}]"
            place = f"{name} ({places[constant]})" if constant else "a number of a formula or guard"
            yield (
                f"{file}, line {there.line}: {place} is {there.text} there, {here.text} in the "
                "gain file"
            )
    if len(theirs) != len(ours):
        how = "goes on after" if len(theirs) > len(ours) else "ends before"
        yield f"{file}: it {how} the end of the law"


def _line_differs(file: Path, there: _Token, here: _Token, wanted: str, found: str) -> str:
    lines = found.splitlines()[there.line - 1 :][:1], wanted.splitlines()[here.line - 1 :][:1]
    theirs, ours = (one[0].strip() if one else "" for one in lines)
    return (
        f"{file}, line {there.line}: the formula or statement is changed; {theirs!r} stands there, "
        f"{ours!r} follows from the gain file"
    )
