"""A limit on the time of all solver calls of a block, passed down to each of them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from takagi.lmi.argument_checks import positive_number


@dataclass(slots=True)
class Budget:
    """When the solver calls of a block end, and whether one was stopped or not made for that."""

    ends: float
    stopped: bool = False


_budget: ContextVar[Budget | None] = ContextVar("time limit of solver calls", default=None)


@contextmanager
def time_limit(seconds: float) -> Iterator[Budget]:
    """Limit all solver calls in the block: ``with time_limit(60) as budget: design = pdc(model)``.

    When the time is over, answers are "unknown", or the best that was found by then, and
    ``budget.stopped`` is true.  A block in another one ends with it.  The limit is that of the
    thread, or task, that opened it.

    Raises ModelError: no positive number of seconds.
    """
    ends = time.perf_counter() + positive_number("time_limit", seconds)
    outer = _budget.get()
    budget = Budget(ends if outer is None else min(ends, outer.ends))
    token = _budget.set(budget)
    try:
        yield budget
    finally:
        _budget.reset(token)
        if outer is not None:
            outer.stopped |= budget.stopped


def remaining() -> float | None:
    """Return how many seconds a solver may take, at least 0; None without a limit."""
    budget = _budget.get()
    return None if budget is None else max(0.0, budget.ends - time.perf_counter())


def stopped() -> None:
    """Note that a solver was stopped by the limit, or not called because of it."""
    budget = _budget.get()
    if budget is not None:
        budget.stopped = True


def out_of_time() -> bool:
    """Return whether nothing is left, and note it if so."""
    if remaining() != 0.0:
        return False
    stopped()
    return True
