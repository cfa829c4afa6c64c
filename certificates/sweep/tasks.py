"""Tasks shared by processes or by a cluster; their results are kept in a store."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from pathlib import Path

from takagi.certificates.sweep.store import (
    Result,
    Task,
    require_same_study,
    result_text,
    store_result,
    stored_result,
)
from takagi.models.errors import ModelError

# How often a pool of processes is made anew in one command.
RENEWALS = 3

Tell = Callable[..., None]


def run_tasks(
    tasks: Sequence[Task],
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> tuple[list[Result], int]:
    """Return the results of all tasks, and how many were in the folder before.

    A task that is given several times is computed once, and counts once.

    A task that ended in an unforeseen error has the result ``{"error": words}``, which is not
    stored: the task is computed again next time.

    Parameters
    ----------
    workers : processes; None takes the cores, 1 computes in this process.  Each is a fresh
        interpreter, so a script that calls this needs ``if __name__ == "__main__":``.
    scheduler : address of a Dask scheduler, whose workers compute in place of processes here.
    tell : called as ``tell(words, share done)``.

    Raises
    ------
    ModelError : fewer than one worker; workers and a scheduler; a cluster that is not there or is
        of other versions; results of another study or of other versions in the folder; processes
        that are killed again and again.
    OSError : a result cannot be written.
    """
    count = cores() if workers is None else workers
    if count < 1:
        raise ModelError(f"--workers {count} was given; at least 1 is needed")
    if scheduler is not None and workers is not None:
        raise ModelError(
            f"--workers {workers} and --scheduler {scheduler} were given; the workers of a "
            "scheduler are started beside it: leave --workers out"
        )
    results = {task.file: stored_result(task, folder) for task in tasks}
    missing = [
        task for file, task in {task.file: task for task in tasks}.items() if results[file] is None
    ]
    resumed = len(results) - len(missing)
    if missing:
        require_same_study(tasks, folder)
    if missing and scheduler is not None:
        # Imported here: only a cluster needs it.
        from takagi.certificates.sweep.cluster import computed_by_cluster

        computing = computed_by_cluster(missing, folder, scheduler)
    else:
        computing = _computed(missing, folder, min(count, len(missing)))
    # Closed also if an interrupt comes between two results: the tasks that wait are dropped then.
    with closing(computing) as computed:
        for number, (file, result) in enumerate(computed, start=1):
            results[file] = result
            if tell is not None:
                ready = resumed + number
                tell(f"{ready} of {len(results)} results", ready / len(results))
    return [results[task.file] or {} for task in tasks], resumed


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _computed(
    tasks: Sequence[Task], folder: Path, workers: int
) -> Generator[tuple[str, Result], None, None]:
    """Yield file name and result of each task as it is finished.

    A process that is killed ends its pool: what was not finished goes to another one.
    """
    if workers <= 1:
        yield from ((task.file, _work(task, folder)) for task in tasks)
        return
    missing = {task.file: task for task in tasks}
    for renewals in range(RENEWALS + 1):
        try:
            for file, result in _of_pool(list(missing.values()), folder, workers):
                del missing[file]
                yield file, result
            return
        except BrokenProcessPool as error:
            if renewals == RENEWALS:
                raise ModelError(
                    f"processes were killed from outside {renewals + 1} times, perhaps for want of "
                    f"memory; what is finished is kept in {folder}. Run the same command again, "
                    "with fewer --workers if it happens again"
                ) from error


def _of_pool(
    tasks: Sequence[Task], folder: Path, workers: int
) -> Generator[tuple[str, Result], None, None]:
    # A fresh interpreter, not a copy of this one: a copy would inherit the locks of its threads.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=start_process)
    try:
        waiting = {pool.submit(_work, task, folder): task.file for task in tasks}
        for future in as_completed(waiting):
            yield waiting[future], future.result()
    finally:
        # Not by ``with``: its second call would undo that waiting tasks are cancelled.
        pool.shutdown(cancel_futures=True)


def _work(task: Task, folder: Path) -> Result:
    # A process that was killed may have stored it before.
    return stored_result(task, folder) or store_result(
        task, folder, result_text(task.function, task.source, task.inputs)
    )


def start_process() -> None:
    """Prepare a new process: one thread for linear algebra, and it ends with its parent."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Ctrl-C reaches the parent too, which says what is kept.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
