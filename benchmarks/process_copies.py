"""Copies of this process (``os.fork``) that work, say what they find, and end.

A copy has all that this process has imported and made, and nothing that it does is seen here but
what it says: lines of JSON through a pipe.
"""

from __future__ import annotations

import json
import os
import resource
import select
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

# What a copy may take beside what it has: a change can make a loop that collects for ever.
MORE_BYTES = 3 << 30


def limit_seconds(seconds: float) -> None:
    """End this process when it has used this much more of the processor [s], from this call on.

    What it starts is held by the limit of whole seconds, which children take over.
    """
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    used = resource.getrusage(resource.RUSAGE_SELF)
    most = int(used.ru_utime + used.ru_stime + seconds) + 2
    resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))


def limit_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + MORE_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def copy(work: Callable[[Callable[[Any], None]], None], limit: float) -> Iterator[dict[str, Any]]:
    """Run work in a copy of this process; yield what it says, until it ends.

    The last is ``{"silent": True}`` where it said nothing for too long.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        _as_copy(work, reader, writer)
    os.close(writer)
    text, silent = b"", False
    try:
        while True:
            ready, _, _ = select.select([reader], [], [], limit)
            if not ready:
                silent = True
                break
            part = os.read(reader, 1 << 16)
            if not part:
                break
            *whole, text = (text + part).split(b"\n")
            for line in whole:
                yield json.loads(line)
    finally:
        os.close(reader)
        _end(child)
    if silent:
        yield {"silent": True}


def _as_copy(work: Callable[[Callable[[Any], None]], None], reader: int, writer: int) -> None:
    """Be the copy: work without a terminal, and end without anything that an end runs."""
    code = 1
    try:
        os.setpgid(0, 0)
        os.close(reader)
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nowhere, stream)

        def say(said: Any) -> None:
            whole = json.dumps(said).encode() + b"\n"
            while whole:
                whole = whole[os.write(writer, whole) :]

        try:
            work(say)
            code = 0
        except BaseException:
            say({"ended": True})
    finally:
        os._exit(code)


def _end(child: int) -> None:
    """End the copy with all that it started, and wait for it."""
    try:
        os.killpg(child, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def copied(work: Callable[[], bool], seconds: float) -> bool:
    """Return what work says in a copy of this process; False where it ends or takes too long."""
    found = False
    for said in copy(lambda say: say({"passed": work()}), seconds):
        found = bool(said.get("passed"))
    return found
