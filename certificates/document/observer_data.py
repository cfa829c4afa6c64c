"""What a certificate states of an observer: gains, measured outputs, and the plant's slopes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from takagi.certificates.document.plant_embedding import plant_data
from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel


def observer_member(L: Floats, measured: Sequence[str], *, at_estimate: bool) -> dict[str, Any]:
    """Return the member ``observer`` of a law.

    Parameters
    ----------
    L : (r, n, p), or (1, n, p) for one gain in all rules.
    measured : names of the p outputs that the observer has.
    at_estimate : whether the weights are those at the estimate; else they are the plant's own.
    """
    same = bool((L == L[0]).all())
    return {
        "weights": "estimated" if at_estimate else "measured",
        "measured": list(measured),
        "L": (L[:1] if same else L).tolist(),
    }


def slopes_data(slopes: TSModel) -> dict[str, Any]:
    """Return the member ``slopes`` of a model of kind ``plant``: premises and entries.

    Parameters
    ----------
    slopes : the plant's ``secant_model``.

    Raises
    ------
    ModelError : as ``plant_data``.
    """
    found = dict(plant_data(slopes)["embedding"])
    del found["form"]
    return found


def slope_claim(name: str) -> dict[str, Any]:
    """Return the claim that the slopes of the plant lie in those of the certificate."""
    return {"name": f"slopes of {name or 'the plant'}", "kind": "slope-embedding"}
