"""Whose family a loop with another feed-forward of the schedule wind's rate belongs to."""

from __future__ import annotations

from dataclasses import replace

import pytest

from takagi.models import Turbine
from takagi.models.laws.effort_sharing.law import EffortSharingLaw, LoopCell
from takagi.models.laws.effort_sharing.schedule import Feedforward, known_rate_feedforward
from tests.certificates.loop_cells.loop_points import (
    BOX,
    ROUNDING,
    WIDE,
    derivative,
    distance,
    effort_sharing_cells,
    points,
    rates_of,
)


def leads(turbine: Turbine, law: EffortSharingLaw, lead: float, inertia: float) -> EffortSharingLaw:
    """Return the law with another pitch lead [s] and share of the torque's feed-forward."""
    ahead = known_rate_feedforward(turbine, law.schedule, inertia_share=inertia)
    return replace(law, feedforward=Feedforward(ahead.inertia, ahead.effort_limit, lead))


@pytest.mark.parametrize(
    ("lead", "inertia"),
    [
        (0.1, 0.5),
        *(pytest.param(*c, marks=pytest.mark.slow) for c in ((0.0, 0.0), (0.3, 1.0))),
    ],
)
def test_another_feedforward_has_its_own_family(
    lead: float, inertia: float, turbine: Turbine, law: EffortSharingLaw, cells: list[LoopCell]
) -> None:
    """The loop lies in the family of its own law, and not in that of the law it was before."""
    other = leads(turbine, law, lead, inertia)
    own = effort_sharing_cells(turbine, other, BOX, WIDE, rates_of(law))
    found = [(p, derivative(turbine, other, p)) for p in points(other, BOX, 1000, seed=8)]

    assert max(distance(own[p.k], p, rates) for p, rates in found) < ROUNDING
    assert max(distance(cells[p.k], p, rates) for p, rates in found) > 100 * ROUNDING
