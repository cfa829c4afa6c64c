"""What the figures and pages of the effort-sharing law's maps read of a point's result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from takagi.certificates.sweep.grid import PointResult, SweepResult
from takagi.models.arrays import Floats

ERROR, RATE = "mean_wind_error [m/s]", "mean_wind_rate [m/s^2]"
LEAST_ERROR, LEAST_RATE = "least_wind_error [m/s]", "least_wind_rate [m/s^2]"
OVERSPEED = "overspeed [%]"


@dataclass(frozen=True, slots=True)
class Line:
    """One proved claim of a trade-off: where, and what it guarantees.

    Attributes
    ----------
    at : axis name -> value;  overspeed [%].
    mean_error, least_error : |v - v_s| over its winds [m/s];  mean_rate, least_rate : |v_s'| over
        its winds [m/s^2];  decay : in one function for all of them [1/s].
    """

    at: Mapping[str, float]
    overspeed: float
    mean_error: float
    least_error: float
    mean_rate: float
    least_rate: float
    decay: float


def column(result: SweepResult, *keys: str | int) -> Floats:
    """Return a number of each point's result, nan where it has none."""
    return np.array([_found(point.result, keys) for point in result.points])


def range_names(result: SweepResult) -> list[tuple[str, float, float]]:
    """Return name and winds [m/s] of the ranges that a map distinguishes."""
    for point in result.points:
        if "ranges" in point.result:
            return [(each["name"], *each["winds [m/s]"]) for each in point.result["ranges"]]
    return []


def wind_words(low: float, high: float) -> str:
    """Return a range of winds in words."""
    return f"{low:g} to {high:g} m/s"


def flat(point: PointResult, units: Mapping[str, str]) -> dict[str, Any]:
    """Return a point as one row: its axes, its numbers, and those of its ranges or claims."""
    row: dict[str, Any] = {f"{name} [{units[name]}]": at for name, at in point.at.items()}
    row["verdict"] = point.result["verdict"]
    parts = [*point.result.get("ranges", ()), *point.result.get("claims", {}).values()]
    plain = {k: v for k, v in point.result.items() if not isinstance(v, dict | list)}
    row |= {key: value for key, value in plain.items() if key != "reason"}
    for each in parts:
        row |= _prefixed(each)
    return row | {"reason": plain.get("reason")}


def guaranteed_pairs(result: SweepResult, name: str) -> list[Line]:
    """Return the proved claims about one range of a trade-off, by overspeed."""
    found = []
    for point in result.points:
        claim = point.result.get("claims", {}).get(name, {})
        if claim.get("verdict") == "PROVED" and claim[LEAST_ERROR] > 0:
            found.append(
                Line(
                    point.at,
                    claim[OVERSPEED],
                    claim[ERROR],
                    claim[LEAST_ERROR],
                    claim[RATE],
                    claim[LEAST_RATE],
                    claim["common_decay [1/s]"],
                )
            )
    return sorted(found, key=lambda line: (line.overspeed, -line.mean_error))


def front(lines: Sequence[Line]) -> list[Line]:
    """Return those that no other beats: less overspeed, no smaller mean error, no smaller rate.

    Of several that guarantee the same the first is kept.
    """
    kept: list[Line] = []
    for line in lines:
        if not any(_beats(other, line) for other in lines) and not any(
            _worth(other) == _worth(line) for other in kept
        ):
            kept.append(line)
    return kept


def _worth(line: Line) -> tuple[float, float, float]:
    """Return three numbers, each the better the larger."""
    return -line.overspeed, line.mean_error, line.mean_rate


def _beats(a: Line, b: Line) -> bool:
    pairs = list(zip(_worth(a), _worth(b), strict=True))
    return all(x >= y for x, y in pairs) and any(x > y for x, y in pairs)


def _prefixed(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a range or claim, its name and winds before each key."""
    low, high = values["winds [m/s]"]
    return {
        f"{values['name']}, {wind_words(low, high)}: {key}": value
        for key, value in values.items()
        if key not in ("name", "reason") and not isinstance(value, dict | list)
    }


def _found(value: Any, keys: Sequence[str | int]) -> float:
    for key in keys:
        if isinstance(value, list):
            value = value[key] if isinstance(key, int) and key < len(value) else None
        else:
            value = value.get(key) if isinstance(value, dict) else None
    return float(value) if isinstance(value, int | float) else float("nan")
