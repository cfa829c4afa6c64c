"""The second checker shares nothing with the first, with the models, or with the solver."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import takagi.certificates.cross_check
from tests.certificates.imported import imported_modules

FOLDER = Path(str(takagi.certificates.cross_check.__file__)).parent

SCRIPT = """
import sys
from takagi.certificates.cross_check.opinion import judge
import takagi.certificates.cross_check.plant.embedding
import takagi.certificates.cross_check.turbine.loop_claim
own = "takagi.certificates.cross_check"
print([n for n in sorted(sys.modules) if n.startswith("takagi.") and not n.startswith(own)])
names = {name.partition(".")[0] for name in sys.modules}
print("numpy" in names, "sympy" in names, "cvxpy" in names, "flint" in names)
"""


def test_sources_import_flint_the_standard_library_and_each_other() -> None:
    for file, name in imported_modules(FOLDER):
        own = name.startswith("takagi.certificates.cross_check")
        known = name.partition(".")[0] in {*sys.stdlib_module_names, "flint"}
        assert own or known, (file.name, name)


def test_nothing_else_is_loaded() -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True
    )

    loaded, others = done.stdout.splitlines()
    assert loaded == "['takagi.certificates']"
    assert others == "False False False True"


def test_no_line_of_code_is_the_first_checker_s() -> None:
    """Longer lines that stand in both are few: types, names of the file's own members."""
    first = FOLDER.parent / "checker"
    theirs = {line for file in first.rglob("*.py") for line in _lines(file)}
    shared = [line for file in FOLDER.rglob("*.py") for line in _lines(file) if line in theirs]

    assert len(shared) < 12, shared


def _lines(file: Path) -> list[str]:
    """Return lines of code of some length, without imports and keyword lines of a table."""
    stripped = (line.strip() for line in file.read_text(encoding="utf-8").splitlines())
    return [
        line
        for line in stripped
        if len(line) > 45 and not line.startswith(("from ", "import ", '"', "#"))
    ]
