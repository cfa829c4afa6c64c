"""What any gain design may be asked to keep, as double sums or LMIs.

requirements    the checked part of it about plants and memberships
closed_loop     the closed loop as a double sum
limits          inputs and states on an ellipsoid, initial states inside it; as ``pdc`` takes them
region_sums     eigenvalues in regions of the complex plane
robust_sums     norm-bounded uncertainty of the model
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.gains.requirements.limits import GivenLimits as GivenLimits
    from takagi.lmi.gains.requirements.limits import Limits as Limits
    from takagi.lmi.gains.requirements.limits import limits_of as limits_of
    from takagi.lmi.gains.requirements.requirements import Requirements as Requirements

__getattr__, __dir__ = lazy_names(__name__)
