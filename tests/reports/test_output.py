"""What leaves the house is whole or absent, whatever the disk does."""

from __future__ import annotations

import errno
import json
import os
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import pytest

from takagi.certificates import Checked, Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.checker.words.figure import Figure
from takagi.reports.ci_formats import junit, markdown, refusal, sarif, with_failures
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
    write_folder(tmp_path, {"gains.json": "old", "notes.txt": "mine"})

    write_folder(tmp_path, {"gains.json": "new"})

    assert tree(tmp_path) == {"gains.json": b"new", "notes.txt": b"mine"}


def test_a_full_disk_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
    monkeypatch.setattr(module, name, fault)

    with pytest.raises(error) as caught:
        write_folder(tmp_path / "deep/out", {"figures/a.svg": "x"})

    assert list(tmp_path.iterdir()) == []
    if error is OutputError:
        assert str(tmp_path) in str(caught.value)
        assert "the disk is full" in str(caught.value) or "read-only; choose" in str(caught.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_read_only_parent_is_named(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)

    with pytest.raises(OutputError, match=r"out: permission denied"):
        write_folder(tmp_path / "out", {"a": "x"})


@pytest.mark.parametrize("path", ["file", "file/below"])
def test_a_file_in_the_way_of_a_folder_stays(tmp_path: Path, path: str) -> None:
    (tmp_path / "file").write_text("mine")

    with pytest.raises(OutputError, match="choose another name|a folder was expected"):
        write_folder(tmp_path / path, {"a": "x"})

    assert tree(tmp_path) == {"file": b"mine"}


def test_a_folder_in_the_way_of_a_file_stops_all(tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()

    with pytest.raises(OutputError, match="this is a folder, and a file was expected"):
        write_folder(tmp_path, {"a": "x", "b": "x"})

    assert tree(tmp_path) == {}


@pytest.mark.parametrize("name", ["../a", "/a", "", "b/../../a"])
def test_a_name_outside_the_folder_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="relative to the folder"):
        write_folder(tmp_path / "out", {name: "x"})

    assert list(tmp_path.iterdir()) == []


def test_a_link_is_followed_and_stays_a_link(tmp_path: Path) -> None:
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


def mixed() -> Checked:
    """One claim of each verdict, with what XML and Markdown must escape."""
    claims = [
        Claim("decay", Verdict.PROVED, "V' <= -2 a V & more"),
        Claim("pitch", Verdict.DISPROVED, "|rate| > limit\x00"),
        Claim("box", Verdict.UNDECIDED, 'cell "3"'),
    ]
    return concluded(claims, ["checked <all>"])


def test_junit_fails_what_is_not_proved() -> None:
    suite = ElementTree.fromstring(junit(mixed(), source="out/certificate.json"))[0]

    cases = suite.findall("testcase")
    failures = {case.get("name"): case.find("failure") for case in cases}

    assert (suite.get("tests"), suite.get("failures")) == ("3", "2")
    assert failures["decay"] is None
    assert failures["pitch"] is not None and failures["pitch"].get("type") == "DISPROVED"
    assert failures["box"] is not None and failures["box"].text == 'cell "3"'
    assert suite.findtext("system-out") == "checked <all>"


def test_sarif_has_one_result_for_what_is_not_proved() -> None:
    run = json.loads(sarif(mixed(), source="my out/certificate.json"))["runs"][0]

    results = run["results"]
    rules = run["tool"]["driver"]["rules"]

    assert [(r["kind"], r["level"]) for r in results] == [("fail", "error"), ("fail", "warning")]
    assert [rules[r["ruleIndex"]]["id"] for r in results] == [r["ruleId"] for r in results]
    assert [rule["id"] for rule in rules] == ["decay", "pitch", "box"]
    location = results[0]["locations"][0]["physicalLocation"]["artifactLocation"]
    assert location["uri"] == "my%20out/certificate.json"


def test_sarif_marks_the_plant_and_names_kinds(tmp_path: Path) -> None:
    """A rule is a kind, never a plant's name; the line is that of the section it follows from."""
    plant = tmp_path / "motor.toml"
    plant.write_text('kind = "plant"\n\n[states]\n[inputs]\n[equations]\n', encoding="utf-8")
    claims = [Claim(f"{name} of motor", Verdict.UNDECIDED, "") for name in ("limits", "decay")]
    missed = with_failures(concluded(claims, []), [("the loop has the margins", "at 9 m/s")])
    text = sarif(missed, source="c", kinds=["input-limits", "decay"], plant=plant)

    run = json.loads(text)["runs"][0]
    driver, places = run["tool"]["driver"], [r["locations"][0] for r in run["results"]]
    ids = [rule["id"] for rule in driver["rules"]]
    assert ids == ["input-limits", "decay", "the-loop-has-the-margins"] and driver["version"]
    assert [p["physicalLocation"]["region"]["startLine"] for p in places] == [4, 5, 5]
    assert places[0]["physicalLocation"]["artifactLocation"]["uri"].endswith("motor.toml")


def test_markdown_is_a_table_of_the_claims() -> None:
    lines = markdown(mixed(), source="certificate.json").splitlines()

    assert lines[0] == "## certificate.json: DISPROVED"
    assert "| DISPROVED | pitch | \\|rate\\| > limit" in lines[5]
    assert lines[-1] == "- checked &lt;all>"


def test_numbers_of_a_claim_stand_beside_it() -> None:
    checked = mixed()
    rate = Figure("decay rate", "1/s", Fraction("3.389"))
    first, *others = checked.claims
    checked = replace(checked, claims=[replace(first, figures=(rate,)), *others])
    case = ElementTree.fromstring(junit(checked, source="c.json"))[0][0]
    shown = case.find("properties/property")
    assert shown is not None and shown.attrib == {"name": "decay rate [1/s]", "value": "3.38"}
    lines = markdown(checked, source="c.json").splitlines()
    assert lines[4].endswith("| decay rate [1/s] 3.38 |") and lines[5].endswith("|  |")


def test_a_refused_file_is_a_failure_in_each_format() -> None:
    """Continuous integration must show a refusal as red, never as an empty, green report."""
    refused = refusal("line 3: not JSON")

    assert 'failures="1"' in junit(refused, source="c.json")
    assert json.loads(sarif(refused, source="c.json"))["runs"][0]["results"][0]["level"] == "error"
    assert "REFUSED" in markdown(refused, source="c.json")


def test_claims_of_one_name_are_told_apart() -> None:
    claims = [Claim("set", verdict, "") for verdict in (Verdict.PROVED, Verdict.UNDECIDED)]
    checked = concluded([*claims, Claim("set (2)", Verdict.PROVED, "")], [])

    names = ["set", "set (2)", "set (2) (2)"]
    cases = ElementTree.fromstring(junit(checked, source="c"))[0].findall("testcase")
    run = json.loads(sarif(checked, source="c"))["runs"][0]
    assert [case.get("name") for case in cases] == names
    assert [result["partialFingerprints"]["claim/v1"] for result in run["results"]] == ["set (2)"]
    assert "| UNDECIDED | set (2) |" in markdown(checked, source="c")
