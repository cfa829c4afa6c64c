"""What leaves the house is whole or absent, whatever the disk does."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import pytest

from takagi.reports.output import OutputError, write_file, write_folder


def failing(code: int, *, after: int = 0) -> Callable[..., Any]:
    """A function that works `after` times and then fails as the operating system would."""
    calls = 0

    def fail(*_args: object, **_options: object) -> None:
        nonlocal calls
        calls += 1
        if calls > after:
            raise OSError(code, os.strerror(code))

    return fail


def tree(folder: Path) -> dict[str, bytes]:
    """Every file under a folder, hidden ones too."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_a_folder_is_written_with_its_subfolders(tmp_path: Path) -> None:
    """Text is UTF-8, bytes are bytes, and no temporary file remains."""
    write_folder(tmp_path / "new/out", {"a.txt": "ω", "figures/b.bin": b"\x00"})

    assert tree(tmp_path) == {"new/out/a.txt": "ω".encode(), "new/out/figures/b.bin": b"\x00"}


def test_existing_outputs_are_replaced_and_other_files_stay(tmp_path: Path) -> None:
    """A second design into the same folder replaces its files and touches no others."""
    write_folder(tmp_path, {"gains.json": "old", "notes.txt": "mine"})

    write_folder(tmp_path, {"gains.json": "new"})

    assert tree(tmp_path) == {"gains.json": b"new", "notes.txt": b"mine"}


def test_a_full_disk_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second file does not fit: the first is not replaced either, and nothing is left over."""
    write_folder(tmp_path / "out", {"gains.json": "old"})
    monkeypatch.setattr(os, "fsync", failing(errno.ENOSPC, after=1))

    with pytest.raises(OutputError, match=r"report\.html: the disk is full") as caught:
        write_folder(tmp_path / "out", {"gains.json": "new", "report.html": "new"})

    assert caught.value.errno == errno.ENOSPC
    assert tree(tmp_path) == {"out/gains.json": b"old"}
    assert list((tmp_path / "out").iterdir()) == [tmp_path / "out/gains.json"]


def interrupt(_handle: int) -> NoReturn:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("module", "name", "fault", "error"),
    [
        (os, "fsync", failing(errno.ENOSPC), OutputError),
        # Ctrl-C between two files is no different from a full disk.
        (os, "fsync", interrupt, KeyboardInterrupt),
        (tempfile, "mkdtemp", failing(errno.EROFS), OutputError),
    ],
)
def test_a_failed_first_run_leaves_the_place_as_it_was(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    module: ModuleType,
    name: str,
    fault: Any,
    error: type[BaseException],
) -> None:
    """Folders made in vain are removed; the message says which folder and what to do."""
    monkeypatch.setattr(module, name, fault)

    with pytest.raises(error) as caught:
        write_folder(tmp_path / "deep/out", {"figures/a.svg": "x"})

    assert list(tmp_path.iterdir()) == []
    if error is OutputError:
        assert str(tmp_path) in str(caught.value)
        assert "the disk is full" in str(caught.value) or "read-only; choose" in str(caught.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_read_only_parent_is_named(tmp_path: Path) -> None:
    """A folder that cannot be made: permission denied, with its path."""
    tmp_path.chmod(0o555)

    with pytest.raises(OutputError, match=r"out: permission denied"):
        write_folder(tmp_path / "out", {"a": "x"})


@pytest.mark.parametrize("path", ["file", "file/below"])
def test_a_file_in_the_way_of_a_folder_stays(tmp_path: Path, path: str) -> None:
    """A file where the folder should be is an error, never overwritten."""
    (tmp_path / "file").write_text("mine")

    with pytest.raises(OutputError, match="choose another name|a folder was expected"):
        write_folder(tmp_path / path, {"a": "x"})

    assert tree(tmp_path) == {"file": b"mine"}


def test_a_folder_in_the_way_of_a_file_stops_all(tmp_path: Path) -> None:
    """Found before anything is renamed."""
    (tmp_path / "b").mkdir()

    with pytest.raises(OutputError, match="this is a folder, and a file was expected"):
        write_folder(tmp_path, {"a": "x", "b": "x"})

    assert tree(tmp_path) == {}


@pytest.mark.parametrize("name", ["../a", "/a", "", "b/../../a"])
def test_a_name_outside_the_folder_is_refused(tmp_path: Path, name: str) -> None:
    """Names come from code, so this is a fault of the caller, not of the disk."""
    with pytest.raises(ValueError, match="relative to the folder"):
        write_folder(tmp_path / "out", {name: "x"})

    assert list(tmp_path.iterdir()) == []


def test_a_link_is_followed_and_stays_a_link(tmp_path: Path) -> None:
    """The user linked the file to where it must be."""
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to("target")

    write_file(tmp_path / "link", "new")

    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "new"


def test_a_pipe_is_written_to_and_stays_a_pipe(tmp_path: Path) -> None:
    """`--json /dev/stdout` must not replace the device by a file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)

    write_file(pipe, "text")

    assert os.read(reader, 10) == b"text"
    assert pipe.is_fifo()
    os.close(reader)
