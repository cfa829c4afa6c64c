"""The certificate file and its members.

certificate_file          the file: model, law, claims as decimals, with hashes
model_data                a Takagi-Sugeno model and its law
plant_text, plant_tables  a plant's numbers, expressions and tables
plant_embedding           a plant, the model derived from it, and the claim that ties them
observer_data             an observer: gains, outputs, and the plant's slopes
plant_blend               a plant behind a blend, and the claim that the blend is the plant
provenance                configuration, versions, the solver's messages
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.document.certificate_file import (
        certificate_document,
        content_of,
        dumps,
        effort_sharing_law_data,
        turbine_data,
    )
    from takagi.certificates.document.model_data import pdc_law_data, ts_model_data
    from takagi.certificates.document.observer_data import (
        observer_member,
        slope_claim,
        slopes_data,
    )
    from takagi.certificates.document.plant_embedding import (
        embedding_claim,
        law_members,
        plant_data,
    )

__all__ = [
    "certificate_document",
    "content_of",
    "dumps",
    "effort_sharing_law_data",
    "embedding_claim",
    "law_members",
    "observer_member",
    "pdc_law_data",
    "plant_data",
    "slope_claim",
    "slopes_data",
    "ts_model_data",
    "turbine_data",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
