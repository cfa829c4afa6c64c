"""Breaks lines of the checker, one at a time, and names the changes that no test notices.

    python benchmarks/checker_lines.py [kernel/definite kinds/ ...] [--tests PATH ...] [--count N]

The tests run once, to see which of them runs which line; that is kept in build/checker_lines, and
measured again after ``--measure``.  Then each change (``line_changes``) is imported in the place
of the checker's module by a process of its own, and the tests of that line run there until one
fails.  A survivor needs a sentence in ``survivors.toml`` that says why it does no harm, or a test.
"""

from __future__ import annotations

import argparse
import importlib
import json
import multiprocessing
import os
import random
import resource
import signal
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from itertools import accumulate
from pathlib import Path
from types import ModuleType

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

import pytest  # noqa: E402  the threads first
from coverage import Coverage, CoverageData  # noqa: E402
from hypothesis import Phase, settings  # noqa: E402
from line_changes import Change, broken_tree, changes_of  # noqa: E402
from measure import table  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
CHECKER = ROOT / "certificates" / "checker"
TESTS = ("tests/certificates", "tests/cli/test_check.py", "tests/cli/test_certify.py")
# Campaigns and maps are dear, and no tests of single lines.
LEFT_OUT = ("campaigns", "campaign", "sweep", "hostile/test_fuzzer.py")
FOLDER = ROOT / "build" / "checker_lines"
WHY = ROOT / "benchmarks" / "survivors.toml"
# Heavy, and not what is tested: imported before the processes part.
PRELOADED = ("numpy", "scipy.linalg", "scipy.optimize", "sympy", "clarabel", "flint")
# A failure is enough: no smaller example is sought.
settings.register_profile(
    "broken lines",
    derandomize=True,
    deadline=None,
    max_examples=50,
    phases=(Phase.explicit, Phase.generate),
)
OPTIONS = (
    *("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--assert=plain"),
    "--hypothesis-profile=broken lines",
)
# Bounds of one change: tests at first, seconds of those after them, seconds of the processor
# beside what the tests took, and bytes.
MOST_TESTS, FURTHER_SECONDS, SECONDS, MEMORY = 60, 60, 15, 6_000_000_000


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the changes that are asked for, print the survivors and a table of rooms."""
    asked = _asked(arguments)
    os.chdir(ROOT)
    for name in PRELOADED:
        importlib.import_module(name)
    tests = LineTests(asked.folder, asked.tests, measure=asked.measure)
    modules = [
        path for path in sorted(CHECKER.rglob("*.py")) if any(t in str(path) for t in asked.only)
    ]
    changes = [c for module in modules for c in changes_of(module) if not c.is_of_size]
    random.Random(asked.seed).shuffle(changes)
    changes = changes[: asked.count]
    why = tomllib.loads(WHY.read_text(encoding="utf-8"))
    survivors, unexplained = [], []
    with multiprocessing.get_context("fork").Pool(asked.jobs) as pool:
        answers = pool.imap(partial(is_noticed, tests=tests), changes)
        for change, noticed in zip(changes, answers, strict=True):
            if noticed:
                continue
            survivors.append(change)
            if not explanation(change, why):
                unexplained.append(change)
                place = f"{change.module.relative_to(ROOT)}:{change.line}"
                print(f"{place}: {change.owner}: {change.what}", flush=True)
    rooms = sorted({room_of(change) for change in changes})
    rows = [_row(room, changes, survivors, unexplained) for room in (*rooms, "all")]
    print(table(("room", "changes", "noticed", "share", "survivors explained"), rows))
    return 1 if unexplained else 0


def _asked(arguments: Sequence[str] | None) -> argparse.Namespace:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("only", nargs="*", default=[""], help="modules with this in their path")
    reader.add_argument("--tests", nargs="+", default=TESTS, help="files or folders of tests")
    reader.add_argument("--count", type=int, help="changes to try at most, drawn from all")
    reader.add_argument("--seed", type=int, default=1, help="of what is drawn")
    reader.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    reader.add_argument("--measure", action="store_true", help="see anew which test runs what")
    reader.add_argument("--folder", type=Path, default=FOLDER, help="of what was measured")
    return reader.parse_args(arguments)


def room_of(change: Change) -> str:
    """Return the room that a change stands in; what opens a certificate is the kernel's."""
    folders = change.module.relative_to(CHECKER).parts[:-1]
    return folders[0] if folders else "kernel"


def explanation(change: Change, why: dict[str, dict[str, str]]) -> str:
    """Return the sentence that says why a change does no harm, or nothing."""
    name = f"{change.module.parent.name}/{change.module.stem}.{change.owner}"
    return why.get(name, {}).get(change.what, "")


def _row(
    room: str, changes: Sequence[Change], survivors: Sequence[Change], open_: Sequence[Change]
) -> tuple[str, ...]:
    def count(of: Sequence[Change]) -> int:
        return sum(room in (room_of(change), "all") for change in of)

    tried, left = count(changes), count(survivors)
    share = f"{100 * (tried - left) / tried:.1f} %" if tried else "-"
    return room, str(tried), str(tried - left), share, f"{left - count(open_)} of {left}"


# ------------------------------------------------------------------ which test runs which line


class LineTests:
    """Tests by line of the checker: the quickest, and those that run little else of it."""

    def __init__(self, folder: Path, paths: Sequence[str], *, measure: bool) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        lines, seconds = folder / "lines.coverage", folder / "seconds.json"
        if measure or not seconds.exists():
            lines.unlink(missing_ok=True)
            if in_a_process(partial(_measure, lines, seconds, paths)) is None:
                raise RuntimeError("the tests did not run; what pytest said stands above")
        self.seconds: dict[str, float] = json.loads(seconds.read_text(encoding="utf-8"))
        data = CoverageData(str(lines))
        data.read()
        self.by_line = {Path(file): data.contexts_by_lineno(file) for file in data.measured_files()}
        self.lines = Counter(
            name
            for by_line in self.by_line.values()
            for names in by_line.values()
            for name in names
        )

    def of(self, change: Change) -> tuple[list[str], list[str]]:
        """Return tests that run the changed statement; of one outside functions the module's.

        First those that are tried on every change, then those for what survives them.
        """
        by_line = self.by_line.get(change.module, {})
        lines = range(change.line, change.last + 1) if change.owner else tuple(by_line)
        names = {name for line in lines for name in by_line.get(line, ()) if name in self.seconds}
        quickest = varied(names, self.seconds)[: MOST_TESTS // 2]
        # A line that hundreds of tests run has its own among those that run the fewest others.
        special = sorted(names - {*quickest}, key=lambda name: (self.lines[name], name))
        first = [*quickest, *special[: MOST_TESTS - len(quickest)]]
        others = sorted(names - {*first}, key=lambda name: (self.seconds[name], name))
        passed = accumulate(self.seconds[name] for name in others)
        return first, [n for n, s in zip(others, passed, strict=True) if s <= FURTHER_SECONDS]


def varied(names: set[str], seconds: dict[str, float]) -> list[str]:
    """Return the quickest first, and of a test with many parameters one before the next."""
    cases: Counter[str] = Counter()
    turn: dict[str, int] = {}
    for name in sorted(names, key=lambda name: (seconds[name], name)):
        function = name.partition("[")[0]
        cases[function] += 1
        turn[name] = cases[function]
    return sorted(turn, key=lambda name: (turn[name] > 1, seconds[name] * turn[name], name))


class _Watched:
    """A plugin of pytest: notes for every test the lines that it runs, and its seconds."""

    def __init__(self, coverage: Coverage) -> None:
        self.coverage = coverage
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.coverage.switch_context(item.nodeid)
        began = time.process_time()
        result = yield
        self.seconds[item.nodeid] = round(time.process_time() - began, 3)
        return result  # noqa: B901

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if not report.passed:
            self.failed.add(report.nodeid)


def _measure(lines: Path, seconds: Path, paths: Sequence[str]) -> bool:
    coverage = Coverage(data_file=str(lines), source=[str(CHECKER)], config_file=False)
    watched = _Watched(coverage)
    left_out = [f"--ignore=tests/certificates/{name}" for name in LEFT_OUT]
    coverage.start()
    pytest.main([*paths, *left_out, *OPTIONS], plugins=[watched])
    coverage.stop()
    coverage.save()
    passing = {name: s for name, s in watched.seconds.items() if name not in watched.failed}
    seconds.write_text(json.dumps(passing), encoding="utf-8")
    return True


# ------------------------------------------------------------------ trying a change


def is_noticed(change: Change, tests: LineTests) -> bool:
    """Whether a test of the changed line fails, crashes or does not end."""
    for names in tests.of(change):
        seconds = SECONDS + 4 * sum(tests.seconds[name] for name in names)
        if names and not in_a_process(partial(_passes, change, names), int(seconds)):
            return True
    return False


def _passes(change: Change, names: Sequence[str]) -> bool:
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    sys.meta_path.insert(0, Broken(change))
    return pytest.main([*names, "-x", *OPTIONS]) == 0


class Broken(MetaPathFinder, Loader):
    """Imports one module of the checker with a change."""

    def __init__(self, change: Change) -> None:
        parts = change.module.relative_to(ROOT).with_suffix("").parts
        self.name = ".".join(("takagi", *(part for part in parts if part != "__init__")))
        self.code = compile(broken_tree(change.module, change.at), str(change.module), "exec")

    def find_spec(
        self, fullname: str, path: object = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname == self.name else None

    def exec_module(self, module: ModuleType) -> None:
        exec(self.code, module.__dict__)


def in_a_process(work: Callable[[], bool], seconds: int = 0) -> bool | None:
    """Run ``work`` in a copy of this process; None where it crashes, or needs more seconds."""
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        status = 2
        try:
            if seconds:
                signal.alarm(10 * seconds)
                resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
            status = 0 if work() else 1
        finally:
            os._exit(status)
    _, ended = os.waitpid(child, 0)
    return {0: True, 256: False}.get(ended)


if __name__ == "__main__":
    raise SystemExit(main())
