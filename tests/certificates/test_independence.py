"""The checker shares nothing: no third-party module, no other floor, by import and by reading."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import takagi.certificates.checker
from tests.syntax import imported_modules

FOLDER = Path(str(takagi.certificates.checker.__file__)).parent

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
from takagi.certificates.checker import check
print(check(sys.argv[2]).verdict.name)
names = {name.partition(".")[0] for name in sys.modules}
foreign = names - set(sys.stdlib_module_names) - {"takagi", "__main__"}
floors = [n for n in sys.modules if n.startswith("takagi.") and ".certificates" not in n]
print(sorted(foreign), floors)
"""


def test_check_runs_without_any_installed_package(tmp_path: Path, short: dict[str, Any]) -> None:
    """Python without site packages, and a folder that holds the checker's files alone."""
    home = tmp_path / "takagi" / "certificates" / "checker"
    shutil.copytree(FOLDER, home, ignore=shutil.ignore_patterns("__pycache__"))
    certificate = tmp_path / "certificate.json"
    certificate.write_text(json.dumps(short))

    done = subprocess.run(
        [sys.executable, "-I", "-S", "-W", "error", "-c", SCRIPT, tmp_path, certificate],
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.stderr == ""
    assert done.stdout.split("\n")[:2] == ["PROVED", "[] []"]


def test_sources_import_the_standard_library_and_each_other() -> None:
    """No import, wherever it stands, leaves the standard library or the checker's own folder."""
    for file, name in imported_modules(FOLDER):
        own = name.startswith("takagi.certificates.checker")
        assert own or name.partition(".")[0] in sys.stdlib_module_names, (file.name, name)


def test_no_float_enters_a_decision() -> None:
    """``float`` appears in messages alone: every comparison is between exact numbers."""
    rooms = ("kernel", "arithmetic", "kinds", "loop", "replay", "turbine")
    files = [file for room in rooms for file in sorted((FOLDER / room).rglob("*.py"))]
    for file in [*files, FOLDER / "plant" / "effort_blend.py"]:
        tree = ast.parse(file.read_text(encoding="utf-8"))
        refusals = [node for node in ast.walk(tree) if isinstance(node, ast.Raise)]
        said = {part for refusal in refusals for part in ast.walk(refusal)}
        assert not [n for n in ast.walk(tree) if _is_float(n) and n not in said], file.name


def _is_float(node: ast.AST) -> bool:
    literal = isinstance(node, ast.Constant) and isinstance(node.value, float)
    return literal or (isinstance(node, ast.Name) and node.id == "float")
