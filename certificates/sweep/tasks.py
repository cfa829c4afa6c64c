"""Tasks shared by processes or by a cluster: one result a file, named by the hash of its task.

    FOLDER/HASH.json    {"task": {...}, "sha256": hash of the result, "result": {...}}

A file is written beside its place and renamed, so it is complete or absent.  A task whose file is
there is not computed again; a damaged file counts as absent.  The hash covers everything that the
result depends on, so a file of another model, law or release is never taken for this task's.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from takagi.certificates.document.certificate_file import provenance
from takagi.models.errors import ModelError

# To be increased where a function returns something else for the same inputs.
FORMAT = 1
RESULTS = "results"
# How often a pool of processes, or the way to a scheduler, is made anew in one command.
RENEWALS = 3

Result = dict[str, Any]
Tell = Callable[..., None]


@dataclass(frozen=True)
class Task:
    """One result to compute.

    Attributes
    ----------
    function : ``module:name`` of a function ``name(source, inputs) -> Result`` at the top of a
        module; the result is JSON without NaN.
    source : where the function finds its file; not part of the hash.
    inputs : everything that the result depends on, as JSON; of ``source`` its SHA-256.
    files : what a worker of a cluster needs to read ``source``, which is there the first of them,
        beside the others; not part of the hash.
    """

    function: str
    source: str
    inputs: Mapping[str, Any]
    files: tuple[Path, ...] = ()

    @cached_property
    def hashed(self) -> str:
        """What the hash covers, as JSON."""
        covered = {"format": FORMAT, "function": self.function, "inputs": self.inputs}
        return canonical({**covered, "versions": provenance({}, {})["versions"]})

    @property
    def file(self) -> str:
        """The name of the result's file."""
        return f"{_sha256(self.hashed)}.json"


def run_tasks(
    tasks: Sequence[Task],
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> tuple[list[Result], int]:
    """Return the results of all tasks, and how many were in the folder before.

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
    folder.mkdir(parents=True, exist_ok=True)
    results = {task.file: _stored(task, folder) for task in tasks}
    missing = [task for task in tasks if results[task.file] is None]
    resumed = len(tasks) - len(missing)
    if missing:
        _require_same_study(tasks, folder)
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
                tell(f"{ready} of {len(tasks)} results", ready / len(tasks))
    return [results[task.file] or {} for task in tasks], resumed


def canonical(value: Any) -> str:
    """Return JSON that is the same for the same value.

    Raises
    ------
    TypeError, ValueError : a value that JSON cannot represent, such as NaN or infinity.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _stored(task: Task, folder: Path) -> Result | None:
    """Return the result in the task's file; None if there is none, or if it is damaged."""
    try:
        content = json.loads((folder / task.file).read_text(encoding="utf-8"))
        result = content["result"]
        same = canonical(content["task"]) == task.hashed
        if same and content["sha256"] == _sha256(canonical(result)) and isinstance(result, dict):
            return result
    except (OSError, ValueError, TypeError, KeyError):
        # Whatever is there instead is replaced; what cannot be replaced is told at writing.
        return None
    return None


def _require_same_study(tasks: Sequence[Task], folder: Path) -> None:
    """Refuse a folder with a result of another function, or of another release or library."""
    ours, functions = {task.file for task in tasks}, {task.function for task in tasks}
    here = json.loads(tasks[0].hashed)["versions"]
    for path in sorted(folder.glob("*.json")):
        if path.name in ours:
            continue
        try:
            stated = json.loads(path.read_text(encoding="utf-8"))["task"]
            function, there = stated["function"], dict(stated["versions"])
        except (OSError, ValueError, TypeError, KeyError):
            continue
        if function not in functions:
            words = f"a result of another study ({function})"
        elif differing := version_differences(there, here):
            words = f"a result of other versions: {differing}"
        else:
            continue
        raise ModelError(
            f"{folder} has {words}; nothing of it can be used here: give another folder, or "
            "remove this one"
        )


def version_differences(there: Mapping[str, str], here: Mapping[str, str]) -> str:
    """Return which versions differ, in words; empty if none does."""
    return ", ".join(
        f"{name} {there.get(name, 'missing')} (here {here.get(name, 'missing')})"
        for name in dict.fromkeys((*here, *there))
        if there.get(name) != here.get(name)
    )


def store_result(task: Task, folder: Path, text: str) -> Result:
    """Write the result's file unless the result is an error; return the result as it is read."""
    result: Result = json.loads(text)
    if "error" in result:
        return result
    checksum = _sha256(canonical(result))
    content = f'{{"task":{task.hashed},"sha256":"{checksum}","result":{text}}}\n'
    with tempfile.TemporaryDirectory(prefix=".result-", dir=folder) as beside:
        with open(Path(beside) / task.file, "w", encoding="utf-8") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(file.name, folder / task.file)
    return result


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
    pool = ProcessPoolExecutor(workers, context, initializer=_start)
    try:
        waiting = {pool.submit(_work, task, folder): task.file for task in tasks}
        for future in as_completed(waiting):
            yield waiting[future], future.result()
    finally:
        # Not by ``with``: its second call would undo that waiting tasks are cancelled.
        pool.shutdown(cancel_futures=True)


def _work(task: Task, folder: Path) -> Result:
    # A process that was killed may have stored it before.
    return _stored(task, folder) or store_result(
        task, folder, result_text(task.function, task.source, task.inputs)
    )


def result_text(function: str, source: str, inputs: Mapping[str, Any]) -> str:
    """Return the result of a task as JSON; ``{"error": words}`` of what ended in an error."""
    try:
        module, _, name = function.partition(":")
        result = getattr(import_module(module), name)(source, inputs)
        return json.dumps(result, separators=(",", ":"), allow_nan=False)
    except Exception as error:
        return json.dumps({"error": f"{type(error).__name__}: {' '.join(str(error).split())}"})


def _start() -> None:
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
