"""Numbers of the curve on which the law ``paper`` rests."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any
from unittest.mock import patch

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    enclose,
    point,
)
from takagi.certificates.checker.turbine.equilibria import one_integrator as paper_one_rest
from takagi.certificates.checker.turbine.equilibria.one_integrator import OneIntegrator
from takagi.certificates.checker.turbine.equilibria.published import published_equilibria
from takagi.certificates.checker.turbine.equilibria.zero_count import Count, Span
from tests.certificates.pinned.turbine.rests_of_paper import (
    FULL,
    LATE,
    WINDS,
    paper_law,
    paper_turbine,
    ramps,
)
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


# Of f_1 at both winds, in the place of the law's own.
SHARES = (
    (F(1, 6400), F(1, 6400)),
    (F(1, 10**7), F(1, 100)),
    None,
    (F(1, 10**7),) * 2,
    (F(1, 100), F(1, 50)),
    (F(0), F(1, 9)),
    (F(0),) * 2,
)


def of_one(start: Fraction | None, where: str) -> Named:
    """Yield the curve of pitch and torque over pieces of it."""
    rest: Any = OneIntegrator(paper_turbine(), paper_law("paper", start))
    winds = WINDS[where]
    yield "saturated", said(rest._saturated, winds)
    for s in ((F(0), F(100)), (F(0), F(1, 9)), (F(1), F(1)), (F(44000), F(90000))):
        yield f"curve excess {s[0]} {s[1]}", said(rest._excess, winds, s)
    for s in ((F(0), F(1, 10)), (F(1, 5), F(2, 5)), (F(2), F(3)), (F(1), F(2))):
        yield f"held {s[0]}", said(rest._held, winds, s)
        yield f"in table {s[0]}", said(rest._in_table, Dual(enclose(*s), (ZERO, UNIT)))


def of_kept(start: Fraction | None, where: str) -> Named:
    """Yield whether u keeps to one side of a number all over a piece of the curve."""
    rest: Any = OneIntegrator(paper_turbine(), paper_law("paper", start))
    winds, span = WINDS[where], (F(1, 10), F(1, 5))
    curve = rest._curve(winds, span)
    assert curve is not None
    low, high = (F(end, ONE) for end in curve[1].value)
    for side, corner in product((-1, 1), (low, high, low - 1, high + 1, (low + high) / 2)):
        for left in (0, 1):
            kept = said(rest._keeps, winds, span, side, corner, left)
            yield f"keeps {side} {float(corner):.6g} {left}", kept


def of_trims() -> Named:
    """Yield how the one rest is found to be the trim, or not, from what signs say."""
    for where, start in (("slow", None), ("below", None), ("fast", None), ("fast", FULL)):
        saturated = OneIntegrator(paper_turbine(), paper_law("paper", start))._saturated(
            WINDS[where]
        )
        for signs in product((1, -1, 0), (1, -1, 0)):
            for kept in (True, False):
                rest: Any = OneIntegrator(paper_turbine(), paper_law("paper", start))
                seen: list[Any] = []

                def sign(_: Any, __: Any, s: Span, seen: Any = seen, signs: Any = signs) -> int:
                    seen.append(s)
                    return int(signs[0] if len(seen) == 1 else signs[1])

                def keeps(*given: Any, seen: Any = seen, kept: bool = kept) -> bool:
                    seen.append(given[1:])
                    return kept

                rest._keeps = keeps
                rest._saturated = lambda _, s=saturated: s
                with patch.object(paper_one_rest, "sign_over", sign):
                    found = rest.at_trim(WINDS[where])
                yield f"{where} {start} {signs} {kept}", (found, seen)


def of_looks() -> Named:
    """Yield where the rest is looked for when the smallest pitch is not zero."""
    law = replace(paper_law("paper"), pitch_min=F(1, 100))
    for where, signs in product(("below", "fast"), ((1, 1), (1, -1), (-1, 1))):
        seen: list[Any] = []
        rest: Any = OneIntegrator(paper_turbine(), law)
        rest._saturated = lambda _: F(1, 3)

        def sign(_: Any, __: Any, s: Span, seen: Any = seen, signs: Any = signs) -> int:
            seen.append(s)
            return int(signs[0] if len(seen) == 1 else signs[len(seen) % 2])

        def keeps(*given: Any, seen: Any = seen) -> bool:
            seen.append(given[1:])
            return len(seen) > 9

        rest._keeps = keeps
        with patch.object(paper_one_rest, "sign_over", sign):
            found = rest.at_trim(WINDS[where])
        yield f"{where} {signs}", (found, seen)


def of_shares() -> Named:
    """Yield when a coupling factor that is zero at some winds, or at all, settles the question."""
    for shares in ((F(0), F(0)), (F(0), F(1, 9)), (F(1, 9), F(0)), (F(1, 9), F(1, 3))):
        rest: Any = OneIntegrator(paper_turbine(), paper_law("paper"))
        told = list(shares)
        rest.share = lambda _, t=told: t.pop(0)
        with patch.object(paper_one_rest, "sign_over", lambda *_: 0):
            yield f"{shares[0]} {shares[1]}", said(rest.at_trim, WINDS["below"])


def of_factors() -> Named:
    """Yield u/s where its sign is known, and where it is not."""
    law = paper_law("paper")
    for pitch_gain in (F(-3), F(-2), F(-3, 2), F(-1), F(-1, 2)):
        gains = [law.full.gains[0], dict.fromkeys(law.full.gains[1], pitch_gain), law.full.gains[2]]
        rest = OneIntegrator(paper_turbine(), replace(law, full=replace(law.full, gains=gains)))
        at = rest.place(WINDS["slow"], Dual(enclose(F(0), F(1, 10)), (ZERO, UNIT)))
        for share in ((F(1, 2), F(1)), (F(1, 2), F(1, 2)), (F(1), F(1))):
            found = said(rest._factor, at, Dual(enclose(*share), (UNIT, ZERO)))
            yield f"{pitch_gain} {share[0]} {share[1]}", found


def of_kept_pieces() -> Named:
    """Yield which halves are looked at to compare u, for curves that are told."""
    winds = WINDS["slow"]
    rest: Any = OneIntegrator(paper_turbine(), paper_law("paper"))
    exact = point(F(1, 3))
    ends = (exact.low - 1, exact.low, exact.high, exact.high + 1)
    for side, low, high, left in product((-1, 1), ends, ends, (0, 1, 2)):
        seen: list[Any] = []

        def curve(_: Any, span: Span, seen: Any = seen, u: Any = (low, high)) -> Any:
            seen.append(span)
            return None if len(seen) > 3 else (None, Dual(Interval(*u), ()), True)

        rest._curve = curve
        found = rest._keeps(winds, (F(0), F(1)), side, F(1, 3), left)
        yield f"{side} {low - exact.low} {high - exact.low} {left}", (found, seen)


def of_one_pieces() -> Named:
    """Yield which pieces of the curve are counted, and what follows from the counts."""
    for where, start in (("slow", None), ("below", None), ("fast", FULL), ("above", LATE)):
        saturated = OneIntegrator(paper_turbine(), paper_law("paper", start))._saturated(
            WINDS[where]
        )
        for number, share in enumerate(SHARES):
            for begin, end, exact in ((1, 0, 0), (1, -1, 1), (0, 1, 0), (1, 1, None), (-1, -1, 0)):
                rest: Any = OneIntegrator(paper_turbine(), paper_law("paper", start))
                rest._saturated = lambda _, s=saturated: s
                if share is not None:
                    told = list(share)
                    rest.share = lambda _, t=told: t.pop(0)
                seen: list[Any] = []

                def count(f: Any, _: Span, pieces: Any, seen: Any = seen,
                          told: Any = (begin, end, exact), **__: Any) -> Count:  # fmt: skip
                    seen.append((f.__name__, [piece.span for piece in pieces]))
                    least = told[2] if told[2] is not None else 0
                    return Count(least, told[2], told[0], told[1], ())

                with patch.object(paper_one_rest, "count_zeros", count):
                    found = said(rest.count, WINDS[where])
                yield f"{where} {number} {begin} {end} {exact}", (found, seen)


def of_trim(start: Fraction | None, where: str) -> Named:
    rest: Any = OneIntegrator(paper_turbine(), paper_law("paper", start))
    yield "at the trim", said(rest.at_trim, WINDS[where])


def of_one_count(start: Fraction | None, where: str) -> Named:
    law = paper_law("paper", start)
    yield "rests", said(published_equilibria, paper_turbine(), law, WINDS[where])


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    return {
        "trims": of_trims,
        "looks": of_looks,
        "shares": of_shares,
        "factors": of_factors,
        "kept pieces": of_kept_pieces,
        "one integrator": of_one_pieces,
        **ramps({
            "one curve": (
                of_one, ((None, "slow"), (None, "above"), (FULL, "below"), (LATE, "fast")),
            ),
            "one curve kept": (of_kept, ((None, "slow"), (FULL, "fast"))),
            "one trim": (
                of_trim, ((None, "slow"), (None, "below"), (None, "fast"), (FULL, "fast")),
            ),
            "one rests": (of_one_count, (
                (FULL, "slow"), (LATE, "below"), (LATE, "rated"), (LATE, "above"), (None, "fast"),
            )),
        }),
    }  # fmt: skip
