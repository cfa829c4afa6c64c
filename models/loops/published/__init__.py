"""The closed loop with a published law, enclosed cell by cell.

cells           interval families, one for each wind cell
vector_field    the loop's right-hand side on ranges with slopes
tables          trim tables, scheduled gains and figures that it is made of
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.loops.published.cells import PublishedCell as PublishedCell
    from takagi.models.loops.published.cells import disturbance_bound as disturbance_bound
    from takagi.models.loops.published.cells import enclosed_cell as enclosed_cell
    from takagi.models.loops.published.cells import wind_breaks as wind_breaks
    from takagi.models.loops.published.tables import LoopFigures as LoopFigures
    from takagi.models.loops.published.tables import loop_figures as loop_figures

__getattr__, __dir__ = lazy_names(__name__)
