"""The certificate of a turbine's default law, without the claim about the loop with its observer.

``takagi design`` searches the cells of that claim as well, which takes most of its time.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from takagi.certificates.claims.turbine.loop_claims import loop_document
from takagi.certificates.design.turbine.effort_sharing_gains import (
    effort_sharing_gain_design,
    wind_by_wind_law,
)
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.models import Turbine
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.turbine.loader import load_turbine, model_files


class TurbineClaims(NamedTuple):
    """A turbine, its default settings and law, and the certificate of three claims."""

    turbine: Turbine
    asked: DesignSettings
    law: EffortSharingLaw
    document: dict[str, Any]


def turbine_claims(file: Path) -> TurbineClaims:
    """Return law and certificate as ``takagi design FILE`` makes them."""
    turbine = load_turbine(file)
    asked = default_settings(turbine)
    made = effort_sharing_gain_design(
        turbine,
        wind_by_wind_law(turbine, asked)[1],
        box=asked.box,
        uncertainty=asked.uncertainty,
        synthesis="two-step",
    )
    document = loop_document(turbine, made.law, made.candidate, asked, files=model_files(file))
    return TurbineClaims(turbine, asked, made.law, document)
