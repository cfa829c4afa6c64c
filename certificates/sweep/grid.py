"""The tasks and the results of the points of a grid."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

from takagi.certificates.sweep.axis import Axis

# A point's verdicts: all claims are proved, some, or none.
PROVED, PARTLY, UNDECIDED = "PROVED", "PARTLY", "UNDECIDED"
# The verdict of a point with an unforeseen error; the point is computed again on resuming.
FAILED = "FAILED"

Place = tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """One point: its coordinates, and the map's data for all points.

    Attributes
    ----------
    at : axis name -> value in the axis's unit.
    settings : as in ``SweepMap``.
    shared : what ``SweepMap.prepare`` returned; without one, ``SweepMap.shared``.
    """

    at: Mapping[str, float]
    settings: Mapping[str, Any]
    shared: Any = None


@dataclass(frozen=True, slots=True, eq=False)
class SweepMap:
    """The task at every point of a grid; the package's docstring defines it.

    Attributes
    ----------
    name : the law.
    axes : the grid's axes, first the slowest.
    settings : everything that results depend on besides the point, JSON-able.
    point : ``point(task)``, at the top of a module.
    shared : picklable, follows from ``settings``.
    prepare : ``prepare(settings, shared)``, at the top of a module; called once a process.
    beside : maps to compare with, each made in a subfolder of its name.
    """

    name: str
    axes: tuple[Axis, ...]
    settings: Mapping[str, Any]
    point: Callable[[Task], dict[str, Any]]
    shared: Any = None
    prepare: Callable[[Mapping[str, Any], Any], Any] | None = None
    beside: tuple[SweepMap, ...] = ()

    @property
    def places(self) -> list[Place]:
        """The coordinates of all points, in the order of the grid."""
        return list(product(*(axis.values for axis in self.axes)))

    def at(self, place: Place) -> dict[str, float]:
        """Return coordinates with the names of their axes."""
        return dict(zip((axis.name for axis in self.axes), place, strict=True))

    @property
    def asked(self) -> dict[str, Any]:
        """What the journal's header must repeat: law, axes without their values, settings.

        Values are left out, so that a finer grid can use the points of a coarser one.
        """
        return {
            "map": self.name,
            "axes": [{"name": axis.name, "unit": axis.unit} for axis in self.axes],
            "settings": json.loads(canonical(self.settings)),
        }

    @property
    def digest(self) -> str:
        """SHA-256 of ``asked``."""
        return hashlib.sha256(canonical(self.asked).encode()).hexdigest()


@dataclass(frozen=True, slots=True, eq=False)
class PointResult:
    """The answer at a point: axis name -> value, the point's result, and the time it took [s]."""

    at: Mapping[str, float]
    result: Mapping[str, Any]
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class SweepResult:
    """All points of a map, in the order of the grid.

    Attributes
    ----------
    resumed : the number of points that the journal contained before.
    beside : the results of the maps to compare with.
    """

    map: SweepMap
    points: tuple[PointResult, ...]
    resumed: int = 0
    beside: tuple[SweepResult, ...] = ()

    def counted(self) -> dict[str, int]:
        """Return verdict -> number of points."""
        found: dict[str, int] = {}
        for point in self.points:
            verdict = str(point.result["verdict"])
            found[verdict] = found.get(verdict, 0) + 1
        return found


def canonical(value: Any) -> str:
    """Return JSON that is the same for the same value.

    Raises
    ------
    TypeError, ValueError : a value that JSON cannot represent, such as NaN or infinity.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
