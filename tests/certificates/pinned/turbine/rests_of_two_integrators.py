"""Numbers of the balances on which the law ``paper-two-integrators`` rests."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any
from unittest.mock import patch

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import (
    UNIT,
    ZERO,
    enclose,
)
from takagi.certificates.checker.turbine.equilibria import two_integrators as paper_two_rest
from takagi.certificates.checker.turbine.equilibria.published import published_equilibria
from takagi.certificates.checker.turbine.equilibria.two_integrators import TwoIntegrators
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


def of_two(start: Fraction | None, where: str) -> Named:
    """Yield the balances of each case over pieces, pitch and torque that are carried."""
    rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators", start))
    winds = WINDS[where]
    zero = (F(0), F(1, 10**6))
    for s in ((F(-90), F(-80)), (F(-5000), F(0)), zero, (F(1, 100), F(1, 50)), (F(1, 9), F(1, 8))):
        yield f"joined {s[0]}", said(rest._joined, winds, s)
    for s in ((F(5), F(6)), (F(7), F(71, 10)), (F(9), F(10)), (F(11), F(12))):
        yield f"still {s[0]}", said(rest._still, winds, s)
        yield f"fast {s[0]}", said(rest._fast, winds, s)
    yield "rotor", said(rest._rotor, winds, (F(0), F(1, 9)))
    yield "passes", said(rest.passes, winds)


def of_two_pieces() -> Named:
    """Yield which pieces of each balance are counted, and what follows from the counts."""
    for where, start in (("slow", None), ("above", None), ("rated", LATE), ("fast", LATE)):
        for begin, exacts in (
            (1, (0, 1, 0)), (0, (0, 1, 0)), (-1, (0, 1, 0)), (1, (1, 1, 0)), (1, (0, 1, 1)),
            (1, (None, 1, 0)), (1, (0, None, 0)), (1, (0, 1, None)),
        ):  # fmt: skip
            rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators", start))
            seen: list[Any] = []

            def count(f: Any, _: Span, pieces: Any, seen: Any = seen,
                      told: Any = (begin, exacts), **__: Any) -> Count:  # fmt: skip
                exact = told[1][len(seen)]
                seen.append((f.__name__, [piece.span for piece in pieces]))
                return Count(exact or 0, exact, told[0], 0, ())

            with patch.object(paper_two_rest, "count_zeros", count):
                found = said(rest.count, WINDS[where])
            yield f"{where} {begin} {exacts}", (found, seen)
    rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators", FULL))
    rest.longest = F(4)
    yield "beyond the table", said(rest.count, WINDS["fast"])
    for where, longest in (("slow", F(38, 5)), ("slow", F(39, 5)), ("rated", F(71, 10))):
        rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators"))
        rest.longest = longest
        spans: list[Any] = []

        def counted(f: Any, _: Span, pieces: Any, spans: Any = spans, **__: Any) -> Count:
            spans.append((f.__name__, [piece.span for piece in pieces]))
            return Count(0, 0, 1, 0, ())

        with patch.object(paper_two_rest, "count_zeros", counted):
            yield f"little room, {where} {longest}", (said(rest.count, WINDS[where]), spans)
    raised = replace(rest.law, pitch_min=F(1, 50))
    rest = TwoIntegrators(paper_turbine(), raised)
    for where in WINDS:
        for signs in ((1, -1), (1, 1), (-1, -1), (0, -1), (1, 0)):
            asked: list[Any] = []

            def sign(_: Any, __: Span, s: Span, asked: Any = asked, signs: Any = signs) -> int:
                asked.append(s)
                return int(signs[(len(asked) - 1) % 2]) if len(asked) > 6 else 0

            with patch.object(paper_two_rest, "sign_over", sign):
                yield f"continuum {where} {signs}", (rest.continuum(WINDS[where]), asked[:9])


def of_two_count(start: Fraction | None, where: str) -> Named:
    law = paper_law("paper-two-integrators", start)
    yield "rests", said(published_equilibria, paper_turbine(), law, WINDS[where])


def of_carried() -> Named:
    """Yield torque and pitch that the two integrators carry, over all their pieces."""
    rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators"))
    h = rest.law.overlaps.torque / 2
    for a, b in ((-1, 0), (0, F(1, 4)), (F(1, 4), F(1, 2)), (F(1, 4), 2), (1, 2), (0, 0), (3, 4)):
        left = Dual(enclose(a * h, b * h), (UNIT,))
        yield f"torque {a} {b}", rest._carried_torque(left)
    ranges = [enclose(F(a), F(b)) for a, b in (("0.05", "0.1"), ("2", "3"), ("0", "1"), ("1", "9"))]
    for i, j in product(range(4), range(4)):
        for known in (None, enclose(F(1, 10), F(1, 5))):
            found = rest._held_to(ranges[i], ranges[j], known)
            yield f"held to {i} {j} {known is None}", found
    for x in (F(0), F(1), F(2), F(1, 4), F(1, 3), F(25, 9)):
        yield f"root {x}", (paper_two_rest._root_below(x), paper_two_rest._root_above(x))


def of_carried_pitch(where: str) -> Named:
    rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators"))
    over, winds = rest.law.overlaps, WINDS[where]
    for a, b in ((-2, -1), (-1, F(1, 2)), (F(1, 4), F(1, 2)), (F(1, 2), 1), (F(1, 2), 2), (1, 2)):
        for size in (F(1, 10**4), F(1), F(30), F(400)):
            ends = over.start + a * over.width, over.start + b * over.width
            middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
            speed = Dual(enclose(*ends), (UNIT, ZERO))
            error = Dual(enclose(size / 2, size), (ZERO, UNIT))
            yield (
                f"pitch {a} {b} {size}",
                said(rest._carried_pitch, winds, (middle, middle, half), speed, error, ends),
            )


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {"carried": of_carried, "two integrators": of_two_pieces}
    for where in ("rated", "fast"):
        found[f"carried pitch, {where}"] = lambda where=where: of_carried_pitch(where)
    return found | ramps({
        "two balances": (of_two, (
            *((None, where) for where in WINDS), (FULL, "below"), (FULL, "fast"), (LATE, "fast"),
            (F(7, 10), "slow"),
        )),
        "two rests": (of_two_count, (
            (None, "slow"), (None, "above"), (FULL, "below"), (FULL, "fast"), (LATE, "rated"),
            (LATE, "above"),
        )),
    })  # fmt: skip
