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
changes: Any = import_module("line_changes")
lines: Any = import_module("checker_lines")


def module_of(text: str, tmp_path: Path) -> Path:
    (tmp_path / "kernel").mkdir(exist_ok=True)
    module = tmp_path / "kernel" / "module.py"
    module.write_text(text, encoding="utf-8")
    return module


def broken(text: str, tmp_path: Path) -> list[str]:
    module = module_of(text, tmp_path)
    return [
        ast.unparse(changes.broken_tree(module, change.at)) for change in changes.changes_of(module)
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("def f(a, b):\n    return a < b", ["a <= b", "a > b"]),
        ("def f(a, b):\n    return a < b <= a", ["a <= b <= a", "a > b", "b < a", "b >= a"]),
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
    """A message, an annotation, an import, a constant of the module; digits, and ``strict``."""
    text = '"""1 + 1"""\nfrom a import b\nMOST = 1 + 1\n'
    text += 'def f(a: "1 + 1") -> None:\n    raise ValueError(f"{a + 1}")\n'
    text += "def g(a, b):\n    return at_least(a, 6), zip(a, b, strict=True)\n"

    found = broken(text, tmp_path)
    assert len(found) == 1 and "at_most(a, 6)" in found[0]


def test_one_more_than_a_limit_of_size_is_left_out(tmp_path: Path) -> None:
    """Its equality alone: a comparison that is turned is no limit, nor is a product a size."""
    text = "MOST = 5\n\n\ndef f(a, LONGEST):\n    bounded(a * 2, a)\n"
    text += "    return 0 < a <= MOST, a <= LONGEST * a, a + a > MOST\n"

    found = [
        change.what for change in changes.changes_of(module_of(text, tmp_path)) if change.is_of_size
    ]

    assert sorted(found) == [
        *("0 < a <= MOST  ->  0 < a < MOST", "2  ->  3", "a * 2  ->  a + 2"),
        *("a + a  ->  a - a", "a + a > MOST  ->  a + a >= MOST"),
    ]


def test_a_change_knows_its_lines(tmp_path: Path) -> None:
    """Those of its statement, of a compound one those of its head."""
    text = "def f(a):\n    if (\n        a\n        < 1\n    ):\n        a = 3\n    return a\n"

    found = changes.changes_of(module_of(text, tmp_path))

    assert {(change.what, change.line, change.last) for change in found} >= {
        ("a < 1  ->  a <= 1", 2, 5),
        ("3  ->  4", 6, 6),
    }


def test_survivors_carry_their_sentence(tmp_path: Path) -> None:
    """By module, function and change; an unknown one has none."""
    why = {"kernel/module.f": {"a + 1  ->  a - 1": "why"}}
    found = changes.changes_of(module_of("def f(a):\n    return a + 1\n", tmp_path))

    assert [lines.explanation(change, why) for change in found] == ["why", ""]


@pytest.mark.slow
def test_broken_definiteness_is_noticed(tmp_path: Path) -> None:
    """Of twelve changes in ``definite`` its own tests leave none that is not explained."""
    command = [sys.executable, "benchmarks/checker_lines.py", "kernel/definite", "--count", "12"]
    command += ["--tests", "tests/certificates/test_matrices.py", "--folder", str(tmp_path)]

    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)

    assert ran.returncode == 0, ran.stdout + ran.stderr
    row = next(line for line in ran.stdout.splitlines() if line.startswith("| kernel |"))
    tried, noticed = (int(cell) for cell in row.split("|")[2:4])
    assert tried == 12 and noticed >= 9, ran.stdout
