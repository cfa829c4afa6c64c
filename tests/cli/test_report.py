"""`takagi report`: the report and its figures alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main


def test_report_and_figures_are_written_and_nothing_else(
    asked: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No gain file and no certificate: those are a design's."""
    assert main(["report", "nrel5mw", "--out", str(tmp_path)]) == 0

    names = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*"))
    assert names == ["figures", "figures/bode.svg", "report.html"]
    assert capsys.readouterr().out == f"{tmp_path / 'report.html'}: PROVED\n"


def test_a_report_is_about_the_design_that_was_asked_for(asked: Any, tmp_path: Path) -> None:
    """The options are those of `takagi design`."""
    main(["report", "nrel5mw", "--out", str(tmp_path), "--overlap", "0.03"])

    assert asked["settings"].overlap == 0.03
