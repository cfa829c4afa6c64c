"""The closed loop with the effort-sharing law as an interval family, one for each wind cell.

cells, loop_cell the families; the region and the enclosures of one cell
torque_slopes        ranges of the aerodynamic torque's slopes
law_interval         the law's tables between two wind nodes, exactly
moving_schedule the effect of a varying schedule wind on the loop
vertices             the matrices whose hull contains every loop of a cell
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.loops.effort_sharing.cells import CellLoop as CellLoop
    from takagi.models.loops.effort_sharing.cells import (
        effort_sharing_cells as effort_sharing_cells,
    )
    from takagi.models.loops.effort_sharing.loop_cell import LoopBox as LoopBox
    from takagi.models.loops.effort_sharing.loop_cell import LoopCell as LoopCell
    from takagi.models.loops.effort_sharing.loop_cell import LoopUncertainty as LoopUncertainty
    from takagi.models.loops.effort_sharing.vertices import loop_vertices as loop_vertices

__getattr__, __dir__ = lazy_names(__name__)
