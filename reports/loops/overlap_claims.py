"""The claims about a turbine in short: one per pair of overlaps, and the one-step search.

Winds count as proved only if the checker says so: all claimed winds of a PROVED claim; for any
other claim, the ranges that its text names as proved, or none if the text cannot be parsed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.claims.turbine.published_search import Span, gaps, merged

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.lmi.turbine.one_step.design_point import ReachedValues

KIND = "paper-loop"
NUMBER = r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
RANGE = re.compile(rf"{NUMBER} to {NUMBER}")
PROVED_WINDS = re.compile(r"proved for winds (.+?)(?: \(\+\d+ more\))? m/s with ")
DECAY = re.compile(rf"at no less than {NUMBER} to {NUMBER} 1/s")
HALF_WIDTH = re.compile(rf"in a stated set \(speed within {NUMBER} to {NUMBER} rad/s\)")
SPEED = re.compile(rf"the speed is within {NUMBER} % of rated of its reference")
PITCH = re.compile(r"of rated of its reference, (pitch within [^;]*)")
FEW, MOST = 3, 6


@dataclass(frozen=True, slots=True)
class OverlapClaim:
    """The claim for one pair of overlaps.

    Attributes
    ----------
    name, text, verdict : the checker's.
    speed_overlap : eps_omega [rad/s];  torque_overlap : eps_T [N m].
    chosen : whether these are the overlaps of the law that is emitted.
    proved : disjoint winds for which it is proved [m/s];  left : those examined and not proved.
    decay : (least, greatest) proved decay rate over the winds [1/s];  speed_share : bound on the
        speed's distance from its reference at rest [% of rated];  half_width : of the widest set,
        in speed [rad/s].  The checker's digits; empty where it names none.
    pitch : how far pitch rests from the trim tables', in the checker's words.
    """

    name: str
    text: str
    verdict: Verdict
    speed_overlap: float
    torque_overlap: float
    chosen: bool
    proved: tuple[Span, ...]
    left: tuple[Span, ...]
    decay: tuple[str, ...]
    speed_share: str
    half_width: str
    pitch: str

    @property
    def label(self) -> str:
        """The overlaps with their units."""
        return f"{self.speed_overlap:g} rad/s, {self.torque_overlap:g} N m"


def overlap_claims(design: TurbineDesign) -> tuple[OverlapClaim, ...]:
    """Return the claims about a published law in the file's order; none for another law."""
    coupling = design.document["gains"].get("coupling", {})
    own = coupling.get("speed_overlap"), coupling.get("torque_overlap")
    pairs = zip(design.document["claims"], design.checked.claims, strict=True)
    return tuple(_short(stated, checked, own) for stated, checked in pairs if _concerned(stated))


def wind_words(claim: OverlapClaim) -> str:
    """Return the proved winds in a few words, no wider than what is proved; "none" without any."""
    proved, count = claim.proved, len(claim.proved)
    if not proved:
        return "none"
    if width := window_width(claim):
        # One window may be left out in several parts.
        looked = count + len(merged(claim.left, reach=width))
        first, last = proved[0][0], proved[-1][0]
        return f"{count} of {looked} windows, from {first:g} to {last:g} m/s"
    more = f" (+{count - MOST} more)" if count > MOST else ""
    return ", ".join(span_words(span, inward=True) for span in proved[:MOST]) + f"{more} m/s"


def gap_words(claim: OverlapClaim) -> str:
    """Return the winds examined and not proved, never narrower than they are."""
    more = f" (+{len(claim.left) - MOST} more)" if len(claim.left) > MOST else ""
    gaps = ", ".join(span_words(span, inward=False) for span in claim.left[:MOST])
    return f"{gaps}{more} m/s" if gaps else "none"


def window_width(claim: OverlapClaim) -> float:
    """Return the width [m/s] of the windows that the winds consist of; 0 where they do not."""
    widths = [round(high - low, 6) for low, high in claim.proved]
    return widths[0] if len(widths) > FEW and len(set(widths)) == 1 else 0.0


def _concerned(stated: Mapping[str, Any]) -> bool:
    return bool(stated["kind"] == KIND)


def _short(stated: Mapping[str, Any], checked: Claim, own: tuple[object, object]) -> OverlapClaim:
    claimed = [(float(low), float(high)) for low, high in stated["winds"]]
    named = [gap["wind"] for gap in stated["unproved"]]
    proved = _proved(merged(claimed), checked)
    looked = merged([*claimed, *((float(low), float(high)) for low, high in named)])
    decay, width, speed, pitch = (
        found.groups() if (found := words.search(checked.text)) and proved else ()
        for words in (DECAY, HALF_WIDTH, SPEED, PITCH)
    )
    return OverlapClaim(
        name=checked.name,
        text=checked.text,
        verdict=checked.verdict,
        speed_overlap=float(stated["speed_overlap"]),
        torque_overlap=float(stated["torque_overlap"]),
        chosen=(stated["speed_overlap"], stated["torque_overlap"]) == own,
        proved=proved,
        left=tuple(gap for span in looked for gap in gaps(span, proved)),
        decay=decay,
        speed_share="".join(speed),
        half_width=width[1] if width else "",
        pitch="".join(pitch),
    )


def _proved(claimed: Sequence[Span], checked: Claim) -> tuple[Span, ...]:
    """Return the winds that are certainly proved, within those claimed."""
    if checked.verdict is Verdict.PROVED:
        return tuple(claimed)
    words = PROVED_WINDS.match(checked.text)
    if checked.verdict is not Verdict.UNDECIDED or words is None:
        return ()
    ranges = [RANGE.fullmatch(part) for part in words[1].split(", ")]
    named = [(float(found[1]), float(found[2])) for found in ranges if found is not None]
    if len(named) < len(ranges):
        return ()
    inside = [(max(a, low), min(b, high)) for a, b in named for low, high in claimed]
    return tuple(merged([span for span in inside if span[0] < span[1]]))


def span_words(span: Span, *, inward: bool) -> str:
    """Return "low to high" of winds, rounded so that it is no wider (inward), or no narrower."""
    turns = (math.ceil, math.floor) if inward else (math.floor, math.ceil)
    low, high = (turn(round(1000 * end, 6)) / 1000 for turn, end in zip(turns, span, strict=True))
    # A range below the digits shown keeps its own.
    return f"{low:.7g} to {high:.7g}" if low < high else f"{span[0]:.9g} to {span[1]:.9g}"


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
