"""Rigorous ranges: rational intervals, Bernstein forms, ball arithmetic, and their evidence.

interval              rational intervals in exact arithmetic
bernstein, blossom    hulls of spline patches, exact
polynomial            Bernstein form of polynomials and rational functions, exact
side, balls           boxes as balls
tape                  expressions compiled to a list of ball operations
ball_form             derivative and Taylor forms of an expression
table_balls           splines as operations on balls
domain                boxes, bands around a curve, unions of cells;  cell_root: one in a search
evidence              trees of boxes that prove a range, and their replay
evidence_file         evidence as JSON data;  expression_text: expressions as plant files write them
sampled               bounds from samples, which prove nothing

A bound from this room, sampled ones apart, holds for every point of the domain, not for the
points somebody looked at.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.enclosure.bernstein import ExactSpline, exact_bounds, exact_value
    from takagi.models.enclosure.domain import Cell, Domain
    from takagi.models.enclosure.evidence import Evidence, replay
    from takagi.models.enclosure.evidence_file import evidence_data, evidence_of_data
    from takagi.models.enclosure.interval import Interval, exact
    from takagi.models.enclosure.sampled import SampledBounds, sampled_bounds

__all__ = [
    "Cell",
    "Domain",
    "Evidence",
    "ExactSpline",
    "Interval",
    "SampledBounds",
    "evidence_data",
    "evidence_of_data",
    "exact",
    "exact_bounds",
    "exact_value",
    "replay",
    "sampled_bounds",
]

_HOME = {
    "Cell": "domain",
    "Domain": "domain",
    "Evidence": "evidence",
    "ExactSpline": "bernstein",
    "Interval": "interval",
    "SampledBounds": "sampled",
    "evidence_data": "evidence_file",
    "evidence_of_data": "evidence_file",
    "exact": "interval",
    "exact_bounds": "bernstein",
    "exact_value": "bernstein",
    "replay": "evidence",
    "sampled_bounds": "sampled",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.models.enclosure.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
