"""The trade-off of the effort-sharing law: wind class against overspeed, by range and in all.

Each point is a law (overlap, bandwidth) and a box.  Four claims are made there, and the independent
checker decides each: one about all winds, and one about each range of ``wind_ranges``, for schedule
winds that stay in this range.  A range has a quadratic function of its own
(``widest_set``), and its box need not fit other winds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.sweep.axis import Axis
from takagi.certificates.sweep.effort_sharing_map import loop_settings
from takagi.certificates.sweep.grid import PARTLY, PROVED, UNDECIDED, SweepMap, Task
from takagi.certificates.sweep.loop_answer import answer, energy_cost
from takagi.certificates.sweep.loop_settings import AXES as AXES  # takagi sweep reads it here
from takagi.certificates.sweep.loop_settings import LoopSettings, loop_at
from takagi.certificates.sweep.widest_set import widest_candidate
from takagi.certificates.sweep.wind_ranges import WindRange, law_on, wind_ranges
from takagi.models.errors import ModelError
from takagi.models.turbine.data import Turbine

# The axes of ``--trade-off`` if none is given.
READY_MADE = (
    "overlap=0.005,0.01,0.02",
    "bandwidth=0.45,0.6,0.75",
    "speed-error=0.02,0.03,0.04,0.06,0.1",
)
Tell = Callable[..., None]


def build(
    law: str, turbine: Turbine, files: Sequence[Path], axes: Sequence[Axis], tell: Tell
) -> SweepMap:
    """Return the trade-off map of the effort-sharing law of a turbine over the axes."""
    return SweepMap(f"{law} trade-off", tuple(axes), loop_settings(turbine), point, turbine)


def point(task: Task) -> dict[str, Any]:
    """Return the claims about all winds and about each range, at one law and box.

    Raises
    ------
    ModelError : no trim or no gain; names the wind and what to change.
    """
    turbine: Turbine = task.shared
    loop = loop_at(turbine, default_settings(turbine), task.at)
    ranges = wind_ranges(turbine)
    every = WindRange("all winds", ranges[0].low, ranges[-1].high)
    claims = {each.name: claim_on(loop, each) for each in (every, *ranges)}
    open_ = [f"{name}: {each['reason']}" for name, each in claims.items() if each["reason"]]
    verdict = PARTLY if len(open_) < len(claims) else UNDECIDED
    return {
        "verdict": verdict if open_ else PROVED,
        "reason": "; ".join(open_) or None,
        "energy_cost [%]": energy_cost(loop.turbine, loop.law),
        "claims": claims,
    }


def claim_on(loop: LoopSettings, winds: WindRange) -> dict[str, Any]:
    """Return the proved claims about the loop for schedule winds that stay in a range.

    The claim is about the law with its tables limited to the range. Its commands are the same while
    the schedule wind stays there.  A box that leaves a table or a limit is a result, with the
    message as its reason.
    """
    part = replace(loop, law=law_on(loop.law, winds.low, winds.high))
    try:
        found = answer(part.turbine, part.law, widest_candidate(part), [winds])
    except ModelError as error:
        found = {"verdict": UNDECIDED, "reason": str(error)}
    class_ = found.pop("ranges", [{}])[0]
    for shared in ("energy_cost [%]", "cells"):
        found.pop(shared, None)
    return {"name": winds.name, "winds [m/s]": [winds.low, winds.high], **found, **class_}
