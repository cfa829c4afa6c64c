"""One path for turbine and plant: a model's file is read once, and one table knows the kinds."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.cli.main import main
from takagi.models.files import library
from takagi.models.files.library import data_folder


def test_numbers_of_a_turbine_file_are_the_floats_nearest_to_them() -> None:
    """Read as decimals for both kinds, they are what a reader of floats gets, also far out."""
    path = data_folder() / "nrel5mw.toml"
    exact = library.read_document(path, parse_float=library.decimal_of)

    assert exact.in_floats() == library.read_document(path)
    for text in ("1e400", "-1e99999999999999999999", "1_000.5", "-0.0", "inf"):
        assert repr(float(library.decimal_of(text))) == repr(float(text))


def test_a_number_beyond_decimals_is_misuse(
    cubic: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An exponent that no decimal has is no fault of takagi: the field is named."""
    text = cubic.read_text(encoding="utf-8")
    cubic.write_text(text.replace("range = [-1, 1]", "range = [-1, 1e99999999999999999999]", 1))

    assert main(["design", str(cubic), "--out", str(tmp_path / "out")]) == 2
    assert f"{cubic}:" in capsys.readouterr().err
