"""The campaign that breaks the checker's lines breaks them, and only one at a time."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]
changes: Any = import_module("line_changes")
journals: Any = import_module("line_journal")
line_tests: Any = import_module("line_tests")
lines: Any = import_module("checker_lines")


def module_of(text: str, tmp_path: Path) -> Path:
    """Return a module of the kernel with this text."""
    (tmp_path / "kernel").mkdir(exist_ok=True)
    module = tmp_path / "kernel" / "module.py"
    module.write_text(text, encoding="utf-8")
    return module


def broken(text: str, tmp_path: Path) -> list[str]:
    """Return every broken form of a module."""
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
    """A message, an annotation, an import, a constant of the module."""
    text = '"""1 + 1"""\nfrom a import b\nMOST = 1 + 1\n'
    text += 'def f(a: "1 + 1") -> None:\n    raise ValueError(f"{a + 1}")\n'

    assert broken(text, tmp_path) == []


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


TWO = "def f(a):\n    return a + 1\n\n\nclass C:\n    def g(self, b):\n        return b < 2\n"


def test_a_change_is_known_by_its_function(tmp_path: Path) -> None:
    """Words, and edits of other functions, leave a key; an edit of the function does not."""

    def keys(text: str) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for change in changes.changes_of(module_of(text, tmp_path)):
            found.setdefault(change.owner, []).append(change.key)
        return found

    first = keys(TWO)
    assert {name: len(listed) for name, listed in first.items()} == {"f": 2, "C.g": 3}
    assert keys(TWO.replace("def f(a):\n", 'def f(a):\n    """Add."""\n    # why\n')) == first
    moved = keys(TWO.replace("a + 1", "a + 2"))
    assert moved["C.g"] == first["C.g"]
    assert not set(moved["f"]) & set(first["f"])


def test_a_change_knows_its_lines(tmp_path: Path) -> None:
    """Those of its statement, of a compound one those of its head."""
    text = "def f(a):\n    if (\n        a\n        < 1\n    ):\n        a = 3\n    return a\n"

    found = changes.changes_of(module_of(text, tmp_path))

    assert {(change.what, change.line, change.last) for change in found} >= {
        ("a < 1  ->  a <= 1", 2, 5),
        ("3  ->  4", 6, 6),
    }
    assert {change.first for change in found} == {1}


def test_every_room_of_the_checker_is_broken() -> None:
    """No module is left out, and a share only of the rooms that are named."""
    rooms = {lines.part_of(module) for module in lines.modules()}

    assert rooms >= {"kernel", "kinds", "plant", "turbine", "arithmetic"}
    assert lines.SHARE.keys() <= rooms
    for name in ("kernel/definite", "kinds/decay", "plant/ranges", "turbine/published/loop"):
        module = lines.CHECKER / f"{name}.py"
        assert module in lines.modules()
        found = changes.changes_of(module)
        assert len({change.key for change in found}) == len(found) > 0


def test_a_third_of_the_plants_reading_is_drawn() -> None:
    """By lot, the same at every run, and another one with another seed."""
    found = changes.changes_of(lines.CHECKER / "plant" / "ranges.py")
    found += changes.changes_of(lines.CHECKER / "plant" / "identity.py")

    drawn = [change.key for change in found if lines.is_drawn(change, 1)]
    others = [change.key for change in found if lines.is_drawn(change, 2)]

    assert 0.25 < len(drawn) / len(found) < 0.42
    assert drawn != others
    whole = changes.changes_of(lines.CHECKER / "kernel" / "definite.py")
    assert all(lines.is_drawn(change, 1) for change in whole)


def test_results_are_kept_and_resumed(tmp_path: Path) -> None:
    """A journal that ends early, its results in the file, and an edited function that is new."""
    module = module_of(TWO, tmp_path)
    listed = changes.changes_of(module)
    results = tmp_path / "results.txt"
    journal = journals.Journal(results, tmp_path / "journal", "0-of-1")
    for change, mark in zip(listed, "nsn", strict=False):
        journal.add(journals.Entry(change.key, mark, "place", change.what, "test", "fails", 1, 0.1))

    again = journals.Journal(results, tmp_path / "journal", "0-of-2")
    assert again.marks == dict(zip([c.key for c in listed], "nsn", strict=False))
    again.keep(listed)

    later = journals.Journal(results, tmp_path / "another", "0-of-1")
    assert later.marks == again.marks
    edited = changes.changes_of(module_of(TWO.replace("b < 2", "b < 3"), tmp_path))
    assert [later.marks.get(change.key) for change in edited] == ["n", "s", None, None, None]
    assert "| module/ |" not in lines.report(listed[:0], [], later, None)


def test_survivors_carry_their_sentence(tmp_path: Path) -> None:
    """By module, function and change; an unknown one has none."""
    said = tmp_path / "said.toml"
    said.write_text('["kernel/module.f"]\n"a + 1  ->  a - 1" = "why"\n', encoding="utf-8")
    found = changes.changes_of(module_of(TWO, tmp_path))

    assert [journals.Explained(said).why(change) for change in found] == ["why", "", "", "", ""]


def test_what_noticed_a_neighbour_is_tried_first(tmp_path: Path) -> None:
    """Then the quickest, and no more than the budget allows."""
    (change, *_) = changes.changes_of(module_of(TWO, tmp_path))
    place = tmp_path / "tests.json"
    ran = {"kernel/module f": [1]}
    tests = {
        name: {"sha": "", "seconds": seconds, "passed": passed, "lines": ran}
        for name, seconds, passed in (
            *(("slow", 3.0, True), ("quick", 0.1, True), ("dear", 9.0, True)),
            ("broken", 0.1, False),
        )
    }
    tests["elsewhere"] = {**tests["quick"], "lines": {"kernel/module f": [2]}}
    place.write_text(json.dumps({"tests": tests, "functions": {}, "fixtures": {}}))
    known = line_tests.LineTests(place, tmp_path)
    known.index()

    assert known.tests_of(change, 5.0) == ["quick", "slow"]
    known.note(change, "slow")
    assert known.tests_of(change, 5.0) == ["slow", "quick"]
    known.note(change, "dear")
    assert known.tests_of(change, 50.0) == ["slow", "dear", "quick"]
    assert known.tests_of(change, 0.01) == ["slow"]


TOY = "MEMORY = []\n\n\ndef larger(a, b):\n    return a > b\n\n\n"
TOY += "def endless(a):\n    while a > 0:\n        a = a - 1\n\n\n"
# Broken, it leaves something behind that makes its own test fail when it is right again.
TOY += "def forgets(a):\n    MEMORY.append(a)\n    MEMORY.pop(0 - 1)\n    return len(MEMORY)\n"
TOY_TESTS = """
import functools
import pytest
import toy

@functools.cache
def known():
    return toy.larger(2, 1)

@pytest.fixture(scope="module")
def shared():
    return toy.larger(3, 2)

def test_larger():
    assert toy.larger(2, 1)

def test_not_larger():
    assert not toy.larger(1, 2)

def test_shared(shared):
    assert shared

def test_known():
    assert known()

def test_ends():
    toy.endless(3)

def test_forgets():
    assert toy.forgets(1) == 0

def test_of_nothing():
    pass

def test_that_fails_as_it_is():
    assert False
"""
TOY_RUN = """
import json, sys
from pathlib import Path
sys.path[:0] = [{benchmarks!r}, "."]
import toy
import warm_tests
from collected_tests import with_tests

warm_tests.SECONDS_SLOWER = 0.5
here = Path(".").resolve()

def work(tests):
    tests.make_fixtures({{}}, traced=True)
    code = lambda old, new: compile(
        Path("toy.py").read_text().replace(old, new), str(here / "toy.py"), "exec"
    )
    names = list(tests.items)
    runs = dict(tests.runs_of(names))
    passing = [name for name in names if runs[name].passed]
    found = {{
        "passing": passing,
        "lines": {{n: sorted(runs[n].lines.get(str(here / "toy.py"), ())) for n in passing}},
        "fixture": [sorted(one[str(here / "toy.py")]) for one in tests.fixture_lines.values()],
        "as it is": tests.outcome(code("", ""), passing, {{}}, tests.fixtures),
        "turned": tests.outcome(code("a > b", "a < b"), passing, {{}}),
        "equal": tests.outcome(code("a > b", "a >= b"), passing, {{}}),
        "kept": tests.outcome(code("a > b", "a < b"), [passing[2]], {{}}),
        "anew": tests.outcome(code("a > b", "a < b"), [passing[2]], {{}}, tests.fixtures),
        "remembered": tests.outcome(code("a > b", "a < b"), [passing[3]], {{}}, tests.fixtures),
        "endless": tests.outcome(code("a - 1", "a + 1"), [passing[4]], {{passing[4]: 0.0}}),
        "together": sorted(
            tests.outcomes(
                [
                    (code("a > b", "a < b"), passing[:5]),
                    (code("a > b", "a >= b"), passing[:5]),
                    (code("a - 1", "a + 1"), [passing[0], passing[4]]),
                    (code("MEMORY.pop(0 - 1)", "MEMORY.append(0 - 1)"), passing),
                    (code("MEMORY.pop(0 - 1)", "MEMORY.index(a + 1)"), passing),
                    (code("0 - 1", "0 + 1"), passing[:3]),
                ],
                {{passing[4]: 0.0}},
            )
        ),
        "after": toy.larger(2, 1),
    }}
    Path("found.json").write_text(json.dumps(found))

with_tests(["one/test_toy.py", "one/test_again.py", "two/test_more.py"], here, here / "tmp", work)
"""


@pytest.mark.slow
def test_broken_code_is_noticed_in_a_copy(tmp_path: Path) -> None:
    """A package of two functions: what its tests run, and what they notice of which change."""
    (tmp_path / "toy.py").write_text(TOY, encoding="utf-8")
    # Three files in two folders: any test follows any other, whatever pytest has set up for it.
    for place in ("one/test_toy.py", "one/test_again.py", "two/test_more.py"):
        (tmp_path / place).parent.mkdir(exist_ok=True)
        text = TOY_TESTS if place == "one/test_toy.py" else "def test_{}():\n    pass\n"
        (tmp_path / place).write_text(text.format(Path(place).stem), encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = slow\n    tex\n    coq\n")
    (tmp_path / "run.py").write_text(TOY_RUN.format(benchmarks=str(ROOT / "benchmarks")))

    ran = subprocess.run([sys.executable, "run.py"], cwd=tmp_path, capture_output=True, text=True)

    assert ran.returncode == 0, ran.stderr
    found = json.loads((tmp_path / "found.json").read_text())
    names = [name.partition("::")[2][5:] for name in found["passing"]]
    assert names[:6] == ["larger", "not_larger", "shared", "known", "ends", "forgets"]
    assert names[6:] == ["of_nothing", "test_again", "test_more"]
    # What a shared fixture has run is not run by the test again.
    assert list(found["lines"].values()) == [[5], [5], [], [5], [9, 10], [14, 15, 16], [], [], []]
    assert found["fixture"] == [[5]]
    assert found["as it is"] == ["", "", 9]
    assert found["turned"] == [found["passing"][0], "fails", 1]
    assert found["equal"] == ["", "", 9]
    # A fixture made before the change shows nothing; made anew it does, and so does a memory.
    assert found["kept"] == ["", "", 1]
    assert found["anew"] == [found["passing"][2], "fails", 1]
    assert found["remembered"] == [found["passing"][3], "fails", 1]
    assert found["endless"] == [found["passing"][4], "does not end", 1]
    # Many in one copy say the same, though one of them does not end and one leaves traces.
    first, ends, forgets = (found["passing"][k] for k in (0, 4, 5))
    assert found["together"] == [
        [0, [first, "fails", 1]],
        [1, ["", "", 5]],
        [2, [ends, "does not end", 2]],
        [3, [forgets, "fails", 6]],
        [4, [forgets, "fails", 6]],
        [5, ["", "", 3]],
    ]
    assert found["after"] is True


@pytest.mark.slow
def test_broken_definiteness_is_noticed(tmp_path: Path) -> None:
    """Of twelve changes in ``definite`` at least eleven are noticed by its own tests."""
    command = [sys.executable, "benchmarks/checker_lines.py", "--only", "kernel/definite"]
    command += ["--tests", "tests/certificates/test_definite.py", "--count", "12", "--print-only"]
    command += ["--folder", str(tmp_path), "--results", str(tmp_path / "results.txt")]

    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)

    assert ran.returncode == 0, ran.stderr
    row = next(line for line in ran.stdout.splitlines() if line.startswith("| kernel/"))
    tried, noticed = (int(cell) for cell in row.split("|")[4:6])
    assert tried == 12 and noticed >= 11, ran.stdout
