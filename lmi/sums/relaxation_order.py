"""Which relaxation contains which, by theorems; and the work of a solver for each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.sums.relaxation_sizes import RelaxationSize

# What "auto" tries.
NAMES = (
    "common-gain",
    "wang-tanaka-griffin",
    "tanaka-wang",
    "tuan",
    "kim-lee",
    "liu-zhang",
    "polya-1",
    "polya-2",
    "polya-4",
    "polya-8",
)
# The list if the premises are known; with a single premise these are Polya's relaxations.
PRODUCTS = ("product", "product-1", "product-2", "product-liu-zhang")

# A relaxation is not tried if one iteration of the solver takes more operations than this. That is
# about a second for an iteration, and half a minute or more for the whole call. The weight of a row
# accounts for the work in sparse matrices: a row took as long as 6e4 operations of a dense cone
# (measured with clarabel; 2 to 16 rules, 4 to 8 states).
MOST_WORK = 1e10
ROW = 6e4


def work_of(size: RelaxationSize) -> float:
    """Return about how many operations one iteration of an interior-point solver takes."""
    return sum(
        items * (ROW * triangle(width) + triangle(width) ** 3) for items, width in size.cones
    )


_BELOW: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "common-gain": (),
        "wang-tanaka-griffin": ("common-gain",),
        "tuan": ("wang-tanaka-griffin",),
        "tanaka-wang": ("wang-tanaka-griffin",),
        "kim-lee": ("tanaka-wang",),
        "liu-zhang": ("kim-lee",),
        "product-liu-zhang": ("liu-zhang", "product"),
        "auto": (*NAMES, *PRODUCTS),
        "polya-0": ("wang-tanaka-griffin",),
        "product-0": ("wang-tanaka-griffin",),
    }
)
SAME: Mapping[str, str] = MappingProxyType(
    {"polya-0": "wang-tanaka-griffin", "product": "product-0"}
)


def contains(rich: str, poor: str, *, few_active: bool = False) -> bool:
    """Return whether unknowns for ``poor`` always give unknowns for ``rich``, by a theorem.

    With M_j = M, Theta_ij + Theta_ji is Theta_i + Theta_j, so one gain gives all pairs.  All pairs
    give Tuan's by adding Theta_ii < 0, and Tanaka and Wang's by a small Y; theirs give Kim and
    Lee's by X_ii = -(r - 1) Y - eps I, X_ij = Y, since 1 1' <= r I; Liu and Zhang only drop the
    symmetry of X_ij.  All pairs are Polya's degree 0; negative definite coefficients stay so when
    the polynomial is multiplied by h_1 + ... + h_r, and when those of equal products of corner
    weights are added up.  "auto" contains the relaxations that it tries, except those that are too
    large. False is no evidence of the contrary: for some pairs no theorem is known.

    Parameters
    ----------
    few_active : at most this many rules are known to act at a time that Tanaka and Wang's s is
        smaller than r, and than the number of rules that some rule acts with; Kim and Lee's and
        those above it make no use of that, so they do not contain Tanaka and Wang's then.
    """
    rich, poor = SAME.get(rich, rich), SAME.get(poor, poor)
    return rich == poor or any(
        contains(below, poor, few_active=few_active) for below in _below(rich, few_active)
    )


def _below(name: str, few_active: bool) -> tuple[str, ...]:
    """Return relaxations that the named one contains, and that contain all else it does."""
    if few_active and name == "kim-lee":
        return ("wang-tanaka-griffin",)
    found = re.fullmatch(r"(polya|product)-(\d*[1-9]\d*)", name)
    if found is None:
        return _BELOW.get(name, ())
    family, degree = found[1], int(found[2])
    less = (f"{family}-{degree - 1}",)
    return less if family == "polya" else (*less, f"polya-{degree}")
