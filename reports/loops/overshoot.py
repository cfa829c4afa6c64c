"""How far motions go beyond their start: the best of the bounds that proved functions give."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.claims.certification import USEFUL
from takagi.models.arrays import Floats
from takagi.reports.loops.proved_kinds import proved_claims

if TYPE_CHECKING:
    from collections.abc import Iterator

    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop

# Their V never grows where the certificate holds.
KINDS = ("decay", "transient", "invariant-ellipsoid")
# Far above the rounding of the formula below in floating point.
_ROUNDED = 1 + 1e-6


def overshoots(design: PlantDesign, loop: PlantLoop) -> dict[str, float]:
    """Return state -> k: started with this state alone off rest, it gets at most k times as far.

    A V = x' P x that does not grow gives |x_k(t)| <= (P_kk (P^-1)_kk)^(1/2) |x_k(0)|, whatever the
    units; the least over the proved functions is returned.  The functions are proved, the figures
    are computed from them in floating point.  They hold for starts in the proved set, and {} is
    returned where there is none, or a disturbance that moves the state.  A state whose bound is
    above 10 is left out: it says nothing.  {} too for a law with outputs, whose motions depend on
    the estimate.
    """
    disturbed = any(not v.schedules for v in loop.plant.disturbances)
    if not loop.level_proved or disturbed or loop.observed is not None:
        return {}
    bounds = [np.sqrt(np.diag(P) * np.diag(np.linalg.inv(P))) for P in _functions(design)]
    least: Floats = _ROUNDED * np.min(bounds, axis=0)
    found = zip(loop.names, least, strict=True)
    return {name: float(most) for name, most in found if most <= USEFUL}


def _functions(design: PlantDesign) -> Iterator[Floats]:
    for kind in KINDS:
        for claim in proved_claims(design.document, design.checked, kind):
            if Fraction(str(claim.get("decay_rate", 0))) >= 0:
                yield np.array([[float(Fraction(str(p))) for p in row] for row in claim["P"]])
