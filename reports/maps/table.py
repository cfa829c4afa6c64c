"""The points of a sweep as CSV and JSON: a row or an object a point, units in the names."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from takagi.certificates.sweep.grid import PointResult, SweepResult
from takagi.reports.csv_text import csv_text


def rows_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows as CSV; columns are the keys, in the order they first appear; None is empty."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return csv_text(names, ([row.get(name, "") for name in names] for row in rows))


def points_csv(
    result: SweepResult, further: Callable[[PointResult], Mapping[str, Any]] | None = None
) -> str:
    """Return a row a point: its axes with units, and every number or word of its result.

    What is neither, such as the list of windows, is left to ``map_json``; ``further`` may add
    columns that follow from it.
    """
    units = {axis.name: axis.unit for axis in result.map.axes}
    return rows_csv(
        [
            {f"{name} [{units[name]}]": value for name, value in point.at.items()}
            | {k: v for k, v in point.result.items() if not isinstance(v, dict | list)}
            | dict(further(point) if further else {})
            for point in result.points
        ]
    )


def map_json(result: SweepResult) -> str:
    """Return everything: axes, settings, points, and the maps that are compared with."""
    return json.dumps(_data(result), indent=1, allow_nan=False) + "\n"


def _data(result: SweepResult) -> dict[str, Any]:
    return {
        **result.map.asked,
        "axes": [
            {"name": axis.name, "unit": axis.unit, "values": list(axis.values)}
            for axis in result.map.axes
        ],
        "sha256": result.map.digest,
        "points": [_point(point) for point in result.points],
        "beside": [_data(other) for other in result.beside],
    }


def _point(point: PointResult) -> dict[str, Any]:
    return {"at": dict(point.at), "seconds": point.seconds, **point.result}
