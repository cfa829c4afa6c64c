"""Say in words which items of an LMI exclude a solution: those with the largest multipliers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from takagi.lmi.condition.term import LMI, Condition
from takagi.models.arrays import Floats

# Items with less of the bound than this are not reported.
LEAST = 0.02


class Share(NamedTuple):
    """How much of the bound on the margin an item carries: its label, its LMI, and 0 ... 1."""

    label: str
    lmi: str
    share: float


def binding_items(
    condition: Condition, multipliers: Mapping[str, Floats], *names: str, most: int = 3
) -> str:
    """Return e.g. ``"the no rests on vertex 2 of 8 (61% of the multipliers that show it)"``.

    Parameters
    ----------
    names : the LMIs to examine.
    """
    shares = binding_shares(condition, multipliers, *names)
    if not shares:
        return "the no depends on no single inequality"
    return f"the no rests on {shares_in_words(shares[:most])}"


def asks_for_decay(condition: Condition) -> bool:
    """Return whether a decay rate above 0 is asked for, which might be lowered."""
    given = condition.parameters
    if not {"alpha", "contraction"} & set(given):
        return True  # the rate is not a parameter of the condition
    return given.get("alpha", 0.0) > 0 or given.get("contraction", 1.0) < 1


def advice_about_limit(condition: Condition) -> str:
    """Return what to change a little where a condition is at its limit."""
    if asks_for_decay(condition):
        return "lower the decay rate a little"
    return "shrink the box a little"


def shares_in_words(shares: Sequence[Share]) -> str:
    """Return labels with their shares; what these are shares of stands behind the first.

    Multipliers show the no: an item without any could be left out, and it would still be no.
    """
    first = f"{shares[0].label} ({shares[0].share:.0%} of the multipliers that show it)"
    return ", ".join([first, *(f"{one.label} ({one.share:.0%})" for one in shares[1:])])


def binding_shares(
    condition: Condition, multipliers: Mapping[str, Floats], *names: str
) -> tuple[Share, ...]:
    """Return the items that carry more than 2% of the bound on the margin, largest first.

    The trace of an item's multiplier times the item's size is its share in the bound on the
    margin: items without a share could be left out and the answer would still be no.

    Parameters
    ----------
    names : the LMIs to examine; without names, all that have a weight.
    """
    found = []
    for lmi in condition.lmis:
        if lmi.name in multipliers and (lmi.name in names or (not names and lmi.strict)):
            traces = _size(lmi) * np.trace(multipliers[lmi.name], axis1=1, axis2=2)
            found += [Share(lmi.label(k), lmi.name, float(t)) for k, t in enumerate(traces)]
    total = sum(one.share for one in found)
    if total <= 0:
        return ()
    # A stable order: of equal shares the first item is named first.
    found.sort(key=lambda one: -one.share)
    return tuple(
        one._replace(share=one.share / total) for one in found if one.share > LEAST * total
    )


def _size(lmi: LMI) -> float:
    """Return the natural size of an LMI: its weight, or that of its constants."""
    constants = (float(np.abs(c.value.astype(np.float64)).max()) for c in lmi.constants)
    return max(lmi.weight, *constants, 0.0)
