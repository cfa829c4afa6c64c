"""Computes the points of a map that are not in its journal yet, in one process or several."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from takagi.certificates.sweep.grid import (
    FAILED,
    UNDECIDED,
    PointResult,
    SweepMap,
    SweepResult,
    Task,
    canonical,
)
from takagi.certificates.sweep.journal import Journal
from takagi.certificates.sweep.sending import received, sent
from takagi.models.errors import ModelError

Place = tuple[float, ...]
Made = tuple[Place, dict[str, Any], float]
Tell = Callable[..., None]

# Environment variables that keep libraries from starting their own threads in each process.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def default_workers() -> int:
    """Return the number of cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_sweep(
    swept: SweepMap, folder: Path, *, workers: int | None = None, tell: Tell | None = None
) -> SweepResult:
    """Return all points of a map; those in the folder's journal are not computed again.

    Every point is on disk before the next is counted, so a sweep that was stopped at any time can
    be continued.

    Parameters
    ----------
    workers : processes; None takes the cores, 1 computes all points in this process.  A process is
        a fresh interpreter, so a script that calls this needs ``if __name__ == "__main__":``.
    tell : called as ``tell(words, share done)`` after each point.

    Raises
    ------
    ModelError : fewer than one worker; a process that was killed from outside.
    JournalError : the folder holds the journal of another sweep, or a damaged one.
    OSError : the journal cannot be written.
    """
    count = default_workers() if workers is None else workers
    if count < 1:
        raise ModelError(f"workers = {count} was given; at least 1 is needed")
    # The comparison map first: it is one point, and its errors should be known early.
    beside = tuple(
        run_sweep(other, folder / other.name, workers=1, tell=tell) for other in swept.beside
    )
    places = swept.places
    with Journal(folder, swept) as journal:
        missing = [place for place in places if place not in journal.done]
        clock = _Clock(swept.name, len(places), len(missing), tell or _tell_nobody)
        for place, result, seconds in _made(swept, missing, min(count, len(missing))):
            journal.add(place, result, seconds)
            clock.step()
        points = tuple(PointResult(swept.at(place), *journal.done[place]) for place in places)
    return SweepResult(swept, points, len(places) - len(missing), beside)


def _tell_nobody(words: str, done: float | None = None) -> None:
    """Ignore a progress report."""


class _Clock:
    """Counts points, and reports how long the rest will take at the present speed."""

    def __init__(self, name: str, total: int, missing: int, tell: Tell) -> None:
        self._name, self._total, self._missing, self._tell = name, total, missing, tell
        self._made, self._started = 0, time.monotonic()
        self._say("")

    def step(self) -> None:
        self._made += 1
        pace = (time.monotonic() - self._started) / self._made
        self._say(f", {_span(pace * (self._missing - self._made))} left")

    def _say(self, left: str) -> None:
        done = self._total - self._missing + self._made
        words = f"{self._name}, {done} of {self._total} points{left}"
        self._tell(words, done / max(self._total, 1))


def _span(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


# ---------------------------------------------------------------------- in one process or several
def _made(swept: SweepMap, places: list[Place], workers: int) -> Iterator[Made]:
    if workers <= 1:
        prepared = _prepared(swept) if places else None
        for place in places:
            yield _evaluated(swept, prepared, place)
        return
    # A fresh process, not a copy of this one: a copy would inherit the locks of its threads.
    context = multiprocessing.get_context("spawn")
    before = set(multiprocessing.active_children())
    with _one_thread_each():
        pool = ProcessPoolExecutor(workers, context, initializer=_start, initargs=(sent(swept),))
        try:
            yield from _collected(pool, places)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in set(multiprocessing.active_children()) - before:
                child.terminate()
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _collected(pool: ProcessPoolExecutor, places: Iterable[Place]) -> Iterator[Made]:
    try:
        for future in as_completed([pool.submit(_work, place) for place in places]):
            yield future.result()
    except BrokenProcessPool as error:
        raise ModelError(
            "a process of the sweep was killed from outside, perhaps for want of memory; what is "
            "finished is in the journal. Run the same again, with fewer --workers"
        ) from error


@contextmanager
def _one_thread_each() -> Iterator[None]:
    added = [name for name in _ONE_THREAD if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


# ---------------------------------------------------------------------- inside a process
class _Process:
    """What one process of a sweep keeps between points."""

    swept: SweepMap | None = None
    prepared: Any = None
    ready = False


def _start(data: bytes) -> None:
    """Receive the map, once per process; the parent handles interrupts, and ends this process."""
    _Process.swept = received(data)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work(place: Place) -> Made:
    swept = _Process.swept
    if swept is None:
        raise RuntimeError("the process was not started by a sweep")
    if not _Process.ready:
        # This is not done in _start, because an exception raised there is lost.
        _Process.prepared, _Process.ready = _prepared(swept), True
    return _evaluated(swept, _Process.prepared, place)


def _prepared(swept: SweepMap) -> Any:
    if swept.prepare is None:
        return swept.shared
    return swept.prepare(swept.settings, swept.shared)


def _evaluated(swept: SweepMap, prepared: Any, place: Place) -> Made:
    started = time.perf_counter()
    try:
        result = swept.point(Task(swept.at(place), swept.settings, prepared))
        # A value that JSON cannot represent must fail here, at its point, not in the journal.
        canonical(result)
    except ModelError as error:
        result = {"verdict": UNDECIDED, "reason": str(error)}
    except Exception as error:
        words = " ".join(str(error).split())
        result = {"verdict": FAILED, "reason": f"{type(error).__name__}: {words}"}
    return place, result, time.perf_counter() - started
