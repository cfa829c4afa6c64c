"""Given gains: the decay rate of the loop u = -sum_j h_j K_j x by each relaxation.

condition        the double sum of a loop with given gains, and one P for all blends
largest_decay    the decay rate that a relaxation shows
ladder           comparison of all relaxations for the same gains
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.given.condition import closed_loop_condition as closed_loop_condition
    from takagi.lmi.gains.given.ladder import closed_loop_ladder as closed_loop_ladder
    from takagi.lmi.gains.given.largest_decay import closed_loop_decay as closed_loop_decay

__getattr__, __dir__ = lazy_names(__name__)
