"""Numbers of the balances whose zeros are where a loop rests, and their counts."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
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
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine import (
    coherent_rest,
    equilibrium,
    paper_one_rest,
    paper_two_rest,
    rest_count,
)
from takagi.certificates.checker.turbine.coherent_inputs import Law, Plant
from takagi.certificates.checker.turbine.coherent_rest import CoherentRests, _Rest, coherent_rests
from takagi.certificates.checker.turbine.paper_inputs import PaperLaw
from takagi.certificates.checker.turbine.paper_one_rest import OneIntegrator
from takagi.certificates.checker.turbine.paper_rest import PaperRests, bends, paper_rests
from takagi.certificates.checker.turbine.paper_two_rest import TwoIntegrators
from takagi.certificates.checker.turbine.rest_count import Count, Piece, Span
from tests.certificates.pinned.turbine.coherent_numbers import read as coherent_read
from tests.certificates.pinned.turbine.inputs import CELLS, as_read
from tests.certificates.pinned.turbine.paper_numbers import LAWS, read
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction
# Where the ramp in speed begins [rad/s]: so that pitch acts alone, and so that it hardly acts.
FULL, LATE = F(115, 100), F(127, 100)
SPAN = F(0), F(1)


# ------------------------------------------------------------------ the coherent loop


def coherent_loop(cell: str) -> tuple[Plant, Law, Span]:
    data = coherent_read(cell)
    law = Law.read(data["gains"])
    return Plant.read(data["model"]), law, (law.wind[0], law.wind[1])


def of_coherent(cell: str) -> Named:
    """Yield the balance of each case over rectangles, and the counts."""
    plant, law, winds = coherent_loop(cell)
    low, high = winds
    parts = ((low, high), (low, (low + high) / 2), (low, low + (high - low) / 9))
    end = plant.surface.y.breaks[-1]
    for name, own in (
        ("recorded", law),
        ("limited", replace(law, pitch_max=F(1, 100), pitch_min=F(1, 400))),
        ("far", replace(law, effort=[e + 10 for e in law.effort])),
        ("at the table's end", replace(law, effort=[e + 10 for e in law.effort], pitch_max=end)),
        (
            "about its end",
            replace(law, effort=[e + F(5, 2) for e in law.effort], pitch_max=end + 1),
        ),
        ("slow torque", replace(law, rated_torque=law.rated_torque / 8)),
    ):
        rest = _Rest(plant, own, winds)
        X = own.integral_limit
        for k, part in enumerate(parts[1:] if name != "recorded" else parts):
            if name == "recorded" or k == 0:
                for s in ((-X, -X / 2), (F(0), X / 7), (X / 9, X / 9), (-X, X)):
                    yield f"{name}: inside {k} {s[0]} {s[1]}", said(rest.inside, part, s)
            for s in ((F(5), F(6)), (F(7), F(71, 10))):
                yield f"{name}: upper {k} {s[0]}", said(rest.upper, part, s)
                yield f"{name}: lower {k} {s[0]}", said(rest.lower, part, s)


def of_coherent_counts(cell: str, common: bool) -> Named:
    yield "counts", said(coherent_rests, *coherent_loop(cell), common=common)


def of_coherent_answers() -> Named:
    """Yield the answer to each kind of counts."""
    loop = coherent_loop("torque")
    one = Count(1, 1, -1, 1, ((F(0), F(1)),))
    two = replace(one, least=2, most=2)
    many = replace(one, least=2, most=None)
    away = replace(one, least=0, most=0, start=1, end=1, blocks=())
    other = replace(away, start=-1, end=-1)
    held = replace(away, blocks=((F(1), F(2)),))
    for inside, upper, lower in product(
        (one, two, many, replace(one, start=1, end=-1), away),
        (away, other, held, replace(away, start=0), replace(away, least=1)),
        (other, away, held, replace(other, end=0), replace(other, least=1)),
    ):
        counts = CoherentRests(inside, upper, lower)
        with patch.object(equilibrium, "coherent_rests", lambda *_, c=counts, **__: c):
            found = said(equilibrium._coherent, *loop)
        name = " ".join(str((c.least, c.most, c.start, c.end, len(c.blocks))) for c in (
            inside, upper, lower,
        ))  # fmt: skip
        yield name, found


def of_claims_of_rests() -> Named:
    """Yield what is said of a claim whose cells are answered as told."""
    answers = {3: "one", 4: "none", 5: "one", 6: Refused("not known")}

    def answer(winds: Span) -> str:
        found = answers[int(winds[0])]
        if isinstance(found, Refused):
            raise found
        return found

    def told(*cells: tuple[float, float, str]) -> Any:
        stated = [{"wind": [low, high], "rests": rests} for low, high, rests in cells]
        claim = as_read({"cells": stated})
        reader = "law", (F(3), F(7)), answer
        with patch.object(equilibrium, "rest_reader", lambda *_: reader):
            found = said(equilibrium.check_equilibrium, claim, {}, {}, "here")
        return found if isinstance(found, str) else (found.verdict.name, found.name, found.text)

    yield "one", told((3, 4, "one"))
    yield "all", told((3, 4, "one"), (4, 5, "none"), (5, 6, "one"))
    yield "several", told((3, 3.5, "one"), (3.5, 4, "one"), (5, 7, "one"))
    yield "wrong", told((3, 4, "none"), (4, 5, "none"))
    yield "not known", told((6, 7, "one"))
    yield "many wrong", told(*((3, 3 + k / 100, "none") for k in range(1, 15)))
    for low, high, rests in (
        (2, 4, "one"), (6, 8, "one"), (5, 5, "one"), (5, 4, "one"), (4, 5, "two"), (6, 7, "one"),
    ):  # fmt: skip
        yield f"{low} to {high} {rests}", told((low, high, rests))
    yield "none", told()
    cells = [(3, 4, "one")]
    for count in (2000, 2001):
        yield f"{count} cells", str(told(*(cells * count)))[:200]
    for wrong in ({}, {"cells": 1}, {"cells": {}}):
        with patch.object(equilibrium, "rest_reader", lambda *_: ("law", (F(3), F(7)), answer)):
            yield f"{wrong}", said(equilibrium.check_equilibrium, wrong, {}, {}, "here")


def of_readers() -> Named:
    """Yield for which laws rests are answered, and for which winds."""
    for name in (*LAWS, "torque"):
        data = read(name) if name in LAWS else coherent_read(name)
        model, gains = data["model"], data["gains"]
        yield name, said(equilibrium.rest_reader, model, gains)[:2]
        for key in ("pitch_min", "pitch_max"):
            other = {**gains, key: Number("0.5")}
            yield f"{name}, other {key}", said(equilibrium.rest_reader, model, other)
    gains = read("paper")["gains"]
    for top in ("44093.54", "44093.55", "44093.56", "43093"):
        other = {**gains, "coupling": {**gains["coupling"], "top_torque": Number(top)}}
        yield f"top torque {top}", str(said(equilibrium.rest_reader, model, other))[:60]


def of_pieces_of_winds() -> Named:
    """Yield the answer to each kind of count, and over a bend of the reference speed."""
    plant, law = paper_turbine(), paper_law("paper")
    one = Count(1, 1, 1, -1, ())
    counts = [
        PaperRests(one, True), PaperRests(one, False), PaperRests(one),
        PaperRests(one, None, WINDS["slow"]),
        PaperRests(Count(0, 0, 1, 1, ())), PaperRests(Count(2, 2, 1, 1, ())),
        PaperRests(Count(2, None, 1, 1, ())), PaperRests(Count(1, None, 1, 1, ())),
        PaperRests(Count(0, None, 1, 1, ())), PaperRests(Count(1, 2, 1, 1, ())),
    ]  # fmt: skip
    for number, rests in enumerate(counts):
        with patch.object(equilibrium, "paper_rests", lambda *_, r=rests: r):
            yield f"piece {number}", said(equilibrium._paper_piece, plant, law, WINDS["slow"])
    bend = sorted(bends(plant, law))[1]
    step = F(1, 10)
    for low, high in ((-1, 1), (0, 1), (-1, 0), (-2, -1)):
        seen: list[Any] = []

        def piece(_: Any, __: Any, winds: Span, seen: list[Any] = seen) -> str:
            seen.append(winds)
            return "one" if winds[1] <= bend else "none"

        with patch.object(equilibrium, "_paper_piece", piece):
            found = said(equilibrium._paper, plant, law, (bend + low * step, bend + high * step))
        yield f"over a bend {low} {high}", (found, seen)


def of_two_cells() -> Named:
    """Yield which cell of a law's table a range of winds is in."""
    plant, law, (low, high) = coherent_loop("rated")
    middle = (low + high) / 2
    columns = ("speed", "effort", "effectiveness", "limit", "gamma")
    wide = {name: [*getattr(law, name), 2 * getattr(law, name)[1]] for name in columns}
    two = replace(law, wind=[low, middle, high], **wide)
    for name, span in (
        ("first", (low, middle)), ("second", (middle, high)), ("within", (middle, middle + 1)),
        ("start", (low, low + F(1, 99))), ("both", (low, high)), ("end", (high, high + 1)),
    ):  # fmt: skip
        yield name, said(lambda span=span: _Rest(plant, two, span).k)
    for cell, span in (("first", (low, middle)), ("second", (middle, high))):
        rest = _Rest(plant, two, span)
        yield f"{cell}: columns", [rest._column(getattr(two, name), span) for name in columns]
        yield f"{cell}: speed", [rest.speed(v) for v in span]


def of_table_ends() -> Named:
    """Yield whether reference speeds near the ends of the table are looked at."""
    plant, law, winds = coherent_loop("rated")
    first, last = plant.surface.x.breaks[0], plant.surface.x.breaks[-1]

    def count(f: Any, _: Span, pieces: Any, **__: Any) -> Any:
        return f.__name__, [(piece.span, sorted(piece.signs)) for piece in pieces]

    for name, least, most in (
        ("inside", first + 1, last - 1), ("at the start", first + F(1, 10**20), last - 1),
        ("after the start", first + F(2, 10**20), last - 1), ("at the end", first + 1, last),
        ("before the end", first + 1, last - F(2, 10**20)), ("beyond", first + 1, last + 1),
        ("one", F(7), F(7)), ("last cell", last - F(1, 10), last - F(1, 20)),
        ("first cell", first + F(1, 20), first + F(1, 10)),
    ):  # fmt: skip
        speed = [ratio * v / plant.radius for ratio, v in zip((least, most), winds, strict=True)]
        for common in (False, True):
            with patch.object(coherent_rest, "count_zeros", count):
                found = said(coherent_rests, plant, replace(law, speed=speed), winds, common=common)
            told = found if isinstance(found, str) else (found.inside, found.upper, found.lower)
            yield f"{name} {common}", told


def of_coherent_refusals() -> Named:
    plant, law, winds = coherent_loop("rated")
    low, high = winds
    for name, span in (
        ("below", (low - 1, low)), ("above", (high, high + 1)), ("beyond", (low, high + 1)),
        ("before", (low - 1, high)), ("none", (low, low)), ("turned", (high, low)),
    ):  # fmt: skip
        yield name, said(coherent_rests, plant, law, span)
    for name, speed in (("slow", F(1, 100)), ("fast", F(9)), ("slow end", F(1, 3))):
        speeds = [speed, law.speed[1]] if name != "slow end" else [law.speed[0], speed]
        yield name, said(coherent_rests, plant, replace(law, speed=speeds), winds)


# ------------------------------------------------------------------ laws of the paper


@cache
def paper_turbine() -> Plant:
    return Plant.read(read("paper")["model"])


def paper_law(name: str, start: Fraction | None = None) -> PaperLaw:
    """Return the recorded law, its ramp in speed begun elsewhere."""
    law = PaperLaw.read(read(name)["gains"])
    if start is None:
        return law
    return replace(law, overlaps=replace(law.overlaps, start=start))


WINDS = {
    "slow": (F(6), F(301, 50)),
    "below": (F(109, 10), F(1093, 100)),
    "rated": (F(113, 10), F(1131, 100)),
    "above": (F(117, 10), F(1171, 100)),
    "fast": (F(20), F(1001, 50)),
}


def of_balance(name: str) -> Named:
    """Yield reference, coupling factor and places, which both laws share."""
    kind = OneIntegrator if name == "paper" else TwoIntegrators
    for smooth in (True, False):
        rest = kind(paper_turbine(), replace(paper_law(name), smooth=smooth))
        over = rest.law.overlaps
        for k in range(-1, 6):
            yield f"{smooth}: share {k}", rest.share(over.start + F(k, 4) * over.width)
        for a, b in product(range(-1, 6), range(-1, 6)):
            if a <= b:
                span = over.start + F(a, 4) * over.width, over.start + F(b, 4) * over.width
                speed = Dual(enclose(*span), (UNIT, ZERO))
                yield f"{smooth}: share of {a} {b}", rest.share_of(speed, span)
    yield "ends", (rest.top, rest.longest, rest.shortest, rest.passing)
    for wind in (F(3), F(4), F(5), F(6), F(8), F(11), F(12), F(20)):
        yield f"reference {wind}", rest.reference(wind)
    for where, winds in WINDS.items():
        yield f"{where}: range", rest.reference_range(winds)
        yield f"{where}: speed", (rest.speed(winds), rest.speed((winds[0],) * 2))
        for pitch in ((F(0), F(1, 100)), (F(1, 5), F(2, 5))):
            at = rest.place(winds, Dual(enclose(*pitch), (ZERO, UNIT)))
            yield f"{where}: rotor at {pitch[0]}", said(getattr, at, "rotor")
            gains = [said(at.gain, f, k) for f in (0, 1) for k in range(3)]
            yield f"{where}: gains at {pitch[0]}", gains
            u = Dual(enclose(F(40000), F(44000)), (ZERO, UNIT))
            yield f"{where}: passed at {pitch[0]}", at.passed(u)
    yield "bends", bends(rest.plant, rest.law)


def of_one(start: Fraction | None, where: str) -> Named:
    """Yield the curve of pitch and torque over pieces of it."""
    rest = OneIntegrator(paper_turbine(), paper_law("paper", start))
    winds = WINDS[where]
    yield "saturated", said(rest._saturated, winds)
    for s in ((F(0), F(100)), (F(0), F(1, 9)), (F(1), F(1)), (F(44000), F(90000))):
        yield f"curve excess {s[0]} {s[1]}", said(rest._excess, winds, s)
    for s in ((F(0), F(1, 10)), (F(1, 5), F(2, 5)), (F(2), F(3)), (F(1), F(2))):
        yield f"held {s[0]}", said(rest._held, winds, s)
        yield f"in table {s[0]}", said(rest._in_table, Dual(enclose(*s), (ZERO, UNIT)))


def of_kept(start: Fraction | None, where: str) -> Named:
    """Yield whether u keeps to one side of a number all over a piece of the curve."""
    rest = OneIntegrator(paper_turbine(), paper_law("paper", start))
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
                rest = OneIntegrator(paper_turbine(), paper_law("paper", start))
                seen: list[Any] = []

                def sign(_: Any, __: Any, s: Span, seen: Any = seen, signs: Any = signs) -> int:
                    seen.append(s)
                    return signs[0] if len(seen) == 1 else signs[1]

                def keeps(*given: Any, seen: Any = seen, kept: bool = kept) -> bool:
                    seen.append(given[1:])
                    return kept

                rest._keeps = keeps  # type: ignore[method-assign]
                rest._saturated = lambda _, s=saturated: s  # type: ignore[method-assign]
                with patch.object(paper_one_rest, "sign_over", sign):
                    found = rest.at_trim(WINDS[where])
                yield f"{where} {start} {signs} {kept}", (found, seen)


def of_one_pieces() -> Named:
    """Yield which pieces of the curve are counted, and what follows from the counts."""
    for where, start in (("slow", None), ("below", None), ("fast", FULL), ("above", LATE)):
        saturated = OneIntegrator(paper_turbine(), paper_law("paper", start))._saturated(
            WINDS[where]
        )
        for share in (None, F(1, 10**7), F(1, 100)):
            for begin, end, exact in ((1, 0, 0), (1, -1, 1), (0, 1, 0), (1, 1, None), (-1, -1, 0)):
                rest = OneIntegrator(paper_turbine(), paper_law("paper", start))
                rest._saturated = lambda _, s=saturated: s  # type: ignore[method-assign]
                if share is not None:
                    rest.share = lambda _, s=share: s  # type: ignore[method-assign]
                seen: list[Any] = []

                def count(f: Any, _: Span, pieces: Any, seen: Any = seen,
                          told: Any = (begin, end, exact), **__: Any) -> Count:  # fmt: skip
                    seen.append((f.__name__, [piece.span for piece in pieces]))
                    least = told[2] if told[2] is not None else 0
                    return Count(least, told[2], told[0], told[1], ())

                with patch.object(paper_one_rest, "count_zeros", count):
                    found = said(rest.count, WINDS[where])
                yield f"{where} {share} {begin} {end} {exact}", (found, seen)


def of_trim(start: Fraction | None, where: str) -> Named:
    rest = OneIntegrator(paper_turbine(), paper_law("paper", start))
    yield "at the trim", said(rest.at_trim, WINDS[where])


def of_one_count(start: Fraction | None, where: str) -> Named:
    law = paper_law("paper", start)
    yield "rests", said(paper_rests, paper_turbine(), law, WINDS[where])


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
    yield "rests", said(paper_rests, paper_turbine(), law, WINDS[where])


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
        for size in (F(1, 10**4), F(1, 100), F(1)):
            ends = over.start + a * over.width, over.start + b * over.width
            middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
            speed = Dual(enclose(*ends), (UNIT, ZERO))
            error = Dual(enclose(size / 2, size), (ZERO, UNIT))
            yield (
                f"pitch {a} {b} {size}",
                said(rest._carried_pitch, winds, (middle, middle, half), speed, error, ends),
            )


def of_refusals() -> Named:
    """Yield what is refused of winds, limits and tables."""
    for name in LAWS:
        law, plant = paper_law(name), paper_turbine()
        end = plant.surface.y.breaks[-1]
        bend = sorted(bends(plant, law))[1]
        for what, own, winds in (
            ("before cut-in", law, (law.cut_in - 1, law.cut_in)),
            ("after cut-out", law, (law.cut_out, law.cut_out + 1)),
            ("turned", law, (F(9), F(8))),
            ("a point", law, (F(9), F(9))),
            ("negative pitch", replace(law, pitch_min=F(-1, 9)), WINDS["slow"]),
            ("pitch within the table", replace(law, pitch_max=end / 2), WINDS["slow"]),
            ("over all bends", law, (law.cut_in, law.cut_out)),
            ("over a bend", law, (bend - F(1, 100), bend + F(1, 100))),
        ):
            yield f"{name}: {what}", said(paper_rests, plant, own, winds)


def of_paper_answers() -> Named:
    """Yield what is made of the counts of both laws, and of a coupling factor that reaches 1."""
    plant = paper_turbine()
    one, two = Count(1, 1, 1, -1, ()), Count(2, 2, 1, -1, ())
    for count, trim in product((one, two), (True, None)):
        with (
            patch.object(OneIntegrator, "count", lambda *_, c=count: c),
            patch.object(OneIntegrator, "at_trim", lambda *_, t=trim: t),
        ):
            name = f"one integrator, {count.least} {trim}"
            yield name, said(paper_rests, plant, paper_law("paper"), WINDS["slow"])
    bend = sorted(bends(plant, paper_law("paper")))[1]
    for shares, sign in product((0, F(1, 2), 1), (-1, 0, 1)):
        for other in (shares, F(1, 3)):
            calls = [shares, other]
            with (
                patch.object(TwoIntegrators, "share", lambda *_, c=calls: c.pop(0)),
                patch.object(TwoIntegrators, "count", lambda *_: one),
                patch.object(TwoIntegrators, "passes", lambda *_, s=sign: s),
                patch.object(TwoIntegrators, "continuum", lambda *_, s=sign: SPAN if s else None),
            ):  # fmt: skip
                winds = (bend - F(1, 100), bend)
                found = said(paper_rests, plant, paper_law("paper-two-integrators"), winds)
            yield f"two integrators, {shares} {other} {sign}", found
    law = paper_law("paper")
    with patch.object(OneIntegrator, "count", lambda *_: two):
        for low, high in ((bend - 1, bend), (bend, bend + 1), (law.cut_in, law.cut_in + 1),
                          (law.cut_out - 1, law.cut_out)):  # fmt: skip
            yield (
                f"up to a bend {float(low - bend):.3g}",
                said(paper_rests, plant, law, (low, high)),
            )
        end = plant.surface.y.breaks[-1]
        for pitch in (end, end + F(1, 10**9)):
            own = replace(law, pitch_max=pitch)
            yield f"pitch to the end {pitch > end}", said(paper_rests, plant, own, WINDS["slow"])
        own = replace(law, pitch_min=F(0))
        yield "pitch from zero", said(paper_rests, plant, own, WINDS["slow"])


# ------------------------------------------------------------------ counting


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
    ends = (-2, -1, 0, 1, 2)
    for low, high in product(ends, ends):
        yield f"bracket {low} {high}", rest_count._bracket_sign(Interval(low, high))


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "rests refused, coherent": of_coherent_refusals,
        "rests refused, paper": of_refusals,
        "carried": of_carried,
        "signs": of_signs,
        "coherent answers": of_coherent_answers,
        "claims of rests": of_claims_of_rests,
        "readers of rests": of_readers,
        "pieces of winds": of_pieces_of_winds,
        "two cells": of_two_cells,
        "ends of the table": of_table_ends,
        "trims": of_trims,
        "one integrator": of_one_pieces,
        "two integrators": of_two_pieces,
        "paper answers": of_paper_answers,
    }
    for cell in CELLS:
        found[f"balance, {cell}"] = lambda cell=cell: of_coherent(cell)
    for common in (False, True):
        found[f"rests, torque, {common}"] = lambda c=common: of_coherent_counts("torque", c)
    for name in ("parabola", "cubic", "cut off"):
        found[f"counts, {name}"] = lambda name=name: of_counts(name)
    for name in ("parabola", "cubic"):
        found[f"cuts, {name}"] = lambda name=name: of_cuts(name)
    for where in ("rated", "fast"):
        found[f"carried pitch, {where}"] = lambda where=where: of_carried_pitch(where)
    for name in LAWS:
        found[f"balance, {name}"] = lambda name=name: of_balance(name)
    for what, numbers, cases in (
        ("one curve", of_one, ((None, "slow"), (None, "above"), (FULL, "below"), (LATE, "fast"))),
        ("one curve kept", of_kept, ((None, "slow"), (FULL, "fast"))),
        ("one trim", of_trim, ((None, "slow"), (None, "below"), (None, "fast"), (FULL, "fast"))),
        ("one rests", of_one_count, (
            (FULL, "slow"), (LATE, "below"), (LATE, "rated"), (LATE, "above"), (None, "fast"),
        )),
        ("two balances", of_two, (
            *((None, where) for where in WINDS), (FULL, "below"), (FULL, "fast"), (LATE, "fast"),
        )),
        ("two rests", of_two_count, (
            (None, "slow"), (None, "above"), (FULL, "below"), (FULL, "fast"), (LATE, "rated"),
            (LATE, "above"),
        )),
    ):  # fmt: skip
        for start, where in cases:
            tag = f"{where}, ramp from {'its start' if start is None else float(start)}"
            found[f"{what}, {tag}"] = lambda n=numbers, s=start, w=where: n(s, w)
    return found
