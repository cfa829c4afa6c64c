"""Tasks on a real Dask cluster: workers and schedulers that are killed lose nothing."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from takagi.certificates.sweep.tasks import Task, run_tasks
from takagi.models import ModelError, nrel5mw
from tests.certificates.sweep.toy import reading, tasks

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning", "default::DeprecationWarning")

COUNT = 40


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.json")}


def meanwhile(results: Path, count: int, work: Callable[[], object]) -> threading.Thread:
    def wait() -> None:
        until(lambda: len(content(results)) >= count)
        work()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


def results_of(cluster: Cluster, folder: Path) -> tuple[list[dict[str, object]], int]:
    work = tasks("slow", str(cluster.folder), COUNT)
    return run_tasks(work, folder, scheduler=cluster.address)


def same_as_alone(results: Path, folder: Path) -> bool:
    folder.mkdir()
    run_tasks(tasks("slow", str(folder), COUNT), folder / "results", workers=1)
    return content(results) == content(folder / "results")


@pytest.mark.slow
def test_two_workers_of_which_one_is_killed(tmp_path: Path) -> None:
    """Its task is computed elsewhere; the files are those of a run without a cluster."""
    results = tmp_path / "results"
    with dask_cluster(tmp_path / "cluster", 2) as cluster:
        killing = meanwhile(results, 8, cluster.workers[1].kill)
        made, resumed = results_of(cluster, results)
        killing.join()
        assert cluster.workers[1].wait(10) != 0
        assert len(list(cluster.folder.glob("process-*"))) == 2

    assert (resumed, [result["z"] for result in made]) == (0, [2 * x for x in range(COUNT)])
    assert same_as_alone(results, tmp_path / "alone")


@pytest.mark.slow
def test_a_scheduler_that_is_lost_and_started_again(tmp_path: Path) -> None:
    """The command says that what is finished is kept; the same one computes the others."""
    results = tmp_path / "results"
    with dask_cluster(tmp_path / "cluster", 2) as cluster:
        killing = meanwhile(results, 8, cluster.started[0].kill)
        with pytest.raises(ModelError, match="is kept in .*: run the same command again"):
            results_of(cluster, results)
        killing.join()
        ready = len(content(results))
        cluster.scheduler()
        # A worker without a nanny may end with its scheduler.
        cluster.worker()
        until(lambda: (cluster.folder / "log").read_text().count("Registered to:") >= 3)
        made, resumed = results_of(cluster, results)

    assert 8 <= ready == resumed < COUNT
    assert [result["z"] for result in made] == [2 * x for x in range(COUNT)]
    assert same_as_alone(results, tmp_path / "alone")


@pytest.mark.slow
def test_a_client_that_is_gone(tmp_path: Path) -> None:
    """The next one computes what is missing, and no more."""
    results, script = tmp_path / "results", tmp_path / "script.py"
    script.write_text(
        "import sys\nfrom pathlib import Path\n"
        "from takagi.certificates.sweep.tasks import run_tasks\n"
        "from tests.certificates.sweep.toy import tasks\n"
        f"work = tasks('slow', sys.argv[1], {COUNT})\n"
        "run_tasks(work, Path(sys.argv[2]), scheduler=sys.argv[3])\n"
    )
    with dask_cluster(tmp_path / "cluster", 2) as cluster:
        words = [sys.executable, str(script), str(cluster.folder), str(results), cluster.address]
        with subprocess.Popen(words, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}) as gone:
            until(lambda: len(content(results)) >= 4)
            gone.kill()
        ready = len(content(results))
        made, resumed = results_of(cluster, results)

    assert 4 <= ready == resumed < COUNT
    assert [result["z"] for result in made] == [2 * x for x in range(COUNT)]
    assert same_as_alone(results, tmp_path / "alone")


@pytest.mark.slow
def test_a_turbine_goes_to_the_workers_with_the_task(tmp_path: Path) -> None:
    """A worker has no file system in common with this machine; an error is the task's alone."""
    turbine = nrel5mw()
    work = [Task("tests.certificates.sweep.toy:reading", turbine, {}), tasks("troubled")[1]]
    with dask_cluster(tmp_path / "cluster", 2) as cluster:
        (read, failed), _ = run_tasks(work, tmp_path / "results", scheduler=cluster.address)

    assert read == reading(turbine, {})
    assert failed == {"error": "ZeroDivisionError: a fault"}


@pytest.mark.slow
def test_a_worker_of_another_release_is_refused(tmp_path: Path) -> None:
    """Before a task is computed; the words name the library and both versions."""
    other = tmp_path / "other" / "takagi-0.0.9.dist-info"
    other.mkdir(parents=True)
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: takagi\nVersion: 0.0.9\n")
    path = f"{other.parent}{os.pathsep}{ROOT}"
    with dask_cluster(tmp_path / "cluster", 2, PYTHONPATH=path) as cluster:
        with pytest.raises(ModelError, match=r"worker has other versions: takagi 0\.0\.9 \(here"):
            results_of(cluster, tmp_path / "results")
        assert not list(cluster.folder.glob("process-*"))
    assert not content(tmp_path / "results")


@pytest.mark.slow
def test_a_cluster_that_is_not_there(tmp_path: Path) -> None:
    """A scheduler without workers, and none at all, are refused within seconds."""
    results, work = tmp_path / "results", tasks()
    with dask_cluster(tmp_path / "cluster", 0) as cluster:
        with pytest.raises(ModelError, match="has no worker; start some with `dask worker tcp"):
            run_tasks(work, results, scheduler=cluster.address)
    with pytest.raises(ModelError, match="no Dask scheduler answers there; start one"):
        run_tasks(work, results, scheduler=cluster.address)
    # What is stored needs no cluster.
    run_tasks(work, results, workers=1)
    assert run_tasks(work, results, scheduler=cluster.address)[1] == len(work)


def test_a_cluster_that_makes_no_sense(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No address, processes beside a cluster, no Dask: each has its sentence."""
    results, work, address = tmp_path / "results", tasks(), "tcp://127.0.0.1:1"
    pytest.importorskip("distributed")
    with pytest.raises(ModelError, match="no Dask scheduler answers there; .*tcp://"):
        run_tasks(work, results, scheduler="somewhere://else")
    with pytest.raises(ModelError, match="leave --workers out"):
        run_tasks(work, results, scheduler=address, workers=2)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ModelError, match=r"pip install 'takagi\[cluster\]'"):
        run_tasks(work, results, scheduler=address)


ROOT = Path(__file__).parents[3]


@dataclass
class Cluster:
    """A scheduler, which ends by itself when nothing comes, and its workers."""

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
    assert callable(condition)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited in vain")
