"""Decides whether a C file is the export of a gain file.

The law is written again from the gain file, with the options that the C file names, and the two
texts are compared byte by byte, comments too; CR LF counts as LF.  So the compiler sees what takagi
has written, whatever a reader takes for a comment.  This is not the trusted checker, which compares
the gain file with the certificate.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import cast

from takagi.models.errors import ModelError
from takagi.reports.code.c.source import CSource, c_source
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.targets import ExportSettings, Precision

SHOWN = 10  # differences in a message


def source_differences(path: Path, gains: Path) -> tuple[str, ...]:
    """Return how a C file and the header beside it differ from the export of a gain file.

    Raises
    ------
    ModelError : a file that cannot be read, or that `takagi export` did not write.
    """
    text = _read(path)
    c = _written_again(path, text, gains)
    header = path.with_name(f"{c.word}.h")
    if not header.is_file():
        raise ModelError(
            f"{path}: its header {header.name} must be in the same folder, to be compared"
        )
    pairs = (path, text, c.source), (header, _read(header), c.header)
    return tuple(
        difference
        for file, there, exported in pairs
        for difference in _differences(file, there, exported.encode().decode("latin-1"))
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


def _written_again(path: Path, text: str, gains: Path) -> CSource:
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
    return c_source(program, settings)


def _differences(file: Path, there: str, exported: str) -> Iterator[str]:
    """Yield the lines that differ, the first alone where there are more or less of them."""
    theirs, ours = there.split("\n"), exported.split("\n")
    pairs = enumerate(zip_longest(theirs, ours, fillvalue="(end of the file)"), start=1)
    differing = [(number, *pair) for number, pair in pairs if pair[0] != pair[1]]
    for number, their_line, our_line in differing[: SHOWN if len(theirs) == len(ours) else 1]:
        yield (
            f"{file}, line {number}{_constant(ours[: number - 1])}: it is not what takagi exports "
            f"from the gain file; {their_line!a} stands there, {our_line!a} follows; export again"
        )


def _constant(before: Sequence[str]) -> str:
    """Return the place in the gain file of the constant whose numbers follow these lines."""
    for line in reversed(before):
        if stated := re.match(r"/\* (\S+) \[", line):
            return f" ({stated[1]})"
        if line.startswith("}") or not line:
            return ""
    return ""
