"""A Dask cluster of processes on this machine, each of which can be killed by its number."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@dataclass
class Cluster:
    """A scheduler, which ends by itself when nothing comes, and its workers.

    ``environment`` is added to that of the workers.
    """

    folder: Path
    port: int
    environment: dict[str, str] = field(default_factory=dict)
    started: list[subprocess.Popen[bytes]] = field(default_factory=list)
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def scheduler(self) -> subprocess.Popen[bytes]:
        own = ("--host", "127.0.0.1", "--port", str(self.port), "--idle-timeout", "120s")
        return self._start("dask_scheduler", *own, "--no-dashboard")

    def worker(self) -> subprocess.Popen[bytes]:
        """Start a worker that is one process, and that waits a while for a new scheduler."""
        own = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "60")
        place = ("--local-directory", str(self.folder), "--host", "127.0.0.1")
        self.workers.append(self._start("dask_worker", self.address, *own, *place))
        return self.workers[-1]

    def _start(self, program: str, *arguments: str) -> subprocess.Popen[bytes]:
        words = [sys.executable, "-m", f"distributed.cli.{program}", *arguments]
        threads = {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
        environment = {**os.environ, **threads, **self.environment}
        with (self.folder / "log").open("ab") as log:
            process = subprocess.Popen(
                words, stdout=log, stderr=log, env=environment, cwd=self.folder
            )
        self.started.append(process)
        return process


@contextmanager
def dask_cluster(folder: Path, workers: int, **environment: str) -> Iterator[Cluster]:
    """A scheduler and so many workers, on the loopback; all of them have ended afterwards."""
    pytest.importorskip("distributed")
    folder.mkdir()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        cluster = Cluster(folder, free.getsockname()[1], environment)
    try:
        cluster.scheduler()
        for _ in range(workers):
            cluster.worker()
        until(lambda: (folder / "log").read_text().count("Registered to:") >= workers)
        yield cluster
    finally:
        for process in cluster.started:
            process.kill()
            process.wait(30)


def until(condition: object, seconds: float = 60.0) -> None:
    """Return when the condition is true, and fail if it does not become so."""
    assert callable(condition)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited in vain")
