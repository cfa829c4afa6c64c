"""Whether a tree is 0 everywhere: by algebra, or refuted at a point."""

from __future__ import annotations

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import NotReplayed
from takagi.certificates.cross_check.plant.algebra import Algebra
from takagi.certificates.cross_check.plant.expression import Tree, names_in
from takagi.certificates.cross_check.plant.interval import Box, Interval, Undefined, range_of

# Places of the points at which a supposed identity is tried out, as shares of each side of the box:
# three inside, where it is unlikely that terms cancel by chance, and two corners.
SHARES = (fmpq(2, 7), fmpq(5, 11), fmpq(11, 13), fmpq(1), fmpq(0))


def identical(algebra: Algebra, tree: Tree, box: Box, label: str) -> bool:
    """Return True if algebra shows that a tree is 0, False if it is not 0 at a point of the box.

    Raises
    ------
    NotReplayed : neither is found.
    """
    if algebra.vanishes(tree):
        return True
    if any(_is_not_zero(tree, box, share) for share in SHARES):
        return False
    raise NotReplayed(f"{label}: not shown to be an identity")


def _is_not_zero(tree: Tree, box: Box, share: fmpq) -> bool:
    """Return whether a tree differs from 0 at one point of the box.

    The point lies at another share of each side (the fractional part of a multiple of ``share``):
    with equal shares a difference of two variables could vanish.
    """
    place: dict[str, Interval] = {}
    for k, name in enumerate(sorted(set(names_in(tree)) & set(box))):
        low, high = box[name] or (fmpq(-1), fmpq(1))
        turned = share * (k + 1)
        part = share if share.q == 1 else turned - turned.p // turned.q
        value = low + part * (high - low)
        place[name] = (value, value)
    try:
        found = range_of(tree, place, lambda *_: False)
    except (Undefined, NotReplayed):
        return False
    return not_zero(found)


def not_zero(a: Interval) -> bool:
    return a is not None and not a[0] <= 0 <= a[1]
