"""Tasks: the same results by one process or several; stopped, killed and damaged, they go on."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from takagi.certificates.sweep.tasks import Task, run_tasks
from takagi.models import ModelError
from tests.certificates.sweep.toy import tasks

ROOT = Path(__file__).parents[3]
SCRIPT = """
import signal, sys
from pathlib import Path
from takagi.certificates.sweep.tasks import run_tasks
from tests.certificates.sweep.toy import tasks

if __name__ == "__main__":
    # A shell's background jobs ignore SIGINT and hand that on: the script hears it again.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    folder = Path(sys.argv[1])
    run_tasks(tasks("slow", str(folder), 24), folder / "results", workers=2)
"""


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.json")}


def test_several_processes_leave_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the order of the tasks; a second run computes nothing, and tells how far it is."""
    monkeypatch.syspath_prepend(str(ROOT))
    heard: list[float] = []

    def tell(words: str, share: float) -> None:
        heard.append(share)

    alone = run_tasks(tasks(), tmp_path / "one", workers=1)
    shared = run_tasks(tasks(), tmp_path / "two", workers=2, tell=tell)

    assert alone == shared == ([{"z": 2 * x, "a": [0.1 * x, None]} for x in range(6)], 0)
    assert list(alone[0][0]) == ["z", "a"]
    assert heard == pytest.approx([k / 6 for k in range(1, 7)])
    assert len(content(tmp_path / "one")) == 6
    assert content(tmp_path / "one") == content(tmp_path / "two")
    assert run_tasks(tasks("slow", "nowhere", 0), tmp_path / "one") == ([], 0)
    assert run_tasks(tasks(), tmp_path / "one", workers=2) == (alone[0], 6)


@pytest.mark.parametrize("damage", ["cut", "changed", "empty", "other task", "list"])
def test_a_damaged_result_is_computed_again(tmp_path: Path, damage: str) -> None:
    """Whatever is wrong with the file: a digit that was changed is noticed, too."""
    run_tasks(tasks(), tmp_path, workers=1)
    before, path = content(tmp_path), tmp_path / tasks()[3].file
    text = path.read_text()
    path.write_text(
        {
            "cut": text[: len(text) // 2],
            "changed": text.replace('"z":6', '"z":7'),
            "empty": "",
            "other task": (tmp_path / tasks()[2].file).read_text(),
            "list": "[1, 2]",
        }[damage]
    )

    results, resumed = run_tasks(tasks(), tmp_path, workers=1)
    assert (results[3]["z"], resumed) == (6, 5)
    assert content(tmp_path) == before


def test_another_study_does_not_use_a_result(tmp_path: Path) -> None:
    """Another function, input or version has another name; the place of the source has not."""
    run_tasks(tasks(), tmp_path, workers=1)

    assert run_tasks(tasks(factor=3), tmp_path, workers=1)[0][1]["z"] == 3
    assert len({tasks()[1].file, tasks(factor=3)[1].file, tasks("slow")[1].file}) == 3
    assert tasks(source="a")[0].file == tasks(source="b")[0].file
    assert "takagi" in json.loads(tasks()[0].hashed)["versions"]


def test_an_error_ends_no_other_task_and_is_tried_again(tmp_path: Path) -> None:
    """A fault, and a result that is no JSON."""
    results, _ = run_tasks(tasks("troubled"), tmp_path, workers=1)

    assert [result.get("z") for result in results] == [0, None, 4, None, 8, None]
    assert results[1]["error"] == "ZeroDivisionError: a fault"
    assert results[3]["error"].startswith("ValueError")
    assert run_tasks(tasks("troubled"), tmp_path, workers=1)[1] == 3


def test_a_killed_process_loses_only_its_task(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other processes take over."""
    monkeypatch.syspath_prepend(str(ROOT))
    work, folder = tasks("deadly", str(tmp_path / "killed"), 40), tmp_path / "results"

    results, _ = run_tasks(work, folder, workers=2)
    assert [result["z"] for result in results] == [2 * x for x in range(40)]
    assert (tmp_path / "killed").exists()
    run_tasks(tasks("deadly", str(tmp_path / "killed"), 40), tmp_path / "alone", workers=1)
    assert content(folder) == content(tmp_path / "alone")


@pytest.mark.slow
def test_processes_that_are_always_killed_end_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The words say how often, and what to do."""
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.setattr("takagi.certificates.sweep.tasks.RENEWALS", 1)
    (tmp_path / "killed").touch()
    # A path below a file can never be made, so that every process that tries x = 3 is killed.
    work = tasks("deadly", str(tmp_path / "killed" / "again"), 5)
    with pytest.raises(ModelError, match="killed from outside 2 times.*run the same command again"):
        run_tasks(work, tmp_path / "deadly", workers=2)


def test_a_folder_of_another_study_or_release_is_refused(tmp_path: Path) -> None:
    """Before anything is computed; a file that cannot be read is no study."""
    run_tasks(tasks(), tmp_path / "a", workers=1)
    (tmp_path / "a" / "other.json").write_text("[]")
    with pytest.raises(ModelError, match=r"result of another study \(tests.*toy:product\)"):
        run_tasks(tasks("slow"), tmp_path / "a", workers=1)

    path = tmp_path / "a" / tasks()[0].file
    older = json.loads(path.read_text())
    older["task"]["versions"]["numpy"] = "1.0"
    path.rename(path.with_name("0.json")).write_text(json.dumps(older))
    with pytest.raises(ModelError, match=r"other versions: numpy 1\.0 \(here 2.*another folder"):
        run_tasks(tasks(), tmp_path / "a", workers=1)


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("stop", [signal.SIGKILL, signal.SIGINT])
def test_stopped_from_outside(tmp_path: Path, stop: signal.Signals) -> None:
    """Stopped in the middle, its processes end too, and the next run computes only what is left."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    results = tmp_path / "results"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, str(script), str(tmp_path)],
        cwd=ROOT,
        env=environment,
        stderr=subprocess.PIPE,
    ) as running:
        _wait(lambda: len(list(results.glob("*.json"))) >= 4)
        running.send_signal(stop)
        running.wait(60)
    _wait(lambda: not any(_alive(int(p.name[8:])) for p in tmp_path.glob("process-*")))
    ready = len(list(results.glob("*.json")))
    assert 4 <= ready < 24
    made, resumed = run_tasks(tasks("slow", str(tmp_path), 24), results, workers=1)
    assert resumed == ready
    assert [result["z"] for result in made] == [2 * x for x in range(24)]


def test_workers_must_be_some(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="at least 1"):
        run_tasks([Task("x:y", "", {})], tmp_path / "none", workers=0)
    assert not (tmp_path / "none").exists()


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def _wait(condition: object, seconds: float = 90.0) -> None:
    assert callable(condition)
    for _ in range(int(seconds / 0.05)):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited in vain")
