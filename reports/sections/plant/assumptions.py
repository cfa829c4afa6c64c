"""What each claim about a plant takes for granted, in short."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop

EMBEDDINGS = ("sector-embedding", "secant-embedding", "slope-embedding", "effort-blend")
SETS = ("invariant-ellipsoid", "input-limits", "sampled-loop", "observed-loop", "exit-probability")
# Kinds that have disturbances of their own.
_DISTURBED = ("l2-gain", "fuzzy-l2-gain", "h2-norm", "peak", "exit-probability", "tracking")


def assumptions(loop: PlantLoop, claim: Mapping[str, Any]) -> list[str]:
    """Return what this claim alone takes for granted."""
    kind = str(claim.get("kind", ""))
    if kind in (*EMBEDDINGS, "bumpless"):
        return ["equations and parameters as in the file", "variables in their ranges"]
    phrases = []
    if kind in SETS or kind == "tracking":
        phrases.append("start in the set")
    elif loop.model.box:
        phrases.append("states stay in their ranges")
    if loop.gains is not None:
        phrases.append("all states known exactly" if loop.observed is None else "exact outputs")
        if kind == "sampled-loop":
            phrases.append("no time for computing")
        elif not loop.discrete:
            phrases.append("no sampling")
    moving = any(not variable.schedules for variable in loop.plant.disturbances)
    if moving and not claim.get("disturbance_bounds") and kind not in _DISTURBED:
        phrases.append("no disturbance")
    if kind == "tracking":
        phrases.append("other signals constant, in their ranges")
    if claim.get("membership_rates") or (kind.startswith("fuzzy") and any(claim.get("rates", ()))):
        phrases.append("memberships keep to the stated rates")
    return phrases
