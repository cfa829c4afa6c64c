"""FMUs of laws, written once, and what FMPy makes of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.reports.code import ControllerProgram, ExportSettings, read_controller
from takagi.reports.code.certified_model import certified_model
from takagi.reports.code.fmu.target import export
from takagi.reports.code.targets import Exported


def fmpy() -> Any:
    """Return the module; where it is not installed the test is skipped."""
    return pytest.importorskip("fmpy")


def exported(
    gains: Path, without: Sequence[str] = (), **settings: Any
) -> tuple[ControllerProgram, Exported]:
    """Write the FMUs of a gain file beside it; return its program and what was written."""
    program = read_controller(gains, without=without)
    model = certified_model(gains, None, program)
    found = export(program, ExportSettings(model=model, **settings))
    for name, content in found.files.items():
        assert isinstance(content, bytes)
        (gains.parent / name).write_bytes(content)
    return program, found


def simulated(
    file: Path,
    times: Any,
    inputs: Mapping[str, Sequence[float]],
    start: Mapping[str, float] | None = None,
) -> Any:
    """Return FMPy's trajectory at equally spaced times, inputs as they are at each."""
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
