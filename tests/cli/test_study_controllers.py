"""`takagi study controllers`: two laws in a short wind, beside `takagi simulate`; ROSCO's library.

ROSCO's tests need the package rosco, which no run of CI installs (1.4 GB with what it needs).
"""

from __future__ import annotations

import csv
import importlib.util
import json
from collections.abc import Mapping
from dataclasses import fields, replace
from math import exp, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.cli.main import main
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.scenario import measure
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import load_turbine
from takagi.reports.simulation.winds import requested_winds
from takagi.reports.study import overlap as module
from takagi.reports.study.rosco import filed_tuning, retuned, shipped_tuning, simulate_rosco
from tests.cli.conftest import contents

Capture = pytest.CaptureFixture[str]
HAS_ROSCO = importlib.util.find_spec("rosco") is not None
with_rosco = pytest.mark.skipif(not HAS_ROSCO, reason="takagi[compare] is not installed")
TINY = ("--winds", "11", "--duration", "10", "--seeds", "2")
TWO = ("--law", "effort-sharing", "--law", "reference")


def studied(out: Path, *options: str, study: str = "controllers") -> int:
    return main(["study", study, "nrel5mw", "--out", str(out), "--workers", "1", *options])


@pytest.fixture(scope="module")
def tiny(given_observer: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("controllers")
    assert studied(out, *TWO, *TINY) == 0
    return out


def rows_of(out: Path) -> list[dict[str, str]]:
    with (out / "study.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_run_is_the_end_of_one_of_simulate(tiny: Path) -> None:
    """The reference as a Python object in the other loop; the first 30 s are not counted."""
    turbine = load_turbine("nrel5mw")
    (wind,) = requested_winds(turbine, ["turbulent:11:B:2"], duration=40)
    history = simulate(validation_plant(turbine), BaselineLaw(turbine), wind)
    arrays = {f.name: getattr(history, f.name) for f in fields(history)}
    late: dict[str, Any] = {k: v[1500:] for k, v in arrays.items() if isinstance(v, np.ndarray)}
    metrics = measure(replace(history, **late), turbine)

    (row,) = [r for r in rows_of(tiny) if r["law"] == "reference" and r["seed"] == "2"]
    for name in ("tower_del", "shaft_del", "energy", "overspeed", "torque_change"):
        assert float(row[name]) == pytest.approx(getattr(metrics, name), rel=1e-6)
    assert float(row["duration"]) == pytest.approx(10)


def test_differences_are_paired_and_what_is_worse_is_said(tiny: Path) -> None:
    """By hand, from the rows of the runs."""
    data = json.loads((tiny / "controllers.json").read_text(encoding="utf-8"))
    rows = {(r["law"], r["seed"]): r for r in rows_of(tiny)}
    ours = data["laws"]["effort-sharing"]["differences"]
    listed = {w["metric"]: w for w in data["worse"] if w["than"] == "reference"}

    for name, sign in (("mean_power", -1), ("tower_del", 1), ("pitch_travel", 1)):
        each = [
            float(rows["effort-sharing", s][name]) - float(rows["reference", s][name]) for s in "12"
        ]
        (stated,) = ours[name]
        assert stated["value"] == pytest.approx(sum(each) / 2)
        assert (stated["low"], stated["high"]) == pytest.approx((min(each), max(each)))
        worse = name in listed
        assert worse == (sign * sum(each) > 0)
        assert not worse or ("11" in listed[name]["clear"]) == (min(each) * max(each) > 0)
    assert data["compared_with"] == "reference"
    text = (tiny / "controllers.md").read_text(encoding="utf-8")
    assert "## Where the effort-sharing law is worse" in text and "## A year" in text
    assert (tiny / "figures/controllers.svg").read_text(encoding="utf-8").startswith("<svg")


def test_the_same_command_goes_on(tiny: Path, capsys: Capture) -> None:
    before = contents(tiny)
    assert studied(tiny, *TWO, *TINY) == 0
    assert "2 of 2 results were computed before" in capsys.readouterr().out
    assert contents(tiny) == before


def test_without_the_package_a_sentence_says_what_to_install(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("takagi.reports.study.rosco.PACKAGE", "no_such_package")

    assert studied(tmp_path / "out", *TWO, *TINY, "--rosco", "shipped") == 2
    assert "pip install 'takagi[compare]'" in capsys.readouterr().err


@pytest.mark.slow
@with_rosco
def test_the_toolbox_makes_what_the_package_ships() -> None:
    """With the package's bandwidth, from the figures here: the same gains, to 1 %."""
    turbine = load_turbine("nrel5mw")
    shipped, made = shipped_tuning(turbine), retuned(turbine, 0.6, 0.7)

    for name in ("PC_GS_KP", "PC_GS_KI", "VS_KP", "VS_KI", "VS_RtTq"):
        rows = [
            [float(x) for x in line.split("!")[0].split()]
            for tuning in (shipped, made)
            for line in tuning.discon.splitlines()
            if "!" in line and line.split("!")[1].split()[0] == name
        ]
        assert rows[0] == pytest.approx(rows[1], rel=0.01)


@with_rosco
def test_rosco_holds_rated_power_and_each_run_begins_anew(capfd: Capture) -> None:
    """At 15 m/s its own design point; twice the same bytes, though the library keeps states."""
    turbine = load_turbine("nrel5mw")
    plant, tuning = validation_plant(turbine), shipped_tuning(turbine)
    (wind,) = requested_winds(turbine, ["15"], duration=60)

    first, second = (simulate_rosco(plant, "rosco", tuning, wind) for _ in range(2))

    assert first.electrical_power[-1] == pytest.approx(turbine.rated_power, rel=0.005)
    assert first.rotor_speed[-1] == pytest.approx(turbine.rated_rotor_speed, rel=0.005)
    assert first.plant_states.tobytes() == second.plant_states.tobytes()
    assert capfd.readouterr().out == ""


@with_rosco
def test_a_file_for_another_machine_is_refused(tmp_path: Path, capsys: Capture) -> None:
    """A tuning that needs a part the plant does not have; one that is no tuning."""
    text = shipped_tuning(load_turbine("nrel5mw")).discon
    for name, content, part in (
        ("floating", text.replace("0                   ! Fl_Mode", "1 ! Fl_Mode"), "Fl_Mode is 1"),
        ("none", "nothing", "names no rotor tables"),
    ):
        (tmp_path / name).write_text(content, encoding="utf-8")
        assert studied(tmp_path / "out", *TINY, "--rosco", f"mine={tmp_path / name}") == 2
        assert part in capsys.readouterr().err
    with pytest.raises(Exception, match="No such file"):
        filed_tuning(tmp_path / "absent")


OVERLAP = "--over speed-overlap=0,0.5 --over wind=9,12 --duration 10 --seeds 1".split()


@pytest.fixture(scope="module")
def overlap_folder(given_observer: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study")
    assert studied(out, *OVERLAP, study="overlap") == 0
    return out


def test_a_study_that_was_stopped_ends_with_the_same_bytes(
    overlap_folder: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the middle: status 130, one sentence; the same command computes the others."""
    motion = module.motion

    def interrupted(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
        if inputs["law"] == "paper":
            raise KeyboardInterrupt
        return motion(turbine, inputs)

    monkeypatch.setattr(module, "motion", interrupted)
    interrupted.__name__ = "motion"
    assert studied(tmp_path, *OVERLAP, study="overlap") == 130
    assert "the same command goes on" in capsys.readouterr().err
    monkeypatch.setattr(module, "motion", motion)
    assert studied(tmp_path, *OVERLAP, study="overlap") == 0
    # Two winds of the reference controller and of the switch, and what is proved of the default.
    assert "5 of 7 results were computed before" in capsys.readouterr().out
    assert contents(tmp_path) == contents(overlap_folder)


def test_a_run_of_the_study_is_that_of_simulate(
    overlap_folder: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The same law, wind and plant by another verb: every metric."""
    words = ["--law", "reference", "--wind", "turbulent:12:B:1", "--duration", "10", "--json"]
    assert main(["simulate", "nrel5mw", *words]) == 0
    (run,) = json.loads(capsys.readouterr().out)["rows"]

    (row,) = [r for r in rows_of(overlap_folder) if r["law"] == "baseline" and r["wind"] == "12.0"]
    for name in ("tower_del", "blade_del", "shaft_del", "energy", "overspeed", "torque_change"):
        assert float(row[name]) == pytest.approx(run[name], rel=1e-12)


def test_winds_are_weighed_by_their_damage(overlap_folder: Path) -> None:
    """By hand, from the rows of the runs: Rayleigh with a mean of 10 m/s, Wohler exponent 10."""
    data = json.loads((overlap_folder / "study.json").read_text(encoding="utf-8"))
    weights = {v: v * exp(-pi / 4 * (v / 10) ** 2) for v in (9.0, 12.0)}
    for point in data["points"]:
        rows = [row for row in rows_of(overlap_folder) if row["law"] == point["law"]]
        damage = sum(weights[float(r["wind"])] * float(r["blade_del"]) ** 10 for r in rows)
        power = sum(weights[float(r["wind"])] * float(r["mean_power"]) for r in rows)
        total, figures = sum(weights.values()), point["figures"]
        assert len(rows) == 2
        assert figures["blade_del"]["mean"] == pytest.approx((damage / total) ** 0.1)
        assert figures["mean_power"]["mean"] == pytest.approx(power / total)


def test_what_is_proved_stands_beside_what_is_simulated(overlap_folder: Path) -> None:
    """The default is proved in every window; of a switch nothing can be."""
    points = json.loads((overlap_folder / "study.json").read_text(encoding="utf-8"))["points"]
    proofs = {point["law"]: point["proof"] for point in points}

    assert proofs["switched"] is None and proofs["baseline"] is None
    assert proofs["paper"]["verdict"] == "PROVED"
    assert proofs["paper"]["proved_windows"] == proofs["paper"]["windows"] == 25
    text = (overlap_folder / "study.md").read_text(encoding="utf-8")
    assert "25 of 25 winds" in text and "nothing can be" in text
    for name in ("overlap", "front"):
        assert (
            (overlap_folder / f"figures/{name}.svg").read_text(encoding="utf-8").startswith("<svg")
        )
