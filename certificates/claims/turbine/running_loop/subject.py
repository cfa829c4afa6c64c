"""A turbine and its law as the checker reads them, for the candidates of the running loop."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import (
    Box,
    Law,
    Plant,
    Subject,
    Uncertainty,
)
from takagi.certificates.document import effort_sharing_law_data, turbine_data

if TYPE_CHECKING:
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.turbine.data import Turbine

Ends = tuple[Fraction, Fraction]


def loop_subject(
    turbine: Turbine, law: EffortSharingLaw, sides: tuple[Fraction, ...], inertia: Ends
) -> Subject:
    """Return turbine, law, box and uncertainty, with the decimals that a certificate would have.

    Parameters
    ----------
    sides : of the box: speed error [rad/s], effort lag [rad/s^2], speed signal [rad/s], and the
        wind's share [-].
    inertia : true over nominal.
    """
    parts = {"model": turbine_data(turbine, []), "gains": effort_sharing_law_data(law)}
    data = read_text(json.dumps(parts), "document")
    one = Fraction(1)
    return Subject(
        Plant.read(data["model"]),
        Law.read(data["gains"]),
        Box(*sides),
        Uncertainty(inertia, False, (one, one)),
    )
