"""The closed loop with a published law, enclosed cell by cell.

cells           interval families, one for each wind cell
vector_field    the loop's right-hand side on ranges with slopes
tables          trim tables, scheduled gains and figures that it is made of
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.loops.published.cells import (
        PublishedCell,
        disturbance_bound,
        enclosed_cell,
        wind_breaks,
    )
    from takagi.models.loops.published.tables import LoopFigures, loop_figures

__all__ = [
    "LoopFigures",
    "PublishedCell",
    "disturbance_bound",
    "enclosed_cell",
    "loop_figures",
    "wind_breaks",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
