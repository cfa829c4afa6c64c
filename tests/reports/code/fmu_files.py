"""FMUs of laws, written once, and what FMPy makes of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.fmu import target
from takagi.reports.code.fmu.target import export
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.targets import Exported, ExportSettings

LIBRARY = target.library


def fmpy() -> Any:
    """Return the module; where it is not installed the test is skipped."""
    return pytest.importorskip("fmpy")


@cache
def _compiled(sources: tuple[tuple[str, str], ...], compiled: tuple[str, ...]) -> target.Library:
    # What it computes does not depend on the optimisation, which takes most of the compiler's time.
    with patch.object(target, "FLAGS", (*target.FLAGS, "-O0")):
        return LIBRARY(dict(sources), compiled)


def compiled_once(sources: Mapping[str, str], compiled: Iterable[str]) -> target.Library:
    """Return the library of these sources, which the compiler is given once in a process."""
    return _compiled(tuple(sources.items()), tuple(compiled))


def exported(
    gains: Path, without: Sequence[str] = (), *, anew: bool = False, **settings: Any
) -> tuple[ControllerProgram, Exported]:
    """Write the FMUs of a gain file beside it; ``anew`` compiles what was compiled before."""
    program = read_controller(gains, without=without)
    with patch.object(target, "library", LIBRARY if anew else compiled_once):
        found = export(program, ExportSettings(**settings))
    for name, content in found.files.items():
        assert isinstance(content, bytes)
        (gains.parent / name).write_bytes(content)
    return program, found


def sources_alone(gains: Path, **settings: Any) -> tuple[ControllerProgram, Exported]:
    """Write the FMUs as where there is no compiler: for what is asked of their other contents."""
    with patch.object(target, "COMPILERS", ()):
        return exported(gains, anew=True, **settings)


def simulated(
    file: Path,
    times: Any,
    inputs: Mapping[str, Sequence[float]],
    start: Mapping[str, float] | None = None,
) -> Any:
    table = np.zeros(len(times), dtype=[("time", float)] + [(name, float) for name in inputs])
    table["time"] = times
    for name, values in inputs.items():
        table[name] = values
    return fmpy().simulate_fmu(
        str(file),
        stop_time=float(times[-1]),
        output_interval=float(times[1] - times[0]),
        input=table if inputs else None,
        start_values=dict(start or {}),
    )
