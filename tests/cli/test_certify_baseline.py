"""`takagi certify --baseline` and `takagi compare`: what got worse, and what was changed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from takagi.certificates.document.certificate_file import certificate_document, dumps
from takagi.cli.main import main
from tests.cli.cubic import CUBIC

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

Capture = pytest.CaptureFixture[str]


def gain_file(path: Path, gain: float) -> Path:
    """Write u = -gain x for both rules of the cubic plant."""
    premise = {"name": "z1", "expression": "x^2", "lower": 0, "upper": 1, "unit": "-"}
    law = {
        "name": "pdc",
        "sample_time": None,
        "state_names": ["x [-]"],
        "input_names": ["u [-]"],
        "premises": [premise],
        "rules": [[0], [1]],
        "K": [[[gain]], [[gain]]],
        "trim": {"state": [0.0], "input": [0.0]},
    }
    path.write_text(json.dumps({"law": law}))
    return path


def certified(cubic: Path, gain: float, out: str, *options: str) -> int:
    """Certify the plant with one gain, beside the plant's file."""
    gains = gain_file(cubic.with_name("gains.json"), gain)
    place = str(cubic.with_name(out))
    return main(["certify", str(cubic), "--gains", str(gains), "--out", place, *options])


def test_gains_from_both_sides_of_the_tolerance(cubic: Path, capsys: Capture) -> None:
    """Decay K - 2: from 4 to 3.9 it falls by 5 % of 2, to 3.8 by 10 %; and by 10 % it may."""
    old = str(cubic.with_name("old.json"))
    assert certified(cubic, 4, "old.json") == 0
    capsys.readouterr()

    assert certified(cubic, 3.95, "a.json", "--baseline", old) == 0
    assert "nothing got worse by more than 5 %" in capsys.readouterr().out
    assert certified(cubic, 3.8, "b.json", "--baseline", old) == 1
    told = capsys.readouterr().out
    words = " ".join(told.split())
    assert "WORSE slower common quadratic decay of cubic decay rate [1/s] fell from " in words
    assert "gains: K of rule 1, u [-] by x [-]: 4.0 -> 3.8" in told
    assert certified(cubic, 3.8, "c.json", "--baseline", old, "--tolerance", "15%") == 0


def test_json_has_every_figure(cubic: Path, capsys: Capture) -> None:
    old = str(cubic.with_name("old.json"))
    certified(cubic, 4, "old.json")
    capsys.readouterr()

    assert certified(cubic, 3, "new.json", "--baseline", old, "--json") == 1

    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "PROVED"
    assert (found["baseline"]["certificate"], found["baseline"]["passes"]) == (old, False)
    worse = [f["figure"] for f in found["baseline"]["figures"] if f["worse"]]
    assert "decay rate" in worse and "limit of input 1" not in worse
    assert found["baseline"]["changed"][0]["place"] == "K of rule 1, u [-] by x [-]"


def test_a_changed_parameter_is_named(cubic: Path, capsys: Capture) -> None:
    old = str(cubic.with_name("old.json"))
    certified(cubic, 4, "old.json")
    cubic.write_text(CUBIC.replace("x + x^3", "1.5*x + x^3").replace("[-1, 1]", "[-0.8, 0.8]"))
    capsys.readouterr()

    gains = cubic.with_name("gains.json")
    law = json.loads(gains.read_text())["law"]
    law["premises"][0]["upper"] = 0.64
    gains.write_text(json.dumps({"law": law}))
    out = str(cubic.with_name("new.json"))
    options = ["--gains", str(gains), "--out", out, "--baseline", old]

    assert main(["certify", str(cubic), *options]) == 1

    told = capsys.readouterr().out
    assert "WORSE narrower box box of validity" in " ".join(told.split())
    assert "model: equation of x: u + x^3 + x -> u + x^3 + 3*x/2" in told


@pytest.mark.parametrize("tolerance", ["x", "5 %%", "-1%", "1/3", "1e9", "101%", "nan", ""])
def test_a_tolerance_that_is_no_share_is_misuse(
    cubic: Path, capsys: Capture, tolerance: str
) -> None:
    assert certified(cubic, 4, "new.json", f"--tolerance={tolerance}") == 2

    assert "--tolerance" in capsys.readouterr().err


def test_the_baseline_is_read_before_the_work_and_never_overwritten(
    cubic: Path, capsys: Capture
) -> None:
    old = cubic.with_name("old.json")
    assert certified(cubic, 4, "old.json") == 0
    before = old.read_bytes()

    assert certified(cubic, 4, "old.json", "--baseline", str(old)) == 2
    assert old.read_bytes() == before
    assert "--out is the --baseline" in capsys.readouterr().err

    old.write_text(old.read_text().replace('"decay_rate":1', '"decay_rate":2', 1))
    assert certified(cubic, 4, "new.json", "--baseline", str(old)) == 2
    assert "claims changed after" in capsys.readouterr().err
    assert not cubic.with_name("new.json").exists()


def test_compare_two_certificates(cubic: Path, tmp_path: Path, capsys: Capture) -> None:
    """Status by what got worse; the same table as Markdown."""
    old, new = (str(cubic.with_name(name)) for name in ("old.json", "new.json"))
    certified(cubic, 4, "old.json")
    certified(cubic, 3, "new.json")
    capsys.readouterr()
    summary = tmp_path / "summary.md"

    assert main(["compare", new, new]) == 0
    assert main(["compare", old, new, "--summary", str(summary)]) == 1
    assert main(["compare", old, new, "--tolerance", "100%"]) == 0
    page = tmp_path / "page.html"
    assert main(["compare", old, new, old, "--html", str(page), "--summary", str(summary)]) == 1
    assert page.read_text().count("badge PROVED") == 3
    assert page.read_text().count("<strong>worse") == page.read_text().count("<strong>not") == 1

    assert (
        "| WORSE | slower | common quadratic decay of cubic | decay rate [1/s] |"
        in summary.read_text()
    )


@pytest.mark.slow
def test_a_turbine_is_compared_wind_by_wind(
    finished: TurbineDesign, tmp_path: Path, capsys: Capture
) -> None:
    """Its own certificate is no worse; one cell's class cut by a tenth is, at that wind."""
    document = json.loads(dumps(finished.document))
    old, new = tmp_path / "old.json", tmp_path / "new.json"
    old.write_text(json.dumps(document))
    assert main(["compare", str(old), str(old), "--tolerance", "0"]) == 0

    cell = document["claims"][0]["cells"][30]
    cell["wind_error"] = round(0.9 * cell["wind_error"], 6)
    new.write_text(json.dumps(sealed(document)))

    assert main(["compare", str(old), str(new)]) == 1
    low, high = cell["wind"]
    assert f"wind error [m/s], {low:g} to {high:g} m/s" in capsys.readouterr().out


def sealed(document: dict[str, Any]) -> dict[str, Any]:
    """Return the certificate with the hashes of what it now says."""
    parts = {key: document[key] for key in ("model", "gains", "claims")}
    return certificate_document(**parts, provenance=document["provenance"])
