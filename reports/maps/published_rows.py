"""What the figures and tables of the published law's map read of its points."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from takagi.certificates.sweep.grid import PointResult, SweepResult
from takagi.models.arrays import Floats

SPEED, TORQUE = "speed-overlap", "torque-overlap"

# A number in a sentence, but not the 1 of "1/s".
NUMBER = re.compile(r"(?<![\w.])\d+(\.\d+)?(e[+-]?\d+)?(?!/s)")


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Numbers of the points over both overlaps; arrays are (speed overlaps, torque overlaps).

    Attributes
    ----------
    speed [rad/s], torque [N m] : the overlaps.
    winds : number of winds that are examined.
    proved : how many of them are proved; NaN where the point has no answer.
    at_trim : how many of those rest at the trim; NaN where the point has no answer.
    first_failing : the first that is not [m/s]; NaN where all are.
    decay : the least proved decay rate [1/s]; NaN where none is.
    """

    speed: Floats
    torque: Floats
    winds: int
    proved: Floats
    at_trim: Floats
    first_failing: Floats
    decay: Floats


def grid(result: SweepResult) -> Grid:
    """Return the points of a map over both overlaps as arrays."""
    axes = {axis.name: np.array(axis.values) for axis in result.map.axes}
    shape = (len(axes[SPEED]), len(axes[TORQUE]))

    rows = [{**point.result, **of_windows(point)} for point in result.points]

    def column(name: str) -> Floats:
        return np.array([_number(row.get(name)) for row in rows]).reshape(shape)

    return Grid(
        axes[SPEED],
        axes[TORQUE],
        len(result.map.settings["windows"]),
        column("proved_windows"),
        column("proved_at_trim"),
        column("first_failing_wind [m/s]"),
        column("least_decay_rate [1/s]"),
    )


def windows_of(point: PointResult) -> Sequence[Mapping[str, Any]]:
    """Return the windows of a point; none where the point itself has no answer."""
    found: Sequence[Mapping[str, Any]] = point.result.get("windows", ())
    return found


def of_windows(point: PointResult) -> dict[str, Any]:
    """Return what a point's windows say together: how many rest at the trim, the smallest set."""
    if not windows_of(point):
        return {"proved_at_trim": None, "smallest_half_width [rad/s]": None}
    proved = [w for w in windows_of(point) if w["verdict"] == "PROVED"]
    return {
        "proved_at_trim": sum(window["rest"] == "intended" for window in proved),
        "smallest_half_width [rad/s]": min(
            (window["half_width [rad/s]"] for window in proved), default=None
        ),
    }


def reason_counts(result: SweepResult) -> list[tuple[str, int, float, float]]:
    """Return (reason, windows, lowest, highest wind [m/s]) of what is not proved, most first.

    Reasons that differ in their numbers alone are one: each number is written as "...".
    """
    found: dict[str, list[float]] = {}
    for point in result.points:
        for window in windows_of(point):
            if window["reason"] is not None:
                words = NUMBER.sub("...", window["reason"])
                found.setdefault(words, []).append(window["wind [m/s]"][0])
    rows = [(words, len(winds), min(winds), max(winds)) for words, winds in found.items()]
    return sorted(rows, key=lambda row: -row[1])


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")
