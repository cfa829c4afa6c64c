"""One turbine, a law with plain gains, and its enclosed loop, for all tests here."""

from __future__ import annotations

import pytest

from takagi.models import Turbine, nrel5mw
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw, LoopCell
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from tests.certificates.loop_cells.loop_points import (
    BOX,
    WIDE,
    effort_sharing_cells,
    plain_gains,
    rates_of,
)


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


@pytest.fixture(scope="module")
def law(turbine: Turbine) -> EffortSharingLaw:
    schedule = effort_schedule(turbine)
    gamma, nu = plain_gains(turbine, schedule)
    return EffortSharingLaw.of(turbine, schedule, EffortGains(gamma, nu))


@pytest.fixture(scope="module")
def cells(turbine: Turbine, law: EffortSharingLaw) -> list[LoopCell]:
    return effort_sharing_cells(turbine, law, BOX, WIDE, rates_of(law))
