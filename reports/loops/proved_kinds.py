"""Which claims of a certificate are proved, and of which kinds they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from takagi.certificates.checker.kernel.result import Checked, Verdict

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign

EMBEDDINGS = {"sector-embedding", "secant-embedding"}


def proved_claims(
    document: Mapping[str, Any], checked: Checked, kind: str | None = None
) -> list[Mapping[str, Any]]:
    """Return the claims that are proved, of one kind if one is given, as the file states them."""
    pairs = zip(document.get("claims", []), checked.claims, strict=False)
    proved = [stated for stated, result in pairs if result.verdict is Verdict.PROVED]
    return [stated for stated in proved if kind in (None, stated.get("kind"))]


def proved_kinds(design: PlantDesign) -> set[str]:
    """Return the kinds of the claims that are proved."""
    return {str(claim.get("kind")) for claim in proved_claims(design.document, design.checked)}


def embedded(design: PlantDesign) -> bool:
    """Return whether it is proved, by the checker, that the model is the plant on its box."""
    return bool(EMBEDDINGS & proved_kinds(design))
