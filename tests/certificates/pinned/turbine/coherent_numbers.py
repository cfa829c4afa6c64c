"""Enclosures of the effort-sharing loop in one wind cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.turbine.effort_sharing import table_residual as coherent_residual
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.moving_schedule import Moving
from tests.certificates.pinned.turbine.inputs import CELLS, read
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


def subject(cell: str) -> Subject:
    """Return what the recorded claim is about."""
    data = read(cell)
    return Subject.read(data["claims"][0], data["model"], data["gains"], "claims[0]")


def stated(cell: str) -> Stated:
    return Stated.read(read(cell)["claims"][0]["cells"][0], "cell")


def other(about: Subject, part: str, **changes: Any) -> Subject:
    """Return the subject with other numbers in one of its parts."""
    return replace(about, **{part: replace(getattr(about, part), **changes)})


def moving(at: Moving) -> Named:
    """Yield what a moving schedule wind does."""
    yield "efforts", (at.low, at.high, at.least_b, at.lead)
    yield "ranges", (at.wind, at.b, at.c, at.radius)
    yield "asked", at.asked
    yield "led", at.led()
    yield "lag rates", at.lag_rates()
    yield "slopes", (at.effectiveness_slope(), at.reference_slope())
    yield "cut", at._cut()
    yield "lag disturbance", at.lag_disturbance()
    yield "least torque", at.least_torque()
    yield "largest pitch", said(at.largest_pitch)


def loop(at: Loop) -> Named:
    """Yield the coefficients of the loop in a cell."""
    yield "reached", at.reached
    yield "pieces", list(at._pieces())
    yield "limits", at.limits_failure()
    yield from (*at.ranges(), *at.sizes())


def in_cell(cell: str) -> Named:
    about, rate = subject(cell), stated(cell).sizes["wind_rate"]
    at = Loop(about, 0, rate)
    yield from moving(at)
    yield from loop(at)
    ranges, sizes = stated(cell).ranges, stated(cell).sizes
    yield "failures", (at.range_failure(ranges), at.size_failure(sizes))
    for name, found in at.ranges():
        low, high = F(found.low, ONE), F(found.high, ONE)
        tried = ((low, high), (low + F(1, ONE), high), (low, high - F(1, ONE)))
        yield f"{name} at its ends", [at.range_failure({**ranges, name: list(e)}) for e in tried]
    for name, size in at.sizes():
        ends = (size, size - F(1, ONE))
        yield f"{name} at its end", [at.size_failure({**sizes, name: end}) for end in ends]


def variants(cell: str) -> Iterator[tuple[str, Subject, Fraction]]:
    """Yield other laws, boxes and uncertainties in the same cell, honest or not."""
    about, rate = subject(cell), stated(cell).sizes["wind_rate"]
    law = about.law
    slow = 3 * rate + F(1, 100)
    yield "still", about, F(0)
    yield "faster", about, 7 * rate + F(1, 50)
    yield "lead", other(about, "law", lead=about.plant.lag / 2), rate
    yield "long lead", other(about, "law", lead=3 * about.plant.lag), 5 * rate + F(1, 10)
    yield "no lead", other(about, "law", lead=F(0)), rate
    for name, f, g, rho in (
        ("fed", F(-1, 10), F(1, 500), rate),
        ("fed, limited", F(1, 7), F(1, 90), F(3, 10)),
        ("fed, none", F(1, 7), F(0), rate),
    ):
        yield name, other(about, "law", inertia=[f], inertia_limit=[g]), rho
    yield "light", other(about, "uncertainty", inertia=(F(7, 10), F(13, 10))), rate
    yield "no wake", other(about, "uncertainty", frozen_wake=False), rate
    yield "power", other(about, "uncertainty", power=(F(9, 10), F(21, 20))), rate
    yield "narrow ramp", other(about, "law", overlap=law.overlap / 50), rate
    yield "wide ramp", other(about, "law", overlap=3 * law.overlap), rate
    small = {"speed_signal": F(1, 1000), "effort_lag": F(1, 2000)}
    yield "small box", other(about, "box", **small), rate
    steep = [law.effectiveness[0], 3 * law.effectiveness[1]]
    yield "steep", other(about, "law", effectiveness=steep), slow
    yield "steeper", other(about, "law", effectiveness=steep), 40 * slow
    names = ("speed", "effort", "effectiveness", "limit", "gamma")
    falling = {name: getattr(law, name)[::-1] for name in names}
    yield "falling", other(about, "law", **falling), slow
    high = {"pitch_min": F(1, 40), "pitch_max": F(1, 3)}
    yield "raised pitch", other(about, "law", **high), rate
    yield "low torque", other(about, "law", rated_torque=F(9000)), rate
    yield "low pitch", other(about, "law", pitch_max=F(1, 50)), rate
    yield "late pitch", other(about, "box", effort_lag=2 * about.plant.pitch_max), rate
    # The lead alone asks for more than the limit, though the set does not.
    led = {"lead": 3 * about.plant.lag, "pitch_max": F(3, 25)}
    yield "led pitch", other(about, "law", **led), 5 * rate + F(1, 10)
    yield "slow drive", other(about, "plant", rate_limit=F(1, 200)), rate


def of_moving(cell: str) -> Named:
    for name, about, rate in variants(cell):
        yield from ((f"{name}: {what}", value) for what, value in moving(Moving(about, 0, rate)))


def of_variants(cell: str) -> Named:
    few = {"light", "no wake", "power", "small box", "falling", "raised pitch"}
    more = {"no wake", "power", "falling", "low pitch", "slow drive", "long lead"}
    more |= {"late pitch", "led pitch", "raised pitch"}
    for name, about, rate in variants(cell):
        if name in (more if cell == "rated" else few):
            at = Loop(about, 0, rate)
            yield f"{name}: ranges", said(dict, at.ranges())
            yield f"{name}: sizes", said(dict, at.sizes())
            yield f"{name}: limits", at.limits_failure()
            yield f"{name}: pieces", list(at._pieces())


def of_middle_cell() -> Named:
    """Yield the numbers of a cell that has neighbours with other tables."""
    about, rate = subject("rated"), stated("rated").sizes["wind_rate"]
    law = about.law
    low, high = law.wind
    nodes = ("speed", "effort", "effectiveness", "limit", "gamma")
    columns = {name: [F(7, 8) * getattr(law, name)[0], *getattr(law, name),
                      F(9, 8) * getattr(law, name)[1]] for name in nodes}  # fmt: skip
    cells = {name: [F(1, 9), *getattr(law, name), F(1, 7)] for name in ("nu", "inertia_limit")}
    columns |= cells | {"inertia": [F(1, 8), F(1, 30), F(1, 6)]}
    cells = {"wind": [low - F(1, 8), low, high, high + F(1, 8)]}
    at = Loop(other(about, "law", **columns, **cells), 1, rate)
    yield from moving(at)
    yield from loop(at)


def of_residual(cell: str) -> Named:
    """Yield the jets that bound how far the tables leave the trim."""
    at = Moving(subject(cell), 0, F(0))
    yield "ratio", coherent_residual._ratio(at)
    yield "pitch", coherent_residual._pitch(at)
    jets = coherent_residual._ratio(at), coherent_residual._pitch(at)
    yield "coefficient", coherent_residual._coefficient(at, *jets)
    yield "curvature", coherent_residual._curvature(at)
    yield "at nodes", [coherent_residual._at_node(at, i) for i in (0, 1)]
    yield "demanded", [coherent_residual._demanded(at, i) for i in (0, 1)]
    for power in ((F(1), F(1)), (F(9, 10), F(1)), (F(1), F(11, 10)), (F(9, 10), F(6, 5))):
        yield f"power {power[0]} to {power[1]}", coherent_residual.residual(at, power)


def of_bends() -> Named:
    eps = F(1, 8)
    ends = [F(k, 16) for k in range(-4, 5)]
    for low, high in product(ends, ends):
        if low <= high:
            yield f"{low} to {high}", coherent_residual._bend(low, high, eps)


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {"ramp bends": of_bends, "middle cell": of_middle_cell}
    for cell in CELLS:
        for name, numbers in (
            ("cell", in_cell), ("moving", of_moving), ("variants", of_variants),
            ("residual", of_residual),
        ):  # fmt: skip
            found[f"{name}, {cell}"] = lambda numbers=numbers, cell=cell: numbers(cell)
    return found
