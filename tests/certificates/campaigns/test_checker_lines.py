"""The campaign that breaks the checker's lines breaks them, and only one at a time."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]
lines: Any = import_module("checker_lines")


def broken(text: str, tmp_path: Path) -> list[str]:
    """Return every broken form of a module."""
    module = tmp_path / "module.py"
    module.write_text(text, encoding="utf-8")
    return [ast.unparse(found.tree) for found in lines.broken_modules(module)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("def f(a, b):\n    return a < b", ["a <= b", "a > b"]),
        ("def f(a, b):\n    return a + b", ["a - b"]),
        ("def f(a, b):\n    return a @ b.T", ["b.T @ a", "a @ b.T.T"]),
        ("def f(a, b):\n    return -a", ["--a"]),
        ("def f(a, b):\n    return a and b", ["a or b"]),
        ("def f(a, b):\n    return min(a, 1)", ["max(a, 1)", "min(a, 2)"]),
        ("def f(a, b):\n    if a:\n        return b", ["if False:"]),
    ],
)
def test_one_change_at_a_time(text: str, expected: list[str], tmp_path: Path) -> None:
    found = broken(text, tmp_path)

    assert len(found) == len(expected)
    for change, form in zip(expected, found, strict=True):
        assert change in form


def test_words_types_and_limits_stay(tmp_path: Path) -> None:
    """A message, an annotation, an import, a constant of the module."""
    text = '"""1 + 1"""\nfrom a import b\nMOST = 1 + 1\n'
    text += 'def f(a: "1 + 1") -> None:\n    raise ValueError(f"{a + 1}")\n'

    assert broken(text, tmp_path) == []


def test_every_part_of_the_checker_is_broken() -> None:
    parts = {lines.part_of(module) for module in lines.targets()}

    assert parts == {"kernel", "kinds/", "plant/"}
    for module in lines.targets():
        assert all(stage for stage in lines.tests_of(module))


@pytest.mark.slow
def test_broken_definiteness_is_noticed() -> None:
    """Of twelve changes in ``definite`` at least nine are noticed by the tests."""
    command = [sys.executable, "benchmarks/checker_lines.py", "--only", "definite.py"]

    ran = subprocess.run(
        [*command, "--count", "12", "--print-only"], cwd=ROOT, capture_output=True, text=True
    )

    assert ran.returncode == 0, ran.stderr
    row = next(line for line in ran.stdout.splitlines() if line.startswith("| kernel"))
    tried, noticed = (int(cell) for cell in row.split("|")[3:5])
    assert tried == 12 and noticed >= 9, ran.stdout
