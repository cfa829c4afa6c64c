"""The journal: stopped at any byte it goes on; another sweep's, or a damaged one, is refused."""

from __future__ import annotations

import errno
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.sweep import Axis, Journal, JournalError, SweepResult, run_sweep
from takagi.certificates.sweep.journal import NAME
from tests.certificates.sweep.toy import toy


def finished(folder: Path) -> bytes:
    """The journal of a finished toy map."""
    run_sweep(toy(), folder, workers=1)
    return (folder / NAME).read_bytes()


def answers(result: SweepResult) -> list[tuple[dict[str, float], dict[str, Any]]]:
    """Where and what, without the time it took."""
    return [(dict(point.at), dict(point.result)) for point in result.points]


def test_stopped_at_any_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut after any number of bytes, the sweep goes on, and makes exactly what was lost.

    Every byte of the header's end and of the last two lines is tried, and one in seven between.
    """
    whole = finished(tmp_path / "whole")
    expected = answers(run_sweep(toy(), tmp_path / "whole", workers=1))
    # Writing through to the disk is not what is tested here, and takes its time.
    monkeypatch.setattr(os, "fsync", lambda _: None)
    first, last = whole.index(b"\n"), whole[:-1].rindex(b"\n")
    dense = {0, *range(first - 3, first + 4), *range(last - 60, len(whole) + 1)}
    for length in sorted(dense | set(range(0, len(whole), 7))):
        folder = tmp_path / "cut"
        folder.mkdir(exist_ok=True)
        (folder / NAME).write_bytes(whole[:length])
        result = run_sweep(toy(), folder, workers=1)
        assert answers(result) == expected
        assert result.resumed == max(whole[:length].count(b"\n") - 1, 0)
        lines = (folder / NAME).read_bytes().split(b"\n")
        assert lines.pop() == b""
        assert sorted(json.loads(line).get("at", []) for line in lines) == sorted(
            json.loads(line).get("at", []) for line in whole.split(b"\n")[:-1]
        )


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (replace(toy(), name="other"), 'map ("toy" there, "other" asked)'),
        (toy(settings={"factor": 3.0}), "settings.factor (2.0 there, 3.0 asked)"),
        (toy(settings={"factor": 2.0, "more": 1}), "settings.more (null there, 1 asked)"),
        (replace(toy(), axes=(Axis("x", "m", (1.0,)), Axis("y", "ms", (1.0,)))), "axes"),
    ],
)
def test_another_sweep_is_refused(tmp_path: Path, changed: Any, words: str) -> None:
    """Another law, other settings, another unit: refused, with what differs; the file stays."""
    before = finished(tmp_path)
    with pytest.raises(JournalError) as raised:
        run_sweep(changed, tmp_path, workers=1)
    assert words in str(raised.value) and "Give another folder" in str(raised.value)
    assert (tmp_path / NAME).read_bytes() == before


def test_a_finer_grid_goes_on(tmp_path: Path) -> None:
    """Values are no part of what must agree: points that are there are kept."""
    finished(tmp_path)
    result = run_sweep(toy(x=(1.0, 1.5, 2.0)), tmp_path, workers=1)
    assert (result.resumed, len(result.points)) == (6, 9)
    assert [point.result["z"] for point in result.points][3:6] == [
        pytest.approx(3.0 * y) for y in (0.1, 0.2, 0.3)
    ]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"my own notes", "not the journal of a sweep"),
        (b"my own notes\n", "line 1 is not the header"),
        (b"[1]\n", "line 1 is not the header"),
        (b'{"format": "takagi-sweep", "version": 2}\n', "version 2"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, content: bytes, words: str) -> None:
    """A file that is no journal is not touched."""
    (tmp_path / NAME).write_bytes(content)
    with pytest.raises(JournalError, match=words):
        run_sweep(toy(), tmp_path, workers=1)
    assert (tmp_path / NAME).read_bytes() == content


@pytest.mark.parametrize(
    "line", [b"\x00\x00", b"{", b'{"at": [1.0], "seconds": 1, "result": {"verdict": "PROVED"}}']
)
def test_a_damaged_line_is_named(tmp_path: Path, line: bytes) -> None:
    """A line in the middle that cannot be read is not passed over."""
    lines = finished(tmp_path).split(b"\n")
    lines[2] = line
    (tmp_path / NAME).write_bytes(b"\n".join(lines))
    with pytest.raises(JournalError, match="line 3 is damaged"):
        run_sweep(toy(), tmp_path, workers=1)


@pytest.mark.skipif(os.name != "posix", reason="locks of whole files")
def test_two_sweeps_do_not_share_a_journal(tmp_path: Path) -> None:
    """While one writes, the other is refused; afterwards it is not."""
    with Journal(tmp_path, toy()), pytest.raises(JournalError, match="another takagi sweep"):
        Journal(tmp_path, toy())
    with Journal(tmp_path, toy()) as free:
        assert free.done == {}


def test_a_full_disk_leaves_whole_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A line that cannot be written whole is taken back, the error names the file."""
    whole = finished(tmp_path / "whole")
    write = os.write

    def full(handle: int, data: bytes) -> int:
        if b"0.3" in data:
            write(handle, data[:7])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(handle, data)

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(OSError, match=NAME) as raised:
        run_sweep(toy(), tmp_path, workers=1)
    assert raised.value.errno == errno.ENOSPC
    left = (tmp_path / NAME).read_bytes()
    assert left.endswith(b"}\n") and left.count(b"\n") == 3
    monkeypatch.undo()
    result = run_sweep(toy(), tmp_path, workers=1)
    assert result.resumed == 2
    assert (tmp_path / NAME).read_bytes().count(b"\n") == whole.count(b"\n")
