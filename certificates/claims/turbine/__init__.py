"""Candidates of claims about a turbine's loop.

effort_sharing         the loop with the effort-sharing law: cells, one P for all, wind class
largest_wind_error     the largest wind error of every cell with one quadratic function
wind_class             the wind class that is tried, cell by cell
failing_winds          at which winds a joint analysis fails
smaller_uncertainty    the smaller uncertainty that would be covered
loop_claims            the claim about the loop, and the claims that depend on it
wind_rate_claim        how fast a wind that the law knows may move
actuator_rates         how fast pitch and torque move
published              the loop with a published law, over a grid of overlaps
published_search       its cells: a centre, a box and a P for each
running_loop           the loop with its observer and filters, at constant winds
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.claims.turbine.effort_sharing import (
        DEFAULT_BOX,
        DEFAULT_UNCERTAINTY,
        effort_sharing_candidate,
        effort_sharing_claim,
    )
    from takagi.certificates.claims.turbine.published import (
        published_candidate,
        published_claim,
        published_law_data,
        with_overlaps,
    )
    from takagi.certificates.claims.turbine.wind_rate_claim import rate_range

__all__ = [
    "DEFAULT_BOX",
    "DEFAULT_UNCERTAINTY",
    "effort_sharing_candidate",
    "effort_sharing_claim",
    "published_candidate",
    "published_claim",
    "published_law_data",
    "rate_range",
    "with_overlaps",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
