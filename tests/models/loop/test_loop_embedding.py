"""The nonlinear loop lies in its interval family, at random points, two independent ways."""

from __future__ import annotations

from fractions import Fraction

import pytest

from takagi.models import ModelError, Turbine
from takagi.models.laws import EffortSharingLaw
from takagi.models.loops.effort_sharing import (
    LoopBox,
    LoopCell,
    effort_sharing_cells,
)
from tests.models.loop.loop_points import (
    BOX,
    FAST,
    ROUNDING,
    WIDE,
    campaign,
    points,
    rates_of,
)


def test_the_loop_lies_in_its_family(
    turbine: Turbine, law: EffortSharingLaw, cells: list[LoopCell]
) -> None:
    """Two thousand points of all cells, any inertia, wake and wind of the class: all inside."""
    drawn = points(law, BOX, 2000, seed=1)

    assert max(d for _, d in campaign(turbine, law, cells, drawn)) < ROUNDING


@pytest.mark.slow
def test_the_rate_limit_is_a_sector(turbine: Turbine, law: EffortSharingLaw) -> None:
    """With a lag box so large that the drive saturates the loop still lies in its family."""
    cells = list(effort_sharing_cells(turbine, law, FAST, WIDE, rates_of(law)))
    found = campaign(turbine, law, cells, points(law, FAST, 500, seed=3))

    assert max(d for _, d in found) < ROUNDING
    assert max(float(cell.pitch_rate) for cell in cells) > 3 * turbine.pitch_rate_limit
    assert min(cell.lag_rate.lower / cell.lag_rate.upper for cell in cells) < 0.3


def test_a_schedule_that_moves_too_fast_is_misuse(turbine: Turbine, law: EffortSharingLaw) -> None:
    """40 m/s^2 asks for more than the pitch rate limit by itself; so many rates as cells."""
    fast = [40.0 for _ in rates_of(law)]

    with pytest.raises(ModelError, match="wind cell .* pitch rate .* lower the wind rate"):
        list(effort_sharing_cells(turbine, law, BOX, WIDE, fast))
    with pytest.raises(ModelError, match="wind rates for"):
        list(effort_sharing_cells(turbine, law, BOX, WIDE, fast[1:]))


@pytest.mark.parametrize(
    ("box", "words"),
    [
        (LoopBox(Fraction("0.045"), Fraction("0.015"), Fraction(2), Fraction("0.03")), "torque"),
        (LoopBox(Fraction("0.045"), Fraction(9), Fraction("0.04"), Fraction("0.03")), "pitch"),
        (LoopBox(Fraction(9), Fraction("0.015"), Fraction("0.04"), Fraction("0.03")), "box"),
    ],
)
def test_a_box_beyond_actuators_or_tables_is_misuse(
    box: LoopBox, words: str, turbine: Turbine, law: EffortSharingLaw
) -> None:
    """The message names the wind cell and what to reduce."""
    with pytest.raises(ModelError, match="wind cell") as raised:
        list(effort_sharing_cells(turbine, law, box, WIDE, rates_of(law)))
    assert words in str(raised.value)
