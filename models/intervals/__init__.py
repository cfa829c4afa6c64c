"""Interval arithmetic and best-first search over boxes: what proved ranges are computed with.

interval      closed intervals of rational numbers, exact
dual          ranges with slopes, in floats
box_search    best-first bisection of boxes, however they are enclosed
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.intervals.dual import Dual as Dual
    from takagi.models.intervals.interval import exact as exact

__getattr__, __dir__ = lazy_names(__name__)
