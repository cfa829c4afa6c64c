"""Progress on standard error, for work that takes over two seconds."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.progress import Progress

# tell(step) or tell(step, done): the step in words, and the part of the whole that is done, 0..1.
# Other packages take such a function as an argument; they do not depend on terminals.
Tell = Callable[..., None]

_PATIENCE = 2.0  # s; shorter work needs no bar


@contextmanager
def progress(
    title: str, *, stream: TextIO | None = None, patience: float = _PATIENCE
) -> Iterator[Tell]:
    """Yield ``tell(step, done=None)``; a bar appears once the work has taken ``patience`` seconds.

    Quiet when the stream (default: standard error) is not a terminal.  The bar is gone when the
    work ends, whether well or not: what remains on the terminal is the answer.
    """
    target = sys.stderr if stream is None else stream
    if not target.isatty():
        yield _tell_nobody
        return
    bar = _Bar(title, target)
    # A timer is used because a solver may run for a minute without reporting progress.
    timer = threading.Timer(patience, bar.show)
    timer.daemon = True
    timer.start()
    try:
        yield bar.tell
    finally:
        timer.cancel()
        bar.close()


def _tell_nobody(step: str, done: float | None = None) -> None:
    """Take a report of progress when there is no terminal to show it on."""


class _Bar:
    """A rich bar that is made late; the timer's thread and the worker's share it under a lock."""

    def __init__(self, title: str, stream: TextIO) -> None:
        self._title, self._stream = title, stream
        self._step = ""
        self._done: float | None = None
        self._shown: Progress | None = None
        self._closed = False
        self._lock = threading.Lock()

    def tell(self, step: str, done: float | None = None) -> None:
        with self._lock:
            self._step, self._done = step, done
            if self._shown is not None:
                self._update(self._shown)

    def show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        with self._lock:
            if self._closed:
                return
            self._shown = Progress(
                SpinnerColumn(),
                TextColumn("{task.description}"),
                BarColumn(bar_width=24),
                TimeElapsedColumn(),
                console=Console(file=self._stream),
                transient=True,
            )
            self._shown.add_task(self._title, total=None)
            self._update(self._shown)
            self._shown.start()

    def close(self) -> None:
        with self._lock:
            self._closed = True
            if self._shown is not None:
                self._shown.stop()

    def _update(self, shown: Progress) -> None:
        text = f"{self._title}: {self._step}" if self._step else self._title
        total = None if self._done is None else 1.0
        shown.update(shown.task_ids[0], description=text, total=total, completed=self._done or 0.0)
