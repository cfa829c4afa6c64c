"""Gains with the least guaranteed quadratic cost.

regulator         the linear-quadratic regulator of a Takagi-Sugeno model; one gain for all vertices
condition         its LMIs
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.cost.regulator import (
        guaranteed_cost_condition as guaranteed_cost_condition,
    )
    from takagi.lmi.gains.cost.regulator import guaranteed_cost_gain as guaranteed_cost_gain

__getattr__, __dir__ = lazy_names(__name__)
