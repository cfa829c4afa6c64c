"""How large a relaxation is, in closed form, before anything of its size is built."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import comb, prod
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.product_premises import known_rules
from takagi.lmi.sums.simplex_products import count_of, simplexes_of
from takagi.lmi.sums.summands import SumPart
from takagi.models.errors import ModelError

# The most entries that are posed. Assembly and clarabel took about 65 bytes for each entry
# (measured for 16 rules with Polya's relaxation of degrees 2 and 3 and Liu and Zhang's): 3 GB and
# some minutes.
MOST_ENTRIES = 50_000_000
CHEAP = ("wang-tanaka-griffin", "tuan", "tanaka-wang", "product", "polya-1", "kim-lee", "liu-zhang")


@dataclass(frozen=True, slots=True)
class RelaxationSize:
    """Size of the LMIs that a relaxation makes of one double sum.

    Attributes
    ----------
    cones : (items, width) of each kind of LMI.
    slack_variables : how many numbers its own unknowns have.
    rules : mean number of different rules in an item, or about.
    """

    cones: tuple[tuple[int, int], ...]
    slack_variables: int = 0
    rules: float = 1.0

    @property
    def lmis(self) -> int:
        """Return the number of LMIs."""
        return sum(items for items, _ in self.cones)

    @property
    def width(self) -> int:
        """Return the size of the largest."""
        return max(width for _, width in self.cones)

    def entries(self, unknown: float = 0.0) -> float:
        """Return about how many numbers are assembled and factored by an interior-point solver.

        An LMI of width w has t = w (w + 1) / 2 rows: a full block (t, t), and rows as long as the
        unknowns in it.

        Parameters
        ----------
        unknown : how many numbers of the double sum's unknowns appear in an item.
        """
        return sum(
            items * triangle(width) * (triangle(width) + unknown) for items, width in self.cones
        )


def relaxation_size(
    name: str,
    rules: int,
    corners: Corners | None = None,
    *,
    size: int = 1,
    active: NDArray[np.bool_] | None = None,
    active_rules: int | None = None,
) -> RelaxationSize:
    """Return how many LMIs, how wide, and how many slack variables; nothing is built.

    The result is an upper bound if it is known which rules act together and the relaxation is by
    products.

    Parameters
    ----------
    name : of the relaxation.
    rules, corners, active, active_rules : as in ``DoubleSum``.
    size : of Theta: n for PDC in continuous time, 2 n in discrete time.

    Raises
    ------
    ModelError : an unknown relaxation, or one that does not apply.
    """
    loop = DoubleSum(
        rules=rules,
        blocks=(size,),
        parts=(),
        corners=corners,
        active=active,
        active_rules=active_rules,
    )
    return size_of(name, loop)


def size_of(name: str, loop: DoubleSum) -> RelaxationSize:
    """Return the size of a relaxation of a double sum.

    Raises
    ------
    ModelError : an unknown relaxation, or one that does not apply.
    """
    r, n = loop.rules, loop.size
    if match := re.fullmatch(r"product-(\d+)|product", name):
        items, mean = _products(loop, int(match[1] or 0))
        return RelaxationSize(((items, n),), rules=mean)
    if name == "common-gain" and not loop.by_gain:
        return RelaxationSize(((r, n),))
    full_lmi = ((1, r * n),)
    if name == "product-liu-zhang":
        items, mean = _products(loop, 0)
        return RelaxationSize(((items, n), *full_lmi), triangle(r * n), mean)
    if match := re.fullmatch(r"polya-(\d+)", name):
        items, mean = _polya(r, int(match[1]), loop.most_active)
        return RelaxationSize(((items, n),), rules=mean)
    pairs = len(loop.pairs()[0])
    alone = ((r, n), (pairs, n)) if pairs else ((r, n),)
    sizes = {
        "common-gain": RelaxationSize(alone, rules=2),
        "wang-tanaka-griffin": RelaxationSize(alone, rules=2),
        "tuan": RelaxationSize(((r, n), (2 * pairs, n)) if pairs else alone, rules=2),
        "tanaka-wang": RelaxationSize((*alone, (1, n)), triangle(n), 2),
        "kim-lee": RelaxationSize((*alone, *full_lmi), triangle(r) * triangle(n), 2),
        "liu-zhang": RelaxationSize((*alone, *full_lmi), triangle(r * n), 2),
    }
    if name not in sizes:
        raise ModelError(f"relaxation {name!r} is not known; there are {', '.join(sizes)}")
    return sizes[name]


def check_size(name: str, loop: DoubleSum) -> None:
    """Raise ModelError for a relaxation too large to pose; the message lists smaller ones."""
    size = size_of(name, loop)
    entries = size.entries(_unknown(loop, size))
    if entries <= MOST_ENTRIES:
        return
    smaller = []
    for alternative in _applicable(loop):
        less = size_of(alternative, loop)
        if less.entries(_unknown(loop, less)) <= min(entries, MOST_ENTRIES) and alternative != name:
            smaller.append(f"{alternative!r} ({less.lmis} LMIs, width {less.width})")
    raise ModelError(
        f"relaxation {name!r} of {loop.rules} rules has {size.lmis} LMIs, the widest of width "
        f"{size.width}, and {size.slack_variables} slack variables: {entries:.2g} entries for a "
        f"solver, more than {MOST_ENTRIES:.2g}; take " + (", ".join(smaller) or "fewer rules")
    )


def _unknown(loop: DoubleSum, size: RelaxationSize) -> float:
    """Return about how many numbers of the double sum's unknowns appear in an item."""
    return sum(
        unknown.entries * min(unknown.count, members)
        for unknown, members in {
            part.unknown: _members(part, size.rules) for part in loop.parts
        }.items()
    )


def _members(part: SumPart, rules: float) -> float:
    """Return about how many members of its unknown a part has in an item of this many rules."""
    if isinstance(part.member, str):
        return 1.0 if part.member == "first" else rules
    return rules**2


def _applicable(loop: DoubleSum) -> tuple[str, ...]:
    return tuple(name for name in CHEAP if name != "product" or loop.corners is not None)


def _products(loop: DoubleSum, degree: int) -> tuple[int, float]:
    """Return prod_k (D_k + d + s_k - 1 choose s_k - 1), and the mean number of rules in each."""
    simplexes = simplexes_of(known_rules(loop))
    items = prod(count_of(simplex.corners, simplex.degree + degree) for simplex in simplexes)
    mean = prod(_polya(simplex.corners, simplex.degree + degree - 2)[1] for simplex in simplexes)
    return items, mean


def _polya(values: int, degree: int, active_rules: int | None = None) -> tuple[int, float]:
    """Return how many products of d + 2 weights have few enough different ones, and their mean."""
    sides = range(1, (values if active_rules is None else active_rules) + 1)
    items = [comb(values, t) * comb(degree + 1, t - 1) for t in sides]
    return sum(items), sum(t * count for t, count in zip(sides, items, strict=True)) / sum(items)


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
    match = re.fullmatch(r"(polya|product)-(\d*[1-9]\d*)", name)
    if match is None:
        return _BELOW.get(name, ())
    family, degree = match[1], int(match[2])
    less = (f"{family}-{degree - 1}",)
    return less if family == "polya" else (*less, f"polya-{degree}")
