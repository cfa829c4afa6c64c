"""Tasks on a Dask cluster: workers compute, and this process writes the results.

A worker needs the same release of takagi and its libraries, and no file of this machine: the
content of a task's files goes with it.  A task whose worker ends is computed by another one; when
the scheduler is lost, what is missing is sent to the one that is started in its place.
"""

from __future__ import annotations

import hashlib
import logging
import tempfile
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import CancelledError
from functools import cache
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from takagi.certificates.document.certificate_file import provenance
from takagi.certificates.sweep.store import (
    Result,
    Task,
    result_text,
    store_result,
    version_differences,
)
from takagi.models.errors import ModelError

# Seconds until a cluster counts as absent: at the beginning, and after a scheduler was lost.
PATIENCE, PATIENCE_LATER = 5.0, 60.0
# How often the way to a scheduler is made anew in one command.
RENEWALS = 3
# Tasks at a scheduler at once: enough for all workers, and little enough to be sent in a moment.
TOGETHER = 500
FOLDERS = ("models", "lmi", "certificates", "reports")

Files = tuple[tuple[str, bytes], ...]
Versions = dict[str, str]


def computed_by_cluster(
    tasks: Sequence[Task], folder: Path, scheduler: str
) -> Generator[tuple[str, Result], None, None]:
    """Yield file name and result of each task as it is finished; results are stored here.

    Raises
    ------
    ModelError : the extra is not installed; no scheduler or no worker at the address; a worker
        without takagi or with other versions; a scheduler that is lost and not started again.
    """
    distributed = _distributed()
    missing, patience = {task.file: task for task in tasks}, PATIENCE
    for renewals in range(RENEWALS + 1):
        client = _client(distributed, scheduler, patience)
        try:
            for file, text in _of_client(distributed, client, list(missing.values())):
                result = store_result(missing.pop(file), folder, text)
                yield file, result
            return
        except _Lost as error:
            patience = PATIENCE_LATER
            if renewals == RENEWALS:
                raise ModelError(
                    f"--scheduler {scheduler}: the scheduler was lost {renewals + 1} times; what "
                    f"is finished is kept in {folder}: run the same command again"
                ) from error
        finally:
            client.close(timeout=2)


class _Lost(Exception):
    """The way to the scheduler is lost, and with it what it had not sent back."""


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise ModelError(
            "--scheduler needs Dask, which is not installed here: pip install 'takagi[cluster]'"
        ) from error
    # What it logs of a cluster that comes and goes, this module says in a sentence.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    return distributed


def _client(distributed: Any, scheduler: str, patience: float) -> Any:
    """Return the client of a scheduler that has workers, all of them with these versions."""
    try:
        # It tries again and again until the time is over.
        client = distributed.Client(scheduler, timeout=patience, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise ModelError(
            f"--scheduler {scheduler}: no Dask scheduler answers there; start one with `dask "
            "scheduler`, and give the address that it prints"
        ) from error
    except ValueError as error:
        raise ModelError(
            f"--scheduler {scheduler}: this is no address of a Dask scheduler; write one such as "
            "tcp://127.0.0.1:8786"
        ) from error
    try:
        client.wait_for_workers(1, timeout=patience)
        here = versions_here()
        for worker, there in client.run(versions_here, on_error="return").items():
            _require_versions(worker, there, here)
    except BaseException as error:
        client.close(timeout=2)
        if isinstance(error, TimeoutError):
            raise ModelError(
                f"--scheduler {scheduler}: the scheduler has no worker; start some with "
                f"`dask worker {scheduler}`"
            ) from error
        raise
    return client


def _require_versions(worker: str, there: Any, here: Versions) -> None:
    if isinstance(there, BaseException):
        raise ModelError(
            f"worker {worker} cannot run takagi ({type(there).__name__}: {there}); install the "
            f"release of this machine there: takagi {here['takagi']}, python {here['python']}"
        )
    if differing := version_differences(there, here):
        raise ModelError(
            f"worker {worker} has other versions: {differing}; install the same ones there, or "
            "results would depend on where they were computed"
        )


def _of_client(
    distributed: Any, client: Any, tasks: Sequence[Task]
) -> Generator[tuple[str, str], None, None]:
    """Yield file name and result's text of each task as it is finished."""
    here = versions_here()
    contents = {files: _content(files) for files in {task.files for task in tasks}}
    files, waiting = dict[str, str](), iter(tasks)

    def send(task: Task) -> Any:
        content = contents[task.files]
        arguments = (task.function, task.source, dict(task.inputs), content, here)
        future = client.submit(computed_far, *arguments, key=f"takagi-{task.file}", pure=False)
        files[future.key] = task.file
        return future

    try:
        first = [send(task) for task in islice(waiting, TOGETHER)]
        completed = distributed.as_completed(first, loop=client.loop)
        for future in completed:
            if future.status in ("cancelled", "lost"):
                raise _Lost
            yield files.pop(future.key), _text(distributed, future)
            for task in islice(waiting, 1):
                completed.add(send(task))
    except (OSError, TimeoutError, CancelledError) as error:
        raise _Lost from error


def _text(distributed: Any, future: Any) -> str:
    """Return what a worker has sent.

    Raises
    ------
    ModelError : a worker that has other versions, or cannot run takagi; it came later.
    OSError, TimeoutError, CancelledError : the scheduler is lost.
    """
    if future.status != "error":
        return str(future.result())
    error = future.exception()
    if isinstance(error, ModelError):
        raise error
    if isinstance(error, distributed.KilledWorker):
        return '{"error": "every worker that computed it was killed"}'
    raise ModelError(
        f"a worker cannot run takagi ({type(error).__name__}: {error}); install there what is here"
    )


def computed_far(
    function: str, source: str, inputs: Mapping[str, Any], files: Files, versions: Versions
) -> str:
    """Return, on a worker, the text of a task's result.

    Raises
    ------
    ModelError : the worker has other versions than the one who asks; it may have come later.
    """
    from distributed import get_worker

    _require_versions(get_worker().address, versions_here(), versions)
    return result_text(function, _placed(files) if files else source, inputs)


@cache
def versions_here() -> Versions:
    """Return what results depend on: the versions of a task's hash, and takagi's own files."""
    digest = hashlib.sha256()
    for folder in FOLDERS:
        package = Path(import_module(f"takagi.{folder}").__path__[0])
        for path in sorted(package.rglob("*.py")):
            digest.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    versions: Versions = provenance({}, {})["versions"]
    return {**versions, "takagi's files": digest.hexdigest()[:12]}


def _content(files: Sequence[Path]) -> Files:
    return tuple((f.relative_to(files[0].parent).as_posix(), f.read_bytes()) for f in files)


# The folders are removed when the worker ends.
_FOLDERS: list[tempfile.TemporaryDirectory[str]] = []


@cache
def _placed(files: Files) -> str:
    """Return the path of the first file, written with the others into a folder of this worker."""
    _FOLDERS.append(folder := tempfile.TemporaryDirectory(prefix="takagi-"))
    for name, content in files:
        path = Path(folder.name) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return str(Path(folder.name) / files[0][0])
