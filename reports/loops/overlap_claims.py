"""The claims about a turbine in short: those about Schulte's law, and the one-step search.

Winds count as proved only if the checker says so: it replays each claim, and returns the cells that
hold.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.obligation import decided_exactly
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.turbine.published.loop import Loop
from takagi.certificates.checker.turbine.published.loop_claim import PublishedLoop
from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.certificates.claims.turbine.published_search import Span, merged

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

KIND = "paper-loop"
MOST = 6


@dataclass(frozen=True, slots=True)
class OverlapClaim:
    """The claim for one pair of overlaps.

    Attributes
    ----------
    name, text, verdict : the checker's.
    speed_overlap : eps_omega [rad/s];  torque_overlap : eps_T [N m].
    proved : disjoint winds for which it is proved [m/s];  unproved : those examined without proof.
    decay : (least, greatest) proved decay rate over the winds [1/s];  speed_share : bound on the
        speed's distance from its reference at rest [% of rated];  half_width : of the widest set,
        in speed [rad/s].  Rounded so that they hold; empty where no wind is proved.
    """

    name: str
    text: str
    verdict: Verdict
    speed_overlap: float
    torque_overlap: float
    proved: tuple[Span, ...]
    unproved: tuple[Span, ...]
    decay: tuple[str, ...]
    speed_share: str
    half_width: str

    @property
    def label(self) -> str:
        """The overlaps with their units."""
        return f"{self.speed_overlap:g} rad/s, {self.torque_overlap:g} N m"


def overlap_claims(design: TurbineDesign) -> tuple[OverlapClaim, ...]:
    """Return the claims about a published law in the file's order; none for another law."""
    document, checked = design.document, design.checked
    return tuple(
        OverlapClaim(
            name=claim.name,
            text=claim.text,
            verdict=claim.verdict,
            speed_overlap=float(stated["speed_overlap"]),
            torque_overlap=float(stated["torque_overlap"]),
            **proved_cells(document, k),
        )
        for k, (stated, claim) in enumerate(zip(document["claims"], checked.claims, strict=True))
        if stated["kind"] == KIND
    )


def proved_cells(document: Mapping[str, Any], k: int) -> Mapping[str, Any]:
    """Return the figures of claim k of a certificate, from those of its cells that hold."""
    excerpt = {"claim": document["claims"][k], "model": document["model"]}
    return _proved_cells(json.dumps(excerpt | {"gains": document["gains"]}), f"claims[{k}]")


@lru_cache(maxsize=32)
def _proved_cells(written: str, where: str) -> Mapping[str, Any]:
    excerpt = read_text(written, where)
    claim = PublishedLoop.read(excerpt["claim"], excerpt, (), where)
    failures = claim.failures(decided_exactly)
    cells = [cell for k, cell in enumerate(claim.cells) if k not in failures]
    figures: dict[str, Any] = {
        name: tuple(merged([(float(low), float(high)) for low, high in spans]))
        for name, spans in (
            ("proved", [cell.ends.wind for cell in cells]),
            ("unproved", [*claim.missing(cells), *claim.unproved]),
        )
    }
    if not cells:
        return figures | {"decay": (), "speed_share": "", "half_width": ""}
    plant = claim.plant
    loops = [Loop(plant, claim.law, claim.overlaps, cell.ends, "none") for cell in cells]
    error = Fraction(max(loop.error.value.magnitude() for loop in loops), ONE)
    rates = [cell.rate for cell in cells]
    return figures | {
        "decay": (at_least(min(rates), 3), at_least(max(rates), 3)),
        "speed_share": at_most(100 * error / plant.rated_speed, 3),
        "half_width": at_most(max(cell.ends.widths[0] for cell in cells), 3),
    }


def wind_words(claim: OverlapClaim) -> str:
    """Return the proved winds in a few words, no wider than what is proved; "none" without any."""
    proved, count = claim.proved, len(claim.proved)
    if not proved:
        return "none"
    omitted = f" (+{count - MOST} more)" if count > MOST else ""
    return ", ".join(span_words(span, inward=True) for span in proved[:MOST]) + f"{omitted} m/s"


def gap_words(claim: OverlapClaim) -> str:
    """Return the winds examined and not proved, never narrower than they are."""
    omitted = f" (+{len(claim.unproved) - MOST} more)" if len(claim.unproved) > MOST else ""
    gaps = ", ".join(span_words(span, inward=False) for span in claim.unproved[:MOST])
    return f"{gaps}{omitted} m/s" if gaps else "none"


def span_words(span: Span, *, inward: bool) -> str:
    """Return "low to high" of winds, rounded so that it is no wider (inward), or no narrower."""
    turns = (math.ceil, math.floor) if inward else (math.floor, math.ceil)
    low, high = (turn(round(1000 * end, 6)) / 1000 for turn, end in zip(turns, span, strict=True))
    # A range below the digits shown keeps its own.
    return f"{low:.7g} to {high:.7g}" if low < high else f"{span[0]:.9g} to {span[1]:.9g}"


def synthesis_words(design: TurbineDesign) -> str:
    """Return a line about how the gains were found; empty for the published laws."""
    synthesis = design.synthesis
    if synthesis is None:
        return ""
    if synthesis.joint is None:
        why = f", for {synthesis.kept}" if synthesis.kept else ""
        return f"two steps: gains wind by wind, then one function for all winds{why}"
    initial, final = synthesis.joint.before, synthesis.joint.after
    return (
        f"one step, {objective_name(design)}, {len(synthesis.joint.history) - 1} joint steps: "
        f"mean wind error {initial.wind_error:.4f} to {final.wind_error:.4f} m/s, decay "
        f"{initial.decay_rate:.4f} to {final.decay_rate:.4f} 1/s"
    )


def objective_name(design: TurbineDesign) -> str:
    """Return the name of what one step of synthesis made better, or "weights of its own"."""
    from takagi.lmi.turbine.one_step.objective import OBJECTIVES

    aim = design.settings.objective
    return next(
        (name for name, objective in OBJECTIVES.items() if objective == aim), "weights of its own"
    )
