"""`takagi simulate` with a certificate or a gain file: tables, files, status, what is refused."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
from tests.certificates.conftest import SHORT_FROM, cells_from
from tests.certificates.kinds.claims import resealed
from tests.cli.conftest import contents

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def certificate(finished: TurbineDesign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("campaign") / "certificate.json"
    alone = {**finished.document, "claims": finished.document["claims"][:1]}
    short = resealed(cells_from(alone, SHORT_FROM))
    path.write_text(json.dumps(short), encoding="utf-8")
    return path


def asked(certificate: Path, *more: str) -> list[str]:
    return ["simulate", "nrel5mw", "--certificate", str(certificate), "--runs", "60",
            "--duration", "0.25", "--workers", "1", *more]  # fmt: skip


def test_no_violation_is_status_0_and_leaves_all_files(
    certificate: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The table, the same bytes for the same seed; nothing on standard error."""
    folders = [tmp_path / name for name in ("first", "second")]
    for folder in folders:
        assert main(asked(certificate, "--seed", "3", "--out", str(folder))) == 0
        for path in (folder / "results").iterdir():
            assert json.loads(path.read_text())["task"]["inputs"]["seed"] == 3
    shown, files = capsys.readouterr(), contents(folders[0])

    assert shown.err == ""
    assert "no violation of any certified bound" in shown.out
    table = [line for line in shown.out.splitlines() if line.startswith("| ")][:12]
    assert len({len(line) for line in table}) == 1 and len(table[0]) <= 100
    assert files == contents(folders[1])
    names = sorted(name for name in files if not name.startswith("results"))
    assert names == ["campaign.json", "figures/inside.svg", "summary.md"]
    made = json.loads(files["campaign.json"])
    assert (made["verdict"], made["violations"]) == ("PROVED", 0)
    assert all(row["largest share"] is None or row["largest share"] <= 1.0001
               for row in made["inside"])  # fmt: skip


@pytest.mark.slow
def test_beyond_says_what_breaks_first(certificate: Path, tmp_path: Path, capsys: Capture) -> None:
    """Status 0, for nothing is promised there; figures of what broke; JSON names the files."""
    more = ("--beyond", "8", "--beyond", "start=4", "--out", str(tmp_path), "--json")
    status = main(asked(certificate, *more))
    found = json.loads(capsys.readouterr().out)

    assert status == 0
    assert "inside" not in found
    assert [row["beyond"] for row in found["beyond"]] == ["wind=8", "start=4"]
    assert found["beyond"][1]["V up to"] > 3
    assert all(Path(name).is_file() for name in found["files"])
    assert any("first-breaks.svg" in name for name in found["files"])
    assert main(asked(certificate, "--beyond", "start=4")) == 0
    assert "speed error" in capsys.readouterr().out


@pytest.mark.slow
def test_a_violated_bound_is_status_1(certificate: Path, tmp_path: Path, capsys: Capture) -> None:
    """A forger's certificate: a peak made a tenth smaller, hashes made to fit."""
    document = json.loads(certificate.read_text())
    document["claims"][0]["peaks"]["speed_error"] *= 0.9
    forged = tmp_path / "forged.json"
    forged.write_text(json.dumps(resealed(document)), encoding="utf-8")

    assert main(asked(forged)) == 1
    shown = capsys.readouterr().out
    assert "violate a certified bound" in shown
    assert "UNDECIDED" in shown


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--law", "paper"], "--law is about a scenario"),
        (["--wake", "equilibrium"], "--wake is about a scenario"),
        (["--beyond", "torque=2"], "'torque' is not one of"),
        (["--beyond", "start=1"], "starts up to V = 1 are within the certificate"),
        (["--runs", "0"], "0 runs were asked for"),
        (["--duration", "-1"], "a duration of -1 s"),
    ],
)
def test_what_makes_no_sense_is_refused(
    certificate: Path, more: list[str], words: str, capsys: Capture
) -> None:
    assert main(asked(certificate, *more)) == 2
    assert words in " ".join(capsys.readouterr().err.split())


def test_what_is_not_of_this_turbine_is_refused(certificate: Path, capsys: Capture) -> None:
    """Runs without a certificate would be ignored, which misleads; a plant has no campaign."""
    for model_and_options, words in (
        (["nrel5mw", "--runs", "5"], "--certificate FILE"),
        (["iea15mw", "--certificate", str(certificate)], ""),
        (["nrel5mw", "--certificate", "nowhere.json"], "nowhere.json"),
        (["cart_pole", "--certificate", str(certificate)], "turbine"),
    ):
        assert main(["simulate", *model_and_options]) == 2
        assert words in capsys.readouterr().err


QUICK = ("simulate", "nrel5mw", "--wind", "step", "--duration", "4", "--json")


@cache
def content(rated: float) -> dict[str, Any]:
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

    gust = ("--wind", "gust", "--duration", "14.5")
    after = answer(capsys, "--law-from", path, *gust)["rows"][-1]

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


def test_another_law_cannot_stand_beside_a_file(tmp_path: Path, capsys: Capture) -> None:
    """It would be designed anew, for the defaults."""
    path = str(gain_file(tmp_path))

    assert main([*QUICK, "--law-from", path, "--law", "paper"]) == 2
    assert "simulate that in its own run" in capsys.readouterr().err
