"""Why a region has no gains: the condition, the winds, and what to relax."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.diagnosis import binding_items
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.turbine.region_request import RegionRequest, Requirement
from takagi.models.turbine.regional_model import WIND_ESTIMATE

BISECTIONS = 8


def why_none(task: RegionRequest, condition: Condition, outcome: Outcome) -> str:
    """Return the sentence that names condition, region, winds, and each single change."""
    low, high = (float(end) for end in task.model.box[WIND_ESTIMATE])
    names = [lmi.name for lmi in condition.lmis]
    asked = task.requirement
    said = (
        f"{task.region}, {low:.4g} to {high:.4g} m/s: no gains were found ({outcome.status}) with "
        f"decay rate {asked.decay_rate:.4g} 1/s from speed errors up to {asked.speed_error:.4g} "
        f"rad/s and pitch errors up to {asked.pitch_error:.4g} rad"
    )
    if outcome.multipliers:
        said += f": {binding_items(condition, outcome.multipliers, *names)}"
    slower = _largest_share(task, lambda s: replace(asked, decay_rate=s * asked.decay_rate))
    smaller = _largest_share(
        task,
        lambda s: replace(
            asked, speed_error=s * asked.speed_error, pitch_error=s * asked.pitch_error
        ),
    )
    free = decide(task.condition(asked, bounded=False)).status == "candidate"
    unboxed = decide(task.condition(asked, boxed=False)).status == "candidate"
    advice = [f"lower the decay rate to {slower * asked.decay_rate:.3g} 1/s"] if slower else []
    if smaller:
        advice.append(f"shrink the operating set to {smaller:.0%}")
    if free:
        advice.append("widen the actuator limits (without them there are gains)")
    if unboxed:
        advice.append(
            "give the model wider bands, if its bounds allow (the ellipsoid does not fit into them)"
        )
    advice.append("narrow the wind range, so that the rules differ less")
    return f"{said}; relax one of these: {', or '.join(advice)}"


def _largest_share(task: RegionRequest, scaled: Callable[[float], Requirement]) -> float:
    """Return the largest share, in steps, at which there are gains; 0 for none down to 1/32."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if decide(task.condition(scaled(middle))).status == "candidate":
            low = middle
        else:
            high = middle
        if high < 1 / 32:
            return 0.0
    return low
