"""The tests, collected once in a warm process, and run in copies of it.

pytest imports the tests and makes the fixtures that more than one test shares.  Every run after
that is a copy of this process (``os.fork``), which costs milliseconds: to see which lines of the
checker a test runs and how long it takes, or to run tests with other code in the place of the
checker's functions until one fails.

A fixture that is made once is made by the code as it is.  Where a changed line ran in such a
fixture, it is made anew in the copy.
"""

from __future__ import annotations

import functools
import gc
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import pytest
from _pytest.fixtures import FixtureDef
from _pytest.runner import runtestprotocol
from process_copies import copy, limit_memory, limit_seconds
from shared_fixtures import Recorder, kept, name_of, shared
from traced_lines import Lines, interrupted, traced

# A test that takes this many times as long as before, and this much longer [s of the processor],
# does not end; one that waits this long [s] neither.
TIMES_SLOWER, SECONDS_SLOWER, SECONDS_SILENT = 4.0, 0.7, 200.0
# Of a test that takes longer than this [s of the processor], or than is asked for, only the lines
# until then are noted, and this is taken to be its time.
LONGEST, TIME_OF_LONGER = 0.3, 1.5
# And those whose shared fixtures do.
LONGEST_FIXTURE = 15.0
# What making shared fixtures anew may take on top [s of the processor].
SECONDS_FIXTURES = 60.0


class Run(NamedTuple):
    """How a test ran: whether it passed, its time [s], and the lines of the checker that it ran."""

    passed: bool
    seconds: float
    lines: Lines


class Outcome(NamedTuple):
    """What a broken line did: the test that noticed it, or "", how, and how many tests ran."""

    test: str
    how: str
    ran: int


class WarmTests:
    """The collected tests of a pytest session and its shared fixtures."""

    def __init__(self, session: pytest.Session, package: Path, longest: float) -> None:
        self.package, self.longest = package, longest
        self.items = {item.nodeid: item for item in session.items}
        self.fixtures: dict[str, tuple[FixtureDef[Any], set[str]]] = {}
        for nodeid, item in self.items.items():
            for definition in shared(item):
                self.fixtures.setdefault(name_of(definition), (definition, set()))[1].add(nodeid)
        self.fixture_lines: dict[str, Lines] = {}
        self.dear: set[str] = set()
        self._all_items = session.items
        self._functions: dict[tuple[str, str, int], list[FunctionType]] = {}
        self._caches: list[Any] = []

    # -------------------------------------------------------------- shared fixtures

    def make_fixtures(
        self, seconds: dict[str, float], *, traced: bool, dear: Iterable[str] = ()
    ) -> None:
        """Make every shared fixture by running the quickest test that asks for it.

        Those in ``dear`` take too long and are left out; others that do are noted there.
        """
        self.dear |= set(dear)
        FixtureDef.finish = kept(FixtureDef.finish)  # type: ignore[method-assign]
        if traced:
            recorder = Recorder(self.package, self.fixtures)
            self._all_items[0].session.config.pluginmanager.register(recorder)
        for name, (definition, nodeids) in self.fixtures.items():
            if definition.cached_result is None and name not in self.dear:
                nodeid = min(nodeids, key=lambda n: (seconds.get(n, 0.0), n))
                with interrupted(LONGEST_FIXTURE) as over:
                    self._run(self.items[nodeid])
                if over:
                    self.dear.add(name)
        if traced:
            self._all_items[0].session.config.pluginmanager.unregister(recorder)
            self.fixture_lines |= recorder.lines
        # The tests' conftest freezes what was collected; the search sees what is not frozen alone.
        gc.unfreeze()
        gc.collect()
        for found in gc.get_objects():
            if isinstance(found, FunctionType) and _inside(found.__code__, self.package):
                self._functions.setdefault(_place(found.__code__), []).append(found)
            elif isinstance(found, functools._lru_cache_wrapper):
                self._caches.append(found)
        # Copies share what is not touched: the collector shall not touch it either.
        gc.freeze()

    def _run(self, item: pytest.Item) -> bool:
        """Run one test as if it were the last, so that any other one may follow."""
        reports = runtestprotocol(item, log=False, nextitem=None)
        return not any(report.failed for report in reports)

    def fixtures_of(self, nodeid: str) -> list[str]:
        """Return the shared fixtures that a test asks for."""
        return [name for name, (_, nodeids) in self.fixtures.items() if nodeid in nodeids]

    # -------------------------------------------------------------- lines of a test

    def runs_of(self, names: Sequence[str]) -> Iterator[tuple[str, Run]]:
        """Yield (test, how it runs); a copy runs tests until one fails or takes too long."""
        left = list(names)
        while left:
            done = 0
            for said in copy(partial(self._measured, left), SECONDS_SILENT):
                if "passed" in said:
                    lines = {path: set(found) for path, found in said["lines"].items()}
                    yield left[done], Run(said["passed"], said["seconds"], lines)
                    done += 1
            if not done:
                yield left[0], Run(False, TIME_OF_LONGER, {})
                done = 1
            left = left[done:]

    def _measured(self, names: Sequence[str], say: Callable[[Any], None]) -> None:
        for nodeid in names:
            self._clear_caches("takagi.", "tests.")
            passed, spent = False, TIME_OF_LONGER
            limit_seconds(self.longest + TIME_OF_LONGER)
            with traced(self.package) as lines, interrupted(self.longest) as over:
                began = time.process_time()
                passed = self._run(self.items[nodeid])
                spent = time.process_time() - began
            say(
                {
                    "passed": passed or bool(over),
                    "seconds": TIME_OF_LONGER if over else spent,
                    "lines": {path: sorted(found) for path, found in lines.items()},
                }
            )
            if over or not passed:
                return

    # -------------------------------------------------------------- broken code

    def outcome(
        self,
        code: CodeType,
        tests: Sequence[str],
        seconds: dict[str, float],
        again: Iterable[str] = (),
    ) -> Outcome:
        """Run tests with other code in the functions of one module, until one fails.

        Parameters
        ----------
        code : the compiled module.
        seconds : how long each test takes, by name.
        again : shared fixtures that must be made anew.
        """
        anew = self._with_dependents(again)

        def work(say: Callable[[Any], None]) -> None:
            limit_memory()
            gc.disable()
            self._put(code)
            self._clear_caches("takagi.", *(("tests.",) if anew else ()))
            for definition in anew:
                definition.cached_result = None
                definition._finalizers.clear()
            for number, nodeid in enumerate(tests):
                say({"starts": number})
                longest = TIMES_SLOWER * seconds.get(nodeid, 1.0) + SECONDS_SLOWER
                limit_seconds(longest + (SECONDS_FIXTURES if anew else 0.0))
                if not self._run(self.items[nodeid]):
                    say({"failed": number})
                    return
            say({"passed": True})

        current, latest = 0, {"ended": True}
        for said in copy(work, SECONDS_SILENT):
            current, latest = said.get("starts", current), said
        if "passed" in latest:
            return Outcome("", "", len(tests))
        how = "fails" if "failed" in latest else "does not end"
        return Outcome(tests[current], how, current + 1)

    def outcomes(
        self, jobs: Sequence[tuple[CodeType, Sequence[str]]], seconds: dict[str, float]
    ) -> Iterator[tuple[int, Outcome]]:
        """Yield (number of the job, outcome) for broken codes with their tests, many in one copy.

        What one change leaves behind could make a test of the next one fail.  So the copy runs
        every test that has failed once more, with the code as it is: where one fails still, its
        changes are tried again, each in a copy of its own.
        """
        for code, _ in jobs:
            if not any(_place(found) in self._functions for found in _codes(code)):
                raise RuntimeError(
                    f"{code.co_filename} is not imported: nothing can be broken there"
                )
        left = list(range(len(jobs)))
        while left:
            failed: dict[int, int] = {}
            sound: set[str] | None
            job, test, sound = left[0], 0, None
            for said in copy(partial(self._several, jobs, left, seconds), SECONDS_SILENT):
                if "job" in said:
                    job, test = said["job"], 0
                test = said.get("starts", test)
                if "survives" in said:
                    left.remove(job)
                    yield job, Outcome("", "", len(jobs[job][1]))
                elif "failed" in said:
                    failed[job] = said["failed"]
                elif "sound" in said:
                    sound = set(said["sound"])
            if sound is None:
                # Those that have failed before it are tried again, for they were not confirmed.
                left.remove(job)
                yield job, Outcome(jobs[job][1][test], "does not end", test + 1)
                continue
            for number, last_run in failed.items():
                code, tests = jobs[number]
                left.remove(number)
                if tests[last_run] in sound:
                    yield number, Outcome(tests[last_run], "fails", last_run + 1)
                else:
                    yield number, self.outcome(code, tests, seconds)

    def _several(
        self,
        jobs: Sequence[tuple[CodeType, Sequence[str]]],
        numbers: Sequence[int],
        seconds: dict[str, float],
        say: Callable[[Any], None],
    ) -> None:
        """Be the copy that tries some jobs: say which begins, how it ends, and what still fails."""
        limit_memory()
        gc.disable()
        suspects: set[str] = set()
        for job in list(numbers):
            code, tests = jobs[job]
            say({"job": job})
            before = self._put(code)
            self._clear_caches("takagi.", "tests.")
            for number, nodeid in enumerate(tests):
                say({"starts": number})
                limit_seconds(TIMES_SLOWER * seconds.get(nodeid, 1.0) + SECONDS_SLOWER)
                if not self._run(self.items[nodeid]):
                    suspects.add(nodeid)
                    say({"failed": number})
                    break
            else:
                say({"survives": True})
            for function, own in before:
                function.__code__ = own
        self._clear_caches("takagi.", "tests.")
        sound: list[str] = []
        say({"sound": sound})
        for nodeid in sorted(suspects):
            limit_seconds(TIMES_SLOWER * seconds.get(nodeid, 1.0) + SECONDS_SLOWER)
            if self._run(self.items[nodeid]):
                sound.append(nodeid)
                say({"sound": sound})

    def _with_dependents(self, names: Iterable[str]) -> list[FixtureDef[Any]]:
        """Return shared fixtures, and those that are made of them."""
        found = {self.fixtures[name][0].argname: self.fixtures[name][0] for name in names}
        while True:
            more = {
                definition.argname: definition
                for definition, _ in self.fixtures.values()
                if definition.argname not in found and set(definition.argnames) & found.keys()
            }
            if not more:
                return list(found.values())
            found |= more

    def _put(self, code: CodeType) -> list[tuple[FunctionType, CodeType]]:
        """Give every live function the code that a module's own code has for it; return the old."""
        before: list[tuple[FunctionType, CodeType]] = []
        for found in _codes(code):
            for function in self._functions.get(_place(found), ()):
                if len(found.co_freevars) == len(function.__code__.co_freevars):
                    before.append((function, function.__code__))
                    function.__code__ = found
        return before

    def _clear_caches(self, *packages: str) -> None:
        """Forget what functions of these packages have remembered."""
        for cache in self._caches:
            if (getattr(cache, "__module__", "") or "").startswith(packages):
                cache.cache_clear()


# ------------------------------------------------------------------ code in its place


def _inside(code: CodeType, package: Path) -> bool:
    return _file(code.co_filename).startswith(f"{package}/")


def _place(code: CodeType) -> tuple[str, str, int]:
    return _file(code.co_filename), code.co_qualname, code.co_firstlineno


@functools.cache
def _file(name: str) -> str:
    """Return a file's own path: a package may be imported through a link."""
    return os.path.realpath(name)


def _codes(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes(constant)
