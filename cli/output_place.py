"""Checks before long work whether its result can be written, and long work whose results stay."""

from __future__ import annotations

import errno
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from takagi.cli.progress import Tell, progress
from takagi.reports.output import OutputError, write_folder

Result = TypeVar("Result")

# The output of a design has this size: a disk with less space is reported now.
_ROOM = 4_000_000


def require_folder_place(
    folder: Path, *, files: Sequence[str] = (), folders: Sequence[str] = ()
) -> None:
    """Return if ``folder`` can be made and filled; leave nothing behind.

    Parameters
    ----------
    files, folders : names that will be written in it; one that is of the other kind is refused.

    Raises
    ------
    OutputError : a part of the path is a file, or its place is read-only or full.
    """
    _refuse_kind(folder, want_folder=True)
    for name in files:
        _refuse_kind(folder / name, want_folder=False)
    for name in folders:
        _refuse_kind(folder / name, want_folder=True)
    _try_to_write(folder)


def require_file_place(path: Path) -> None:
    """Return if a file can be written at ``path``; leave nothing behind.

    Raises
    ------
    OutputError : it is a folder, or its place is read-only or full.
    """
    _refuse_kind(path, want_folder=False)
    if path.exists() and not path.is_file():
        return  # A device or a pipe: writing is the only way to know.
    _try_to_write(Path(os.path.realpath(path)).parent)


def _refuse_kind(path: Path, *, want_folder: bool) -> None:
    if want_folder and path.exists() and not path.is_dir():
        raise OutputError(path, _system_error(errno.EEXIST, path))
    if not want_folder and path.is_dir():
        raise OutputError(path, _system_error(errno.EISDIR, path))


def _system_error(number: int, path: Path) -> OSError:
    return OSError(number, os.strerror(number), str(path))


def _try_to_write(folder: Path) -> None:
    existing = folder
    try:
        # The folder itself may not exist yet; what counts is the nearest one that does.
        while not existing.exists() and existing != existing.parent:
            existing = existing.parent
        with tempfile.TemporaryDirectory(prefix=".takagi-", dir=existing) as trial:
            with open(Path(trial) / "trial", "wb") as file:
                file.write(bytes(_ROOM))
                file.flush()
                os.fsync(file.fileno())
    except OSError as error:
        raise OutputError(folder, error) from error


def kept_results(
    title: str,
    out: Path | None,
    work: Callable[[Tell], Result],
    files_of: Callable[[Result], Mapping[str, bytes | str]],
    *,
    what: str = "results",
) -> tuple[Result, list[str]]:
    """Return the result of a long work and the files that were written of it into ``out``.

    Ctrl-C says that what is finished stays there, and passes.  Without ``out`` none is written.
    """
    with progress(title) as tell:
        try:
            result = work(tell)
        except KeyboardInterrupt:
            if out is not None:
                words = f"Finished {what} are kept in {out}: the same command goes on."
                print(words, file=sys.stderr)
            raise
        if out is None:
            return result, []
        tell("figures and tables")
        files = files_of(result)
        write_folder(out, files)
    return result, [str(out / name) for name in files]
