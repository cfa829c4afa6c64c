"""Tasks that cost nothing, for fresh processes too."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from takagi.certificates.sweep.tasks import Task
from takagi.models.turbine.data import Turbine


def tasks(
    function: str = "product", source: str = "", count: int = 6, factor: int = 2
) -> list[Task]:
    inputs = [{"x": x, "factor": factor} for x in range(count)]
    return [Task(f"{__name__}:{function}", source, each) for each in inputs]


def product(source: object, inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"z": inputs["factor"] * inputs["x"], "a": [0.1 * inputs["x"], None]}


def troubled(source: object, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Fail for odd x; a result that JSON cannot represent fails too."""
    if inputs["x"] == 1:
        raise ZeroDivisionError("a\nfault")
    return {"z": float("nan")} if inputs["x"] % 2 else product(source, inputs)


def deadly(source: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Kill the process at x = 3, as a system without memory does, unless ``source`` exists."""
    if inputs["x"] == 3 and not Path(source).exists():
        if Path(source).parent.is_dir():
            Path(source).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return product(source, inputs)


def slow(source: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    (Path(source) / f"process-{os.getpid()}").touch()
    time.sleep(0.1)
    return product(source, inputs)


def reading(source: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"name": source.name, "coefficient": float(source.torque(7.0, 0.01))}
