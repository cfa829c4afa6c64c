"""Rigorous ranges: rational intervals, and Bernstein hulls of spline patches.

Everything here is exact arithmetic on integers and fractions.  A bound from this room holds
for every point of the box, not for the points somebody looked at.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.enclosure.bernstein import ExactSpline, exact_bounds, exact_value
    from takagi.models.enclosure.interval import Interval, exact

__all__ = ["ExactSpline", "Interval", "exact", "exact_bounds", "exact_value"]

_HOME = {
    "ExactSpline": "bernstein",
    "Interval": "interval",
    "exact": "interval",
    "exact_bounds": "bernstein",
    "exact_value": "bernstein",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.models.enclosure.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
