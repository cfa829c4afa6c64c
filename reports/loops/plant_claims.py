"""What the proved claims of a plant say in numbers: overshoot, settling, disturbances withstood."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.claims.certification import USEFUL
from takagi.models.arrays import Floats
from takagi.reports.loops.plant_loop import claimed_matrix, proved_claims

if TYPE_CHECKING:
    from collections.abc import Iterator

    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.plant import Variable
    from takagi.reports.loops.plant_loop import PlantLoop

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
    bounds = [np.sqrt(np.diag(P) * np.diag(np.linalg.inv(P))) for P in _functions(design)]
    if not bounds:
        return {}
    factors: Floats = _ROUNDED * np.min(bounds, axis=0)
    count = len(loop.names) - len(loop.plant.integrators)
    pairs = zip(loop.names[:count], factors, strict=False)
    return {name: float(factor) for name, factor in pairs if factor <= USEFUL}


def _functions(design: PlantDesign) -> Iterator[Floats]:
    for kind in _NEVER_GROWING:
        for claim in proved_claims(design.document, design.checked, kind):
            if Fraction(str(claim.get("decay_rate", 0))) >= 0:
                yield claimed_matrix(claim)


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
    from takagi.certificates.requests.tracking import jump_shares

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
