"""Relaxations by name, and their sizes."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import comb, gcd, prod
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from takagi.lmi.condition.statements import lmi_of
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.expressions.piece import Piece
from takagi.lmi.sums.double_sum import DoubleSum, RelaxedSum, Summand
from takagi.lmi.sums.product_premises import (
    count_of,
    known_corners,
    polya,
    product,
    product_liu_zhang,
    sides_of,
)
from takagi.lmi.sums.slack_matrices import (
    SLACK_SHARE,
    kim_lee,
    liu_zhang,
    pair_lmis,
    rule_lmi,
    slack_name,
    slack_unknown,
)
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError, did_you_mean

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

        ``unknown`` : how many numbers of the double sum's unknowns appear in an item.
        """
        return sum(
            items * triangle(width) * (triangle(width) + unknown) for items, width in self.cones
        )


def relaxation_size(
    name: str, rules: int, corners: Indices | None = None, *, size: int = 1
) -> RelaxationSize:
    """Return how many LMIs, how wide, and how many slack variables; nothing is built.

    Parameters
    ----------
    name : of the relaxation.
    rules, corners : as in ``DoubleSum``.
    size : of Theta: n for PDC in continuous time, 2 n in discrete time.

    Raises ModelError: an unknown relaxation, or one that does not apply.
    """
    return size_of(name, DoubleSum(rules=rules, blocks=(size,), parts=(), corners=corners))


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
        items, mean = _polya(r, int(match[1]))
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
    for alternative in CHEAP:
        if alternative == "product" and loop.corners is None:
            continue
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
    members = {
        piece.unknown: _members(piece, size.rules)
        for piece, _ in loop.parts
        if isinstance(piece.unknown, Unknown)
    }
    return sum(unknown.entries * min(unknown.count, m) for unknown, m in members.items())


def _members(piece: Piece, rules: float) -> float:
    """Return about how many members of its unknown a part has in an item of this many rules."""
    if piece.members is None:
        return 1.0
    return rules if piece.members.ndim == 2 and 1 in piece.members.shape else rules**2


def _products(loop: DoubleSum, degree: int) -> tuple[int, float]:
    """Return prod_k (d + s_k + 1 choose s_k - 1), and the mean number of rules in each."""
    sides = sides_of(known_corners(loop))
    items = prod(count_of(side, 2 + degree) for side in sides)
    return items, prod(_polya(side, degree)[1] for side in sides)


def _polya(values: int, degree: int) -> tuple[int, float]:
    """Return how many products of d + 2 weights there are, and the mean of different ones."""
    sides = range(1, values + 1)
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


def contains(rich: str, poor: str) -> bool:
    """Return whether unknowns for ``poor`` always give unknowns for ``rich``, by a theorem.

    With M_j = M, Theta_ij + Theta_ji is Theta_i + Theta_j, so one gain gives all pairs.  All pairs
    give Tuan's by adding Theta_ii < 0, and Tanaka and Wang's by a small Y; theirs give Kim and
    Lee's by X_ii = -(r - 1) Y - eps I, X_ij = Y, since 1 1' <= r I; Liu and Zhang only drop the
    symmetry of X_ij.  All pairs are Polya's degree 0; negative definite coefficients stay so when
    the polynomial is multiplied by h_1 + ... + h_r, and when those of equal products of corner
    weights are added up.  "auto" contains the relaxations that it tries, except those that are too
    large. False is no evidence of the contrary: for some pairs no theorem is known.
    """
    rich, poor = SAME.get(rich, rich), SAME.get(poor, poor)
    return rich == poor or any(contains(below, poor) for below in _below(rich))


def _below(name: str) -> tuple[str, ...]:
    """Return relaxations that the named one contains, and that contain all else it does."""
    match = re.fullmatch(r"(polya|product)-(\d*[1-9]\d*)", name)
    if match is None:
        return _BELOW.get(name, ())
    family, degree = match[1], int(match[2])
    less = (f"{family}-{degree - 1}",)
    return less if family == "polya" else (*less, f"polya-{degree}")


Relaxation: TypeAlias = Callable[[DoubleSum], RelaxedSum]


def relaxation_named(name: str) -> Relaxation:
    """Return the relaxation; ``"polya-<d>"``, ``"product-<d>"`` for degree d = 0, 1, 2, ...

    It raises ModelError where it does not apply, and where it is too large to be posed.

    Raises
    ------
    ModelError : unknown name; the message lists those that there are.
    """
    text = name if isinstance(name, str) else ""
    match = re.fullmatch(r"(polya|product)-(\d+)", text)
    if text == "auto":
        raise ModelError(
            'relaxation "auto", one after another, is for pdc and observer; here name one: '
            'pdc(model, relaxation="auto").relaxation is the first that has gains, "liu-zhang" '
            'and "polya-2" have them more often'
        )
    if match is None and text not in RELAXATIONS:
        names = [*RELAXATIONS, "polya-<d>", "product-<d>"]
        raise ModelError(
            f"relaxation {name!r} is not known; there are {', '.join(names)}, and of pdc and "
            "observer also auto, which tries one after another"
            + did_you_mean(str(name), [*RELAXATIONS, "polya-1", "polya-2", "product-1"])
        )

    def relaxed(loop: DoubleSum) -> RelaxedSum:
        check_size(name, loop)
        if match is None:
            return RELAXATIONS[name](loop)
        return {"polya": polya, "product": product}[match[1]](loop, int(match[2]))

    return relaxed


def common_gain(loop: DoubleSum) -> RelaxedSum:
    """Theta_i < 0 with one gain for all rules: a robust controller, no schedule.

    If Theta changes with j although the gain does not, this poses all pairs.
    """
    if not loop.by_gain:
        return (), (rule_lmi(loop),)
    return wang_tanaka_griffin(loop)


def wang_tanaka_griffin(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < 0, and Theta_ij + Theta_ji < 0 for all pairs i < j.

    Source: Wang, Tanaka and Griffin (1996), IEEE Trans. Fuzzy Systems 4(1), theorem 3.
    """
    return (), pair_lmis(loop)


def tanaka_wang(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii + (r - 1) Y < 0, Theta_ij + Theta_ji - 2 Y < 0 for i < j, Y > 0.

    Y is a common slack: the sum for a pair may be positive if each rule alone has a margin.

    Source: Tanaka, Ikeda and Wang (1998), IEEE Trans. Fuzzy Systems 6(2), theorem 2; Tanaka and
    Wang (2001), theorem 9.
    """
    Y = slack_unknown(loop, "Y", loop.size)
    name = slack_name(loop, "slack")
    positive = lmi_of((Y >> 0).named(name, weight=SLACK_SHARE * loop.weight))
    rule_slack = (loop.rules - 1) * Y if loop.rules > 1 else None
    return (Y,), (*pair_lmis(loop, rule_slack, -2 * Y), positive)


def tuan(loop: DoubleSum) -> RelaxedSum:
    """Theta_ii < 0, and 2/(r - 1) Theta_ii + Theta_ij + Theta_ji < 0 for all i != j.

    No slack unknowns, and never more conservative than all pairs.

    Source: Tuan, Apkarian, Narikiyo and Yamamoto (2001), IEEE Trans. Fuzzy Systems 9(2).
    """
    first, second = loop.pairs()
    if not len(first):
        return (), (rule_lmi(loop),)
    i, j = np.concatenate([first, second]), np.concatenate([second, first])
    # In whole numbers, so that no rounding error can invalidate the inequality.
    common = gcd(2, loop.rules - 1)
    rule_factor, pair_factor = 2 // common, (loop.rules - 1) // common
    weight = np.ones(len(i))
    pairs = loop.lmi(
        "pair",
        (
            Summand(i, i, rule_factor * weight, names=("i", "i"), factor=_number(rule_factor)),
            Summand(i, j, pair_factor * weight, factor=_number(pair_factor)),
            Summand(j, i, pair_factor * weight, names=("j", "i"), factor=_number(pair_factor)),
        ),
        count=len(i),
        label=lambda item: f"rules {i[item] + 1} and {j[item] + 1}",
        index=rf"i \ne j = 1, \dots, {loop.rules}",
        scale=2.0 ** -round(np.log2(pair_factor)),
    )
    return (), (rule_lmi(loop), pairs)


def _number(value: int) -> str:
    return "" if value == 1 else str(value)


RELAXATIONS: Mapping[str, Relaxation] = MappingProxyType(
    {
        "common-gain": common_gain,
        "wang-tanaka-griffin": wang_tanaka_griffin,
        "tanaka-wang": tanaka_wang,
        "tuan": tuan,
        "kim-lee": kim_lee,
        "liu-zhang": liu_zhang,
        "product": product,
        "product-liu-zhang": product_liu_zhang,
    }
)
