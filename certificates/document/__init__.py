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
        certificate_document as certificate_document,
    )
    from takagi.certificates.document.certificate_file import content_of as content_of
    from takagi.certificates.document.certificate_file import dumps as dumps
    from takagi.certificates.document.certificate_file import (
        effort_sharing_law_data as effort_sharing_law_data,
    )
    from takagi.certificates.document.certificate_file import turbine_data as turbine_data
    from takagi.certificates.document.model_data import pdc_law_data as pdc_law_data
    from takagi.certificates.document.model_data import ts_model_data as ts_model_data
    from takagi.certificates.document.observer_data import observer_member as observer_member
    from takagi.certificates.document.observer_data import slope_claim as slope_claim
    from takagi.certificates.document.observer_data import slopes_data as slopes_data
    from takagi.certificates.document.plant_embedding import embedding_claim as embedding_claim
    from takagi.certificates.document.plant_embedding import law_members as law_members
    from takagi.certificates.document.plant_embedding import plant_and_claim as plant_and_claim
    from takagi.certificates.document.plant_embedding import plant_data as plant_data

__getattr__, __dir__ = lazy_names(__name__)
