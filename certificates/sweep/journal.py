r"""The journal of a sweep: a header and a line per finished point, flushed before it is reported.

    {"format": "takagi-sweep", "version": 1, "sha256": "...", "map": ..., "axes": ..., ...}\n
    {"at": [0.02, 500.0], "seconds": 1.2, "result": {...}}\n

A line ends with its newline.  Text after the last newline belongs to a write that was interrupted;
it is removed, and that point is computed again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from takagi.certificates.sweep.grid import FAILED, SweepMap, canonical
from takagi.certificates.sweep.lock import hold
from takagi.models.errors import ModelError
from takagi.models.files.flushed_folder import flush_folder

FORMAT, VERSION = "takagi-sweep", 1
NAME = "points.jsonl"

Place = tuple[float, ...]


class JournalError(ModelError):
    """The journal is another sweep's, or is damaged; the message says which, and what to do."""


class Journal:
    """The journal of a map in a folder, open for more points; use it in a ``with`` statement.

    Attributes
    ----------
    done : coordinates -> (result as JSON, seconds) of the points on disk.  Points that FAILED are
        not among them: they are computed again.

    Raises
    ------
    JournalError : the file belongs to another sweep, is damaged, or another process writes it.
    OSError : the folder or the file cannot be made, read or written.
    """

    def __init__(self, folder: Path, swept: SweepMap) -> None:
        self.path = folder / NAME
        self.done: dict[Place, tuple[Mapping[str, Any], float]] = {}
        folder.mkdir(parents=True, exist_ok=True)
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        try:
            if not hold(self._file):
                raise JournalError(
                    f"{self.path}: another takagi sweep is writing it; wait for its end, or give "
                    "another folder"
                )
            self._read(swept)
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self._file)

    def add(self, place: Place, result: Mapping[str, Any], seconds: float) -> None:
        """Write a point's line and flush it to the disk.

        Raises
        ------
        OSError : it cannot be written (a full disk); the journal ends with the point before.
        """
        line = {"at": list(place), "seconds": round(seconds, 3), "result": result}
        text = canonical(line)
        self._append(text + "\n")
        # In the form in which it will be read when the sweep is resumed.
        self.done[place] = (json.loads(text)["result"], round(seconds, 3))

    def _append(self, text: str) -> None:
        data, size = text.encode(), os.fstat(self._file).st_size
        try:
            written = 0
            while written < len(data):
                written += os.write(self._file, data[written:])
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, size)
            raise OSError(error.errno, error.strerror, str(self.path)) from error

    # ------------------------------------------------------------------ what is there already
    def _read(self, swept: SweepMap) -> None:
        head = _header(swept)
        data = self.path.read_bytes()
        whole = data.rfind(b"\n") + 1
        if whole == 0:
            if not head.encode().startswith(data):
                raise JournalError(
                    f"{self.path}: this is not the journal of a sweep; give another folder, or "
                    "remove the file"
                )
            os.ftruncate(self._file, 0)
            self._append(head)
            flush_folder(self.path.parent)
            return
        first, *lines = data[:whole].split(b"\n")[:-1]
        _require_same(self.path, first, swept)
        for number, line in enumerate(lines, start=2):
            place, result, seconds = _point(self.path, number, line, len(swept.axes))
            if result.get("verdict") == FAILED:
                self.done.pop(place, None)
            else:
                self.done[place] = (result, seconds)
        # The file is changed only here, after all checks: a refused file remains unchanged.
        os.ftruncate(self._file, whole)


def _header(swept: SweepMap) -> str:
    return (
        canonical({"format": FORMAT, "version": VERSION, "sha256": swept.digest, **swept.asked})
        + "\n"
    )


def _require_same(path: Path, line: bytes, swept: SweepMap) -> None:
    try:
        head = json.loads(line)
        there = (head["format"], head["version"])
    except (ValueError, TypeError, KeyError) as error:
        raise JournalError(
            f"{path}: line 1 is not the header of a sweep; give another folder, or remove the file"
        ) from error
    if there != (FORMAT, VERSION):
        raise JournalError(
            f"{path}: format {there[0]!r} version {there[1]!r} was found; this release writes "
            f"{FORMAT!r} version {VERSION}. Give another folder"
        )
    if head.get("sha256") == swept.digest:
        return
    asked, found = swept.asked, {key: head.get(key) for key in swept.asked}
    differing = ", ".join(_differences(found, asked)[:6]) or "its hash"
    raise JournalError(
        f"{path}: this journal was made for another sweep; different: {differing}. Give another "
        "folder, or ask for the same law, model and settings again to go on with it"
    )


def _differences(found: Any, asked: Any, name: str = "") -> list[str]:
    """Return the differences as "name: found, now requested" with short values."""
    if isinstance(found, dict) and isinstance(asked, dict):
        return [
            text
            for key in sorted({*found, *asked})
            for text in _differences(found.get(key), asked.get(key), f"{name}.{key}".strip("."))
        ]
    if found == asked:
        return []
    shown = [text if len(text := json.dumps(v)) <= 40 else "..." for v in (found, asked)]
    return [f"{name} ({shown[0]} there, {shown[1]} asked)"]


def _point(
    path: Path, number: int, line: bytes, count: int
) -> tuple[Place, Mapping[str, Any], float]:
    try:
        entry = json.loads(line)
        place = tuple(float(value) for value in entry["at"])
        result, seconds = entry["result"], float(entry["seconds"])
        if len(place) != count or not isinstance(result, dict) or "verdict" not in result:
            raise ValueError("not a point of this grid")
    except (ValueError, TypeError, KeyError) as error:
        raise JournalError(
            f"{path}: line {number} is damaged ({error}); remove that line to make its point again"
        ) from error
    return place, result, seconds
