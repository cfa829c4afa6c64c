"""Maps that cost nothing: what a sweep does with points, without a turbine."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from takagi.certificates.sweep import Axis, SweepMap, Task
from takagi.models import ModelError


def toy(
    point: Any = None,
    *,
    x: tuple[float, ...] = (1.0, 2.0),
    settings: Mapping[str, Any] | None = None,
) -> SweepMap:
    """Return a map over x and y of two or more by three points."""
    axes = (Axis("x", "m", x), Axis("y", "s", (0.1, 0.2, 0.3)))
    return SweepMap(
        "toy", axes, {"factor": 2.0} if settings is None else settings, point or product
    )


def product(task: Task) -> dict[str, Any]:
    """Return factor x y."""
    return {"verdict": "PROVED", "reason": None, "z": task.settings["factor"] * _xy(task)}


def slow_product(task: Task) -> dict[str, Any]:
    """Return factor x y, after a while, and leave the process's number in the folder named."""
    time.sleep(0.2)
    (Path(task.settings["folder"]) / f"process-{os.getpid()}").touch()
    return product(task)


def troubled(task: Task) -> dict[str, Any]:
    """Return a result, raise misuse, raise a fault, or return what JSON does not know."""
    x, y = task.at["x"], task.at["y"]
    if (x, y) == (1.0, 0.2):
        raise ModelError("no such loop at y = 0.2 s")
    if (x, y) == (2.0, 0.1):
        raise ZeroDivisionError("a fault")
    if (x, y) == (2.0, 0.3):
        return {"verdict": "PROVED", "reason": None, "z": float("nan")}
    return product(task)


def deadly(task: Task) -> dict[str, Any]:
    """End the process, as a system without memory does."""
    os._exit(9)


def _xy(task: Task) -> float:
    return task.at["x"] * task.at["y"]
