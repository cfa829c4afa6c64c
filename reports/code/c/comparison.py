"""Decides whether a C file is the export of a gain file.

The law is written again from the gain file, with the options that the C file names, and the two
texts are compared byte by byte, comments too; CR LF counts as LF.  So the compiler sees what takagi
has written, whatever a reader takes for a comment.  Words of C are told apart for the message
alone: it names the numbers that differ.  This is not the trusted checker, which compares the gain
file with the certificate.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import cast

from takagi.models.errors import ModelError
from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.targets import ExportSettings, Precision

SHOWN = 10  # differences in a message
_WORD = re.compile(
    r"""/\*.*?\*/|//[^\n]*|(?P<number>-?\.?[0-9](?:[eEpP][+-]|[A-Za-z0-9_.])*)|\n
    |(?P<word>"[^"\n]*"|[A-Za-z_][A-Za-z0-9_]*|[^\s])""",
    re.DOTALL | re.VERBOSE,
)


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    line: int


def source_differences(path: Path, gains: Path) -> tuple[str, ...]:
    """Return how a C file and the header beside it differ from the export of a gain file.

    Raises ModelError: a file that cannot be read, or that `takagi export` did not write.
    """
    text = _read(path)
    program, c = _written_again(path, text, gains)
    header = path.with_name(f"{c.word}.h")
    if not header.is_file():
        raise ModelError(
            f"{path}: its header {header.name} must be in the same folder, to be compared"
        )
    file_places = _places(program, c)
    pairs = (path, text, c.source), (header, _read(header), c.header)
    return tuple(
        difference
        for file, there, exported in pairs
        if there != _as_bytes(exported)
        for difference in _differences(file, there, _as_bytes(exported), file_places)
    )


def require_readable(path: Path) -> None:
    """Return if the C file can be read; ModelError says why not."""
    _read(path)


def _read(path: Path) -> str:
    """Return the bytes of a file, one character each, with LF for CR LF."""
    try:
        return path.read_bytes().decode("latin-1").replace("\r\n", "\n")
    except OSError as error:
        raise ModelError(
            f"{path}: cannot be read ({error.strerror}); give a C file of `takagi export --to c`, "
            "with its header beside it"
        ) from error


def _as_bytes(text: str) -> str:
    """Return a text as ``_read`` would read it from its file."""
    return text.encode("utf-8").decode("latin-1")


def _written_again(path: Path, text: str, gains: Path) -> tuple[ControllerProgram, CSource]:
    programs = re.search(r"^ \* Programs: (.*)$", text, re.MULTILINE)
    options = re.search(r"^ \* Numbers: (double|float); starts with (\S+) s$", text, re.MULTILINE)
    if programs is None or options is None:
        raise ModelError(
            f"{path}: its first comment does not name programs and numbers, as one of "
            "`takagi export --to c` does"
        )
    complete = read_controller(gains)
    there = programs[1].split(", ")
    absent = [stage.name for stage in complete.stages if stage.name not in there]
    program = read_controller(gains, without=absent)
    try:
        settings = ExportSettings(cast(Precision, options[1]), float(options[2]))
    except ValueError as error:
        raise ModelError(f"{path}: sample time {options[2]!r} is no number") from error
    return program, c_source(program, settings)


def _tokens(text: str) -> list[_Token]:
    """Return numbers and other words of a C text, without comments and space."""
    tokens, line = [], 1
    for match in _WORD.finditer(text):
        if match.lastgroup:
            tokens.append(_Token(match.lastgroup, match[0], line))
        line += match[0].count("\n")
    return tokens


def _places(program: ControllerProgram, c: CSource) -> dict[str, str]:
    """Return the place in the gain file of each constant of the C file."""
    file_places: dict[str, str] = {}
    for constant in program.constants:
        name = c.constants.get(constant.name)
        if name is not None:
            file_places[name] = constant.path
            for k in (1, 2):
                file_places[f"{name}_knots_{k}"] = f"{constant.path}.knots.{k - 1}"
    return file_places


def _differences(
    file: Path, there: str, exported: str, file_places: dict[str, str]
) -> Iterator[str]:
    """Yield the numbers that differ; where anything else does, the first line that differs."""
    theirs, ours = _tokens(there), _tokens(exported)
    pairs = list(zip(theirs, ours, strict=False))
    if (
        len(theirs) != len(ours)
        or all(their_token.text == our_token.text for their_token, our_token in pairs)
        or any(
            their_token.text != our_token.text and {their_token.kind, our_token.kind} != {"number"}
            for their_token, our_token in pairs
        )
    ):
        yield _line_differs(file, there, exported)
        return
    constant, index, number_count = "", 0, 0
    for k, (their_token, our_token) in enumerate(pairs):
        if our_token.text in file_places and "const" in (ours[k - 2].text, ours[k - 3].text):
            constant, index = our_token.text, 0
        elif our_token.text == ";":
            constant = ""
        elif our_token.text == "," and constant:
            index += 1
        if their_token.text == our_token.text:
            continue
        number_count += 1
        if number_count > SHOWN:
            yield f"{file}: and more numbers"
            return
        name = constant
        if constant and (index or ours[k + 1].text != ";"):
            name = f"{constant}[{index}]"
        number_words = (
            f"{name} ({file_places[constant]})" if constant else "a number of a formula or guard"
        )
        yield (
            f"{file}, line {their_token.line}: {number_words} is {their_token.text} there, "
            f"{our_token.text} in the gain file"
        )


def _line_differs(file: Path, there: str, exported: str) -> str:
    lines = there.split("\n"), exported.split("\n")
    pairs = enumerate(zip_longest(*lines, fillvalue="(end of the file)"), start=1)
    number, (theirs, ours) = next((k, pair) for k, pair in pairs if pair[0] != pair[1])
    return (
        f"{file}, line {number}: it is not what takagi exports from the gain file; "
        f"{theirs!a} stands there, {ours!a} follows; export it again"
    )
