"""Progress on standard error, for work that takes over two seconds."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from statistics import median_high
from typing import TYPE_CHECKING, NamedTuple, TextIO

if TYPE_CHECKING:
    from rich.progress import Progress

# tell(step) or tell(step, done): the step in words, and the part of the whole that is done, 0..1.
# Other packages take such a function as an argument; they do not depend on terminals.
Tell = Callable[..., None]

_PATIENCE = 2.0  # s; shorter work needs no bar
_TELLING = 0.5  # s; the pace of a shorter step says little
_EARLIEST = 4.0  # s; before that a time remaining would be a guess


class Step(NamedTuple):
    """A step of a long work: how its words begin, and what it usually takes on one core [s].

    ``varies``: its time depends on the model, so that nothing is said of the time remaining before
    it has ended.
    """

    words: str
    seconds: float
    varies: bool = False


class StepLine:
    """The step at work, the share that is done, and about how long the others take."""

    def __init__(self, steps: Sequence[Step], now: Callable[[], float] = time.monotonic) -> None:
        self._steps, self._now = list(steps), now
        self._started = self._entered = now()
        self._k, self._words = -1, ""
        # Time taken over time expected, of the steps done.
        self._paces: list[float] = []

    def tell(self, words: str) -> None:
        """Take a report; it begins a later step if it has the words of one."""
        following = range(self._k + 1, len(self._steps))
        k = next((k for k in following if words.startswith(self._steps[k].words)), None)
        if k is not None:
            ended, taken = self._steps[self._k], self._now() - self._entered
            if self._k >= 0 and taken and not ended.varies and ended.seconds >= _TELLING:
                self._paces.append(taken / ended.seconds)
            self._k, self._entered = k, self._now()
        self._words = words

    def __str__(self) -> str:
        """Return a line such as ``"3 of 6  gains  45 %  about 12 s left"``.

        No time where nothing honest can be said of it.
        """
        if self._k < 0:
            return self._words
        now, (step, *later) = self._now(), self._steps[self._k :]
        spent, pace = now - self._entered, median_high(self._paces or [1.0])
        total, before = (
            sum(s.seconds for s in part) for part in (self._steps, self._steps[: self._k])
        )
        # A step alone never fills its part.
        share = (before + min(spent / pace, 0.95 * step.seconds)) / total
        parts = [f"{self._k + 1} of {len(self._steps)}", self._words, f"{100 * share:.0f} %"]
        varies = any(s.varies for s in (step, *later))
        # A step that takes longer than expected makes the expectation worthless.
        late = spent > step.seconds * pace
        if self._paces and now - self._started >= _EARLIEST and not varies and not late:
            left = pace * (step.seconds + sum(s.seconds for s in later)) - spent
            parts.append(f"about {_in_words(left)} left")
        return "  ".join(parts)


def _in_words(seconds: float) -> str:
    """Return a time to about a tenth of it."""
    if seconds < 20:
        return f"{max(round(seconds), 1)} s"
    return f"{round(seconds / 10) * 10} s" if seconds < 90 else f"{round(seconds / 60)} min"


@contextmanager
def progress(
    title: str,
    *,
    line: StepLine | None = None,
    stream: TextIO | None = None,
    patience: float = _PATIENCE,
) -> Iterator[Tell]:
    """Yield ``tell(step, done=None)``; a bar appears once the work has taken ``patience`` seconds.

    With ``line`` the bar counts its steps; several bars, one after the other, may have one line.

    Quiet when the stream (default: standard error) is not a terminal.  The bar is gone when the
    work ends, whether well or not: what remains on the terminal is the answer.
    """
    target = sys.stderr if stream is None else stream
    if not target.isatty():
        yield lambda step, done=None: None
        return
    bar = _Bar(title, target, line)
    # A timer is used because a solver may run for a minute without reporting progress.
    timer = threading.Timer(patience, bar.show)
    timer.daemon = True
    timer.start()
    try:
        yield bar.tell
    finally:
        timer.cancel()
        bar.close()


class _Bar:
    """A rich bar that is made late; the timer's thread and the worker's share it under a lock."""

    def __init__(self, title: str, stream: TextIO, line: StepLine | None) -> None:
        self._title, self._stream, self._line = title, stream, line
        self._step = ""
        self._done: float | None = None
        self._shown: Progress | None = None
        self._closed = False
        self._lock = threading.Lock()

    def tell(self, step: str, done: float | None = None) -> None:
        with self._lock:
            self._step, self._done = step, done
            if self._line is not None:
                self._line.tell(step)
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
                TextColumn("{task.description}", markup=False),
                # The line becomes text whenever the bar is drawn: time passes within a step.
                BarColumn(bar_width=24)
                if self._line is None
                else TextColumn("{task.fields[line]}", markup=False),
                TimeElapsedColumn(),
                console=Console(file=self._stream),
                transient=True,
            )
            self._shown.add_task(self._title, total=None, line=self._line or "")
            self._update(self._shown)
            self._shown.start()

    def close(self) -> None:
        with self._lock:
            self._closed = True
            if self._shown is not None:
                self._shown.stop()

    def _update(self, shown: Progress) -> None:
        named = self._step and self._line is None
        text = f"{self._title}: {self._step}" if named else self._title
        total = None if self._done is None else 1.0
        shown.update(shown.task_ids[0], description=text, total=total, completed=self._done or 0.0)
