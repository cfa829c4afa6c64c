"""Candidates of claims about a turbine's loop.

effort_sharing         the loop with the effort-sharing law: cells, one P for all, wind class
largest_wind_error     the largest wind error of every cell with one quadratic function
wind_class             the wind class that is tried, cell by cell
failing_winds          at which winds a joint analysis fails, and what smaller uncertainty would do
cell_loop              one wind cell's coefficients, as the checker encloses them
stated_residual        the trim error that a claim states
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
    from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_BOX as DEFAULT_BOX
    from takagi.certificates.claims.turbine.effort_sharing import (
        DEFAULT_UNCERTAINTY as DEFAULT_UNCERTAINTY,
    )
    from takagi.certificates.claims.turbine.effort_sharing import (
        effort_sharing_candidate as effort_sharing_candidate,
    )
    from takagi.certificates.claims.turbine.effort_sharing import (
        effort_sharing_claim as effort_sharing_claim,
    )
    from takagi.certificates.claims.turbine.largest_wind_error import (
        EffortSharingCandidate as EffortSharingCandidate,
    )
    from takagi.certificates.claims.turbine.published import (
        PublishedCandidate as PublishedCandidate,
    )
    from takagi.certificates.claims.turbine.published import (
        overlap_candidates as overlap_candidates,
    )
    from takagi.certificates.claims.turbine.published import (
        published_candidate as published_candidate,
    )
    from takagi.certificates.claims.turbine.published import published_claim as published_claim
    from takagi.certificates.claims.turbine.published import (
        published_law_data as published_law_data,
    )
    from takagi.certificates.claims.turbine.published import with_overlaps as with_overlaps
    from takagi.certificates.claims.turbine.published_search import merged as merged
    from takagi.certificates.claims.turbine.wind_rate_claim import rate_range as rate_range

__getattr__, __dir__ = lazy_names(__name__)
