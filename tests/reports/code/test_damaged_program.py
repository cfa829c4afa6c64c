"""Gain files whose programs are damaged, or newer than this takagi: named, with what to do."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from takagi.models import ModelError
from takagi.models.turbine import load_turbine
from takagi.reports.code import baseline_program
from takagi.reports.code.controller_program import controller_program

Document = dict[str, Any]


def document() -> Document:
    return dict(baseline_program(load_turbine("nrel5mw")).document)


DAMAGES: dict[str, tuple[Callable[[Document], object], str]] = {
    "no law": (lambda d: d.pop("law"), "'law' is missing"),
    "a program without a name": (lambda d: d.update(programs=[{}]), "'name' is missing"),
    "programs that are a text": (lambda d: d.update(programs="x"), "a part cannot be read"),
    "a program that is a number": (lambda d: d.update(programs=[Decimal(3)]), "cannot be read"),
}


@pytest.mark.parametrize("what", DAMAGES)
def test_a_part_that_is_damaged_is_named(what: str) -> None:
    change, words = DAMAGES[what]
    changed = document()
    change(changed)

    with pytest.raises(ModelError, match="the gain file is damaged: ") as refused:
        controller_program(changed)

    assert words in str(refused.value)
    assert "give the gains.json that `takagi design` has written" in str(refused.value)
    assert "Error(" not in str(refused.value)


@pytest.mark.parametrize("version", [4, Decimal(77)])
def test_a_newer_version_is_refused(version: Any) -> None:
    assert controller_program(document() | {"version": Decimal(3)}).name
    with pytest.raises(ModelError, match=rf"version {version}; this takagi reads versions up to 3"):
        controller_program(document() | {"version": version})


def test_the_place_of_theorems_is_looked_at_before_they_are_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    certificate = tmp_path / "certificate.json"
    certificate.write_text("{}")

    def never(document: Document) -> None:
        pytest.fail("the work has begun")

    monkeypatch.setattr("takagi.certificates.coq.coq_file", never)
    assert main(["export", str(certificate), "--coq", str(tmp_path)]) == 2
    assert "this is a folder, and a file was expected" in capsys.readouterr().err
