"""Counts of zeros of families that are told: which parts are looked at, and what their ends say."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import ONE, UNIT, ZERO, Interval
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.equilibria import zero_count as rest_count
from takagi.certificates.checker.turbine.equilibria.zero_count import Excess, Piece, Span
from tests.certificates.pinned.turbine.values import Named

F = Fraction
OPEN = Interval(-ONE, ONE)
WINDS = (F(8), F(9))


def told(parts: dict[int, Dual], ends: dict[int, int] | None = None) -> Excess:
    """Return a family with a bracket on each unit of s, and signs at whole s or none at all."""

    def family(_: Span, span: Span) -> Dual | None:
        if span[0] == span[1]:
            if ends is None or span[0].denominator != 1:
                raise Refused("a point")
            sign = ends[int(span[0])]
            return Dual(Interval(sign, sign) if sign else OPEN, ())
        return parts[int(span[0])]

    return family


def of_blocks() -> Named:
    """Yield counts of one block, by the signs at its ends and beside it."""
    rising = Dual(OPEN, (ZERO, Interval(1, ONE * 10**6)))
    bent = Dual(OPEN, (ZERO, Interval(-ONE, ONE)))
    for left, right in product((-1, 0, 1), repeat=2):
        for name, part in (("rising", rising), ("bent", bent)):
            family = told({0: part}, {0: left, 1: right})
            found = rest_count.count_zeros(family, WINDS, [Piece((F(0), F(1)))], most_parts=0)
            yield f"{name} {left} {right}", found
    whole = {sign: Dual(Interval(sign, sign), (ZERO, UNIT)) for sign in (-1, 1)}
    partly = {sign: Dual(Interval(sign, sign), ()) for sign in (-1, 1)}
    for name, rows in (
        ("whole", (whole[-1], whole[-1], bent, whole[1], whole[1])),
        ("first in part", (partly[-1], whole[-1], bent, whole[1], whole[1])),
        ("last in part", (whole[-1], whole[-1], bent, whole[1], partly[1])),
        ("left in part", (whole[-1], partly[-1], bent, whole[1], whole[1])),
        ("right in part", (whole[-1], whole[-1], bent, partly[1], whole[1])),
        ("rising", (whole[-1], whole[-1], rising, whole[1], whole[1])),
        ("down", (whole[1], whole[1], bent, whole[-1], whole[-1])),
    ):
        pieces = [Piece((F(k), F(k + 1))) for k in range(5)]
        family = told(dict(enumerate(rows)))
        yield name, rest_count.count_zeros(family, WINDS, pieces, most_parts=0)


def of_order() -> Named:
    """Yield the parts in the order in which they are looked at: the widest first."""
    for name, spans in (
        ("one", [(F(0), F(1))]),
        ("two", [(F(0), F(2, 5)), (F(2, 5), F(7, 5))]),
        ("three", [(F(0), F(1, 3)), (F(1, 3), F(3)), (F(3), F(7, 2))]),
    ):
        for most in (2, 4):
            seen: list[Span] = []

            def open_everywhere(_: Span, span: Span, seen: Any = seen) -> Dual:
                seen.append(span)
                return Dual(OPEN, ())

            pieces = [Piece(span) for span in spans]
            found = rest_count.count_zeros(open_everywhere, WINDS, pieces, most_parts=most)
            yield f"{name} {most}", (found, seen)


def of_points() -> Named:
    """Yield signs over rectangles without width in wind, in s, or in both."""
    for (v1, v2), (s1, s2) in product(((F(8), F(8)), WINDS), ((F(1), F(1)), (F(1), F(2)))):
        seen: list[Any] = []

        def found(winds: Span, span: Span, seen: Any = seen) -> Dual:
            seen.append((winds, span))
            value = OPEN if len(seen) == 1 else UNIT
            return Dual(value, (Interval(0, 9), Interval(-9, 0)))

        yield f"{v2 - v1} {s2 - s1}", (rest_count.sign_over(found, (v1, v2), (s1, s2)), seen)


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    return {"edges of blocks": of_blocks, "order of parts": of_order, "points": of_points}
