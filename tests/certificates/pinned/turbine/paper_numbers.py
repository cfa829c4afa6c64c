"""Brackets of the loop with a law of the paper, over boxes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import ONE, UNIT, enclose
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.published import loop as paper_loop
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw, Region
from takagi.certificates.checker.turbine.published.loop import Ends, Loop, interpolated
from tests.certificates.pinned.turbine.inputs import read
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


LAWS = ("paper", "paper-two-integrators")


SEEDS = ("states", "line", "none")


PARTS = (
    *("state", "rotor", "error", "partial_weights", "full_weights"),
    *("torque_command", "share", "pitch_command"),
)


@cache
def plant() -> Plant:
    """Return the turbine with a drive of any speed, so that no box is refused for its rate."""
    return replace(Plant.read(read("paper")["model"]), rate_limit=F(1000))


def law_of(name: str) -> PublishedLaw:
    """Return the recorded law with gains that differ from corner to corner, by much."""
    law = PublishedLaw.read(read(name)["gains"])

    def region(own: Region, *tables: tuple[int, ...]) -> Region:
        corners = own.gains[0].keys()
        gains = [dict(zip(corners, map(F, row), strict=True)) for row in tables]
        return replace(own, gains=[*({c: g / 100 for c, g in t.items()} for t in gains)])

    return replace(
        law,
        smooth=name == "paper",
        partial=region(law.partial, (-6000000, -9500000), (0, 0), (-1200000, -600000)),
        full=region(_bent(law.full), (-20, -40, -60, -10), (-30, -50, -20, -70), (-5, -9, -7, -12)),
    )


def _bent(own: Region) -> Region:
    """Return a region whose trim speed goes with the wind."""
    return replace(own, speed=[s * (1 + F(k, 500)) for k, s in enumerate(own.speed)])


def boxes(law: PublishedLaw) -> Iterator[tuple[str, Ends]]:
    """Yield boxes in both regions, on the ramps, at limits of pitch and torque, and held winds."""
    for name, v, off, pitch, torque, size in (
        ("slow", F(6), F(0), F(0), F(12000), F(1, 4)),
        ("very slow", F(7, 2), F(1, 50), F(0), F(0), F(1)),
        ("middle", F(9), F(-1, 40), F(1, 100), F(27000), F(1, 10)),
        ("ramp starts", F(109, 10), F(1, 50), F(0), F(42500), F(1, 20)),
        ("ramp", F(113, 10), F(1, 25), F(1, 80), F(43093), F(1, 10)),
        ("corner", F(116, 10), F(-1, 100), F(1, 60), F(44000), F(1, 4)),
        ("beyond", F(14), F(1, 30), F(3, 20), F(46000), F(1, 10)),
        ("fast", F(20), F(3, 50), F(3, 10), F(40000), F(1, 50)),
        ("end", F(25), F(0), F(2, 5), F(43000), F(1, 50)),
        ("wide", F(12), F(0), F(1, 20), F(43000), F(1)),
    ):
        reference = min(law.setpoint, law.optimal_ratio * v / plant().radius)
        first = [reference + off, pitch, -torque / 9000]
        if law.states == 4:
            first.append(-pitch * 22)
        last = [entry + (1 + abs(entry)) / 999 for entry in first]
        widths = [size * width for width in (F(1, 50), F(1, 100), F(1, 5), F(1, 10))]
        yield name, Ends((v, v + F(1, 64)), (first, last), widths[: law.states])


def of_boxes(name: str, seeds: str, part: int) -> Named:
    """Yield the loop's pieces and z' with its slopes."""
    law = law_of(name)
    for number, (box, ends) in enumerate(boxes(law)):
        if number % 3 != part:
            continue
        at = Loop(plant(), law, law.overlaps, ends, seeds)
        for what in PARTS:
            yield f"{box}: {what}", said(getattr, at, what)
        for work in (at._torque_slope, at._pitch_cases, at.choices, at.rates):
            yield f"{box}: {work.__name__}", said(work)
        for end, free in product((None, 0, 1), (None, True, False)) if seeds == "states" else ():
            if free in (None, *(case for _, case in at.choices())):
                yield f"{box}: rates {end} {free}", said(at.rates, end, free)


def of_pieces(name: str) -> Named:
    """Yield what is passed of a torque, columns between nodes, and winds that are held."""
    law = law_of(name)
    ends = dict(boxes(law))["corner"]
    at = Loop(plant(), law, law.overlaps, ends, "states")
    half = law.overlaps.torque / 2
    for step in (-99, -2, -1, -F(1, 2), 0, F(1, 2), 1, 2):
        x = int((law.rated_torque + step * half) * ONE)
        yield f"passed {step}", at._passed(x)
    yield "passed below 0", at._passed(-ONE)
    bent = replace(law, largest_ratio=F(9))
    for low, high in ((3, 4), (5, 6), (6, 7), (9, 12)):
        states = [[z[0] * low / 11, *z[1:]] for z in ends.states]
        here = Ends((F(low), F(high)), (states[0], states[1]), ends.widths)
        yield f"error {low} {high}", Loop(plant(), bent, law.overlaps, here, "line").error
    nodes, column = [F(4), F(6), F(9), F(10)], [F(1), F(3), F(-2), F(5)]
    for wind in (F(3), F(4), F(5), F(6), F(17, 2), F(9), F(19, 2), F(10), F(12)):
        yield f"interpolated {wind}", interpolated(nodes, column, wind)
    for v1, v2 in ((4, 5), (3, 4), (F(7, 2), F(9, 2)), (5, 10), (10, 11), (9, 12), (2, 30), (6, 6)):
        held = Loop(
            plant(), law, law.overlaps,
            Ends((F(v1), F(v2)), ends.states, ends.widths), "line" if v1 != v2 else "none",
        )  # fmt: skip
        region = replace(law.partial, wind=nodes, speed=[F(1), F(11, 10), F(6, 5), F(1)])
        yield f"held wind {v1} {v2}", held._held_wind(F(4), F(10))
        yield f"column {v1} {v2}", held._column(region, column)
        for of_state, of_trim in ((True, False), (False, True), (True, True)):
            yield (
                f"ratio {v1} {v2} {of_state} {of_trim}",
                [
                    held._ratio(region, of_state, of_trim),
                    *([held._ratio(None, of_state, of_trim)] if of_state else []),
                ],
            )


def of_ramps(name: str) -> Named:
    """Yield share, torque and pitch for efforts and speeds on each side of each corner."""
    law = law_of(name)
    ends, over = dict(boxes(law))["corner"], law.overlaps
    steps = (F(-1), F(0), F(2, 5), F(1, 2), F(3, 5), F(1), F(2))
    for a, b in product(steps, steps):
        if a > b:
            continue
        at = Loop(plant(), law, over, ends, "states")
        slopes = at.speed.slopes
        at.speed = Dual(enclose(over.start + a * over.width, over.start + b * over.width), slopes)
        yield f"share {a} {b}", at.share
        half = over.torque / 2
        low, high = (law.rated_torque + (2 * s - 1) * half for s in (a, b))
        for what, u in (("corner", enclose(low, high)), ("zero", enclose(a * half, b * half))):
            at.__dict__["torque_command"] = Dual(u, slopes)
            yield f"torque slope at the {what} {a} {b}", at._torque_slope()
            yield f"torque at the {what} {a} {b}", [at._torque(end) for end in (None, 0, 1)]
        at.__dict__["share"] = Dual(UNIT, slopes)
        for what, limit in (("bottom", law.pitch_min), ("top", law.pitch_max)):
            at.__dict__["pitch_command"] = Dual(enclose(limit + a, limit + b), slopes)
            yield f"pitch cases at the {what} {a} {b}", at._pitch_cases()
            for free in (None, True, False):
                yield f"pitch at the {what} {a} {b} {free}", said(at._angle, free)


def of_drive(name: str) -> Named:
    """Yield in which boxes the drive may be asked for more than its limit."""
    law = law_of(name)
    for box, ends in boxes(law):
        for limit in (F(1, 20), F(1, 2), F(2)):
            slow = replace(plant(), rate_limit=limit)
            found = said(Loop(slow, law, law.overlaps, ends, "none").rates)
            yield f"{box} {limit}", found if isinstance(found, str) else "within"


def of_quotients() -> Named:
    """Yield averages that are quotients, and gains between corners."""
    found = Dual(enclose(F(1), F(2)), (UNIT,))
    for rise, step in product(
        ((1, 2), (3, 4), (-1, 1)), ((1, 2), (-2, -1), (-1, 1), (0, 1), (-1, 0))
    ):
        rises, steps = enclose(*map(F, rise)), enclose(*map(F, step))
        yield f"quotient {rise} {step}", said(paper_loop._quotient, found, rises, steps)
    bounds = F(1, 2), F(3, 2)
    for low, high in ((0, 1), (1, 1), (1, 2), (0, 2), (-1, 0), (2, 3)):
        premise = Dual(enclose(F(low), F(high)), (UNIT,))
        yield f"weight {low} {high}", paper_loop._weight(premise, bounds)


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {"averages": of_quotients}
    for law in LAWS:
        for seeds, part in product(SEEDS, range(3)):
            tag = f"{law}, {seeds}, {part}"
            found[tag] = lambda law=law, seeds=seeds, part=part: of_boxes(law, seeds, part)
        found[f"{law}, pieces"] = lambda law=law: of_pieces(law)
        found[f"{law}, drive"] = lambda law=law: of_drive(law)
        found[f"{law}, ramps"] = lambda law=law: of_ramps(law)
    return found
