"""Measures and reports the time of each step of a design."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Tell = Callable[[str], None]


class StepClock:
    """The time of each step: ``seconds``, step -> time [s]; repeated steps are summed."""

    def __init__(self, tell: Tell | None) -> None:
        self._tell = tell
        self.seconds: dict[str, float] = {}

    def told(self, words: str) -> None:
        """Report a part of a step."""
        if self._tell is not None:
            self._tell(words)

    @contextmanager
    def __call__(self, step: str) -> Iterator[None]:
        """Report a step, and record its duration."""
        self.told(step)
        started = time.perf_counter()
        yield
        self.seconds[step] = self.seconds.get(step, 0.0) + time.perf_counter() - started
