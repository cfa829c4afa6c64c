"""Thousands of random simulations of a certified loop, inside and outside its certified class.

    loop, spline_patches    plant, law and claim as numbers, from the certificate's document alone
    motion                  the nonlinear loop of docs/effort-sharing-loop.md, n runs at once
    plants, winds           starts, plants and winds of the certified class; adversaries
    bounds                  every bound of the certificate, as a ratio that must not exceed 1
    batch, runs             steps that end at wind nodes, and records: ``run_campaign``
    outside                 campaigns outside the certified class
    first_breaks            which bound is exceeded first in them

No proof uses this code, and this code uses no result of a proof.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.campaign.bounds import BOUNDS as BOUNDS
    from takagi.certificates.campaign.first_breaks import Break as Break
    from takagi.certificates.campaign.first_breaks import breaks_of as breaks_of
    from takagi.certificates.campaign.loop import CertifiedLoop as CertifiedLoop
    from takagi.certificates.campaign.loop import certified_loop as certified_loop
    from takagi.certificates.campaign.outside import INSIDE as INSIDE
    from takagi.certificates.campaign.outside import STANDARD as STANDARD
    from takagi.certificates.campaign.outside import Beyond as Beyond
    from takagi.certificates.campaign.outside import beyond_of as beyond_of
    from takagi.certificates.campaign.runs import Campaign as Campaign
    from takagi.certificates.campaign.runs import run_campaign as run_campaign
    from takagi.certificates.campaign.winds import PLAYERS as PLAYERS

__getattr__, __dir__ = lazy_names(__name__)
