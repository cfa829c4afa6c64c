"""`takagi certify` and `takagi simulate` for plants, with gains of a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import Verdict, check
from takagi.cli.main import main
from tests.cli.cubic import CUBIC
from tests.plant_files import designed_in

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def designed(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("designed")
    designed_in(folder, CUBIC, "cubic.toml")
    return (folder / "gains.json").read_text(encoding="utf-8")


@pytest.fixture
def gains(designed: str, cubic: Path, tmp_path: Path) -> Path:
    path = tmp_path / "gains.json"
    path.write_text(designed, encoding="utf-8")
    return path


def changed(gains: Path, **law: Any) -> Path:
    content = json.loads(gains.read_text(encoding="utf-8"))
    content["law"] |= law
    path = gains.with_name("changed.json")
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def certified(cubic: Path, gains: Path, out: Path) -> int:
    return main(["certify", str(cubic), "--gains", str(gains), "--out", str(out)])


PREMISE = {"name": "z1", "expression": "x^2", "lower": 0, "upper": 1, "unit": "-"}


def test_gains_from_both_sides_of_the_threshold(cubic: Path, gains: Path, tmp_path: Path) -> None:
    """x' = (1 + x^2 - k) x decays on |x| <= 1 exactly for k > 2: 2.01 is PROVED, 1.99 is not."""
    out = tmp_path / "c.json"

    assert certified(cubic, changed(gains, K=[[[2.01]], [[2.02]]], premises=[PREMISE]), out) == 0
    assert json.loads(out.read_text(encoding="utf-8"))["gains"]["K"] == [[[2.01]], [[2.02]]]
    assert check(out, gains=gains.with_name("changed.json"), model=cubic).verdict is Verdict.PROVED
    assert certified(cubic, changed(gains, K=[[[1.99]]]), out) == 1
    assert check(out).verdict is not Verdict.PROVED


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({"name": "coherent"}, "law.name is 'coherent'; the model is a plant"),
        ({"K": [[[1.0, 2.0]]]}, "law.K has shape (1, 1, 2); 2 rules, 1 inputs and 1 states"),
        ({"K": [[[3.0]]] * 3}, "law.K has shape (3, 1, 1)"),
        ({"state_names": ["y [-]"]}, "law.state_names is not the model's"),
        ({"sample_time": 0.1}, "law.sample_time is not the model's"),
        ({"rules": [[1], [0]]}, "law.rules is not the model's"),
        ({"trim": {"state": [0.5], "input": [0.0]}}, "law.trim is not the model's"),
        ({"premises": []}, "law.premises is not the model's"),
        ({"premises": [PREMISE | {"upper": 1.000001}]}, "law.premises is not the model's"),
        ({"more": 1}, "law.more is not the model's"),
        ({"K": "many"}, "law"),
    ],
)
def test_a_law_of_another_model_is_refused(
    cubic: Path, gains: Path, tmp_path: Path, capsys: Capture, law: Any, message: str
) -> None:
    out = tmp_path / "c.json"

    assert certified(cubic, changed(gains, **law), out) == 2

    said = capsys.readouterr().err
    assert said.startswith("Error: ") and message in said and "Traceback" not in said
    assert not out.exists()


@pytest.mark.parametrize("verb", ["design", "certify"])
def test_a_proof_about_vertices_alone_is_no_proof_about_the_plant(
    verb: str, cubic: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the equations cannot be written into the certificate: status 1, and it is said."""
    from takagi.certificates.claims import certification as plant_certificate
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.plant import page

    nothing: tuple[None, list[object], tuple[str]] = (
        None,
        [],
        ("claims about the vertices alone: no words for a function",),
    )
    monkeypatch.setattr(plant_certificate, "plant_and_claim", lambda _: nothing)
    monkeypatch.setattr(page, "plant_report_files", lambda *_, **__: ReportFiles("", {}))

    assert main([verb, str(cubic), "--out", str(tmp_path / "out")]) == 1
    assert "PROVED, of the vertices alone: not of the plant" in capsys.readouterr().out


def test_starts_are_corners_drawn_into_the_proved_set(
    cubic: Path, gains: Path, capsys: Capture
) -> None:
    """Of an interval both ends, and every motion stays inside and settles."""
    assert main(["simulate", str(cubic), "--gains", str(gains), "--json"]) == 0

    runs = json.loads(capsys.readouterr().out)["runs"]
    assert len(runs) == 2 and runs[0]["start"]["x"] == -runs[1]["start"]["x"] != 0
    for run in runs:
        assert not run["left_the_box"] and not run["diverged"]
        assert run["settled_after"] > 0
