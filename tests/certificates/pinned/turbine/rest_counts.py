"""Counts of zeros of families that are known, cut off or refused in parts."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import (
    UNIT,
    Interval,
    enclose,
    point,
)
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.equilibria import zero_count as rest_count
from takagi.certificates.checker.turbine.equilibria.zero_count import Piece, Span
from tests.certificates.pinned.turbine.values import Named

F = Fraction


def parabola(winds: Span, span: Span) -> Dual:
    """s^2 - v."""
    v, s = enclose(*winds), enclose(*span)
    return Dual(s.square() - v, (-UNIT, point(F(2)) * s))


def cubic(winds: Span, span: Span) -> Dual:
    """s^3 - s/2 - v/8."""
    v, s = enclose(*winds), enclose(*span)
    half, eighth = point(F(1, 2)), point(F(1, 8))
    return Dual(s.square() * s - half * s - eighth * v, (-eighth, point(F(3)) * s.square() - half))


def cut_off(winds: Span, span: Span) -> Dual | None:
    """s - v for s <= 1/2, not defined beyond; without slopes where a part is cut off."""
    if span[0] > F(1, 2):
        return None
    found = enclose(*span) - enclose(*winds)
    if span[1] > F(1, 2):
        return Dual(Interval(found.low, enclose(F(1, 2), F(1, 2)).high - enclose(*winds).low), ())
    return Dual(found, (-UNIT, UNIT))


def cut(f: Any, at: Fraction, *, below: bool) -> Any:
    """Return a family that is defined on one side of a place alone."""

    def family(winds: Span, span: Span) -> Dual | None:
        outside = span[0] > at if below else span[1] < at
        if outside:
            return None
        inside = (span[0], min(span[1], at)) if below else (max(span[0], at), span[1])
        found = f(winds, inside)
        return found if inside == span else Dual(found.value, ())

    return family


def of_counts(name: str) -> Named:
    f = {"parabola": parabola, "cubic": cubic, "cut off": cut_off}[name]
    spans = ((F(1, 100), F(1, 10)), (F(-1, 5), F(-1, 100)), (F(-1, 50), F(1, 50)), (F(0), F(1, 4)))
    for winds, s in product(spans, ((F(-1), F(1)), (F(0), F(1)), (F(-1, 4), F(1, 3)))):
        middle = (s[0] + 2 * s[1]) / 3
        for what, most, pieces in (
            ("one", 4, [Piece(s)]),
            ("one", 16, [Piece(s)]),
            ("two", 8, [Piece((s[0], middle), frozenset({-1})), Piece((middle, s[1]))]),
            ("up", 4, [Piece(s, frozenset({1}))]),
        ):
            found = rest_count.count_zeros(f, winds, pieces, most_parts=most)
            yield f"{winds[0]} {s[0]} {most} {what}", (found, found.exact)


def of_cuts(name: str) -> Named:
    """Yield counts of families that are not defined all over."""
    f = {"parabola": parabola, "cubic": cubic}[name]
    for at, below, most in product(
        (F(-3, 4), F(-1, 3), F(0), F(1, 3), F(5, 8)), (True, False), (2, 5)
    ):
        for winds in ((F(1, 9), F(1, 7)), (F(-1, 50), F(1, 50))):
            family = cut(f, at, below=below)
            pieces = [Piece((F(-1), F(1)))]
            found = rest_count.count_zeros(family, winds, pieces, most_parts=most)
            yield f"{at} {below} {most} {winds[0]}", found
    for at in (F(-1), F(0), F(1)):
        yield (
            f"refused at {at}",
            rest_count.count_zeros(
                refusing(f, at), (F(1, 9), F(1, 7)), [Piece((F(-1), F(1)))], most_parts=6
            ),
        )


def refusing(f: Any, at: Fraction) -> Any:
    """Return a family that is refused wherever a part holds a place."""

    def family(winds: Span, span: Span) -> Dual | None:
        if span[0] <= at <= span[1]:
            raise Refused("here")
        found: Dual | None = f(winds, span)
        return found

    return family


def of_signs() -> Named:
    points = [F(k, 4) for k in range(-4, 5)]
    for f, a, b in product((parabola, cubic, cut_off), points, points):
        if a <= b:
            for winds in ((F(1, 16), F(1, 8)), (F(1, 4), F(1, 4))):
                yield f"{f.__name__} {winds[0]} {a} {b}", rest_count.sign_over(f, winds, (a, b))
    for name, at_points in (("refused", True), ("none", False)):
        for f in (parabola, cubic):

            def spotted(winds: Span, span: Span, f: Any = f, refuse: bool = at_points) -> Any:
                if span[0] < span[1]:
                    return f(winds, span)
                if refuse:
                    raise Refused("a point")
                return None

            for a, b in ((F(-1), F(1)), (F(1, 8), F(3, 4)), (F(1, 2), F(3, 4))):
                sign = rest_count.sign_over(spotted, (F(1, 4), F(3, 8)), (a, b))
                yield f"{f.__name__}, points {name} {a} {b}", sign
    ends = (-2, -1, 0, 1, 2)
    for low, high in product(ends, ends):
        yield f"bracket {low} {high}", rest_count._bracket_sign(Interval(low, high))


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {"signs": of_signs}
    for name in ("parabola", "cubic", "cut off"):
        found[f"counts, {name}"] = lambda name=name: of_counts(name)
    for name in ("parabola", "cubic"):
        found[f"cuts, {name}"] = lambda name=name: of_cuts(name)
    return found
