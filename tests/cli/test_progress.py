"""Progress is for a waiting person: silent for scripts, silent for short work, gone at the end."""

from __future__ import annotations

import io
import threading

from takagi.cli.progress import progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal, and tells when something was written to it."""

    def __init__(self) -> None:
        super().__init__()
        self.written = threading.Event()

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.written.set()
        return super().write(text)


def test_quiet_when_not_a_terminal() -> None:
    """A log file gets no bar, however long the work."""
    stream = io.StringIO()

    with progress("Design", stream=stream, patience=0.0) as tell:
        tell("gains", 0.5)

    assert stream.getvalue() == ""


def test_quiet_when_the_work_is_short() -> None:
    """What ends before the patience does shows nothing."""
    stream = Terminal()

    with progress("Design", stream=stream, patience=3600.0) as tell:
        tell("gains")

    assert stream.getvalue() == ""


def test_a_bar_appears_though_the_work_tells_nothing() -> None:
    """A solver calls nobody for a minute; the bar must come all the same."""
    stream = Terminal()

    with progress("Design", stream=stream, patience=0.0) as tell:
        tell("region 2", 0.25)
        assert stream.written.wait(timeout=10.0)

    assert "Design: region 2" in stream.getvalue()
