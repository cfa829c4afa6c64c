"""One-step against two-step: both sets of gains in the same analysis."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.loops.synthesis_summary import synthesis_summary
from takagi.reports.page.text import Table, with_decimals

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw


def synthesis_table(design: TurbineDesign) -> Table | None:
    """Return the comparison; None where the design's gains were found in two steps."""
    found, law = synthesis_summary(design), design.effort_sharing_law
    if found is None or found.before is None or found.after is None:
        return None
    if law is None or design.effort is None:
        return None
    rows = []
    for name, reached, own in (
        ("two-step: wind by wind, then the function", found.before, design.effort.gains),
        (f"one-step: together ({found.objective})", found.after, law.gains),
    ):
        pitch, tower = _activity(design, replace(law, gains=own))
        rows.append(
            (
                name,
                with_decimals(reached.wind_error, 4),
                with_decimals(reached.decay_rate, 4),
                with_decimals(math.degrees(pitch), 3),
                with_decimals(1e3 * tower, 2),
            )
        )
    return Table(
        "One-step against two-step",
        (
            ("gains", ""),
            ("largest wind error, mean over wind", "m/s"),
            ("common decay rate", "1/s"),
            ("pitch rate per m/s of turbulence", "°/s"),
            ("tower speed per m/s of turbulence", "mm/s"),
        ),
        tuple(rows),
        note="Both judged by the same analysis in floating point, with the same box and the same "
        "rates of the schedule wind, so that the overspeed bound is the same: a comparison, no "
        "proof. The certificate states what is proved of the second row. Pitch and tower are "
        f"estimates about the trim, means over wind. {found.steps} joint steps were taken.",
    )


def _activity(design: TurbineDesign, law: EffortSharingLaw) -> tuple[float, float]:
    """Return the means over wind of the pitch rate [rad/s] and the tower speed [m/s]."""
    from takagi.lmi.turbine.one_step.value import motion

    moved = motion(design.turbine, law)
    share = np.diff(law.schedule.wind) / np.ptp(law.schedule.wind)
    return float(share @ moved.pitch_rate), float(share @ moved.tower_speed)
