"""The ranges of schedule winds that are searched for claims of kind ``schedule-rate``.

One claim has one rate of the wind.  Near rated wind a low rate alone is kept, and the faster the
wind may move, the wider is the lag of the schedule wind and the shorter the range of winds that a
claim leaves.  So there are a few claims, whose ranges overlap.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.refusal import Refused

# Schedule winds over the first wind at which pitch has the whole effort, and the rate of the wind
# [m/s^2].  For the default law of the NREL 5-MW turbine these are the three ranges, of 12.1509 to
# 24.0042 m/s, for which docs/schedule-rate.md has the results.
RANGES = (
    (Fraction("1.05"), Fraction("1.25"), 0.008),
    (Fraction("1.125"), Fraction("1.4"), 0.016),
    (Fraction("1.3"), Fraction("2.1"), 0.03),
)


@dataclass(frozen=True, slots=True)
class ScheduleRange:
    """Schedule winds ``low`` to ``high`` [m/s], both in the law's tables; ``rate`` [m/s^2]."""

    low: Fraction
    high: Fraction
    rate: float

    @property
    def words(self) -> str:
        """The range and the rate, with their units."""
        return f"{float(self.low):g} to {float(self.high):g} m/s at {self.rate:g} m/s^2"


def schedule_ranges(gains: Mapping[str, Any]) -> list[ScheduleRange]:
    """Return the ranges of ``RANGES`` in which the law has an interval of its tables.

    Parameters
    ----------
    gains : the law, as the certificate states it.

    Raises
    ------
    Refused : pitch has the whole effort at no wind of the tables, or no range has an interval.
    """
    winds = [Fraction(str(v)) for v in gains["wind"]]
    efforts = zip(winds, gains["trim_effort"], strict=True)
    first = next((v for v, effort in efforts if effort >= gains["overlap"]), None)
    if first is None:
        raise Refused("pitch has the whole effort at no wind of the law's tables")
    found: list[ScheduleRange] = []
    for low, high, rate in RANGES:
        inside = [v for v in winds if low * first <= v <= high * first]
        if len(inside) > 1:
            found.append(ScheduleRange(inside[0], inside[-1], rate))
    if not found:
        raise Refused("the law's tables have no interval far enough above rated wind")
    return found
