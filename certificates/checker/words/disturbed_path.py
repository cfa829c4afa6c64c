"""What a disturbance and an output are in the sentence of a claim about the path between them."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.family import Family
from takagi.certificates.checker.words.deviations import deviations

__all__ = ["path_deviations", "shown_path"]


def shown_path(claim: Any, family: Family) -> str:
    """Return in words what w is, and where y comes from."""
    alone = ", without the model's disturbance" if family.E else ""
    given = claim["disturbance"] == "disturbances"
    way = "the model's disturbance" if given else f"added to u{alone}"
    return f"w {way}, y {'of the claim' if 'output' in claim else 'the output of the model'}"


def path_deviations(claim: Any, family: Family, others: str = "") -> str:
    """Return what w and y, and other letters, stand for where they do not rest at 0.

    A w that is added to u is no deviation; an output that the claim writes itself is of x and u.
    """
    seen = {*others, *("xu" if "output" in claim else "y")}
    seen |= {"w"} if claim["disturbance"] == "disturbances" else set()
    return deviations(family, "".join(a for a in "xuyw" if a in seen))
