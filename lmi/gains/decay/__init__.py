"""Gains for a decay rate, by parallel distributed compensation.

pdc                one gain a rule, one Lyapunov function for all; what each relaxation gives
request, condition, design    what is asked; the LMIs; gains in the model's units, or a no
largest_rate       the largest rate with gains
relaxation_search  one relaxation after another
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.decay.design import decided as decided
    from takagi.lmi.gains.decay.design import stopped_by_limit as stopped_by_limit
    from takagi.lmi.gains.decay.request import decay_request as decay_request

__getattr__, __dir__ = lazy_names(__name__)
