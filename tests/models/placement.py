"""Which regions each placement of the speed ramp serves, by where the published law then rests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from takagi.models.laws import PublishedLaw, published_law
from takagi.models.laws.published import PublishedLawName
from takagi.models.laws.published.coupling_filter import coupling_filter
from takagi.models.laws.published.equilibrium import equilibrium
from takagi.models.laws.published.equilibrium_point import Equilibrium


@dataclass(frozen=True, slots=True)
class PlacementRow:
    """Which regions one placement of the ramp serves.

    Attributes
    ----------
    placement : share of the overlap above rated speed.
    kinds : region -> (winds at the intended equilibrium, winds tried), for "1.5", "2", "2.5", "3".
    worst_pitch : largest pitch offset [rad]; worst_power : smallest power ratio, where it rests.
    integral_travel : how far an integral moves over the winds that were tried [rad].
    """

    placement: float
    kinds: dict[str, tuple[int, int]]
    worst_pitch: float
    worst_power: float
    integral_travel: float

    @property
    def served(self) -> tuple[str, ...]:
        """Regions in which every wind that was tried has the intended equilibrium."""
        return tuple(region for region, (good, tried) in self.kinds.items() if good == tried)


def placement_rows(
    law: PublishedLaw,
    *,
    placements: Sequence[float] = (0.0, 0.25, 0.5, 0.75, 1.0),
    winds: Sequence[float],
    speed_overlap: float | None = None,
    name: PublishedLawName | None = None,
) -> tuple[PlacementRow, ...]:
    """Return which regions each placement of the speed ramp serves.

    Parameters
    ----------
    law : everything but the placement is taken from it.
    placements : shares of the overlap above rated speed.
    winds : [m/s].
    speed_overlap : [rad/s]; None takes the law's.
    name : None takes the law's.
    """
    coupling = law.coupling
    rows = []
    for placement in placements:
        moved = coupling_filter(
            law.turbine,
            speed_overlap=coupling.speed_ramp.width if speed_overlap is None else speed_overlap,
            torque_overlap=coupling.torque_overlap,
            variant=coupling.variant,
            placement=placement,
            minimum_torque=coupling.minimum_torque,
            shape=coupling.speed_ramp.shape,
            torque_shape=coupling.shape,
            speed_setpoint=law.speed_setpoint,
        )
        tried = published_law(
            law.turbine,
            partial=law.partial,
            full=law.full,
            coupling=moved,
            name=law.name if name is None else name,
            tracking_time=5.0 if law.tracking_time is None else law.tracking_time,
            speed_setpoint=law.speed_setpoint,
        )
        rows.append(_row(placement, [equilibrium(tried, float(v)) for v in winds]))
    return tuple(rows)


def _row(placement: float, found: Sequence[Equilibrium]) -> PlacementRow:
    kinds = {}
    for region in ("1.5", "2", "2.5", "3"):
        here = [point for point in found if point.trim.region == region]
        if here:
            kinds[region] = (sum(point.kind == "intended" for point in here), len(here))
    resting = [point for point in found if point.kind != "none"]
    pitches = [abs(point.pitch_offset) for point in resting]
    powers = [point.power_ratio for point in resting]
    travel = max(
        (np.ptp(x) for x in zip(*(p.integrals for p in resting), strict=True)), default=0.0
    )
    worst = max(pitches, default=0.0), min(powers, default=1.0)
    return PlacementRow(placement, kinds, *worst, float(travel))
