"""Gain files whose programs are damaged, or newer than this takagi: named, with what to do."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from takagi.models import ModelError
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller

Document = dict[str, Any]


def document() -> Document:
    return dict(baseline_program(load_turbine("nrel5mw")).document)


def program_of(content: Document, folder: Path) -> ControllerProgram:
    path = folder / "gains.json"
    path.write_text(json.dumps(content, default=float))
    return read_controller(path)


DAMAGES: dict[str, tuple[Callable[[Document], object], str]] = {
    "no law": (lambda d: d.pop("law"), "'law' is missing"),
    "a program without a name": (lambda d: d.update(programs=[{}]), "'name' is missing"),
    "programs that are a text": (lambda d: d.update(programs="x"), "a part cannot be read"),
    "a program that is a number": (lambda d: d.update(programs=[3]), "cannot be read"),
}


@pytest.mark.parametrize("what", DAMAGES)
def test_a_part_that_is_damaged_is_named(what: str, tmp_path: Path) -> None:
    change, words = DAMAGES[what]
    changed = document()
    change(changed)

    with pytest.raises(ModelError, match=r"gains\.json: the gain file is damaged: ") as refused:
        program_of(changed, tmp_path)

    assert words in str(refused.value)
    assert "give the gains.json that `takagi design` has written" in str(refused.value)
    assert "Error(" not in str(refused.value)


@pytest.mark.parametrize("version", [4, 77])
def test_a_newer_version_is_refused(version: Any, tmp_path: Path) -> None:
    assert program_of(document() | {"version": 3}, tmp_path).name
    with pytest.raises(ModelError, match=rf"version {version}; this takagi reads versions up to 3"):
        program_of(document() | {"version": version}, tmp_path)


def test_the_place_of_theorems_is_looked_at_before_they_are_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    certificate = tmp_path / "certificate.json"
    certificate.write_text("{}")

    def never(document: Document) -> None:
        pytest.fail("the work has begun")

    monkeypatch.setattr("takagi.certificates.coq.coq_export.coq_file", never)
    assert main(["export", str(certificate), "--coq", str(tmp_path)]) == 2
    assert "this is a folder, and a file was expected" in capsys.readouterr().err
