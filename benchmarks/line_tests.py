"""Which tests run which lines of the checker, and in which order they are tried.

Measured once, a test at a time, and kept in a file beside the journal.  A test is measured anew
when its own file has changed.  Lines are counted from the head of their function, so that a
function may move.  Of a function that was edited since, a test that ran it may run any line; of a
new one, a test that ran an edited or a lost function may.  That is more than is true, which costs
time; a test that is run in vain decides nothing.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from line_changes import Change, Function, functions_of, module_name
from line_journal import Entry

FEW, OFTEN = 40, 8
# In the place of a line: it is not known which of a function's lines a test runs.
ANY = -1


class LineTests:
    """Tests by line: seconds of each test, and the lines that each test and fixture runs."""

    def __init__(self, place: Path, package: Path) -> None:
        self.place, self.package = place, package
        known = json.loads(place.read_text()) if place.exists() else {}
        self.functions: dict[str, str] = known.get("functions", {})
        self.tests: dict[str, dict[str, Any]] = known.get("tests", {})
        self.fixtures: dict[str, dict[str, Any]] = known.get("fixtures", {})
        # Fixtures that take too long, with all tests that ask for them.
        self.dear: set[str] = set(known.get("dear", ()))
        self.noticed: dict[str, Counter[str]] = {}
        self._by_line: dict[tuple[str, int], list[str]] = {}

    @property
    def seconds(self) -> dict[str, float]:
        return {name: test["seconds"] for name, test in self.tests.items()}

    # ------------------------------------------------------------------ measuring

    def update(self, warm: Any) -> None:
        """Make the fixtures that tests share, and measure what is not known; minutes at first."""
        functions = {path: functions_of(path) for path in sorted(self.package.rglob("*.py"))}
        hashes = {found.name: found.sha for listed in functions.values() for found in listed}
        files = {name.partition("::")[0] for name in warm.items}
        shas = {file: _sha(Path(file)) for file in sorted(files)}
        stale = [
            name
            for name in warm.items
            if name not in self.tests or self.tests[name]["sha"] != shas[name.partition("::")[0]]
        ]
        for known in (*self.tests.values(), *self.fixtures.values()):
            known["lines"] = _renewed(known["lines"], self.functions, hashes)
        self.functions = hashes
        unknown = [name for name in warm.fixtures if name not in self.fixtures]
        warm.make_fixtures(
            self.seconds, traced=bool(unknown), dear=self.dear & warm.fixtures.keys()
        )
        for name, lines in warm.fixture_lines.items():
            self.fixtures[name] = {"lines": _by_function(lines, functions)}
        self.dear = warm.dear
        for name in self.dear:
            stale = [one for one in stale if one not in warm.fixtures[name][1]]
            self.fixtures[name] = {"lines": {}}
        for count, (name, run) in enumerate(warm.runs_of(stale), start=1):
            self.tests[name] = {
                "sha": shas[name.partition("::")[0]],
                "seconds": run.seconds,
                "passed": run.passed,
                "lines": _by_function(run.lines, functions),
            }
            if count % 100 == 0:
                print(f"{count} of {len(stale)} tests measured", flush=True)
                self._save()
        self._save()
        # What other tests have shown stays in the file; here only those that can be run count.
        self.tests = {n: test for n, test in self.tests.items() if n in warm.items}
        self.fixtures = {n: one for n, one in self.fixtures.items() if n in warm.fixtures}
        self.index()

    def index(self) -> None:
        """Note for every line the tests that run it; those that fail as they are do not count."""
        self._by_line = {}
        for name, test in self.tests.items():
            if test["passed"]:
                for function, lines in test["lines"].items():
                    for line in lines or (ANY,):
                        self._by_line.setdefault((function, line), []).append(name)

    def _save(self) -> None:
        self.place.parent.mkdir(parents=True, exist_ok=True)
        beside = self.place.with_name(f"{self.place.name}.{os.getpid()}")
        known = {"functions": self.functions, "tests": self.tests, "fixtures": self.fixtures}
        known["dear"] = sorted(self.dear)
        beside.write_text(json.dumps(known))
        beside.replace(self.place)

    # ------------------------------------------------------------------ choosing

    def tests_of(self, change: Change, budget: float) -> list[str]:
        """Return tests that run the changed line: what noticed its neighbours, then the quickest.

        The first is always among them, further ones until their seconds are more than ``budget``.
        """
        function, lines = _where(change)
        running = {
            name for line in (*lines, ANY) for name in self._by_line.get((function, line), ())
        }
        seconds = self.seconds
        ordered: list[str] = []
        for counts in (self.noticed.get(function), self.noticed.get(module_name(change.module))):
            each = {
                name: seconds[name] / count
                for name, count in (counts or {}).items()
                if name in running and name not in ordered
            }
            ordered += sorted(each, key=each.__getitem__)[:OFTEN]
        ordered += _varied(running - set(ordered), seconds)
        return _within(ordered, seconds, budget)

    def tests_of_module(self, module: Path) -> list[str]:
        """Return the tests that run any function of a module, quick and different ones first."""
        found = [
            name
            for name, test in self.tests.items()
            if test["passed"]
            and any(f.startswith(f"{module_name(module)} ") for f in test["lines"])
        ]
        return _varied(found, self.seconds)

    def fixtures_of(self, change: Change) -> list[str]:
        """Return the shared fixtures that run the changed line."""
        function, lines = _where(change)
        return [
            name
            for name, fixture in self.fixtures.items()
            if function in fixture["lines"]
            and set(lines) & set(fixture["lines"][function] or lines)
        ]

    def users_of(self, fixtures: Iterable[str], warm: Any, budget: float) -> list[str]:
        """Return the quickest tests that use these fixtures."""
        seconds = self.seconds
        using = {name for fixture in fixtures for name in warm.fixtures[fixture][1]}
        passing = [name for name in using if self.tests.get(name, {}).get("passed")]
        return _within(sorted(passing, key=lambda name: seconds[name])[:FEW], seconds, budget)

    def leave_out(self, test: str) -> None:
        """Forget a test that fails although nothing is broken."""
        self.tests[test]["passed"] = False
        self.index()

    def learn(self, entries: Iterable[Entry]) -> None:
        """Remember which tests noticed changes in earlier runs."""
        for entry in entries:
            if entry.by in self.tests:
                module, owner = entry.key.split()[:2]
                for name in (f"{module} {owner}", module):
                    self.noticed.setdefault(name, Counter())[entry.by] += 1

    def note(self, change: Change, test: str) -> None:
        """Remember which test noticed a change."""
        for name in (_where(change)[0], module_name(change.module)):
            self.noticed.setdefault(name, Counter())[test] += 1


def _varied(names: Iterable[str], seconds: dict[str, float]) -> list[str]:
    """Return the quickest first, and of a test with many parameters one before the next."""
    cases: Counter[str] = Counter()
    turn: dict[str, int] = {}
    for name in sorted(names, key=lambda name: (seconds[name], name)):
        function = name.partition("[")[0]
        cases[function] += 1
        turn[name] = cases[function]
    return sorted(turn, key=lambda name: (turn[name] > 1, seconds[name] * turn[name], name))


def _within(ordered: Sequence[str], seconds: dict[str, float], budget: float) -> list[str]:
    found: list[str] = []
    left = budget
    for name in ordered:
        if found and seconds[name] > left:
            continue
        found.append(name)
        left -= seconds[name]
    return found


def _where(change: Change) -> tuple[str, range]:
    """Return the function of a change, and the lines of its statement from the function's head."""
    start = change.line - change.first
    return f"{module_name(change.module)} {change.owner}", range(
        start, start + change.last - change.line + 1
    )


def _by_function(
    lines: dict[str, set[int]], functions: dict[Path, list[Function]]
) -> dict[str, list[int]]:
    """Return lines of files as lines of functions."""
    found = {}
    for path, numbers in lines.items():
        for function in functions.get(Path(path), ()):
            inside = range(function.first, function.last + 1)
            ran = sorted(n - function.first for n in numbers if n in inside and n > function.first)
            if ran:
                found[function.name] = ran
    return found


def _renewed(
    lines: dict[str, list[int]], before: dict[str, str], now: dict[str, str]
) -> dict[str, list[int]]:
    """Return lines by function for the functions that there are now; none are named: any."""
    kept = {name: listed for name, listed in lines.items() if now.get(name) == before.get(name)}
    edited = lines.keys() - kept.keys()
    if edited:
        kept |= {name: [] for name in edited if name in now}
        rooms = {name.partition(" ")[0] for name in edited}
        known = {name.partition(" ")[0] for name in before}
        for name in now.keys() - before.keys():
            room = name.partition(" ")[0]
            if room in rooms or room not in known:
                kept[name] = []
    return kept


def _sha(path: Path) -> str:
    """Return a hash of a file of tests without its imports, which may follow moved modules."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    tree.body = [node for node in tree.body if not isinstance(node, (ast.Import, ast.ImportFrom))]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:12]
