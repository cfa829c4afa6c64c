"""Test whether gains depend on signals that a law does not know.

A rule is a corner of premises.  A law cannot compute the weights of premises with a hidden signal.
If all rules with the same corners of the other premises have one gain, these weights cancel in the
sum of weights times gains.
"""

from __future__ import annotations

from itertools import product
from typing import Any

from takagi.certificates.cross_check.kernel.reading import Refusal, stack
from takagi.certificates.cross_check.plant.expression import names_in
from takagi.certificates.cross_check.plant.plant import TreePlant


def goes_with_known(plant: TreePlant, hidden: set[str], gains: Any) -> bool:
    """Return whether rules that differ only in premises with a hidden symbol have equal gains.

    Raises
    ------
    Refusal : another number of gains than of rules.
    """
    K = stack(gains, "K")
    if len(K) == 1:
        return True
    seen = [not hidden & set(names_in(p.tree)) for p in plant.premises]
    corners = list(product(*(range(1 + (p.lower < p.upper)) for p in plant.premises)))
    if len(K) != len(corners):
        raise Refusal(f"K: {len(corners)} gains are needed")
    first: dict[tuple[int, ...], Any] = {}
    for corner, gain in zip(corners, K, strict=True):
        key = tuple(c for c, known in zip(corner, seen, strict=True) if known)
        if first.setdefault(key, gain) != gain:
            return False
    return True
