"""The largest disturbance that a proved invariant set withstands, and the range in the file."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.reports.loops.proved_kinds import proved_claims

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.variables import Variable

_KINDS = ("invariant-ellipsoid", "input-limits")


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
        return min(1.0, self.proved / self.stated)


def withstood(design: PlantDesign) -> list[Withstood]:
    """Return the disturbances that have a range and are no scheduling signals; [] for none."""
    disturbances = design.plant.disturbances
    bounds = [0.0] * len(disturbances)
    for kind in _KINDS:
        for claim in proved_claims(design.document, design.checked, kind):
            stated = claim.get("disturbance_bounds")
            if stated is not None and len(stated) == len(bounds):
                found = [float(Fraction(str(bound))) for bound in stated]
                bounds = [max(pair) for pair in zip(bounds, found, strict=True)]
    rows = []
    for variable, proved in zip(disturbances, bounds, strict=True):
        side = variable.range
        if side is None or variable.schedules:
            continue
        far = max(abs(float(end - variable.rest)) for end in (side.lower, side.upper))
        if far > 0:
            rows.append(Withstood(variable, proved, far))
    return rows
