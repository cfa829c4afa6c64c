"""Dynamic output feedback: controllers with states of their own, by linear matrix inequalities.

One linear plant, least energy gain:

generalised_plant      plant and weights as one system, from w and u to z and y
condition              the LMIs of the energy gain; what makes them linear
controller             the controller of their unknowns; mixed sensitivity
fixed_order            a controller of given order, static ones among them, by descent on the norm

A Takagi-Sugeno model with measured premises, decay rate:

scheduled_controller   one set of controller matrices for each rule
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.output_feedback.condition import (
        controller_matrices as controller_matrices,
    )
    from takagi.lmi.gains.output_feedback.condition import factors as factors
    from takagi.lmi.gains.output_feedback.condition import (
        lyapunov_matrix as lyapunov_matrix,
    )

__getattr__, __dir__ = lazy_names(__name__)
