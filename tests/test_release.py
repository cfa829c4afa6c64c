"""What a release promises: files of other versions, no network, and how it is cited."""

from __future__ import annotations

import json
import socket
import tomllib
from pathlib import Path

import pytest
import yaml

from takagi.cli.main import main
from takagi.models.files.library import data_folder
from tests.cli.cubic import CUBIC
from tests.docs_pages import ROOT
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def offline(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise AssertionError("takagi must not use the network")

    monkeypatch.setattr(socket.socket, "connect", refused)
    monkeypatch.setattr(socket.socket, "connect_ex", refused)
    monkeypatch.setattr(socket, "getaddrinfo", refused)


@pytest.fixture(scope="module")
def design(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("design")
    (folder / "cubic.toml").write_text(CUBIC, encoding="utf-8")
    with undrawn():
        assert main(["design", str(folder / "cubic.toml"), "--out", str(folder / "out")]) == 0
    return folder / "out"


def test_no_command_uses_the_network(offline: None, design: Path, tmp_path: Path) -> None:
    """From a new plant to exported code; ``.ci/try-wheel`` does the same with the wheel."""
    plant, out = str(tmp_path / "plant.toml"), str(tmp_path / "out")

    assert main(["new", plant]) == 0
    assert main(["design", plant, "--out", out, "--no-report"]) == 0
    assert main(["check", out]) == 0
    assert main(["compare", str(design), str(design), "--html", f"{out}/page.html"]) == 0
    assert main(["export", out, "--to", "c", "--out", f"{out}/c"]) == 0


def told(words: list[str], capsys: Capture) -> str:
    """Return the one line of a refusal, which says where and what; its status is 2."""
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    return line


@pytest.mark.parametrize("model", ["plant", "turbine"])
@pytest.mark.parametrize(("written", "words"), [("format = 2", "2 was given"), ("", "is missing")])
def test_a_model_file_of_another_format_is_refused(
    model: str, written: str, words: str, tmp_path: Path, capsys: Capture
) -> None:
    text = CUBIC if model == "plant" else (data_folder() / "nrel5mw.toml").read_text("utf-8")
    file = tmp_path / "model.toml"
    file.write_text(text.replace("format = 1", written, 1), encoding="utf-8")

    line = told(["design", str(file), "--out", str(tmp_path / "out")], capsys)

    assert "model.toml" in line and f"field 'format': {words}" in line
    assert "format = 1: write it so, or use a newer takagi" in line


def changed(design: Path, folder: Path, name: str, version: int) -> Path:
    content = json.loads((design / name).read_text(encoding="utf-8")) | {"version": version}
    (folder / name).write_text(json.dumps(content), encoding="utf-8")
    return folder / name


@pytest.mark.parametrize("version", [0, 2])
def test_a_certificate_of_another_version_is_refused(
    design: Path, tmp_path: Path, capsys: Capture, version: int
) -> None:
    file = str(changed(design, tmp_path, "certificate.json", version))

    for command in (["check", file], ["export", file, "--coq", str(tmp_path / "proof.v")]):
        line = told(command, capsys)
        assert line == (
            f"Error: {file}: a certificate of version {version}; this checker reads 1: "
            "use the takagi that wrote it, or make it again by certify"
        )


def test_a_gain_file_of_a_later_version_is_refused(
    design: Path, tmp_path: Path, capsys: Capture
) -> None:
    """By each verb that reads its law; ``check --gains`` says that it is not the certificate's."""
    file = str(changed(design, tmp_path, "gains.json", 4))
    model, out = str(design / "model" / "cubic.toml"), str(tmp_path / "out")

    for command in (
        ["certify", model, "--gains", file, "--out", out],
        ["export", file, "--to", "c", "--out", out],
        ["simulate", model, "--gains", file, "--out", out],
    ):
        line = told(command, capsys)
        assert f"{file}: a gain file of version 4; this takagi reads versions up to 3" in line
        assert "use the takagi that wrote it, or a newer one" in line
    assert main(["check", str(design / "certificate.json"), "--gains", file]) == 1
    assert "version is 4 there, 3 in the certificate" in capsys.readouterr().err


def test_the_citation_is_that_of_this_release() -> None:
    """The members that the Citation File Format 1.2.0 requires, and the version of the project."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))

    assert citation["cff-version"] == "1.2.0" and citation["message"] and citation["title"]
    assert all(author["name"] for author in citation["authors"])
    assert (citation["version"], citation["license"]) == (project["version"], project["license"])
