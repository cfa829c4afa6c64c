"""The published coupling filter and the law that it blends, with the numbers of this design."""

from __future__ import annotations

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.laws.published.law import PublishedLaw
from takagi.reports.appendix.tex import Tex, matrix, scientific, with_decimals
from takagi.reports.sections.turbine.blending import filter_of


def blending_context(design: TurbineDesign) -> dict[str, object]:
    """Return the numbers of the filter, its corners, and the count of rules."""
    coupling = filter_of(design)
    low, high = coupling.torque_corners
    ramp = coupling.speed_ramp
    law = design.law if isinstance(design.law, PublishedLaw) else None
    n_b, n_c = len(design.partial_load.rules), len(design.full_load.rules)
    slopes = coupling.torque_slope_range
    return {
        "paper_law": law is not None,
        "law_name": design.law.name,
        "tracking_time": None if law is None or law.tracking_time is None
        else with_decimals(law.tracking_time, 1),
        "variant": coupling.variant,
        "shape": ramp.shape,
        "corners": [matrix(corner, digits=6) for corner in coupling.corners],
        "f2_low": scientific(low, 6),
        "f2_high": scientific(high, 6),
        "ramp_start": with_decimals(ramp.start, 5),
        "ramp_end": with_decimals(ramp.end, 5),
        "speed_overlap": scientific(ramp.width),
        "torque_overlap": scientific(coupling.torque_overlap, 6),
        "minimum_torque": scientific(coupling.minimum_torque, 8),
        "maximum_torque": scientific(coupling.rated_torque, 8),
        "top_torque": scientific(coupling.top_torque, 8),
        "slopes": Tex(f"[{slopes[0]:.4g},\\ {slopes[1]:.4g}]"),
        "n_b": n_b,
        "n_c": n_c,
        "n_rules": 4 * n_b * n_c,
    }  # fmt: skip
