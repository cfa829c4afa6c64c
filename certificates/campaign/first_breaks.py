"""The order in which runs exceed the bounds, and at which winds.

A run leaves the set before, or when, it exceeds one of the peaks. The first of the other bounds to
be exceeded therefore shows the physical consequence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.certificates.campaign.bounds import BOUNDS
from takagi.certificates.campaign.runs import Campaign
from takagi.models.arrays import Floats, Indices

TABLE = "coefficient table"


@dataclass(frozen=True, slots=True)
class Break:
    """How often one bound was exceeded in a campaign.

    Attributes
    ----------
    bound : its name, or ``TABLE`` where the table of power coefficients was left.
    runs : that exceeded it;  first : of these, runs in which no other but the set was before it.
    earliest : time of the earliest [s];  wind : least and greatest schedule wind then [m/s].
    """

    bound: str
    runs: int
    first: int
    earliest: float
    wind: tuple[float, float]


def breaks_of(campaign: Campaign) -> list[Break]:
    """Return the bounds that were exceeded, in the order of ``BOUNDS``, the table last."""
    first, records = first_breaks(campaign), campaign.records
    lost = np.where(np.isfinite(records.lost_at), records.start_wind, np.nan)
    times = np.vstack([records.broken_at, records.lost_at])
    winds = np.vstack([records.broken_wind, lost])
    found = []
    for i, name in enumerate((*BOUNDS, TABLE)):
        broken = np.isfinite(times[i])
        if not broken.any():
            continue
        at = winds[i, broken]
        own = int(np.count_nonzero(first == i)) if name != "set" else int(broken.sum())
        found.append(
            Break(
                name,
                int(broken.sum()),
                own,
                float(times[i].min()),
                (float(at.min()), float(at.max())),
            )
        )
    return found


def first_breaks(campaign: Campaign) -> Indices:
    """Return per run the index in ``(*BOUNDS, TABLE)`` of the first exceeded bound but the set.

    -1 means none. Of two at the same time, the one that comes first in ``BOUNDS`` counts.
    """
    times = np.vstack([campaign.records.broken_at, campaign.records.lost_at])
    times[0] = np.inf
    first = np.argmin(times, axis=0)
    return np.where(np.isfinite(times.min(axis=0)), first, -1)


def overspeed(campaign: Campaign) -> Floats:
    """Return per run the largest excess of rotor speed over rated, relative to rated [-]."""
    loop = campaign.loop
    used = campaign.records.share[BOUNDS.index("rotor speed")]
    speed = loop.tables[0].max() + used * loop.peaks[0]
    return np.asarray(speed / loop.rated_speed - 1)
