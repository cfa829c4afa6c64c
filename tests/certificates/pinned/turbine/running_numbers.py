"""The running loop's cells: tables, efforts, factors, equations, sides, and limits of rates."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

from takagi.certificates.checker import read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop import limits
from takagi.certificates.checker.turbine.running_loop.cell import Cell, down, size, up
from takagi.certificates.checker.turbine.running_loop.equations import (
    equations,
    measured_rate,
    rows,
)
from takagi.certificates.checker.turbine.running_loop.factors import cut, drive_secant, factors
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Sides
from takagi.certificates.checker.turbine.running_loop.reach import squared_reaches
from takagi.certificates.checker.turbine.running_loop.running_claim import (
    StatedCell,
    stated_winds,
)
from takagi.certificates.checker.turbine.running_loop.signals import decay_form
from takagi.certificates.checker.turbine.wind_intervals import gaps
from tests.certificates.pinned.turbine.values import Named, said
from tests.certificates.recorded.answers import recorded

F = Fraction
CELLS = range(4)
NAMES = (
    *("k", "reach", "estimate_is_free", "near", "b", "b_reach", "b0", "q", "rest"),
    *("rest_integral", "efforts", "efforts_at_rest", "pitches", "share", "shed"),
    *("schedule_rate", "lead", "wind", "c", "effort_unit"),
)
# Other data of the same turbine: a wider box, no band-stop, an estimate near its limits.
VARIANTS: dict[str, Callable[[Any], None]] = {
    "as stated": lambda parts: None,
    "wide": lambda parts: parts.update(sides=scaled(parts["sides"], F(3, 2))),
    "narrow": lambda parts: parts.update(sides=scaled(parts["sides"], F(1, 3))),
    "no band-stop": lambda parts: parts.update(machine=replace(parts["machine"], stop=None)),
    "schedule of all winds": lambda parts: parts.update(
        sides=replace(parts["sides"], schedule=parts["winds"][0] - F(1, 100))
    ),
    "pitch from 1/50 on": lambda parts: parts.update(
        plant=replace(parts["plant"], pitch_min=F(1, 50)),
        law=replace(parts["law"], pitch_min=F(1, 50)),
    ),
    "a slow drive": lambda parts: parts.update(
        plant=replace(parts["plant"], rate_limit=parts["plant"].rate_limit / 50)
    ),
    "a late wake": lambda parts: parts.update(
        law=replace(parts["law"], limit=[value / 9 for value in parts["law"].limit])
    ),
    "tilted": lambda parts: parts.update(law=tilted(parts["law"])),
    "at a node": lambda parts: parts.update(
        winds=(parts["law"].wind[node(parts)], parts["winds"][1])
    ),
}


def scaled(sides: Sides, factor: Fraction) -> Sides:
    return Sides(*(factor * getattr(sides, name) for name in Sides.__dataclass_fields__))


def tilted(law: Law) -> Law:
    """Return the law with columns that differ from node to node."""
    columns = ("gamma", "nu", "inertia", "inertia_limit", "limit", "effectiveness")
    moved: dict[str, Any] = {
        name: [value * (1 + F(j % 7, 200)) for j, value in enumerate(getattr(law, name))]
        for name in columns
    }
    return replace(law, **moved)


def node(parts: Any) -> int:
    """Return the last node below the cell."""
    return max(j for j, wind in enumerate(parts["law"].wind) if wind <= parts["winds"][0])


def document() -> Any:
    return read_text(json.dumps(json.loads(next(recorded("running-loop"))[1])), "document")


def parts_of(k: int, variant: str) -> dict[str, Any]:
    data = document()
    claim = data["claims"][0]
    stated = StatedCell.read(claim["cells"][k], 10, "cell")
    machine = Machine.read(claim, data["model"], data["gains"], "claim")
    found = {"plant": Plant.read(data["model"]), "law": Law.read(data["gains"])}
    found |= {"machine": machine, "winds": stated.winds, "sides": stated.sides}
    VARIANTS[variant](found)
    return found | {"stated": stated}


def built(parts: dict[str, Any]) -> Cell:
    order = ("plant", "law", "machine", "winds", "sides")
    return Cell(*(parts[name] for name in order))


def of_cell(k: int, variant: str) -> Named:
    """Yield what a cell encloses; its refusal alone where it has one."""
    parts = parts_of(k, variant)
    cell = said(built, parts)
    if isinstance(cell, str):
        yield "refused", cell
        return
    for name in NAMES:
        yield name, getattr(cell, name)
    yield "wind gain", cell.wind_gain()
    yield "drive", drive_secant(cell)
    found = said(factors, cell)
    yield "factors", found
    yield "rates", limits.command_rates(cell)
    yield "limit", limits.limit_failure(cell)
    if isinstance(found, str):
        return
    for name, (row, bound) in rows(cell, found).items():
        yield f"side {name}", (row, bound)
    for i, held in enumerate(cut(cell.share, 2)):
        signals, rates = equations(cell, found, held)
        yield f"signals {i}", (signals.names, [sorted(s.items()) for s in signals.outer])
        yield f"state rates {i}", [sorted(rate.items()) for rate in rates]
    yield "measured rate", sorted(measured_rate(cell.machine).items())


def of_form(k: int) -> Named:
    """Yield the form of the decay, and how far the set reaches."""
    parts = parts_of(k, "as stated")
    cell, stated = built(parts), parts["stated"]
    found = factors(cell)
    signals, rates = equations(cell, found, cell.share)
    tau = [stated.multipliers[0][name] for name in signals.names]
    yield "form", decay_form(signals, rates, stated.P, tau, F(1, 250))
    yield "reaches", squared_reaches(stated.P, [row for row, _ in rows(cell, found).values()])


def of_numbers() -> Named:
    """Yield what is rounded, and which winds are left out."""
    for value in (F(1, 3), F(-1, 3), F(0), F(5, 2), F(1, 10**8), F(-1, 10**8)):
        yield f"rounded {value}", (down(value), up(value))
    yield "sizes", [size((F(a), F(b))) for a, b in ((-3, 2), (-2, 3), (1, 2), (-2, -1))]
    yield "cut", [cut((F(1), F(2)), parts) for parts in (1, 2, 3)]
    yield (
        "gaps",
        [
            gaps((F(3), F(25)), winds)
            for winds in ([(F(3), F(5))], [(F(4), F(5)), (F(5), F(7))], [(F(4), F(25))])
        ],
    )
    cell = parts_of(0, "as stated")["stated"]
    for name, listed, claimed in (
        ("joined", [(3, 4), (4, 5), (6, 7)], [[3, 5], [6, 7]]),
        ("not joined", [(3, 4), (4, 5), (6, 7)], [[3, 4], [4, 5], [6, 7]]),
        ("overlapping", [(3, 5), (4, 6)], [[3, 6]]),
        ("backward", [(4, 5), (3, 4)], [[3, 5]]),
        ("one", [(3, 4)], [[3, 4]]),
        ("another", [(3, 4)], [[3, 5]]),
    ):
        cells = [replace(cell, winds=(F(a), F(b))) for a, b in listed]
        claim = read_text(json.dumps({"winds": claimed}), "claim")
        yield f"winds {name}", said(stated_winds, claim, cells, "claim")


def of_refusals() -> Named:
    """Yield what a cell answers at the ends of what it may be."""
    parts = parts_of(3, "as stated")
    (low, high), sides, nodes = parts["winds"], parts["sides"], parts["law"].wind
    machine, at = parts["machine"], node(parts)

    def answer(**changed: Any) -> str:
        found = said(built, parts | changed)
        return found if isinstance(found, str) else "built"

    for name, winds in (
        ("over a node", (low, nodes[at + 1] + F(1, 100))),
        ("to a node", (low, nodes[at + 1])),
        ("of one wind", (low, low)),
        ("backward", (high, low)),
        ("below the tables", (nodes[0] - 1, nodes[0])),
        ("above the tables", (nodes[-1], nodes[-1] + 1)),
        ("in the last interval", (nodes[-2], nodes[-1])),
    ):
        yield name, answer(winds=winds)
    ends = (low - sides.estimate, high + sides.estimate)
    for name, limit in (
        ("limits that hold the estimate", (ends[0] - F(1, 10**6), ends[1] + F(1, 10**6))),
        ("a lower limit that is reached", (ends[0], ends[1] + 1)),
        ("an upper limit that is reached", (ends[0] - 1, ends[1])),
        ("limits that are reached", ends),
    ):
        yield name, answer(machine=replace(machine, wind_limits=limit))
    for name, value in (("to zero", low), ("nearly to zero", low - F(1, 10**6))):
        yield f"a schedule {name}", answer(sides=replace(sides, schedule=value))
    still = replace(parts["law"], effectiveness=[F(0)] * len(nodes))
    yield "no effectiveness", answer(law=still)
    cell, last = built(parts), nodes[-1]
    for wind in (nodes[0], (nodes[0] + nodes[1]) / 2, nodes[1], nodes[2], (nodes[-2] + last) / 2):
        yield f"speed at {wind}", cell.at(parts["law"].speed, wind)
    yield "speed at the last", cell.at(parts["law"].speed, last)
    yield "speed over all", cell.over(parts["law"].speed, (nodes[0], last))
    small = replace(parts["law"], effectiveness=[F(1, 10**5)] * len(nodes))
    yield "little effectiveness", answer(law=small)


def groups() -> dict[str, Callable[[], Named]]:
    found: dict[str, Callable[[], Named]] = {
        f"running cell {k}, {variant}": partial(of_cell, k, variant)
        for k in CELLS
        for variant in VARIANTS
    }
    found |= {f"running form {k}": partial(of_form, k) for k in CELLS}
    return found | {"running numbers": of_numbers, "running refusals": of_refusals}
