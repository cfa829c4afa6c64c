"""A law with a map that costs nothing, for the verb `takagi sweep`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from takagi.certificates.sweep import Axis, AxisKind, SweepMap, SweepResult
from takagi.models import Turbine
from tests.certificates.sweep.toy import product, toy, troubled

AXES = (AxisKind("x", "m", "one"), AxisKind("y", "s", "the other"))


def build(
    law: str,
    turbine: Turbine,
    files: Sequence[Path],
    axes: Sequence[Axis],
    tell: Callable[..., None],
) -> SweepMap:
    """Return the toy map; law "troubled" has points that fail."""
    tell("gains")
    point = troubled if law == "troubled" else product
    swept = toy(point, settings={"factor": 2.0, "model": turbine.name})
    return replace(swept, name=law, axes=tuple(axes))


def pages(result: SweepResult) -> dict[str, bytes | str]:
    """Return a file that names the points."""
    return {"map.md": f"{len(result.points)} points\n"}
