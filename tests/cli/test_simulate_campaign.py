"""`takagi simulate --certificate`: tables, files, exit status, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.cli.main import main
from tests.cli.conftest import contents

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def certificate(finished: TurbineDesign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The default design's certificate as a file."""
    from takagi.certificates.document.certificate_file import dumps

    path = tmp_path_factory.mktemp("campaign") / "certificate.json"
    path.write_text(dumps(finished.document), encoding="utf-8")
    return path


def asked(certificate: Path, *more: str) -> list[str]:
    """A short campaign."""
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
    read = read_text(json.dumps(document), "document")
    hashes = {part: digest(read.get(part)) for part in ("model", "gains", "claims")}
    document["provenance"]["sha256"] = hashes
    forged = tmp_path / "forged.json"
    forged.write_text(json.dumps(document), encoding="utf-8")

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
    """Status 2 and one line."""
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
