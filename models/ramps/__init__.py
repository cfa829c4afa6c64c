"""Ramps that hand one quantity over to another.

effort_ramp           how two actuators share one effort: in floats, and in exact numbers
membership_ramp       the membership pair w_1 + w_2 = 1
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.ramps.effort_ramp import effort_ramp_slope as effort_ramp_slope
    from takagi.models.ramps.membership_ramp import Ramp as Ramp
    from takagi.models.ramps.membership_ramp import Shape as Shape

__getattr__, __dir__ = lazy_names(__name__)
