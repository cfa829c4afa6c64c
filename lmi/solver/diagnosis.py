"""Say in words which items of an LMI stand in the way: where the multipliers are largest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from takagi.lmi.answer import Floats
from takagi.lmi.term import LMI, Condition

__all__ = ["binding_items"]


def binding_items(
    condition: Condition, multipliers: Mapping[str, Floats], *names: str, most: int = 3
) -> str:
    """Return e.g. ``"binding: vertex 2 of 8 (61%), vertex 5 of 8 (39%)"``.

    The trace of an item's multiplier times the item's size is its share in the bound on the
    margin: items without a share could be left out and the answer would still be no.

    Parameters
    ----------
    names : the LMIs to look at.
    """
    shares = []
    for lmi in condition.lmis:
        if lmi.name in names and lmi.name in multipliers:
            traces = _size(lmi) * np.trace(multipliers[lmi.name], axis1=1, axis2=2)
            shares += [(float(trace), lmi.label(k)) for k, trace in enumerate(traces)]
    total = sum(share for share, _ in shares)
    if total <= 0:
        return "no single item binds"
    shares.sort(key=lambda pair: -pair[0])
    large = [pair for pair in shares[:most] if pair[0] > 0.02 * total]
    return "binding: " + ", ".join(f"{name} ({share / total:.0%})" for share, name in large)


def _size(lmi: LMI) -> float:
    """Return the natural size of an LMI: its weight, or that of its constants."""
    constants = (float(np.abs(c.value.astype(np.float64)).max()) for c in lmi.constants)
    return max(lmi.weight, *constants, 0.0)
