"""`certify --gains`: a certificate for a gain file that is there, bound to it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, read_text
from takagi.certificates.checker.files.gain_file import expected_file
from takagi.certificates.checker.kernel import reader
from takagi.cli.main import main

Capture = pytest.CaptureFixture[str]
Change = Callable[[dict[str, Any]], object]


def certified(tank: Path, gains: Path, out: Path, *more: str) -> int:
    return main(
        ["certify", str(tank / "tank.toml"), "--gains", str(gains), "--out", str(out), *more]
    )


def test_a_certificate_for_a_given_file_is_bound_to_it(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """The pair is PROVED; what the file says of an older certificate does no harm."""
    out = tmp_path / "c.json"

    assert certified(tank, tank / "gains.json", out) == 0
    assert "will refuse" not in capsys.readouterr().out
    assert main(["check", str(out), "--gains", str(tank / "gains.json")]) == 0


@pytest.mark.parametrize(
    "option",
    ["--decay-rate=0.5", "--damping=0.5", "--input-limit=q=1", "--gain-bound=4", "--initial=h=1"],
)
def test_options_about_making_gains_are_refused_beside_them(
    option: str, tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """As docs/cli.md says; those that say which model it is are taken."""
    out = tmp_path / "c.json"

    assert certified(tank, tank / "gains.json", out, option) == 2
    assert "is about designing gains, but --gains gives them" in capsys.readouterr().err
    assert certified(tank, tank / "gains.json", out, "--choice=fewest-rules", "--solve-rest") == 0


def test_fields_that_are_not_the_plant_s_are_told_and_written_anew(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """A range of an input that is another: told, refused by check, right in --gains-out."""
    content = json.loads((tank / "gains.json").read_text("utf-8"))
    content["inputs"][0]["range"] = [0, 50]
    content["formulas"]["command"] = "u = u* + ..."
    gains, out, new = tmp_path / "wide.json", tmp_path / "c.json", tmp_path / "new.json"
    gains.write_text(json.dumps(content), "utf-8")

    assert certified(tank, gains, out) == 0
    said = capsys.readouterr().out
    assert "inputs[0].range[1] is 50 there, 5.0 for this model" in said
    assert "--gains-out FILE" in said
    assert main(["check", str(out), "--gains", str(gains)]) == 1

    assert certified(tank, gains, out, "--gains-out", str(new)) == 0
    assert main(["check", str(out), "--gains", str(new)]) == 0
    made = json.loads(new.read_text("utf-8"))
    assert made["inputs"][0]["range"] == [0, 5] and made["law"] == content["law"]


def earlier(content: dict[str, Any]) -> dict[str, Any]:
    """Return the file as version 1 had it."""
    kept = ("format", "name", "plant", "units", "law", "states", "inputs", "formulas", "notes")
    return {"version": 1, **{key: content[key] for key in kept}}


def test_a_file_of_an_earlier_version_is_certified_and_bound(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Old files are read; a change afterwards is noticed; the check says what it rests on."""
    content = earlier(json.loads((tank / "gains.json").read_text("utf-8")))
    gains, out = tmp_path / "old.json", tmp_path / "c.json"
    gains.write_text(json.dumps(content), "utf-8")

    assert certified(tank, gains, out) == 0
    asked = ["check", str(out), "--gains", str(gains)]
    assert "will refuse it beside this certificate: of an earlier" in capsys.readouterr().out
    assert main(asked) == 1
    assert "or accept this with --allow-old-gain-files" in capsys.readouterr().err
    assert main([*asked, "--allow-old-gain-files"]) == 0
    assert "certificate's copy of it, not with model and law" in capsys.readouterr().out
    content["notes"].append("changed")
    gains.write_text(json.dumps(content), "utf-8")
    assert main([*asked, "--allow-old-gain-files"]) == 1
    assert "notes is " in capsys.readouterr().err


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_program_cannot_hide_behind_an_earlier_version(
    version: int, tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Contents with ``version`` are compared with themselves alone: that proves no program."""
    document = json.loads((tank / "c.json").read_text(encoding="utf-8"))
    content = json.loads((tank / "gains.json").read_text("utf-8"))
    content["programs"][0]["steps"] = []
    own = {key: value for key, value in content.items() if key not in ("format", "law")}
    document["controller"] = {**own, "version": version}
    gains, out = tmp_path / "forged.json", tmp_path / "c.json"
    gains.write_text(json.dumps({**content, "version": version}), "utf-8")
    read = read_text(json.dumps(document), "forged")
    document["provenance"]["sha256"]["controller"] = reader.digest(read["controller"])
    out.write_text(json.dumps(document), "utf-8")

    assert main(["check", str(out), "--gains", str(gains)]) == 2
    assert "an earlier gain file, 1 or 2, which has no programs" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f["states"][0].update(rest=1.1), "states[0].rest is 1.1 there"),
        (lambda f: f["formulas"].update(command="u = u* + ..."), "formulas.command is"),
    ],
)
def test_an_earlier_file_that_says_something_else_is_not_certified(
    change: Change, words: str, tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    content = earlier(json.loads((tank / "gains.json").read_text("utf-8")))
    change(content)
    gains, out = tmp_path / "old.json", tmp_path / "c.json"
    gains.write_text(json.dumps(content), "utf-8")

    assert certified(tank, gains, out) == 2
    assert words in capsys.readouterr().err and not out.exists()


def test_gains_out_needs_gains_and_a_place_of_its_own(
    tank: Path, tmp_path: Path, capsys: Capture
) -> None:
    out = str(tmp_path / "c.json")

    assert main(["certify", str(tank / "tank.toml"), "--out", out, "--gains-out", "g.json"]) == 2
    assert "--gains-out writes the file of --gains anew" in capsys.readouterr().err
    assert certified(tank, tank / "gains.json", tmp_path / "c.json", "--gains-out", out) == 2
    assert "the same file" in capsys.readouterr().err


def test_a_law_of_another_kind_of_model_has_no_file(tank: Path) -> None:
    """The program follows from the law's name: a plant's claims would stand beside another's."""
    document = json.loads((tank / "c.json").read_text(encoding="utf-8"))
    document["gains"]["name"] = "coherent"
    with pytest.raises(CertificateError, match="'coherent' is no law of this kind of model"):
        expected_file(read_text(json.dumps(document), "certificate"))
