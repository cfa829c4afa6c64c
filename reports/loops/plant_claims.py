"""What proved claims say in numbers.

Of a plant: overshoot, settling, disturbances withstood.  Of a turbine: those about Schulte's law,
and the one-step search.  Winds count as proved only if the checker says so: it replays each claim,
and returns the cells that hold.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.obligation import decided_exactly
from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.turbine.published.loop import Loop
from takagi.certificates.checker.turbine.published.loop_claim import PublishedLoop
from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.certificates.claims.certification import USEFUL
from takagi.certificates.claims.turbine.published import Span, merged
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.certificates.requests.tracking import jump_shares
from takagi.lmi.turbine.one_step.design_point import OBJECTIVES
from takagi.models.arrays import Floats
from takagi.models.plant.plant import Variable
from takagi.reports.loops.plant_loop import PlantLoop, claimed_matrix, proved_claims

SETTLED = 0.02
# Far above the rounding of the formulas below in floating point.
_ROUNDED = 1 + 1e-6


def half_widths(loop: PlantLoop) -> Floats | None:
    """Return (n,): how far each state gets at most from rest, from anywhere in the proved set.

    None where no set is proved to be invariant.
    """
    if not (loop.bounded and loop.level_proved):
        return None
    P, level = loop.ellipsoid
    return np.asarray(np.sqrt(level * np.diag(np.linalg.inv(P))), dtype=np.float64)


def norm_settling_time(rate: float) -> float:
    """Return the time [s] in which exp(-rate t) falls to 2 %, a bound on sqrt(V(t) / V(0))."""
    return float(_ROUNDED * -np.log(SETTLED) / rate)


def settling_time(loop: PlantLoop) -> float | None:
    """Return T [s] after which every state stays below 2 % of its half-width of the set.

    From anywhere in {x' P x <= c}, W = x' D x of the proved decay is at first lambda c at most,
    with D <= lambda P; then |x_k| <= (W (D^-1)_kk)^(1/2), and W falls at least as exp(-2 alpha t).
    The claims are proved, this conclusion from them is computed in floating point.  Disturbances
    and references are at rest.  None without proved set or decay.
    """
    reach = half_widths(loop)
    if loop.observed is not None:
        # V is the function of the set itself: |x_k| is at most its half-width times sqrt(V / c).
        proved = reach is not None and loop.decay_rate
        return norm_settling_time(loop.decay_rate) if proved and loop.decay_rate else None
    if reach is None or not loop.decay_rate or loop.decay_P is None:
        return None
    P, level = loop.ellipsoid
    D = loop.decay_P
    largest = level * float(np.linalg.eigvals(np.linalg.solve(P, D)).real.max())
    begun = np.sqrt(largest * np.diag(np.linalg.inv(D)))
    return float(_ROUNDED * np.log((begun / reach).max() / SETTLED) / loop.decay_rate)


# Their V never grows where the certificate holds.
_NEVER_GROWING = ("decay", "transient", "invariant-ellipsoid")


def overshoots(design: PlantDesign, loop: PlantLoop) -> dict[str, float]:
    """Return state -> k: started with this state alone off rest, it gets at most k times as far.

    A V = x' P x that does not grow gives |x_k(t)| <= (P_kk (P^-1)_kk)^(1/2) |x_k(0)|, whatever the
    units; the least over the proved functions is returned.  The functions are proved, the figures
    are computed from them in floating point.  They hold for starts in the proved set, and {} is
    returned where there is none, or a disturbance that moves the state.  A state whose bound is
    above 10 is left out: it says nothing; and so are the states of a controller.  {} too for a law
    with outputs, whose motions depend on the estimate.
    """
    disturbed = any(not v.schedules for v in loop.plant.disturbances)
    if not loop.level_proved or disturbed or loop.observed is not None:
        return {}
    functions = [
        claimed_matrix(claim)
        for kind in _NEVER_GROWING
        for claim in proved_claims(design.document, design.checked, kind)
        if Fraction(str(claim.get("decay_rate", 0))) >= 0
    ]
    bounds = [np.sqrt(np.diag(P) * np.diag(np.linalg.inv(P))) for P in functions]
    if not bounds:
        return {}
    factors: Floats = _ROUNDED * np.min(bounds, axis=0)
    count = len(loop.names) - len(loop.plant.integrators)
    pairs = zip(loop.names[:count], factors, strict=False)
    return {name: float(factor) for name, factor in pairs if factor <= USEFUL}


_INVARIANT = ("invariant-ellipsoid", "input-limits")


@dataclass(frozen=True, slots=True)
class Withstood:
    """A disturbance as a deviation from rest, in SI.

    Attributes
    ----------
    proved : the largest |w - w*| for which a set is proved to be invariant; 0 where none is.
    stated : the largest |w - w*| in the range of the file.
    """

    variable: Variable
    proved: float
    stated: float

    @property
    def share(self) -> float:
        """proved over stated, at most 1."""
        # Twelve digits: 0.007 of 0.05 is 14 %, not the float below it.
        return min(1.0, float(f"{self.proved / self.stated:.12g}"))


def withstood(design: PlantDesign) -> list[Withstood]:
    """Return the disturbances that have a range and are no scheduling signals; [] for none."""
    disturbances = design.plant.disturbances
    bounds = [0.0] * len(disturbances)
    for kind in _INVARIANT:
        for claim in proved_claims(design.document, design.checked, kind):
            stated = claim.get("disturbance_bounds")
            if stated is not None and len(stated) == len(bounds):
                claimed = [float(Fraction(str(bound))) for bound in stated]
                bounds = [max(pair) for pair in zip(bounds, claimed, strict=True)]
    rows = []
    for variable, proved in zip(disturbances, bounds, strict=True):
        side = variable.range
        if side is None or variable.schedules:
            continue
        largest = max(abs(float(end - variable.rest)) for end in (side.lower, side.upper))
        if largest > 0:
            rows.append(Withstood(variable, proved, largest))
    return rows


def proved_jumps(design: PlantDesign) -> list[dict[str, float]]:
    """Return the largest proved jumps from rest, up and down, within the ranges."""
    claims = list(proved_claims(design.document, design.checked, "tracking"))
    if not claims:
        return []
    signals = {v.name: v for v in design.plant.disturbances}
    found = []
    for one, share in zip(
        design.plant.references, jump_shares(design.plant, claims[0]), strict=True
    ):
        variable = signals[one.name]
        assert variable.range is not None  # a reference has one
        low, high, rest = map(float, (variable.range.lower, variable.range.upper, variable.rest))
        reach = share * (high - low)
        ends = (max(low, rest - reach), min(high, rest + reach))
        found += [{one.name: end} for end in ends if end != rest]
    return found


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
    aim = design.settings.objective
    return next(
        (name for name, objective in OBJECTIVES.items() if objective == aim), "weights of its own"
    )
