"""`takagi certify`: a certificate for gains that exist, or for new ones."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from takagi.certificates.checker import Verdict, check
from takagi.certificates.design.given.turbine_law import effort_sharing_law_from_data, read_law
from takagi.certificates.document.certificate_file import dumps, effort_sharing_law_data
from takagi.cli.main import main
from takagi.reports.gains_file.envelope import dump_gains, gain_file
from tests.turbine_designs import recorded_cells_for_sought, recorded_rows, running_loop

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def gains(finished: TurbineDesign, tmp_path: Path) -> Path:
    """A gain file with the finished design's law."""
    path = tmp_path / "gains.json"
    path.write_text(json.dumps({"law": finished.document["gains"]}))
    return path


def changed(gains: Path, **entries: Any) -> Path:
    """The gain file with entries of its law replaced."""
    law = {**json.loads(gains.read_text())["law"], **entries}
    gains.write_text(json.dumps({"law": law}))
    return gains


def test_a_law_survives_its_file(finished: TurbineDesign, gains: Path) -> None:
    """What is read back writes the same numbers: the certificate is about what was emitted."""
    law = effort_sharing_law_from_data(read_law(gains))

    assert effort_sharing_law_data(law) == finished.document["gains"]


@pytest.mark.slow
def test_given_gains_are_proved_as_they_stand(
    gains: Path, finished: TurbineDesign, tmp_path: Path, capsys: Capture, reduced: bool
) -> None:
    """Design and certify find the same claim, and the checker accepts it for this gain file."""
    if reduced:
        pytest.skip("reduced: the whole gain file is proved again below")
    out = tmp_path / "certificate.json"

    assert main(["certify", "nrel5mw", "--gains", str(gains), "--out", str(out)]) == 0

    assert check(out, gains=gains).verdict is Verdict.PROVED
    # A file with the law alone says nothing of the observer, so that its loop is not claimed.
    known = [c for c in finished.document["claims"] if c["kind"] != "running-loop"]
    assert len(known) == len(finished.document["claims"]) - 1
    assert json.loads(out.read_text())["claims"] == known
    assert f"takagi check {out} --gains {gains}" in capsys.readouterr().out


@pytest.mark.slow
def test_a_whole_gain_file_has_the_loop_with_its_observer_proved_again(
    finished: TurbineDesign, tmp_path: Path
) -> None:
    """It states observer and filters: all claims are those of the design, to the last digit.

    The cells of the running loop are stated as recorded, if those of the design are: they are
    proved for the observer and the filters that were read.
    """
    gains, out = tmp_path / "gains.json", tmp_path / "certificate.json"
    gains.write_text(dump_gains(gain_file(finished)), encoding="utf-8")
    claim = running_loop(finished)
    recorded = claim is not None and claim["cells"] == recorded_rows()

    with recorded_cells_for_sought() if recorded else nullcontext():
        assert main(["certify", "nrel5mw", "--gains", str(gains), "--out", str(out)]) == 0

    assert claim is not None
    assert check(out, gains=gains).verdict is Verdict.PROVED
    assert json.loads(out.read_text())["claims"] == finished.document["claims"]


def test_the_inequalities_hold_without_takagi(finished: TurbineDesign, tmp_path: Path) -> None:
    """The program of docs/certificate.md accepts the certificate, and refuses a larger class."""
    page = (Path(__file__).parents[2] / "docs" / "certificate.md").read_text(encoding="utf-8")
    program = page.split("```python\n")[1].split("```")[0]
    assert "import takagi" not in program and "from takagi" not in program
    path = tmp_path / "build" / "nrel5mw" / "certificate.json"
    path.parent.mkdir(parents=True)
    document = json.loads(dumps(finished.document))

    def status() -> int:
        path.write_text(json.dumps(document))
        command = [sys.executable, "-I", "-S", "-c", program]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode

    assert status() == 0
    document["claims"][0]["cells"][30]["wind_error"] *= 1.2
    assert status() == 1


def test_without_gains_they_are_designed_anew(asked: Any, tmp_path: Path, capsys: Capture) -> None:
    """One file, and the same verdict in JSON."""
    out = tmp_path / "certificate.json"

    assert main(["certify", "nrel5mw", "--out", str(out), "--json"]) == 0

    assert json.loads(capsys.readouterr().out)["verdict"] == "PROVED"
    assert [path.name for path in tmp_path.iterdir()] == ["certificate.json"]


@pytest.mark.slow
def test_a_loop_without_a_proof_names_the_winds(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Inertia 0.2 to 3 of nominal: which condition, where, and what to relax; status 1."""
    out = tmp_path / "certificate.json"
    options = ["--gains", str(gains), "--out", str(out), "--inertia", "0.2", "3"]

    assert main(["certify", "nrel5mw", *options]) == 1

    told = capsys.readouterr().err
    assert "no common quadratic function" in told and "at wind 11." in told
    assert "--inertia 0.2 3; relax that first" in told
    assert not out.exists()


def test_designing_options_do_not_go_with_given_gains(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Silently ignored, they would mislead."""
    options = ["--gains", str(gains), "--out", str(tmp_path / "c.json"), "--bandwidth", "0.4"]

    assert main(["certify", "nrel5mw", *options]) == 2
    assert "--bandwidth is about designing gains" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("entries", "told"),
    [
        ({"name": "paper"}, "a gain file is certified for the effort-sharing law ('coherent')"),
        ({"proportional": [0.1]}, "proportional: a row of 71 numbers is needed"),
        ({"overlap": "wide"}, "overlap: a number is needed"),
        ({"overlap": -0.01}, "must be positive"),
        ({"integral_rate": [-0.1] * 70}, "must be a row of positive numbers"),
    ],
)
def test_a_damaged_gain_file_is_misuse(
    gains: Path, tmp_path: Path, capsys: Capture, entries: dict[str, Any], told: str
) -> None:
    """The message names the entry; nothing is written."""
    out = tmp_path / "certificate.json"
    asked_for = ["--gains", str(changed(gains, **entries)), "--out", str(out)]

    assert main(["certify", "nrel5mw", *asked_for]) == 2
    assert told in capsys.readouterr().err and not out.exists()


def test_a_gain_file_that_is_none_is_misuse(tmp_path: Path, capsys: Capture) -> None:
    """Not JSON, and not there."""
    wrong = tmp_path / "gains.json"
    wrong.write_text("gamma = 1")
    out = str(tmp_path / "c.json")

    assert main(["certify", "nrel5mw", "--gains", str(wrong), "--out", out]) == 2
    assert "not JSON" in capsys.readouterr().err
    assert main(["certify", "nrel5mw", "--gains", str(tmp_path / "no"), "--out", out]) == 2
    assert "cannot be read" in capsys.readouterr().err


def test_a_gain_file_is_read_before_the_plant_s_model_is_made(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        pytest.fail("the work has begun")

    monkeypatch.setattr("takagi.cli.runs.plant.PlantMaker.certify", never)
    asked_for = ["--gains", str(tmp_path / "no"), "--out", str(tmp_path / "c.json")]

    assert main(["certify", "dc_servo", *asked_for]) == 2
    assert "cannot be read" in capsys.readouterr().err


def test_a_folder_in_the_place_of_the_certificate_is_misuse(
    tmp_path: Path, capsys: Capture
) -> None:
    """Told before the long work."""
    assert main(["certify", "nrel5mw", "--out", str(tmp_path)]) == 2
    assert "this is a folder" in capsys.readouterr().err
