"""The effort-sharing law's tables over wind."""

from __future__ import annotations

from typing import Any

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.reports.appendix.tex import NONE, Tex, decimal, escape, scientific, with_decimals
from takagi.reports.appendix.turbine import DEGREES


def law_context(design: TurbineDesign) -> dict[str, Any]:
    """Return constants and gain table of the effort-sharing law; for another law a flag alone."""
    law = design.effort_sharing_law
    if law is None:
        return {"coherent": False}
    return {
        "coherent": True,
        "overlap": scientific(law.schedule.overlap),
        "wind_filter": decimal(law.wind_filter),
        "pitch_lead": with_decimals(law.feedforward.pitch_lead, 3),
        "integral_limit": scientific(law.integral_limit),
        "effort_torque": scientific(law.effort_torque, 8),
        "rated_torque": scientific(law.rated_torque, 8),
        "nodes": len(law.schedule.wind),
        "gain_rows": [_row(design, law, k) for k in range(len(law.schedule.wind))],
        "limited": design.effort is not None and bool(design.effort.torque_limited.any()),
    }


def _row(design: TurbineDesign, law: EffortSharingLaw, k: int) -> list[Tex]:
    table, gains, turbine = law.schedule, law.gains, design.turbine
    wind = float(table.wind[k])
    last = k == len(table.wind) - 1
    limited = design.effort is not None and bool(design.effort.torque_limited[k])
    return [
        escape(k + 1),
        with_decimals(wind, 4),
        with_decimals(table.rotor_speed[k], 4),
        with_decimals(table.trim_effort[k], 5),
        with_decimals(table.pitch(wind, turbine) * DEGREES, 2),
        with_decimals(table.torque(wind, turbine) / 1e3, 2),
        with_decimals(law.pitch_share(wind), 3),
        with_decimals(table.effectiveness[k], 4),
        with_decimals(table.effectiveness_limit[k], 4),
        Tex(with_decimals(gains.proportional[k], 5) + (r"\rlap{$^\dagger$}" if limited else "")),
        NONE if last else with_decimals(gains.integral_rate[k], 6),
        NONE if last else with_decimals(law.feedforward.inertia[k], 4),
        NONE if last else with_decimals(law.feedforward.effort_limit[k], 4),
    ]
