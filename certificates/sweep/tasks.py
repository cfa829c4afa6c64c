"""Tasks shared by processes or a Dask cluster, through joblib; each finished one is a file.

    FOLDER/HASH.json    {"task": {...}, "sha256": hash of the result, "result": {...}}

The hash covers everything that the result depends on, so a file of another model, law or release is
never taken for this task's.  A file is written beside its place and renamed, so it is complete or
absent.  A task whose file is there is not computed again; a damaged file counts as absent.
"""

from __future__ import annotations

import copyreg
import hashlib
import json
import logging
import os
import pickle
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any

from takagi.certificates.document.certificate_file import provenance
from takagi.models.errors import ModelError

# To be increased where a function returns something else for the same inputs.
FORMAT = 1
RESULTS = "results"
# How often killed processes are replaced in one command.
RENEWALS = 3
# Seconds until a scheduler, or its first worker, counts as absent.
PATIENCE = 5.0

Result = dict[str, Any]
Tell = Callable[..., None]


@dataclass(frozen=True)
class Task:
    """One result to compute.

    Attributes
    ----------
    function : ``module:name`` of a function ``name(model, inputs) -> Result`` at the top of a
        module; the result is JSON without NaN.
    model : what the function reads beside the inputs; goes to the process or worker as a copy, the
        same one for consecutive tasks.  Not part of the hash.
    inputs : everything that the result depends on, as JSON; of the model the SHA-256 of its files.
    """

    function: str
    model: Any
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
    tasks: Sequence[Task],
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> tuple[list[Result], int]:
    """Return the results of all tasks, and how many were in the folder before.

    A task that is given several times is computed once, and counts once.  A task that ended in an
    unforeseen error has the result ``{"error": words}``, which is not stored: it is computed again
    next time.

    Parameters
    ----------
    workers : processes; None takes the cores, 1 computes in this process.
    scheduler : address of a Dask scheduler, whose workers compute in place of processes here.
    tell : called as ``tell(words, share done)``.

    Raises
    ------
    ModelError : fewer than one worker; workers and a scheduler; a cluster that is not there, is of
        other versions, or is lost; results of another study or of other versions in the folder;
        processes that are killed again and again.
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
    results = {task.file: _stored(task, folder) for task in tasks}
    missing = {task.file: task for task in tasks if results[task.file] is None}
    resumed = len(results) - len(missing)
    if missing:
        _require_same_study(tasks, folder)
    # Closed also if an interrupt comes between two results: the tasks that wait are dropped then.
    with closing(_computed(missing, folder, count, scheduler)) as computed:
        for number, (task, text) in enumerate(computed, start=resumed + 1):
            results[task.file] = _store(task, folder, text)
            if tell is not None:
                tell(f"{number} of {len(results)} results", number / len(results))
    return [results[task.file] or {} for task in tasks], resumed


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _computed(
    missing: Mapping[str, Task], folder: Path, workers: int, scheduler: str | None
) -> Generator[tuple[Task, str], None, None]:
    """Yield each task with its result's text, as it is finished."""
    if not missing:
        return
    from joblib import Parallel, delayed, parallel_config

    models = {id(task.model): pickle.dumps(task.model) for task in missing.values()}
    waiting, sources = dict(missing), None if scheduler is None else _sources()
    kept = f"what is finished is kept in {folder}: run the same command again"

    def parallel() -> Iterator[tuple[Task, str]]:
        calls = [
            delayed(_named_text)(file, task.hashed, models[id(task.model)], sources)
            for file, task in waiting.items()
        ]
        results = Parallel(batch_size=1, return_as="generator_unordered")(calls)
        with closing(results):
            for file, text in results:
                yield waiting.pop(file), text

    if scheduler is not None:
        with _cluster(scheduler) as client, parallel_config("dask", client=client):
            try:
                yield from parallel()
            except (ModelError, OSError, GeneratorExit):
                raise
            except Exception as error:
                raise ModelError(
                    f"--scheduler {scheduler}: {type(error).__name__}: {error}; {kept}"
                ) from error
        return
    processes = {"n_jobs": min(workers, len(missing)), "inner_max_num_threads": 1}
    for renewals in range(RENEWALS + 1):
        try:
            with parallel_config("loky", initializer=start_process, **processes):
                yield from parallel()
            return
        except BrokenProcessPool as error:
            if renewals == RENEWALS:
                raise ModelError(
                    f"processes were killed from outside {renewals + 1} times, perhaps for want of "
                    f"memory; {kept}, with fewer --workers if it happens again"
                ) from error


@contextmanager
def _cluster(scheduler: str) -> Iterator[Any]:
    """Return the client of a scheduler that has workers."""
    try:
        dask: Any = import_module("distributed")
    except ImportError as error:
        raise ModelError(
            "--scheduler needs Dask, which is not installed here: pip install 'takagi[cluster]'"
        ) from error
    # What it logs of a cluster that comes and goes, this module says in a sentence.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        client = dask.Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ModelError(
            f"--scheduler {scheduler}: no Dask scheduler answers there; start one with `dask "
            "scheduler`, and give the address that it prints, such as tcp://127.0.0.1:8786"
        ) from error
    try:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError as error:
            raise ModelError(
                f"--scheduler {scheduler}: the scheduler has no worker; start some with "
                f"`dask worker {scheduler}`"
            ) from error
        yield client
    finally:
        client.close(timeout=2)


@cache
def _sources() -> str:
    """Return a hash of takagi's own files, which may differ where the version does not."""
    digest = hashlib.sha256()
    for floor in ("models", "lmi", "certificates", "reports"):
        for path in sorted(Path(import_module(f"takagi.{floor}").__path__[0]).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _named_text(file: str, hashed: str, model: bytes, sources: str | None) -> tuple[str, str]:
    """Return, where it is computed, the file's name and the text of a task's result.

    ``sources`` : those of the one who asks a cluster; None in a process of this machine.
    """
    asked = json.loads(hashed)
    here, there = asked["versions"], provenance({}, {})["versions"]
    if sources is not None:
        here, there = (
            {**v, "takagi's files": s} for v, s in ((here, sources), (there, _sources()))
        )
    if differing := _differences(there, here):
        raise ModelError(
            f"a worker has other versions: {differing}; install the same ones there, or results "
            "would depend on where they were computed"
        )
    try:
        module, _, name = asked["function"].partition(":")
        result = getattr(import_module(module), name)(_unpickled(model), asked["inputs"])
        return file, json.dumps(result, separators=(",", ":"), allow_nan=False)
    except Exception as error:
        words = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return file, json.dumps({"error": words})


@lru_cache(maxsize=1)
def _unpickled(model: bytes) -> Any:
    """Return the model; the same object for the same bytes, which caches of functions rely on."""
    return pickle.loads(model)


def _read_only(members: dict[str, Any]) -> Any:
    return MappingProxyType(members)


# A turbine has such mappings, which pickle alone cannot copy.
copyreg.pickle(MappingProxyType, lambda members: (_read_only, (dict(members),)))


def start_process() -> None:
    """Prepare a new process: one thread for linear algebra, and it ends with its parent."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Ctrl-C reaches the parent too, which says what is kept.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def canonical(value: Any) -> str:
    """Return JSON that is the same for the same value.

    Raises
    ------
    TypeError, ValueError : a value that JSON cannot represent, such as NaN or infinity.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


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


def _store(task: Task, folder: Path, text: str) -> Result:
    """Write the result's file unless the result is an error; return the result as it is read."""
    result: Result = json.loads(text)
    if "error" in result:
        return result
    checksum = _sha256(canonical(result))
    content = f'{{"task":{task.hashed},"sha256":"{checksum}","result":{text}}}\n'
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".result-", dir=folder) as beside:
        with open(Path(beside) / task.file, "w", encoding="utf-8") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(file.name, folder / task.file)
    return result


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
        elif differing := _differences(there, here):
            words = f"a result of other versions: {differing}"
        else:
            continue
        raise ModelError(
            f"{folder} has {words}; nothing of it can be used here: give another folder, or "
            "remove this one"
        )


def _differences(there: Mapping[str, str], here: Mapping[str, str]) -> str:
    """Return which versions differ, in words; empty if none does."""
    return ", ".join(
        f"{name} {there.get(name, 'missing')} (here {here.get(name, 'missing')})"
        for name in dict.fromkeys((*here, *there))
        if there.get(name) != here.get(name)
    )
