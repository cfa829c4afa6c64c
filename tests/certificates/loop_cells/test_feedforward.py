"""What the feed-forward of the schedule wind's rate leaves, and whose family it belongs to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.models import Turbine
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import LoopCell
from takagi.models.laws.effort_sharing.schedule import Feedforward, known_rate_feedforward
from takagi.models.laws.protocol import Measurement
from tests.certificates.loop_cells.loop_points import (
    BOX,
    ROUNDING,
    WIDE,
    Point,
    column,
    commanded,
    derivative,
    distance,
    effort_sharing_cells,
    physical,
    points,
    rates_of,
)


def left_over(turbine: Turbine, law: EffortSharingLaw, p: Point) -> tuple[float, float]:
    """Return what the feed-forward leaves of a moving schedule: in speed, and in effort owed.

    From the law's own commands, with and without the rate: omega*' v_s' less what torque takes of
    it, and v_s' times the slope of psi(U) / b (by differences, e - x held) less what pitch does.
    """
    omega, beta, _ = physical(law, p)
    v, rate = p.schedule_wind, p.schedule_rate
    still = law.command([p.x, v], Measurement(omega, beta, v))
    moved = commanded(law, p, omega, beta)
    taken = turbine.gear_ratio * (still.torque - moved.torque) / turbine.inertia
    table, k = law.schedule, p.k
    slope = float((np.diff(table.rotor_speed) / np.diff(table.wind))[k])

    def asked(wind: float) -> float:
        speed = column(law, "rotor_speed", wind) + p.e
        return law.command([p.x, wind], Measurement(speed, beta, wind)).pitch

    h = 1e-6
    bent = column(law, "effectiveness", v) * (asked(v + h) - asked(v - h)) / (2 * h)
    pitched = column(law, "effectiveness", v) * (moved.pitch - still.pitch)
    return slope * rate - p.kappa * taken, bent * rate - pitched / turbine.pitch_time_constant


def leads(turbine: Turbine, law: EffortSharingLaw, lead: float, inertia: float) -> EffortSharingLaw:
    """Return the law with another pitch lead [s] and share of the torque's feed-forward."""
    ahead = known_rate_feedforward(turbine, law.schedule, inertia_share=inertia)
    return replace(law, feedforward=Feedforward(ahead.inertia, ahead.effort_limit, lead))


@pytest.mark.parametrize(
    ("lead", "inertia"),
    [
        (0.2, 1.0),
        *(pytest.param(*c, marks=pytest.mark.slow) for c in ((0.1, 0.5), (0.0, 0.0), (0.3, 0.0))),
    ],
)
def test_what_the_feedforward_leaves_is_bounded(
    lead: float, inertia: float, turbine: Turbine, law: EffortSharingLaw
) -> None:
    """Both remainders from the law's commands, inside their bounds and close to them somewhere."""
    other = leads(turbine, law, lead, inertia)
    cells = effort_sharing_cells(turbine, other, BOX, WIDE, rates_of(law))
    speed, owed = [], []
    for p in points(other, BOX, 3000, seed=7):
        nodes = other.schedule.wind[p.k : p.k + 2]
        if min(abs(nodes - p.schedule_wind)) < 1e-5:
            continue
        left, lag_left = left_over(turbine, other, p)
        cell = cells[p.k]
        bound = float(cell.reference_slope * cell.wind_rate)
        assert abs(left) <= bound + 1e-12
        assert abs(lag_left) <= float(cell.lag_disturbance) + ROUNDING
        speed.append(abs(left) / bound if bound else 0.0)
        owed.append(abs(lag_left) / float(cell.lag_disturbance) if cell.lag_disturbance else 0.0)
    assert max(speed) > 0.9 and max(owed) > 0.5


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
