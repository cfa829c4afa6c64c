"""Tasks shared by several processes: one result a file, named by the hash of its task.

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
    """

    function: str
    source: str
    inputs: Mapping[str, Any]

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
    tasks: Sequence[Task], folder: Path, *, workers: int | None = None, tell: Tell | None = None
) -> tuple[list[Result], int]:
    """Return the results of all tasks, and how many were in the folder before.

    A task that ended in an unforeseen error has the result ``{"error": words}``, which is not
    stored: the task is computed again next time.

    Parameters
    ----------
    workers : processes; None takes the cores, 1 computes in this process.  Each is a fresh
        interpreter, so a script that calls this needs ``if __name__ == "__main__":``.
    tell : called as ``tell(words, share done)``.

    Raises
    ------
    ModelError : fewer than one worker, or a process that was killed from outside.
    OSError : a result cannot be written.
    """
    count = cores() if workers is None else workers
    if count < 1:
        raise ModelError(f"--workers {count} was given; at least 1 is needed")
    folder.mkdir(parents=True, exist_ok=True)
    results = {task.file: _stored(task, folder) for task in tasks}
    missing = [task for task in tasks if results[task.file] is None]
    resumed = len(tasks) - len(missing)
    # Closed also if an interrupt comes between two results: the tasks that wait are dropped then.
    with closing(_computed(missing, folder, min(count, len(missing)))) as computed:
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


def _store(task: Task, folder: Path, result: str) -> None:
    checksum = _sha256(canonical(json.loads(result)))
    text = f'{{"task":{task.hashed},"sha256":"{checksum}","result":{result}}}\n'
    with tempfile.TemporaryDirectory(prefix=".result-", dir=folder) as beside:
        with open(Path(beside) / task.file, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(file.name, folder / task.file)


def _computed(
    tasks: Sequence[Task], folder: Path, workers: int
) -> Generator[tuple[str, Result], None, None]:
    """Yield file name and result of each task as it is finished."""
    if workers <= 1:
        yield from ((task.file, _work(task, folder)) for task in tasks)
        return
    # A fresh interpreter, not a copy of this one: a copy would inherit the locks of its threads.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=_start)
    try:
        waiting = {pool.submit(_work, task, folder): task.file for task in tasks}
        for future in as_completed(waiting):
            yield waiting[future], future.result()
    except BrokenProcessPool as error:
        raise ModelError(
            f"a process was killed from outside, perhaps for want of memory; what is finished is "
            f"kept in {folder}. Run the same command again, with fewer --workers if it happens "
            "again"
        ) from error
    finally:
        # Not by ``with``: its second call would undo that waiting tasks are cancelled.
        pool.shutdown(cancel_futures=True)


def _work(task: Task, folder: Path) -> Result:
    try:
        module, _, name = task.function.partition(":")
        result = getattr(import_module(module), name)(task.source, task.inputs)
        text = json.dumps(result, separators=(",", ":"), allow_nan=False)
    except Exception as error:
        return {"error": f"{type(error).__name__}: {' '.join(str(error).split())}"}
    _store(task, folder, text)
    # As it is read when the tasks are resumed.
    read: Result = json.loads(text)
    return read


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
