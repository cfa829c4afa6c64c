r"""Weights that a loop takes by itself: rules alone, and blends of shares in whole numbers.

A point is one row of shares for each premise where weights are products of those of premises, else
one row for all rules; a row over its sum are the weights.  It is what the claim
``no-common-decay`` names its blends by.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations_with_replacement, product
from math import comb, prod
from typing import TypeAlias

from takagi.certificates.checker.kernel.family import Family

__all__ = ["Point", "grid", "points_of", "weights_at"]

Point: TypeAlias = tuple[tuple[int, ...], ...]


def points_of(family: Family) -> list[Point]:
    """Return the point of every rule alone, in order."""
    if family.corners is None:
        return [(_unit(family.rules, i),) for i in range(family.rules)]
    return [tuple(_unit(2, c) for c in row) for row in family.corners]


def grid(family: Family, parts: int, most: int) -> list[Point]:
    """Return all points whose shares are multiples of 1/parts; none where these exceed ``most``.

    Where rules leave out a combination of corners, only the rules alone.
    """
    if family.corners is None:
        sizes = [family.rules]
    else:
        sizes = [2] * len(family.corners[0])
        if 2 ** len(sizes) != family.rules:
            return points_of(family)
    if prod(comb(size + parts - 1, parts) for size in sizes) > most:
        return []
    return list(product(*(list(_shares(size, parts)) for size in sizes)))


def weights_at(family: Family, point: Point) -> list[Fraction]:
    """Return h, (rules,)."""
    corners = family.corners or [(i,) for i in range(family.rules)]
    return [
        prod(
            (Fraction(row[c], sum(row)) for row, c in zip(point, rule, strict=True)),
            start=Fraction(1),
        )
        for rule in corners
    ]


def _shares(size: int, parts: int) -> Iterator[tuple[int, ...]]:
    for chosen in combinations_with_replacement(range(size), parts):
        yield tuple(chosen.count(c) for c in range(size))


def _unit(size: int, place: int) -> tuple[int, ...]:
    return tuple(int(c == place) for c in range(size))
