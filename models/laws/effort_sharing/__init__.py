"""The effort-sharing law (``coherent`` on the command line).

law           one effort, divided between generator torque and blade pitch by a ramp
schedule      its tables over wind
feedforward   its feed-forward of the schedule wind's rate
loop_cell     the closed loop in one cell of winds: region, ranges of coefficients, corners
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.laws.effort_sharing.loop_cell import LoopBox as LoopBox
    from takagi.models.laws.effort_sharing.loop_cell import LoopCell as LoopCell
    from takagi.models.laws.effort_sharing.loop_cell import LoopUncertainty as LoopUncertainty
    from takagi.models.laws.effort_sharing.loop_cell import loop_vertices as loop_vertices
    from takagi.models.laws.effort_sharing.schedule import (
        frozen_wake_effectiveness as frozen_wake_effectiveness,
    )

__getattr__, __dir__ = lazy_names(__name__)
