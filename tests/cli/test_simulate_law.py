"""`takagi simulate`: a law from its gain file, and how often the laws run."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates import CertificateError
from takagi.certificates.document.certificate_file import effort_sharing_law_data
from takagi.cli.main import main
from takagi.models import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.turbine.loader import nrel5mw
from takagi.models.turbine.trim import derated
from takagi.reports.simulation import laws

Capture = pytest.CaptureFixture[str]
QUICK = ("simulate", "nrel5mw", "--scenario", "step", "--duration", "4", "--json")


@cache
def content(rated: float) -> dict[str, Any]:
    """Return a gain file with a law for the turbine at this torque, and the observer's gains."""
    turbine = derated(nrel5mw(), rated) if rated < nrel5mw().rated_torque else nrel5mw()
    schedule = effort_schedule(turbine)
    count = len(schedule.wind)
    gains = EffortGains([0.6] * count, [0.15] * (count - 1))  # type: ignore[arg-type]
    law = effort_sharing_law_data(EffortSharingLaw.of(turbine, schedule, gains))
    return {"format": "takagi-gains", "version": 2, "law": law}


def gain_file(folder: Path, rated: float = np.inf, **observer: Any) -> Path:
    """Write it, with what the observer states beside its gains."""
    path = folder / "gains.json"
    stated = content(rated) | {"observer": {"l1": 1.8, "l2": 49.0, **observer}}
    path.write_text(json.dumps(stated), encoding="utf-8")
    return path


def answer(capsys: Capture, *options: str) -> dict[str, Any]:
    assert main([*QUICK, *options]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_a_law_comes_from_its_file(tmp_path: Path, capsys: Capture) -> None:
    """It alone, or beside the reference's own controller; nothing is designed."""
    path = str(gain_file(tmp_path))

    alone = answer(capsys, "--law-from", path)
    beside = answer(capsys, "--law-from", path, "--law", "baseline")

    assert list(alone["laws"]) == ["coherent"]
    assert list(beside["laws"]) == ["coherent", "baseline"]
    assert alone["rows"] == [row for row in beside["rows"] if row["law"] == "coherent"]


@pytest.mark.parametrize("limits", [None, [2.0, 12.0]])
def test_the_observer_has_the_limits_of_its_file(
    tmp_path: Path, limits: list[float] | None
) -> None:
    """A loop whose estimate stops at 12 m/s has other margins above, and was measured without.

    A file without limits has an observer with those that follow from cut-in and cut-out.
    """
    turbine = nrel5mw()
    stated: dict[str, Any] = {"wind_limits": limits} if limits else {}
    path = gain_file(tmp_path, **stated)
    seen: Any = laws.filed_laws(turbine, path)[1].observer
    assert seen.limits == (tuple(limits) if limits else (1.5, 37.5))
    assert seen.wind_estimate([1.2, 20.0]) == (12.0 if limits else 20.0)


@pytest.mark.parametrize("limits", [[12.0, 2.0], [0.0, 12.0], [2.0], "all", None])
def test_limits_of_the_estimate_that_are_none_are_refused(tmp_path: Path, limits: Any) -> None:
    path = gain_file(tmp_path, wind_limits=limits)
    with pytest.raises((CertificateError, ModelError), match=r"wind.limits"):
        laws.filed_laws(nrel5mw(), path)


def test_a_derated_law_gives_its_power(tmp_path: Path, capsys: Capture) -> None:
    """80 % of 5 MW above its rated wind; torque at its set-point is no fight of the actuators."""
    path = str(gain_file(tmp_path, 0.8 * nrel5mw().rated_torque))

    gust = ("--scenario", "gust", "--duration", "14.5")
    after = answer(capsys, "--law-from", path, *gust)["rows"][2]

    assert after["wind"] == "gust at 15.1 m/s"  # 4.5 m/s above the de-rated wind
    assert after["mean_power"] == pytest.approx(4e3, rel=0.03)
    assert after["both_active"] == 0.0
    assert main([*QUICK, "--law-from", path, "--law", "baseline"]) == 2
    assert "no de-rated form" in capsys.readouterr().err


def test_the_sampling_is_as_asked(capsys: Capture) -> None:
    """Another record, and the answer says how it was sampled."""
    usual = answer(capsys, "--law", "baseline")
    rare = answer(capsys, "--law", "baseline", "--sample-time", "0.1", "--computation-time", "0.05")

    assert (usual["sample_time"], usual["computation_time"]) == (0.02, 0.0)
    assert (rare["sample_time"], rare["computation_time"]) == (0.1, 0.05)
    assert usual["rows"] != rare["rows"]
    command = [word for word in QUICK if word != "--json"]
    assert main([*command, "--law", "baseline", "--sample-time", "0.01"]) == 0
    assert "laws every 10 ms" in capsys.readouterr().out.splitlines()[0]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sample-time", "0"], "sample time 0 s was given; 0.001 to 1 s"),
        (["--sample-time", "nan"], "option --sample-time: 'nan' was given"),
        (["--computation-time", "0.03"], "0 up to the sample time"),
        (["--computation-time", "0.0037177"], "a simple fraction of the sample time"),
        (["--law-from", "nowhere.json"], "nowhere.json: cannot be read"),
    ],
)
def test_misuse_is_told_before_any_work(options: list[str], words: str, capsys: Capture) -> None:
    """Status 2, and one message."""
    law = [] if "--law-from" in options else ["--law", "baseline"]
    assert main([*QUICK, *law, *options]) == 2

    assert words in capsys.readouterr().err


def test_another_law_cannot_stand_beside_a_file(tmp_path: Path, capsys: Capture) -> None:
    """It would be designed anew, for the defaults."""
    path = str(gain_file(tmp_path))

    assert main([*QUICK, "--law-from", path, "--law", "paper"]) == 2
    assert "simulate that in its own run" in capsys.readouterr().err
