"""Which lines of a package run, and an end to what runs for too long."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from coverage import Coverage

Lines = dict[str, set[int]]


class TooLong(BaseException):
    """A test or a shared fixture takes longer than a campaign allows; no test may catch it."""


@contextmanager
def interrupted(seconds: float) -> Iterator[list[str]]:
    """Raise TooLong in what runs inside when it has used this much of the processor [s].

    The list that is given has an entry then: pytest makes a failed test of the exception.
    """
    over: list[str] = []

    def end(number: int, frame: FrameType | None) -> None:
        if _within_coverage(frame):
            # It may hold its lock: a moment later it does not.
            signal.setitimer(signal.ITIMER_VIRTUAL, 0.001)
            return
        over.append("too long")
        raise TooLong(f"{seconds} s")

    before = signal.signal(signal.SIGVTALRM, end)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield over
    except TooLong:
        # It came between two tests' steps: the next one starts all the same.
        return
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def _within_coverage(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_globals.get("__name__", "").startswith("coverage."):
            return True
        frame = frame.f_back
    return False


class traced:
    """Collects the lines of a package that run inside a ``with`` statement, by file."""

    def __init__(self, package: Path) -> None:
        self.tracer = Coverage(data_file=None, config_file=False, include=[f"{package}/*"])
        # A test that runs no line of the package is no reason to warn.
        self.tracer.set_option("run:disable_warnings", ["no-data-collected"])
        self.lines: Lines = {}

    def __enter__(self) -> Lines:
        self.tracer.start()
        return self.lines

    def __exit__(self, *raised: object) -> None:
        self.tracer.stop()
        data = self.tracer.get_data()
        self.lines.update((path, set(data.lines(path) or ())) for path in data.measured_files())
