"""Thousands of random simulations of a certified loop, inside and outside its certified class.

    loop      plant, law and claim as numbers, from the certificate's document alone
    motion    one run of the nonlinear loop, compared with every bound of the certificate
    runs      many runs, inside or beyond the certified class: ``run_campaigns``

No proof uses this code, and this code uses no result of a proof.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.campaign.loop import CertifiedLoop as CertifiedLoop
    from takagi.certificates.campaign.loop import certified_loop as certified_loop
    from takagi.certificates.campaign.motion import BOUNDS as BOUNDS
    from takagi.certificates.campaign.runs import INSIDE as INSIDE
    from takagi.certificates.campaign.runs import STANDARD as STANDARD
    from takagi.certificates.campaign.runs import Beyond as Beyond
    from takagi.certificates.campaign.runs import Campaign as Campaign
    from takagi.certificates.campaign.runs import beyond_of as beyond_of
    from takagi.certificates.campaign.runs import run_campaigns as run_campaigns

__getattr__, __dir__ = lazy_names(__name__)
