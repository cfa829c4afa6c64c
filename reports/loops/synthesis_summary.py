"""How the effort-sharing law's gains were found, and the improvement by the one-step synthesis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.lmi.turbine.one_step.value import ReachedValues


@dataclass(frozen=True, slots=True)
class SynthesisSummary:
    """Both ways of finding the gains, by the same analysis in floating point.

    Attributes
    ----------
    objective : the name of what was made better, or "weights of its own".
    before, after : what the two-step gains reach, and those found in one step; None where the
        two-step gains are the design's.
    steps : number of joint steps that were taken.
    kept : why the two-step gains were kept although one step was asked for; else empty.
    """

    objective: str
    before: ReachedValues | None
    after: ReachedValues | None
    steps: int
    kept: str


def synthesis_summary(design: TurbineDesign) -> SynthesisSummary | None:
    """Return how the gains were found; None for the published laws."""
    found = design.synthesis
    if found is None:
        return None
    joint = found.joint
    name = _name(design)
    if joint is None:
        return SynthesisSummary(name, None, None, 0, found.kept)
    return SynthesisSummary(name, joint.before, joint.after, len(joint.history) - 1, "")


def synthesis_words(design: TurbineDesign) -> str:
    """Return a line about how the gains were found; empty for the published laws."""
    found = synthesis_summary(design)
    if found is None:
        return ""
    if found.before is None or found.after is None:
        why = f", for {found.kept}" if found.kept else ""
        return f"two steps: gains wind by wind, then one function for all winds{why}"
    return (
        f"one step, {found.objective}, {found.steps} joint steps: mean wind "
        f"error {found.before.wind_error:.4f} to {found.after.wind_error:.4f} m/s, decay "
        f"{found.before.decay_rate:.4f} to {found.after.decay_rate:.4f} 1/s"
    )


def _name(design: TurbineDesign) -> str:
    from takagi.lmi.turbine.one_step.objective import OBJECTIVES

    aim = design.settings.objective
    return next((name for name, each in OBJECTIVES.items() if each == aim), "weights of its own")
