"""Gains that are sought, one kind of question a room.

requirements/      what any of them may have to keep: limits, rates, regions, uncertainty
decay/             a decay rate: parallel distributed compensation, one relaxation after another
cost/              the least guaranteed quadratic cost
disturbance/       the least gain of energy, variance or peaks
attraction/        the largest region of attraction, with input limits and saturation
fuzzy/             with a Lyapunov function that depends on the memberships
structured/        with zeros, shared gains, outputs in the place of states
output_feedback/   controllers with states of their own, from measured outputs
observer, secant_vertices    observers, also with premises that are not measured

The sums and their relaxations are in ``sums``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.output_feedback.scheduled_controller import (
        DynamicController as DynamicController,
    )
    from takagi.lmi.gains.output_feedback.scheduled_controller import (
        DynamicOutputDesign as DynamicOutputDesign,
    )
    from takagi.lmi.gains.output_feedback.scheduled_controller import (
        dynamic_output_condition as dynamic_output_condition,
    )
    from takagi.lmi.gains.output_feedback.scheduled_controller import (
        dynamic_output_feedback as dynamic_output_feedback,
    )

__getattr__, __dir__ = lazy_names(__name__)
