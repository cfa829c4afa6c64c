"""The shared design with a published law in the place of its own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from takagi.certificates import TurbineDesign
from takagi.models.laws.published.law import published_law
from takagi.models.laws.published.regional_schedule import (
    Variant,
    coupling_filter,
    regional_schedule,
)


def with_published_law(
    design: TurbineDesign, variant: Variant = "saturated", **parts: Any
) -> TurbineDesign:
    turbine, regional = design.turbine, design.regional
    partial, full = (
        regional_schedule(turbine, region.model, k_x=k_x, k_I=k_I)
        for region in (regional.partial, regional.full)
        for k_x, k_I in [region.require()]
    )
    coupling = coupling_filter(turbine, variant=variant)
    law = published_law(turbine, partial=partial, full=full, coupling=coupling)
    return replace(design, law=law, effort=None, candidate=None, **parts)
