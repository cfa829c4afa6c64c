"""Points in one process and several: the same answers, errors as values, ends at any time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import MappingProxyType

import pytest

from takagi.certificates.sweep import run_sweep
from takagi.certificates.sweep.journal import NAME
from takagi.certificates.sweep.sending import received, sent
from takagi.models import ModelError, nrel5mw
from tests.certificates.sweep.toy import deadly, toy, troubled

ROOT = Path(__file__).parents[3]

# A shell's background jobs ignore SIGINT and hand that on: the script hears it again.
SCRIPT = """
import signal
import sys
from pathlib import Path
from takagi.certificates.sweep.runner import run_sweep
from tests.certificates.sweep.toy import slow_product, toy

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    folder = Path(sys.argv[1])
    x = tuple(float(k) for k in range(1, 21))
    run_sweep(toy(slow_product, x=x, settings={"factor": 2.0, "folder": str(folder)}), folder,
              workers=2)
"""


def test_processes_agree_with_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processes make what one makes, in the order of the grid."""
    # A fresh process takes the path along, and must find the toy.
    monkeypatch.syspath_prepend(str(ROOT))
    told: list[tuple[str, float]] = []
    one = run_sweep(toy(), tmp_path / "one", workers=1)
    two = run_sweep(
        toy(), tmp_path / "two", workers=2, tell=lambda words, done: told.append((words, done))
    )
    assert [(p.at, p.result) for p in one.points] == [(p.at, p.result) for p in two.points]
    assert [point.result["z"] for point in two.points] == [
        pytest.approx(2 * x * y) for x in (1.0, 2.0) for y in (0.1, 0.2, 0.3)
    ]
    assert two.counted() == {"PROVED": 6}
    assert [done for _, done in told] == pytest.approx([k / 6 for k in range(7)])
    assert told[0][0] == "toy, 0 of 6 points" and "3 of 6 points, " in told[3][0]
    assert told[3][0].endswith(" s left")


def test_trouble_is_a_value(tmp_path: Path) -> None:
    """What cannot be is UNDECIDED with its words; a fault is FAILED, and tried again."""
    result = run_sweep(toy(troubled), tmp_path, workers=1)
    assert [point.result["verdict"] for point in result.points] == [
        *("PROVED", "UNDECIDED", "PROVED"),
        *("FAILED", "PROVED", "FAILED"),
    ]
    reasons = [point.result["reason"] for point in result.points]
    assert reasons[1] == "no such loop at y = 0.2 s"
    assert reasons[3] == "ZeroDivisionError: a fault"
    assert str(reasons[5]).startswith("ValueError: ")
    mended = run_sweep(toy(), tmp_path, workers=1)
    assert mended.resumed == 4
    assert [point.result["verdict"] for point in mended.points].count("PROVED") == 5


def test_workers_must_be_some(tmp_path: Path) -> None:
    """None at all is misuse, told before anything is written."""
    with pytest.raises(ModelError, match="at least 1"):
        run_sweep(toy(), tmp_path / "none", workers=0)
    assert not (tmp_path / "none").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("stop", [signal.SIGKILL, signal.SIGINT])
def test_stopped_from_outside(tmp_path: Path, stop: signal.Signals) -> None:
    """Stopped in the middle, its processes end too, and the next run makes only the rest."""
    script = tmp_path / "sweep.py"
    script.write_text(SCRIPT)
    folder = tmp_path / "out"
    folder.mkdir()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [sys.executable, str(script), str(folder)],
        cwd=ROOT,
        env=environment,
        stderr=subprocess.PIPE,
    ) as running:
        _wait(lambda: _lines(folder) >= 4)
        running.send_signal(stop)
        running.wait(30)
        _wait(lambda: not any(_alive(int(p.name[8:])) for p in folder.glob("process-*")))
    made = _lines(folder) - 1
    assert 3 <= made < 60
    x = tuple(float(k) for k in range(1, 21))
    settings = {"factor": 2.0, "folder": str(folder)}
    result = run_sweep(toy(x=x, settings=settings), folder, workers=1)
    assert result.resumed == made
    assert [point.result["z"] for point in result.points] == [
        pytest.approx(2 * a * y) for a in x for y in (0.1, 0.2, 0.3)
    ]


def test_a_killed_process_is_told(tmp_path: Path) -> None:
    """A process that the system ends stops the sweep with a cure; what was made stays."""
    with pytest.raises(ModelError, match="killed from outside"):
        run_sweep(toy(deadly), tmp_path, workers=2)
    assert json.loads((tmp_path / NAME).read_text().splitlines()[0])["map"] == "toy"
    assert run_sweep(toy(), tmp_path, workers=1).counted() == {"PROVED": 6}


def test_a_turbine_can_be_sent() -> None:
    """Read-only mappings arrive as such, and the numbers are the same."""
    turbine = nrel5mw()
    there = received(sent(turbine))
    assert isinstance(there.figures, MappingProxyType) and there.figures == turbine.figures
    assert float(there.torque(7.5, 0.02)) == float(turbine.torque(7.5, 0.02))
    with pytest.raises((AttributeError, TypeError)):
        sent(lambda: None)


def _lines(folder: Path) -> int:
    path = folder / NAME
    return path.read_bytes().count(b"\n") if path.exists() else 0


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def _wait(condition: object, seconds: float = 60.0) -> None:
    assert callable(condition)
    for _ in range(int(seconds / 0.05)):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited in vain")
