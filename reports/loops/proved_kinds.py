"""Which kinds of claims a plant's certificate proves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.certificates.checker.kernel.result import Verdict

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign

__all__ = ["embedded", "proved_kinds"]

EMBEDDING = "sector-embedding"


def proved_kinds(design: PlantDesign) -> set[str]:
    """Return the kinds of the claims that are proved."""
    claims = design.document.get("claims", [])
    pairs = zip(claims, design.checked.claims, strict=False)
    return {str(c.get("kind")) for c, found in pairs if found.verdict is Verdict.PROVED}


def embedded(design: PlantDesign) -> bool:
    """Return whether it is proved, by the checker, that the model is the plant on its box."""
    return EMBEDDING in proved_kinds(design)
