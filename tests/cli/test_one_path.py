"""One path for turbine and plant: a model's file is read once, and one table knows the kinds."""

from __future__ import annotations

import subprocess
import sys
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


def test_help_and_check_load_nothing_of_designs() -> None:
    """The makers belong to the verbs that design; the front door and the checker do without."""
    said = "print(*(name for name in sys.modules if name.startswith('takagi.')))"
    for arguments in (["--help"], ["check", "--help"]):
        program = f"import sys; from takagi.cli.main import main; main({arguments}); {said}"
        ran = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True
        )
        loaded = ran.stdout.splitlines()[-1].split()
        rooms = ("takagi.cli.runs", "takagi.cli.options", "takagi.certificates", "takagi.models")
        assert "takagi.cli.main" in loaded
        assert [name for name in loaded if name.startswith(rooms)] == []


@pytest.mark.parametrize("verb", ["design", "simulate", "certify", "report", "export", "compare"])
def test_help_of_a_verb_loads_no_numbers(verb: str) -> None:
    """Help is read before anything is computed: numpy alone would take longer than all of it."""
    heavy = ("numpy", "scipy", "sympy", "clarabel", "matplotlib")
    said = f"print(*(name for name in {heavy} if name in sys.modules), sep='|', end='|')"
    program = f"import sys; from takagi.cli.main import main; main([{verb!r}, '--help']); {said}"
    ran = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert "Usage" in ran.stdout or "usage" in ran.stdout
    assert ran.stdout.splitlines()[-1] == "|"
