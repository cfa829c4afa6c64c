"""One path for turbine and plant: a model's file is read once, and one table knows the kinds."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import Verdict
from takagi.cli.main import main
from takagi.cli.runs.makers import MAKERS
from takagi.models.files import built_in_kinds, data_folder, toml_document
from tests.undrawn import undrawn

ROOT = Path(__file__).parents[2]
# The one choice of a maker, and the table of what makes each kind's pages.
KNOW_THE_KINDS = {"cli/runs/makers.py", "reports/design_folder.py", "cli/verbs/models.py"}


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each TOML file was read."""
    found: Counter[str] = Counter()
    read_text = toml_document.read_text

    def counted(path: Path) -> str:
        found[path.name] += 1
        return read_text(path)

    monkeypatch.setattr(toml_document, "read_text", counted)
    return found


@pytest.fixture
def plain() -> Iterator[None]:
    """Let a plant's report and appendix be a word: they are tested elsewhere."""
    with undrawn():
        yield


@pytest.mark.parametrize("verb", ["design", "report", "appendix", "certify", "simulate"])
def test_a_plant_file_is_read_once(
    plain: None, reads: Counter[str], cubic: Path, tmp_path: Path, verb: str
) -> None:
    """Kind, options of ``[design]``, plant and the files of the certificate are all from there."""
    assert main([verb, str(cubic), "--out", str(tmp_path / "out")]) == 0

    assert reads == {"cubic.toml": 1}


def test_a_plant_file_is_read_once_for_given_gains(
    plain: None, reads: Counter[str], cubic: Path, tmp_path: Path
) -> None:
    """Certified as they stand, and simulated."""
    out = tmp_path / "out"
    main(["design", str(cubic), "--out", str(out)])
    given = ["--gains", str(out / "gains.json")]

    for verb in ("certify", "simulate"):
        reads.clear()
        assert main([verb, str(cubic), *given, "--out", str(tmp_path / verb)]) == 0
        assert reads == {"cubic.toml": 1}


@pytest.mark.parametrize("verb", ["design", "report", "certify"])
def test_a_turbine_file_is_read_once(
    asked: Any, reads: Counter[str], tmp_path: Path, verb: str
) -> None:
    """Of the built-in name, among the other files of the library."""
    assert main([verb, "nrel5mw", "--out", str(tmp_path / "out")]) == 0

    assert reads == {"nrel5mw.toml": 1}


def test_a_turbine_file_is_read_once_by_a_simulation(reads: Counter[str]) -> None:
    """The reference's own controller, which needs no design."""
    quick = ["--law", "baseline", "--scenario", "step", "--duration", "1", "--json"]

    assert main(["simulate", "nrel5mw", *quick]) == 0

    assert reads == {"nrel5mw.toml": 1}


def test_numbers_of_a_turbine_file_are_the_floats_nearest_to_them() -> None:
    """Read as decimals for both kinds, they are what a reader of floats gets, also far out."""
    path = data_folder() / "nrel5mw.toml"
    exact = toml_document.read_document(path, parse_float=toml_document.decimal_of)

    assert exact.in_floats() == toml_document.read_document(path)
    for text in ("1e400", "-1e99999999999999999999", "1_000.5", "-0.0", "inf"):
        assert repr(float(toml_document.decimal_of(text))) == repr(float(text))


def test_a_number_beyond_decimals_is_misuse(
    cubic: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An exponent that no decimal has is no fault of takagi: the field is named."""
    text = cubic.read_text(encoding="utf-8")
    cubic.write_text(text.replace("range = [-1, 1]", "range = [-1, 1e99999999999999999999]", 1))

    assert main(["design", str(cubic), "--out", str(tmp_path / "out")]) == 2
    assert f"{cubic}:" in capsys.readouterr().err


def test_one_table_knows_the_kinds_of_models() -> None:
    """No verb asks whether a model is a plant: each kind's maker answers for it."""
    asking = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in [*(ROOT / "cli").rglob("*.py"), *(ROOT / "reports").glob("*.py")]
        if str(path.relative_to(ROOT)) not in KNOW_THE_KINDS
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in MAKERS
    ]

    assert asking == []
    assert set(MAKERS) == set(built_in_kinds().values())


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


def test_both_designs_are_read_alike(plain: None, finished: Any, cubic: Path) -> None:
    """What verbs and reports ask of a design, both have."""
    from takagi.certificates.design.design import Design
    from takagi.certificates.design.plant import PlantDesign, design_plant
    from takagi.models.plant_files import load_plant

    plant = design_plant(load_plant(cubic))
    assert isinstance(plant, PlantDesign)
    both: list[Design] = [finished, plant]

    for design in both:
        assert design.proved and design.is_about_plant and design.verdict_words == "PROVED"
        assert design.checked.verdict is Verdict.PROVED and design.document["claims"]
        assert design.kind in MAKERS and design.name and design.seconds and design.settings
        json.dumps(design.notes)
