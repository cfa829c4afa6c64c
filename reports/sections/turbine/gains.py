"""The law and its gains over wind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.reports.figures.style import captioned_figure
from takagi.reports.loops.overlap_claims import synthesis_words
from takagi.reports.page.text import Section
from takagi.reports.sections.turbine.drawings import effort_figure, gains_figure
from takagi.reports.sections.turbine.model import region_starts

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw


def gains_section(design: TurbineDesign) -> Section:
    """Return the section about the law and its gains."""
    law = design.effort_sharing_law
    content: dict[str, Any] = {"law": design.law, "figure": None}
    if law is not None:
        content |= _effort_sharing(design, law)
    else:
        content["rules"] = [4, len(design.partial_load.rules), len(design.full_load.rules)]
    return Section("law", "The law and its gains", content)


def _effort_sharing(design: TurbineDesign, law: EffortSharingLaw) -> dict[str, Any]:
    limited = design.effort.torque_limited if design.effort is not None else np.zeros(0)
    winds = law.schedule.wind[limited.astype(bool)] if limited.size else limited
    return {
        "figure": captioned_figure(
            gains_figure(law, region_starts(design)),
            "gains",
            caption="Gains of the law over the schedule wind, the assumed pitch effectiveness, "
            "and how a change of effort is shared at the trim.",
            alternative="Proportional gain, integral rate, pitch effectiveness, and the shares of "
            "pitch and torque over wind; pitch takes over from torque around rated wind",
        ),
        "effort": captioned_figure(
            effort_figure(float(law.schedule.overlap)),
            "effort-ramp",
            caption="The effort ramp and its slope, the share of pitch in a change of effort. "
            "The shares sum to 1 at every effort; both act in the shaded overlap only.",
            alternative="The ramp psi of the demanded effort and of its negative, and their "
            "slopes, which sum to one",
        ),
        "synthesis": synthesis_words(design),
        "limited": "" if not winds.size else f"{winds.min():g} to {winds.max():g} m/s",
    }
