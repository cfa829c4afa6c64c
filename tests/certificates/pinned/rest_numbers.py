"""Numbers of the balances whose zeros are where a loop rests, and their counts."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import UNIT, ZERO, Interval, enclose, point
from takagi.certificates.checker.turbine import equilibrium, paper_two_rest, rest_count
from takagi.certificates.checker.turbine.coherent_inputs import Law, Plant
from takagi.certificates.checker.turbine.coherent_rest import _Rest, coherent_rests
from takagi.certificates.checker.turbine.paper_inputs import PaperLaw
from takagi.certificates.checker.turbine.paper_one_rest import OneIntegrator
from takagi.certificates.checker.turbine.paper_rest import bends, paper_rests
from takagi.certificates.checker.turbine.paper_two_rest import TwoIntegrators
from takagi.certificates.checker.turbine.rest_count import Piece, Span
from tests.certificates.pinned.coherent_numbers import read as coherent_read
from tests.certificates.pinned.inputs import CELLS
from tests.certificates.pinned.paper_numbers import LAWS, read
from tests.certificates.pinned.values import Named, said

F = Fraction
# Where the ramp in speed begins [rad/s]: so that pitch acts alone, and so that it hardly acts.
FULL, LATE = F(115, 100), F(127, 100)


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


def of_coherent_counts(cell: str) -> Named:
    plant, law, winds = coherent_loop(cell)
    for common in (False, True):
        yield f"common {common}", said(coherent_rests, plant, law, winds, common=common)
    yield "answer", said(equilibrium._coherent, plant, law, winds)


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
    """Yield the curve of pitch and torque over pieces of it, and the count."""
    rest = OneIntegrator(paper_turbine(), paper_law("paper", start))
    winds = WINDS[where]
    yield "saturated", said(rest._saturated, winds)
    for s in ((F(0), F(100)), (F(20000), F(30000)), (F(1), F(1)), (F(44000), F(90000))):
        yield f"curve excess {s[0]} {s[1]}", said(rest._excess, winds, s)
    for s in ((F(0), F(1, 10)), (F(1, 5), F(2, 5)), (F(2), F(3)), (F(1), F(2))):
        yield f"held {s[0]}", said(rest._held, winds, s)
        pitch = Dual(enclose(*s), (ZERO, UNIT))
        yield f"in table {s[0]}", said(rest._in_table, pitch)
    corner = rest.law.rated_torque + rest.law.overlaps.torque / 2
    for side, span in product((-1, 1), ((F(0), F(1)), (F(0), F(90000)), (F(44000), F(90000)))):
        for left in (0, 2):
            kept = said(rest._keeps, winds, span, side, corner, left)
            yield f"keeps {side} {span} {left}", kept


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
    over, winds = rest.law.overlaps, WINDS["rated"]
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
    ranges = [enclose(F(a), F(b)) for a, b in (("0.05", "0.1"), ("2", "3"), ("0", "1"), ("1", "9"))]
    for i, j in product(range(4), range(4)):
        for known in (None, enclose(F(1, 10), F(1, 5))):
            found = rest._held_to(ranges[i], ranges[j], known)
            yield f"held to {i} {j} {known is None}", found
    for x in (F(0), F(1), F(2), F(1, 4), F(1, 3), F(25, 9)):
        yield f"root {x}", (paper_two_rest._root_below(x), paper_two_rest._root_above(x))


def of_refusals() -> Named:
    """Yield what is refused of winds, limits and tables."""
    for name in LAWS:
        law, plant = paper_law(name), paper_turbine()
        end = plant.surface.y.breaks[-1]
        for what, own, winds in (
            ("before cut-in", law, (law.cut_in - 1, law.cut_in)),
            ("after cut-out", law, (law.cut_out, law.cut_out + 1)),
            ("turned", law, (F(9), F(8))),
            ("a point", law, (F(9), F(9))),
            ("negative pitch", replace(law, pitch_min=F(-1, 9)), WINDS["slow"]),
            ("pitch within the table", replace(law, pitch_max=end / 2), WINDS["slow"]),
            ("over all bends", law, (law.cut_in, law.cut_out)),
        ):
            yield f"{name}: {what}", said(paper_rests, plant, own, winds)


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


def of_counts() -> Named:
    spans = ((F(1, 100), F(1, 10)), (F(-1, 5), F(-1, 100)), (F(-1, 50), F(1, 50)), (F(0), F(1, 4)))
    ranges = ((F(-1), F(1)), (F(0), F(1)), (F(-1, 4), F(1, 3)))
    for f, winds, s in product((parabola, cubic, cut_off), spans, ranges):
        middle = (s[0] + 2 * s[1]) / 3
        for most in (4, 32):
            for name, pieces in (
                ("one", [Piece(s)]),
                ("two", [Piece((s[0], middle), frozenset({-1})), Piece((middle, s[1]))]),
                ("up", [Piece(s, frozenset({1}))]),
            ):
                found = rest_count.count_zeros(f, winds, pieces, most_parts=most)
                yield f"{f.__name__} {winds[0]} {s[0]} {most} {name}", (found, found.exact)


def of_signs() -> Named:
    points = [F(k, 4) for k in range(-4, 5)]
    for f, a, b in product((parabola, cubic, cut_off), points, points):
        if a <= b:
            for winds in ((F(1, 16), F(1, 8)), (F(1, 4), F(1, 4))):
                yield f"{f.__name__} {winds[0]} {a} {b}", rest_count.sign_over(f, winds, (a, b))
    ends = (-2, -1, 0, 1, 2)
    for low, high in product(ends, ends):
        yield f"bracket {low} {high}", rest_count._bracket_sign(Interval(low, high))


def of_answers(name: str, where: str) -> Named:
    """Yield the answer for a range of winds, bends of the reference speed within."""
    plant, law = paper_turbine(), paper_law(name)
    low, _ = WINDS[where]
    yield where, said(equilibrium._paper, plant, law, WINDS[where])
    yield f"{where}, wider", said(equilibrium._paper, plant, law, (low, low + F(1, 4)))


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "rests refused, coherent": of_coherent_refusals,
        "rests refused, paper": of_refusals,
        "carried": of_carried,
        "counts": of_counts,
        "signs": of_signs,
    }
    for cell in CELLS:
        found[f"balance, {cell}"] = lambda cell=cell: of_coherent(cell)
        found[f"rests, {cell}"] = lambda cell=cell: of_coherent_counts(cell)
    for name in LAWS:
        found[f"balance, {name}"] = lambda name=name: of_balance(name)
    for what, numbers, cases in (
        ("one curve", of_one, ((None, "slow"), (None, "above"), (FULL, "below"), (LATE, "fast"))),
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
    for name, where in (("paper", "slow"), ("paper-two-integrators", "rated")):
        found[f"answers, {name}"] = lambda name=name, where=where: of_answers(name, where)
    return found
