"""`takagi study overlap`: a tiny study, stopped and gone on with, beside `takagi simulate`."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from math import exp, pi
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from takagi.models.turbine.data import Turbine
from takagi.reports.study import overlap as module
from tests.cli.conftest import contents

Capture = pytest.CaptureFixture[str]
TINY = ("--over", "speed-overlap=0,0.5", "--over", "wind=9,12", "--duration", "20")


def studied(out: Path, *options: str, model: str = "nrel5mw") -> int:
    """Run the verb in one process."""
    return main(["study", "overlap", model, "--out", str(out), "--workers", "1", *options])


@pytest.fixture(scope="module")
def tiny(given_observer: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a study of the hard switch and Schulte's default, two winds, one seed."""
    out = tmp_path_factory.mktemp("study")
    assert studied(out, *TINY, "--seeds", "1") == 0
    return out


def rows_of(out: Path) -> list[dict[str, str]]:
    with (out / "study.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_study_that_was_stopped_ends_with_the_same_bytes(
    tiny: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the middle: status 130, one sentence; the same command computes the others."""
    motion = module.motion

    def interrupted(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
        if inputs["law"] == "paper":
            raise KeyboardInterrupt
        return motion(turbine, inputs)

    monkeypatch.setattr(module, "motion", interrupted)
    interrupted.__name__ = "motion"
    assert studied(tmp_path, *TINY, "--seeds", "1") == 130
    assert "the same command goes on" in capsys.readouterr().err
    monkeypatch.setattr(module, "motion", motion)
    assert studied(tmp_path, *TINY, "--seeds", "1") == 0
    # Two winds of the reference controller and of the switch, and what is proved of the default.
    assert "5 of 7 results were computed before" in capsys.readouterr().out
    assert contents(tmp_path) == contents(tiny)


def test_a_run_of_the_study_is_that_of_simulate(
    tiny: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The same law, wind and plant by another verb: every metric."""
    words = ["--law", "reference", "--wind", "turbulent:12:B:1", "--duration", "20", "--json"]
    assert main(["simulate", "nrel5mw", *words]) == 0
    (run,) = json.loads(capsys.readouterr().out)["rows"]

    (row,) = [r for r in rows_of(tiny) if r["law"] == "baseline" and r["wind"] == "12.0"]
    for name in ("tower_del", "blade_del", "shaft_del", "energy", "overspeed", "torque_change"):
        assert float(row[name]) == pytest.approx(run[name], rel=1e-12)


def test_winds_are_weighed_by_their_damage(tiny: Path) -> None:
    """By hand, from the rows of the runs: Rayleigh with a mean of 10 m/s, Wohler exponent 10."""
    data = json.loads((tiny / "study.json").read_text(encoding="utf-8"))
    weights = {v: v * exp(-pi / 4 * (v / 10) ** 2) for v in (9.0, 12.0)}
    for point in data["points"]:
        rows = [row for row in rows_of(tiny) if row["law"] == point["law"]]
        damage = sum(weights[float(r["wind"])] * float(r["blade_del"]) ** 10 for r in rows)
        power = sum(weights[float(r["wind"])] * float(r["mean_power"]) for r in rows)
        total, figures = sum(weights.values()), point["figures"]
        assert len(rows) == 2
        assert figures["blade_del"]["mean"] == pytest.approx((damage / total) ** 0.1)
        assert figures["mean_power"]["mean"] == pytest.approx(power / total)


def test_what_is_proved_stands_beside_what_is_simulated(tiny: Path) -> None:
    """The default is proved in every window; of a switch nothing can be."""
    points = json.loads((tiny / "study.json").read_text(encoding="utf-8"))["points"]
    proofs = {point["law"]: point["proof"] for point in points}

    assert proofs["switched"] is None and proofs["baseline"] is None
    assert proofs["paper"]["verdict"] == "PROVED"
    assert proofs["paper"]["proved_windows"] == proofs["paper"]["windows"] == 25
    text = (tiny / "study.md").read_text(encoding="utf-8")
    assert "25 of 25 winds" in text and "nothing can be" in text
    for name in ("overlap", "front"):
        assert (tiny / f"figures/{name}.svg").read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (("--over", "speed-overlap=0.7"), ["begin below the smallest speed", "every wind from 3"]),
        (("--over", "torque-overlap=9kNm"), ["at most 8618", "at rated wind"]),
        (("--over", "overlap=0"), ["overlap must be above 0"]),
        (("--over", "bandwidth=1"), ["cannot be swept", "centred-overlap [rad/s]"]),
        (("--over", "wind=8,26"), ["26 m/s was given", "from 3 to 25 m/s"]),
        (("--seeds", "0"), ["0 seeds", "at least 1 seed"]),
        (("--duration", "5"), ["duration of 5 s", "10 s are needed"]),
        (("--scheduler", "tcp://127.0.0.1:1"), ["leave --workers out"]),
    ],
)
def test_misuse(
    tmp_path: Path, capsys: Capture, options: tuple[str, ...], parts: list[str]
) -> None:
    """One message, status 2, and no folder."""
    assert studied(tmp_path / "out", *options) == 2
    told = capsys.readouterr()
    assert told.out == "" and told.err.startswith("Error: ")
    for part in parts:
        assert part in told.err
    assert not (tmp_path / "out").exists()


def test_what_is_no_turbine_and_no_study(tmp_path: Path, capsys: Capture) -> None:
    """The refusal is about the model; an unknown study is answered with the known ones."""
    assert studied(tmp_path / "out", model="cart_pole") == 2
    assert "model cart_pole is a plant" in capsys.readouterr().err
    assert main(["study", "overlp", "nrel5mw"]) == 2
    assert "'overlp' is not a study (did you mean 'overlap'?)" in capsys.readouterr().err
