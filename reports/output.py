"""Write files completely or not at all: a temporary file, flushed to disk, renamed; and tables."""

from __future__ import annotations

import csv
import errno
import io
import os
import tempfile
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path, PurePosixPath
from typing import Any


class OutputError(OSError):
    """A file could not be written.  The message says which, why and what to do.

    ``errno`` and ``filename`` are kept; nothing half-written is left behind.
    """

    def __init__(self, path: Path, error: OSError) -> None:
        super().__init__(error.errno, error.strerror or str(error), str(path))

    def __str__(self) -> str:
        return f"cannot write {explain(self)}"


@cache
def read_words(place: str) -> Mapping[str, Any]:
    """Return a TOML file of words; ``place`` is below ``takagi.reports``."""
    text = files("takagi.reports").joinpath(place).read_text(encoding="utf-8")
    return tomllib.loads(text)


def sentence(place: str, key: str, **filled: Any) -> str:
    """Return a sentence of such a file, its gaps filled."""
    gaps: str = read_words(place)["sentences"][key]
    return gaps.format(**filled)


def write_file(path: str | Path, data: bytes | str) -> Path:
    """Write ``data`` (text as UTF-8) to ``path`` completely or not at all; return the path.

    Folders on the way are made.  A file of that name is replaced in one step: a reader sees the
    old content or the new, and after a crash, a full disk or an interrupt the old is still there.
    A link is followed; a device or a pipe (``/dev/stdout``) is written to as it is.

    Raises
    ------
    OutputError : the file cannot be written there.
    """
    target = Path(os.path.realpath(path))
    if _is_stream(Path(path)):
        # To rename over a device would replace the device itself.
        try:
            Path(path).write_bytes(_encoded(data))
        except OSError as error:
            raise OutputError(Path(path), error) from error
    else:
        write_folder(target.parent, {target.name: data})
    return Path(path)


def write_folder(path: str | Path, files: Mapping[str, bytes | str]) -> Path:
    """Write ``files`` (relative name -> content) into the folder ``path``; return the path.

    All files are first written and flushed to disk in a temporary folder beside their place; only
    when all are complete are they renamed into place, each in one step.  Other files in the
    folder stay as they are.

    Not promised: that all files are of the same age after a crash between two renames. Each one is
    complete, old or new.

    Raises
    ------
    OutputError : a file cannot be written; nothing half-written is left.
    ValueError : a name is absolute or leads out of the folder.
    """
    folder = Path(path)
    placed = {_inside(name): _encoded(data) for name, data in files.items()}
    new_folders: list[Path] = []
    try:
        _make_folder(folder, new_folders)
        _stage_and_rename(folder, placed, new_folders)
    except BaseException:
        for new in reversed(new_folders):
            if not any(new.iterdir()):
                new.rmdir()
        raise
    return folder


def _inside(name: str) -> PurePosixPath:
    relative_path = PurePosixPath(name)
    if not relative_path.parts or relative_path.is_absolute() or ".." in relative_path.parts:
        raise ValueError(f"output file {name!r}: give a path relative to the folder, without '..'")
    return relative_path


def _encoded(data: bytes | str) -> bytes:
    return data.encode("utf-8") if isinstance(data, str) else data


def _is_stream(path: Path) -> bool:
    try:
        return path.exists() and not path.is_file() and not path.is_dir()
    except OSError:
        # The path cannot be examined; the attempt to write will report why.
        return False


def _make_folder(folder: Path, new_folders: list[Path]) -> None:
    """Make a folder and those on the way; append new ones to ``new_folders``, outermost first."""
    try:
        for directory in (*reversed(folder.parents), folder):
            if not directory.is_dir():
                directory.mkdir()
                new_folders.append(directory)
    except OSError as error:
        raise OutputError(folder, error) from error


def _stage_and_rename(
    folder: Path, files: Mapping[PurePosixPath, bytes], new_folders: list[Path]
) -> None:
    current = folder
    try:
        # Inside the folder, not next to it: the renames must stay on one file system, and the
        # user's permission may end at the folder.
        with tempfile.TemporaryDirectory(prefix=".takagi-", dir=folder) as staging:
            for relative_path, content in files.items():
                current = folder / relative_path
                if current.is_dir():
                    raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
                _make_folder(current.parent, new_folders)
                _write_through(Path(staging) / relative_path, content)
            for relative_path in files:
                current = folder / relative_path
                os.replace(Path(staging) / relative_path, current)
        current = folder
        _flush_folder(folder)
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(current, error) from error


def _write_through(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _flush_folder(folder: Path) -> None:
    """Write a folder's entries to disk: a renamed file may else not survive a power failure."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


_ADVICE = {
    errno.ENOSPC: "the disk is full; free some space or choose another place",
    errno.EDQUOT: "your disk quota is used up; free some space or choose another place",
    errno.EROFS: "the file system is read-only; choose another place",
    errno.EACCES: "permission denied; check the permissions or choose another place",
    errno.EPERM: "the system does not permit it; check the permissions or choose another place",
    errno.ENOENT: "no such file or folder; check the path",
    errno.EEXIST: "a file of this name stands where a folder is needed; choose another name",
    errno.EISDIR: "this is a folder, and a file was expected",
    errno.ENOTDIR: "a part of this path is a file, and a folder was expected",
    errno.ENAMETOOLONG: "the name is too long for this file system; choose a shorter one",
}


def explain(error: OSError) -> str:
    """Return what happened and what to do, in one line, after the path if it is known."""
    advice = _ADVICE.get(error.errno or 0, error.strerror or str(error))
    path = error.filename2 or error.filename
    return (
        f"{os.fsdecode(path)}: {advice}" if isinstance(path, str | bytes | os.PathLike) else advice
    )


def csv_text(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a line of headings and one a row; None is empty, lines end in a line feed."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([head, *rows])
    return text.getvalue()


def rows_csv(rows: Sequence[Mapping[str, object]]) -> str:
    """Return rows as CSV; columns are the keys, in the order in which they first appear."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return csv_text(names, ([row.get(name) for name in names] for row in rows))


def markdown_table(rows: Sequence[Mapping[str, object]]) -> str:
    """Return a table with a head for each key of the rows, and columns of equal width."""
    heads = list(dict.fromkeys(key for row in rows for key in row))
    cells = [heads, *([_cell(row.get(head)) for head in heads] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        "| "
        + " | ".join(text.ljust(width) for text, width in zip(line, widths, strict=True))
        + " |"
        for line in cells
    ]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    return "\n".join([lines[0], rule, *lines[1:]]) + "\n"


def markdown_page(room: str, name: str, **values: object) -> str:
    """Return ``name.md.jinja`` of a room of reports, filled; rows become tables by ``|table``."""
    # Imported here: `takagi check` does without it.
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(f"takagi.reports.{room}", ""), undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    short = lambda x: f"{x:g}" if isinstance(x, float | int) else [f"{v:g}" for v in x]  # noqa: E731
    environment.filters |= {"table": markdown_table, "short": short}
    return environment.get_template(f"{name}.md.jinja").render(values)


def _cell(value: object) -> str:
    if isinstance(value, float | int):
        return f"{value:.4g}"
    # A vertical bar would end the cell.
    return "" if value is None else str(value).replace("|", "\\|")
