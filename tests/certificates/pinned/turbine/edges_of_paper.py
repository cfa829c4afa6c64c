"""What the checks of the paper's laws do exactly at their limits, told what they ask for."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from types import SimpleNamespace as Told
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
from takagi.certificates.checker.turbine.equilibria import one_integrator as paper_one_rest
from takagi.certificates.checker.turbine.equilibria import two_integrators as paper_two_rest
from takagi.certificates.checker.turbine.equilibria.one_integrator import LONGEST, OneIntegrator
from takagi.certificates.checker.turbine.equilibria.published import bends, published_equilibria
from takagi.certificates.checker.turbine.equilibria.published_balance import RestPlace
from takagi.certificates.checker.turbine.equilibria.two_integrators import TwoIntegrators
from takagi.certificates.checker.turbine.equilibria.zero_count import Count
from takagi.certificates.checker.turbine.published import loop_claim as paper
from takagi.certificates.checker.turbine.published.inputs import Overlaps, Region
from takagi.certificates.checker.turbine.published.loop import Ends, Loop
from takagi.certificates.checker.words.sentences import published as words
from tests.certificates.pinned.turbine.inputs import as_read, document
from tests.certificates.pinned.turbine.pairs_and_limits import refused
from tests.certificates.pinned.turbine.paper_numbers import boxes, law_of, plant
from tests.certificates.pinned.turbine.rests_of_paper import (
    LATE,
    WINDS,
    paper_law,
    paper_turbine,
)
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction
# Brackets of 1/3 and 2/3, whose ends differ.
THIRD, LARGER = point(F(1, 3)), point(F(2, 3))
ANY: Any = None


def of_lengths() -> Named:
    """Yield that rows of a cell are never paired with more or fewer."""
    rate = Dual(ZERO, (ZERO,))
    ends = Ends((F(8), F(9)), ([F(1)] * 2, [F(1)] * 2), [F(1)] * 2)
    cell: Any = Told(ends=ends, corners=[([[F(0)]] * 2, [[F(0)]] * 2)], disturbance=[F(1)] * 2,
                     P=ANY, rate=ANY, multiplier=ANY)  # fmt: skip
    law: Any = Told(states=2)
    for count, size in ((2, 2), (3, 2), (2, 3), (1, 2), (2, 1)):
        loop = Told(choices=lambda: [(0, True)], rates=lambda *_, n=count: [rate] * n)
        with (
            patch.object(paper, "Loop", lambda *_, at=loop: at),
            patch.object(paper, "_holds", lambda *_: True),
            patch.object(paper, "_disturbance", lambda *_, n=size: [0] * n),
            patch.object(paper, "contraction_failure", lambda *_: ""),
        ):
            yield f"rates {count} {size}", refused(paper._failure, ANY, law, ANY, cell, "here")
    states = [F(1)] * 2
    for first, along, wrong in ((2, 2, states), (1, 2, states), (2, 2, states[:1])):
        counts = {"none": first, "line": along}
        own = replace(ends, states=(states, wrong))
        with patch.object(
            paper, "Loop", lambda *given, n=counts: Told(rates=lambda: [rate] * n[given[-1]])
        ):
            yield (
                f"field {first} {along} {len(wrong)}",
                refused(paper._disturbance, ANY, law, ANY, own),
            )


def of_trim_pitch() -> Named:
    """Yield whether pitch is near the trim's, with nodes in the cell and at the tables' ends."""
    near, tables = words.NEAR_PITCH, [F(0), F(1, 20), F(1, 10)]
    later = [F(1, 4), F(1, 5), F(2, 5)]
    for full in ([F(11), F(20)], [F(9), F(20)], [F(9), F(11), F(20)], [F(12), F(20)]):
        law: Any = Told(partial=Told(wind=[F(4), F(8), F(11)], pitch=tables),
                        full=Told(wind=full, pitch=later[: len(full)]))  # fmt: skip
        for number, (winds, line, width) in enumerate((
            ((F(10), F(11)), (F(1, 12), F(1, 10)), F(0)),
            ((F(7), F(9)), (F(3, 80), F(1, 15)), F(0)),
            ((F(7), F(9)), (F(3, 80) + F(1, 30), F(1, 15) + F(1, 30)), F(0)),
            ((F(7), F(9)), (F(3, 80) + near, F(1, 15)), F(0)),
            ((F(7), F(9)), (F(3, 80), F(1, 15)), near - F(1, 480)),
            ((F(7), F(9)), (F(3, 80), F(1, 15) + F(1, 20)), F(0)),
            ((F(4), F(8)), (F(0), F(1, 20)), near),
            ((F(13), F(14)), (F(1, 4), F(1, 4)), F(0)),
        )):  # fmt: skip
            ends: Any = Told(wind=winds, states=([F(1), line[0]], [F(1), line[1]]),
                             widths=[F(0), width])  # fmt: skip
            yield f"{number} {' '.join(map(str, full))}", words._near_trim_pitch(law, ends)
    none = Told(error=Dual(ZERO, ()))
    with patch.object(words, "Loop", lambda *_: none), patch.object(
        words, "_near_trim_pitch", lambda *_: True
    ):  # fmt: skip
        yield "no error", words._rest(plant(), ANY, ANY, [Told(ends=ANY)])  # type: ignore[list-item]


def of_regions() -> Named:
    """Yield tables of two winds, a first wind below 1 m/s, and a narrow overlap."""
    own = document("paper")["gains"]["partial"]
    for winds in ([4, 5], [0.5, 5], [0.5, 0.9]):
        short = {name: own[name][:2] for name in ("rotor_speed", "pitch")}
        given = as_read({"region": {**own, **short, "wind": winds}})["region"]
        found = said(Region.read, given, "here", 1)
        yield f"winds {winds}", found if isinstance(found, str) else found.wind
    for torque in ("0.5", "1", "0"):
        stated = {"speed_ramp_start": Number("1"), "speed_overlap": Number("0.1"),
                  "torque_overlap": Number(torque)}  # fmt: skip
        yield f"overlap {torque}", said(Overlaps.read, stated, "here", F(43000))
    rest = OneIntegrator(paper_turbine(), paper_law("paper"))
    region = rest.law.full
    wide = Dual(enclose(F(0), F(1)), (UNIT, ZERO))
    for low, high in (region.wind[-2:], (region.wind[-1] - F(1, 9), region.wind[-1])):
        at = RestPlace(rest, (low, high), (F(5), F(6), F(1, 9)), wide, wide, wide)
        yield f"ratio up to the last wind {float(low)}", at._ratio(region, True, False)
    still = RestPlace(rest, (F(8), F(8)), (F(1), F(1), F(0)), wide, wide, wide)
    yield "a column at one wind", still._column(rest.law.partial, rest.law.partial.speed)


def of_loop() -> Named:
    """Yield rates, choices, slopes and cases of the loop at limits that are not decimals."""
    zero, one = Dual(ZERO, ()), Dual(UNIT, ())
    for value in (THIRD.low, THIRD.high, THIRD.high + 1):
        at: Any = Told(
            plant=Told(lag=F(1), rate_limit=F(1, 3), gear_per_inertia=F(1)),
            law=Told(tracking_time=None), pitch=zero, rotor=one, error=one,
            _torque=lambda _: (one, one), _angle=lambda _, v=value: (Dual(Interval(v, v), ()), one),
        )  # fmt: skip
        yield f"rate {value - THIRD.low}", said(Loop.rates, at)
    for slope, free, held in product((ZERO, Interval(0, ONE)), (True, False), (True, False)):
        case: Any = Told(_torque_slope=lambda s=slope: s, _pitch_cases=lambda c=(free, held): c)
        yield f"choices {slope.high} {free} {held}", Loop.choices(case)
    for low, high in product((-1, 0, 1, ONE // 2, ONE), repeat=2):
        if low <= high:
            command, law_ = Dual(Interval(low, high), ()), Told(rated_torque=F(1, 4))
            torque: Any = Told(torque_command=command, law=law_, overlaps=Told(torque=F(5, 2)))
            yield f"slope {low} {high}", Loop._torque_slope(torque)
    ends = sorted({end + k for end in (*THIRD, *LARGER) for k in (-1, 0, 1)})
    for low, high in product(ends, ends):
        if low <= high:
            place = f"{low - THIRD.low} {high - LARGER.low}"
            pitch: Any = Told(
                share=Dual(UNIT, (ZERO,)), pitch_command=Dual(Interval(low, high), (UNIT,)),
                law=Told(pitch_min=F(1, 3), pitch_max=F(2, 3)),
            )  # fmt: skip
            yield f"cases {place}", Loop._pitch_cases(pitch)
            pitch._pitch_cases = lambda: (True, True)
            yield f"angle {place}", Loop._angle(pitch, None)
    law = law_of("paper")
    for name, box in boxes(law):
        if name in ("slow", "fast"):
            seen: list[Any] = []
            loop: Any = Loop(plant(), law, law.overlaps, box, "line")
            ratio = loop._ratio

            def recorded(*given: Any, seen: Any = seen, ratio: Any = ratio) -> Interval:
                seen.append((given[0] is None, *given[1:]))
                found: Interval = ratio(*given)
                return found

            loop._ratio = recorded
            yield f"{name}: rotor", (loop.rotor, seen)
            yield f"{name}: premise", said(loop._pitch_premise, law.full)


def of_one() -> Named:
    """Yield which curve the law with one integrator is counted on, and where its trim is sought."""
    rest: Any = OneIntegrator(paper_turbine(), paper_law("paper"))
    for saturated, share in (
        (F(1, 100), rest.top / 1000), (F(1), rest.top / LONGEST), (F(1, 2), 2 * rest.top / LONGEST),
        (F(1), rest.top / (LONGEST + F(1, 2))),
    ):  # fmt: skip
        seen: list[Any] = []

        def count(f: Any, _: Any, pieces: Any, seen: Any = seen, **__: Any) -> Count:
            seen.append((f.__name__, [piece.span for piece in pieces]))
            return Count(0, 0, 1, 0, ())

        rest._saturated = lambda _, s=saturated: s
        rest.share = lambda _, s=share: s
        with patch.object(paper_one_rest, "count_zeros", count):
            yield f"curve {saturated} {share}", (said(rest.count, WINDS["slow"]), seen)
    for shares, saturated in product(((F(1, 9), F(1, 3)), (F(1, 3), F(1, 9))), (F(1), F(50))):
        rest = OneIntegrator(paper_turbine(), replace(paper_law("paper"), pitch_min=F(1, 100)))
        told, looks = list(shares), list[Any]()
        rest.share = lambda _, t=told: t.pop(0)
        rest._saturated = lambda _, s=saturated: s

        def sign(_: Any, __: Any, s: Any, looks: Any = looks) -> int:
            looks.append(s)
            return 1 if len(looks) == 1 else 0

        with patch.object(paper_one_rest, "sign_over", sign):
            yield f"trim {shares[0]} {saturated}", (rest.at_trim(WINDS["below"]), looks)
    rest._curve = lambda *_: None
    yield "no curve", [rest._keeps(WINDS["slow"], (F(0), F(1)), side, F(1)) for side in (-1, 1)]
    for factor, ratio in product(((0, 5), (1, 5), (-1, 5), (5, 5)), repeat=2):
        told_gains = {
            (True, 1): Interval(factor[0] - ONE, factor[1] - ONE),
            (False, 2): Interval(*ratio),
            (True, 2): UNIT,
        }
        at: Any = Told(gain=lambda *kind, g=told_gains: Dual(g[kind], ()))
        yield f"factor {factor} {ratio}", said(rest._factor, at, Dual(UNIT, ()))
    rest.top = F(1, 3)
    for low, high in product([THIRD.low - 1, *THIRD, THIRD.high + 1], repeat=2):
        if low <= high:
            found = rest._in_table(Dual(Interval(low, high), (UNIT, UNIT)))
            yield f"in table {low - THIRD.low} {high - THIRD.low}", found
    plant_, law = paper_turbine(), paper_law("paper")
    bend = sorted(bends(plant_, law))[1]
    with patch.object(OneIntegrator, "count", lambda *_: Count(2, 2, 1, -1, ())):
        for winds in ((bend, bend + F(1, 100)), (bend - F(1, 100), bend)):
            yield f"beside a bend {winds[0] < bend}", said(published_equilibria, plant_, law, winds)


def of_two() -> Named:
    """Yield what the balance of two integrators is asked for, and at the ends of its ramp."""
    law = paper_law("paper-two-integrators")
    rest: Any = TwoIntegrators(paper_turbine(), law)
    winds, seen = (F(6), F(13, 2)), []
    rest.longest = min(rest.reference(v) * rest.plant.radius / v for v in winds)

    def record(*given: Any) -> int:
        seen.append([value for value in given if isinstance(value, tuple)])
        return 0

    with patch.object(paper_two_rest, "count_zeros", lambda *_, **__: Count(0, 0, 1, 0, ())):
        yield "no room", said(rest.count, winds)
    with patch.object(paper_two_rest, "sign_over", record):
        yield "passes", (rest.passes(winds), seen)
    rest._overspeed = lambda *given: given  # noqa: ARG005
    for ratio in ((F(12), F(13)), (F(8), F(9))):
        asked: list[Any] = []
        rest._overspeed = lambda *given, asked=asked: asked.append(given)
        yield f"fast {ratio[0]}", (rest._fast(winds, ratio), asked)
    own: Any = TwoIntegrators(paper_turbine(), law)
    still, wide = Dual(ZERO, (ZERO, ZERO)), Dual(enclose(F(1), F(2)), (UNIT, ZERO))
    for speeds in ((F(1), F(2), F(1, 9)), (F(2), F(1), F(1, 9))):
        ends: list[Any] = []
        own._carried_pitch = lambda *given, ends=ends: ends.append(given[-1])
        yield f"ends {speeds[0]}", (own._overspeed(winds, speeds, wide, still, ANY), ends)
    own = TwoIntegrators(paper_turbine(), replace(law, tracking_time=F(0)))
    own._carried_pitch = lambda *_: Dual(ZERO, (ZERO, ZERO))
    error = Dual(enclose(F(1, 100), F(1, 50)), (ZERO, UNIT))
    speed = Dual(enclose(F(1), F(101, 100)), (UNIT, ZERO))
    place = (F(1), F(101, 100), F(1, 90))
    yield "no tracking time", said(own._overspeed, winds, place, speed, error, (F(0), F(1)))


def of_held_pitch() -> Named:
    """Yield the pitch that two integrators carry, from gains that are told."""
    law, winds = paper_law("paper-two-integrators"), WINDS["fast"]
    law = replace(law, tracking_time=F(1))
    over, zero = law.overlaps, (ZERO, ZERO)
    start, middle, end = (over.start + k * over.width / 2 for k in range(3))
    place = (F(1), F(1), F(0))

    def carried(rest: Any, ends: Any, size: Dual, gain: Dual | None, slopes: int = 2) -> Any:
        speed = Dual(enclose(*ends), (UNIT, *(ZERO,) * (slopes - 1)))
        told = Told(gain=lambda *_: -gain if gain else 1 / 0)
        with patch.object(paper_two_rest, "RestPlace", lambda *_: told):
            return said(rest._carried_pitch, winds, place, speed, size, ends)

    one = Dual(UNIT, zero)
    rest: Any = TwoIntegrators(paper_turbine(), law)
    yield "before the ramp", carried(rest, (start - 1, start), one, None)
    for top in (law.pitch_max, law.pitch_max - F(1, 99)):
        rest.top = top
        yield f"beyond the ramp {top == law.pitch_max}", carried(rest, (end, end + 1), one, None)
    rest = TwoIntegrators(paper_turbine(), law)
    gain = Dual(point(F(1, 5)), (*zero, ZERO))
    small = Dual(Interval(0, 10**6), zero)
    yield "to the ramp's end", carried(rest, (middle, end), small, gain)
    held, nothing = point(F(1, 9)), (None, ZERO)
    for name, answers in (("first", [nothing]), ("second", [(held, held), nothing])):
        rest._held_to = lambda *_, a=list(answers): a.pop(0)
        yield f"nothing is left, {name}", carried(rest, (middle, middle), one, gain)
    rest.top = F(1, 3)
    sides = (ONE - 2, ONE - 1, ONE, ONE + 1)
    for high, low, most in product((THIRD.low, THIRD.high, THIRD.high + 1), sides, sides):
        if low <= most:
            wanted = Interval(THIRD.low // 2, high)
            rest._held_to = lambda *_, w=wanted: (held, w)
            steep = Dual(point(F(1, 5)), (UNIT, ZERO, Interval(low, most)))
            found = carried(rest, (middle, middle), one, steep)
            yield f"slopes {high - THIRD.low} {low - ONE} {most - ONE}", found
    steep = Dual(point(F(1, 5)), (*zero, ZERO))
    rest._held_to = lambda *_: (held, held)
    three = Dual(UNIT, (*zero, ZERO))
    yield "three slopes", refused(carried, rest, (middle, middle), three, steep, 3)
    rest = TwoIntegrators(paper_turbine(), paper_law("paper-two-integrators", LATE))
    rest.top = F(1, 3)
    for low, high in product([THIRD.low - 1, *THIRD, THIRD.high + 1], repeat=2):
        if low <= high:
            found = rest._held_to(Interval(low, high), UNIT)
            yield f"held to {low - THIRD.low} {high - THIRD.low}", found


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    return {
        "edges of cells, paper": of_lengths,
        "edges of the trim's pitch": of_trim_pitch,
        "edges of regions": of_regions,
        "edges of the loop": of_loop,
        "edges of one integrator": of_one,
        "edges of two integrators": of_two,
        "edges of held pitch": of_held_pitch,
    }
