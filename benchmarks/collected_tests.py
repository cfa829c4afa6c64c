"""A pytest session that collects tests and hands them over, warm, in place of running them."""

from __future__ import annotations

import io
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import pytest
from hypothesis import Phase, settings
from warm_tests import LONGEST, WarmTests

# Which tests are collected.
MARKS = "not slow and not tex and not coq"


def _short_report(item: pytest.Item, call: pytest.CallInfo[None]) -> pytest.TestReport:
    """Return how a step of a test went, without its source, its frames and its values."""
    when: Any = call.when or "call"
    outcome: Literal["passed", "failed", "skipped"] = "passed"
    if call.excinfo is not None:
        outcome = "skipped" if call.excinfo.errisinstance(pytest.skip.Exception) else "failed"
    return pytest.TestReport(item.nodeid, item.location, {}, outcome, None, when)


def with_tests(
    paths: Sequence[str],
    package: Path,
    place: Path,
    work: Callable[[WarmTests], None],
    longest: float = LONGEST,
    marks: str = MARKS,
) -> None:
    """Collect tests with pytest, and call ``work`` with them.

    Parameters
    ----------
    place : of the files of the run.
    longest : of a test that takes longer [s of the processor] only the lines until then are noted.
    marks : which tests, as pytest has it.
    """
    shutil.rmtree(place, ignore_errors=True)
    place.parent.mkdir(parents=True, exist_ok=True)

    class Session:
        @pytest.hookimpl(tryfirst=True)
        def pytest_collection(self) -> None:
            # Which example is the smallest that fails is of no interest here, and dear.
            quick = settings(settings(), phases=(Phase.explicit, Phase.generate))
            settings.register_profile("quick", quick)
            settings.load_profile("quick")

        @pytest.hookimpl(tryfirst=True)
        def pytest_runtest_makereport(
            self, item: pytest.Item, call: pytest.CallInfo[None]
        ) -> pytest.TestReport:
            return _short_report(item, call)

        @pytest.hookimpl(tryfirst=True)
        def pytest_runtestloop(self, session: pytest.Session) -> bool:
            if session.testsfailed:
                raise RuntimeError(f"{session.testsfailed} files of tests cannot be collected")
            hidden, sys.stdout = sys.stdout, shown
            try:
                work(WarmTests(session, package, longest))
            finally:
                sys.stdout = hidden
            return True

    options = ["-q", "-s", "-p", "no:cacheprovider", "-p", "no:xdist", f"--basetemp={place}"]
    # An assertion that fails shall only fail: to explain it takes longer than most tests do.
    options += ["--assert=plain", "-o", "tmp_path_retention_policy=none"]
    options += ["-m", marks]
    # pytest's own words are of no use here; what ``work`` prints is.
    shown, words = sys.stdout, io.StringIO()
    sys.stdout = words
    try:
        status = int(pytest.main([*paths, *options], plugins=[Session()]))
    finally:
        sys.stdout = shown
    if status not in (0, 5):
        raise RuntimeError(f"pytest ended with status {status}:\n{words.getvalue()}")
