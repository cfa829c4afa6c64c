"""Breaks the checker's own lines, one at a time, and counts which the tests notice.

    python benchmarks/checker_lines.py [--only TEXT ...] [--seconds S] [--shard I/N] [--budget S]
                                       [--longest S] [--marks EXPR] [--survivors]
                                       [--tests PATH ...] [--print-only]

Every change (``line_changes``) is put in the place of the function in a copy of a warm process,
and the tests that run that line (``line_tests``) are run until one fails.  The changes come in an
order drawn from all of them, so that what has been tried at any time is a fair sample; of the
plant's reading it is a third.  A run that ends goes on where it was.  Survivors are printed with
their lines and with the sentence in ``survivors.toml`` that says why they do no harm; one without
such a sentence is a test that is missing.  The tables go to docs/benchmarks.md and
docs/broken-lines.md.
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import importlib
import os
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType, ModuleType

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from collected_tests import MARKS, with_tests  # noqa: E402  the threads first
from line_changes import Change, broken_tree, changes_of  # noqa: E402
from line_journal import NOTICED, SURVIVES, Entry, Explained, Journal  # noqa: E402
from line_tests import LineTests  # noqa: E402
from measure import PAGE, placed, table  # noqa: E402
from process_copies import copied
from warm_tests import LONGEST, Outcome, WarmTests  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
CHECKER = ROOT / "certificates" / "checker"
TESTS = ("tests/certificates", "tests/cli/test_check.py", "tests/cli/test_certify.py")
# Campaigns, simulations, maps and the second checker: dear, and no tests of single lines.
LEFT_OUT = tuple(f"tests/certificates/{n}" for n in ("campaign", "campaigns", "sweep", "cross"))
LEFT_OUT += ("tests/certificates/hostile/test_fuzzer.py",)
FOLDER = ROOT / "build" / "checker_lines"
RESULTS = ROOT / "benchmarks" / "checker_lines.txt"
WHY = ROOT / "benchmarks" / "survivors.toml"
SURVIVORS_PAGE = ROOT / "docs" / "broken-lines.md"
# The share of a part's changes that is drawn; of the others it is all.
SHARE = {"plant": 1 / 3}
# Changes that are tried in one copy.
TOGETHER = 10
# Heavy, and not what is tested: imported before the processes part.
PRELOADED = ("numpy", "scipy.linalg", "scipy.optimize", "sympy", "clarabel", "flint")


def main(arguments: Sequence[str] | None = None) -> int:
    """Try what has not been tried, print survivors and the table, and write the pages."""
    asked = _asked(arguments)
    os.chdir(ROOT)
    every = [change for module in modules() for change in changes_of(module)]
    drawn = sorted((c for c in every if is_drawn(c, asked.seed)), key=lambda c: lot(c, asked.seed))
    idle, drawn = [c for c in drawn if c.is_of_size], [c for c in drawn if not c.is_of_size]
    index, count = (int(word) for word in asked.shard.split("/"))
    journal = Journal(asked.results, asked.folder, f"{index}-of-{count}")
    left = [
        change
        for change in drawn
        if any(text in str(change.module.relative_to(CHECKER)) for text in asked.only)
        and int(lot(change, asked.seed), 16) % count == index
        and (
            journal.marks.get(change.key) == SURVIVES
            if asked.survivors
            else change.key not in journal.marks
        )
    ]
    if left and asked.seconds > 0:
        campaign = Campaign(journal, asked)
        campaign.run(left[: asked.count])
    explained = Explained(WHY)
    print(report(drawn, idle, journal, explained))
    if not asked.print_only:
        journal.keep(every)
        publish(drawn, idle, journal, explained)
    return 0


def _asked(arguments: Sequence[str] | None) -> argparse.Namespace:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("--only", nargs="+", default=[""], help="modules with this in their path")
    reader.add_argument("--seed", type=int, default=1, help="of the order, and of what is drawn")
    reader.add_argument("--seconds", type=float, default=float("inf"), help="stop after these")
    reader.add_argument("--count", type=int, help="changes to try at most")
    reader.add_argument("--shard", default="0/1", help="I/N: every N-th change, from the I-th")
    reader.add_argument("--budget", type=float, default=3.0, help="seconds of tests for a change")
    reader.add_argument("--longest", type=float, default=LONGEST, help="of a test, to note lines")
    reader.add_argument("--marks", default=MARKS, help="of tests, as pytest has it")
    reader.add_argument("--survivors", action="store_true", help="try survivors once more")
    reader.add_argument("--tests", nargs="+", default=TESTS, help="files or folders of tests")
    reader.add_argument("--folder", type=Path, default=FOLDER, help="of the journal")
    reader.add_argument("--results", type=Path, default=RESULTS, help="what is known by now")
    reader.add_argument("--print-only", action="store_true", help="leave results and pages")
    return reader.parse_args(arguments)


def modules() -> list[Path]:
    """Return the checker's modules."""
    return sorted(CHECKER.rglob("*.py"))


def part_of(module: Path) -> str:
    """Return the room that a module stands in; what opens a certificate is the kernel's."""
    folders = module.relative_to(CHECKER).parts[:-1]
    return folders[0] if folders else "kernel"


def lot(change: Change, seed: int) -> str:
    """Return the number in hexadecimal that decides a change's place in the order."""
    return hashlib.sha256(f"{seed} {change.key}".encode()).hexdigest()


def is_drawn(change: Change, seed: int) -> bool:
    """Whether the campaign tries the change: all, but of some parts a share."""
    share = SHARE.get(part_of(change.module), 1.0)
    return int(lot(change, seed)[-8:], 16) < share * 16**8


# ------------------------------------------------------------------ trying


class Campaign:
    """Tries changes until the time is over."""

    def __init__(self, journal: Journal, asked: argparse.Namespace) -> None:
        self.journal, self.budget, self.paths = journal, asked.budget, asked.tests
        self.longest: float = asked.longest
        self.marks: str = asked.marks
        self.deadline = time.monotonic() + asked.seconds
        self.tests = LineTests(journal.folder / "tests.json", CHECKER)
        self.sound: dict[str, bool] = {}
        module = CHECKER / "kernel" / "reader.py"
        self.unbroken = compile(module.read_text(encoding="utf-8"), str(module), "exec")

    def run(self, changes: Sequence[Change]) -> None:
        """Try the changes: those in a function's body in one warm process, others in a cold one."""
        for name in PRELOADED:
            importlib.import_module(name)
        # The warm process is a copy too: in this one no module of the checker is imported yet.
        child = os.fork()
        if child == 0:
            self._in_warm_process([change for change in changes if change.inside])
        _, status = os.waitpid(child, 0)
        if status:
            raise RuntimeError("the process with the tests has failed; its reason stands above")
        # What the copy has noted is in its journal, not in the memory of this process.
        self.journal.read()
        self.tests = LineTests(self.tests.place, CHECKER)
        for change in changes:
            if not change.inside and time.monotonic() < self.deadline:
                self._note(change, *_timed(lambda change=change: self._cold(change)))

    def _in_warm_process(self, changes: Sequence[Change]) -> None:
        status = 1
        try:
            place = self.journal.folder / f"tmp-{self.journal.own.stem}"
            paths = [*self.paths, *(f"--ignore={path}" for path in LEFT_OUT)]
            work = partial(self._warm, changes=changes)
            with_tests(paths, CHECKER, place, work, self.longest, self.marks)
            status = 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            os._exit(status)

    def _warm(self, warm: WarmTests, *, changes: Sequence[Change]) -> None:
        # What the checker imports only when it meets a kind of claim must be there to be broken.
        for module in modules():
            importlib.import_module(_imported_name(module))
        with _alone(self.journal.folder / "tests.lock"):
            self.tests = LineTests(self.tests.place, CHECKER)
            self.tests.update(warm)
        self.tests.learn(self.journal.entries())
        for first in range(0, len(changes), TOGETHER):
            if time.monotonic() > self.deadline:
                return
            self._together(warm, changes[first : first + TOGETHER])

    def _together(self, warm: WarmTests, changes: Sequence[Change]) -> None:
        """Try some changes in one copy, each with the tests of its line."""
        seconds = self.tests.seconds
        jobs = [(_compiled(c), self.tests.tests_of(c, self.budget)) for c in changes]
        began = time.perf_counter()
        for number, found in warm.outcomes(jobs, seconds):
            change = changes[number]
            if not found.test:
                found = self._made_anew(warm, change, found.ran)
            if found.test and not self._holds(warm, found.test):
                print(f"left out: {found.test} fails although nothing is broken", flush=True)
                self.tests.leave_out(found.test)
                self._together(warm, [change])
            else:
                self._note(change, found, round(time.perf_counter() - began, 3))
            began = time.perf_counter()

    def _made_anew(self, warm: WarmTests, change: Change, ran: int) -> Outcome:
        """Run tests whose shared fixtures ran the line, with fixtures made by the broken code."""
        again = self.tests.fixtures_of(change)
        users = self.tests.users_of(again, warm, self.budget)
        if not users:
            return Outcome("", "", ran)
        found = warm.outcome(_compiled(change), users, self.tests.seconds, again)
        return Outcome(found.test, found.how, ran + found.ran)

    def _holds(self, warm: WarmTests, test: str) -> bool:
        """Whether a test passes in a copy in which nothing is broken; asked once."""
        if test not in self.sound:
            found = warm.outcome(self.unbroken, [test], self.tests.seconds, warm.fixtures_of(test))
            self.sound[test] = not found.test
        return self.sound[test]

    def _cold(self, change: Change) -> Outcome:
        """Import the broken module before the tests that run its file."""
        names = self.tests.tests_of_module(change.module)[:100]
        if not names:
            return Outcome("", "", 0)

        def work() -> bool:
            import pytest

            sys.meta_path.insert(0, Breaker(change))
            # To explain assertions, pytest asks for modules that are not imported yet, and fails.
            options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--assert=plain"]
            return pytest.main([*names, *options]) == 0

        return Outcome(*(("", "") if copied(work, 300.0) else ("a test", "fails")), len(names))

    def _note(self, change: Change, found: Outcome, seconds: float) -> None:
        mark = NOTICED if found.test else SURVIVES
        place = f"{change.module.relative_to(ROOT)}:{change.line}"
        entry = Entry(
            change.key, mark, place, change.what, found.test, found.how, found.ran, seconds
        )
        self.journal.add(entry)
        if found.test:
            self.tests.note(change, found.test)
        else:
            print(f"survives: {place}: {change.what} ({found.ran} tests)", flush=True)


class Breaker(MetaPathFinder, Loader):
    """Imports one module from a changed tree."""

    def __init__(self, change: Change) -> None:
        self.name = _imported_name(change.module)
        self.code = _compiled(change)

    def find_spec(
        self, fullname: str, path: object = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname == self.name else None

    def exec_module(self, module: ModuleType) -> None:
        exec(self.code, module.__dict__)


def _imported_name(module: Path) -> str:
    parts = module.relative_to(ROOT).with_suffix("").parts
    return ".".join(("takagi", *(part for part in parts if part != "__init__")))


def _compiled(change: Change) -> CodeType:
    return compile(broken_tree(change.module, change.at), str(change.module), "exec")


def _timed(work: object) -> tuple[Outcome, float]:
    began = time.perf_counter()
    found = work()  # type: ignore[operator]
    return found, round(time.perf_counter() - began, 3)


@contextmanager
def _alone(place: Path) -> Iterator[None]:
    """Let one process at a time measure the tests."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with place.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


# ------------------------------------------------------------------ saying


def report(
    drawn: Sequence[Change], idle: Sequence[Change], journal: Journal, explained: Explained
) -> str:
    """Return the table of parts, and the survivors without a sentence."""
    rows, open_ = [], []
    for part in sorted({part_of(change.module) for change in drawn}):
        of_part = [change for change in drawn if part_of(change.module) == part]
        left_out = sum(part_of(change.module) == part for change in idle)
        rows.append(_row(f"{part}/", of_part, left_out, journal, explained))
        open_ += [c for c in survivors(of_part, journal) if not explained.why(c)]
    rows.append(_row("all", drawn, len(idle), journal, explained))
    heads = (
        *("part of the checker", "changes", "left out", "tried", "noticed", "share"),
        "survivors explained",
    )
    lines = [f"{c.module.relative_to(ROOT)}:{c.line}: {c.owner}: {c.what}" for c in open_]
    return "\n".join([*lines, table(heads, rows)])


def survivors(changes: Sequence[Change], journal: Journal) -> list[Change]:
    """Return the changes that no test noticed, by place."""
    found = [change for change in changes if journal.marks.get(change.key) == SURVIVES]
    return sorted(found, key=lambda change: (change.module, change.line, change.at))


def _row(
    name: str, changes: Sequence[Change], left_out: int, journal: Journal, explained: Explained
) -> tuple[str, ...]:
    marks = [journal.marks.get(change.key) for change in changes]
    noticed = marks.count(NOTICED)
    tried = noticed + marks.count(SURVIVES)
    said = sum(bool(explained.why(change)) for change in survivors(changes, journal))
    share = f"{100 * noticed / tried:.1f} %" if tried else "-"
    counts = (str(len(changes)), str(left_out), str(tried), str(noticed))
    return name, *counts, share, f"{said} of {tried - noticed}"


def publish(
    drawn: Sequence[Change], idle: Sequence[Change], journal: Journal, explained: Explained
) -> None:
    """Write the table of parts, and the list of survivors with the reason for each."""
    parts = report(drawn, idle, journal, explained).split("\n")
    text = "\n".join(line for line in parts if line.startswith("|"))
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "checker lines", text), "utf-8")
    rows = [
        (
            f"`{change.module.relative_to(CHECKER).with_suffix('')}.{change.owner}`",
            f"`{change.what.replace('|', chr(92) + '|')}`",
            explained.why(change) or "not explained",
        )
        for change in survivors(drawn, journal)
    ]
    listed = table(("function", "change", "why it does no harm"), rows)
    old = SURVIVORS_PAGE.read_text(encoding="utf-8")
    SURVIVORS_PAGE.write_text(placed(old, "survivors", listed), "utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
