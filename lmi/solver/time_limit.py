"""A limit on the time of all solver calls of one question, passed down to each of them.

``limited`` opens a budget for the call of a public function that takes ``time_limit``, and notes
whether it was exceeded; ``remaining`` gives the seconds that are left for a solver. A limited
function that is called inside another one shares its budget.  The budget belongs to the thread, or
task, that opened it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, is_dataclass, replace
from functools import wraps
from typing import Any, ParamSpec, TypeVar, cast

from takagi.lmi.argument_checks import number
from takagi.models.errors import ModelError

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(slots=True)
class _Budget:
    """Seconds for all solver calls, when they end, and whether one was stopped."""

    seconds: float
    ends: float
    stopped: bool = False


_budget: ContextVar[_Budget | None] = ContextVar("time limit of solver calls", default=None)


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


def limited(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function within the budget of its keyword ``time_limit`` [s]; None for none.

    An answer that is "unknown" after a solver was stopped says so in its diagnosis.
    """

    @wraps(function)
    def within(*args: P.args, **kwargs: P.kwargs) -> R:
        time_limit = kwargs.get("time_limit")
        if time_limit is None:
            return function(*args, **kwargs)
        seconds = float(number("time_limit", cast(float, time_limit)))
        if seconds <= 0:
            raise ModelError(f"time_limit is {seconds:g}; a positive number of seconds is needed")
        seconds_left = remaining()
        allowed = seconds if seconds_left is None else min(seconds, seconds_left)
        budget = _Budget(seconds, time.perf_counter() + allowed)
        token = _budget.set(budget)
        try:
            result = function(*args, **kwargs)
        finally:
            _budget.reset(token)
        if not budget.stopped:
            return result
        if seconds_left is not None:
            stopped()
        return cast(R, _told(result, seconds))

    return within


def _told(result: Any, seconds: float) -> Any:
    """Return an answer, or a value that holds one, whose diagnosis says why it is unknown."""
    words = f"stopped by the time limit of {seconds:g} s before it was settled"
    for field in ("diagnosis", "reason"):
        if is_dataclass(result) and hasattr(result, field):
            if getattr(result, "status", "") != "unknown":
                return result
            earlier = str(getattr(result, field))
            return replace(
                cast(Any, result), **{field: f"{words}; {earlier}" if earlier else words}
            )
    if is_dataclass(result) and hasattr(result, "answer"):
        return replace(cast(Any, result), answer=_told(cast(Any, result).answer, seconds))
    return result
