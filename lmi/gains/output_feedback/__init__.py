"""Dynamic output feedback: a controller with states of its own, by linear matrix inequalities.

generalised_plant   plant and weights as one system, from w and u to z and y
condition           the LMIs of the energy gain, linear after a change of variables
controller          the controller of their unknowns, and the gain that its loop has
weighted_loop       S, K S and T with weights
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.output_feedback.condition import (
        hinf_output_feedback_condition as hinf_output_feedback_condition,
    )
    from takagi.lmi.gains.output_feedback.controller import OutputFeedback as OutputFeedback
    from takagi.lmi.gains.output_feedback.controller import (
        hinf_output_feedback as hinf_output_feedback,
    )
    from takagi.lmi.gains.output_feedback.generalised_plant import (
        GeneralisedPlant as GeneralisedPlant,
    )
    from takagi.lmi.gains.output_feedback.weighted_loop import (
        mixed_sensitivity as mixed_sensitivity,
    )

__getattr__, __dir__ = lazy_names(__name__)
