"""Numbers of the loop with a law of the paper: its brackets over boxes, and its claim."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import ONE, UNIT, enclose
from takagi.certificates.checker.turbine import paper, paper_loop
from takagi.certificates.checker.turbine.coherent_inputs import Plant
from takagi.certificates.checker.turbine.paper_inputs import PaperLaw, Region
from takagi.certificates.checker.turbine.paper_loop import Ends, Loop, interpolated
from tests.certificates.pinned.turbine.inputs import Document, as_read, document
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction
LAWS = ("paper", "paper-two-integrators")
SEEDS = ("states", "line", "none")
PARTS = (
    *("state", "rotor", "error", "partial_weights", "full_weights"),
    *("torque_command", "share", "pitch_command"),
)


@cache
def read(name: str) -> Document:
    return as_read(document(name))


@cache
def plant() -> Plant:
    """Return the turbine with a drive of any speed, so that no box is refused for its rate."""
    return replace(Plant.read(read("paper")["model"]), rate_limit=F(1000))


def law_of(name: str) -> PaperLaw:
    """Return the recorded law with gains that differ from corner to corner, by much."""
    law = PaperLaw.read(read(name)["gains"])

    def region(own: Region, *tables: tuple[int, ...]) -> Region:
        corners = own.gains[0].keys()
        gains = [dict(zip(corners, map(F, row), strict=True)) for row in tables]
        return replace(own, gains=[*({c: g / 100 for c, g in t.items()} for t in gains)])

    return replace(
        law,
        smooth=name == "paper",
        partial=region(law.partial, (-6000000, -9500000), (0, 0), (-1200000, -600000)),
        full=region(law.full, (-20, -40, -60, -10), (-30, -50, -20, -70), (-5, -9, -7, -12)),
    )


def boxes(law: PaperLaw) -> Iterator[tuple[str, Ends]]:
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
    steps = (F(-1), F(0), F(1, 4), F(1, 2), F(1), F(2))
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


def of_quotients() -> Named:
    """Yield averages that are quotients, and gains between corners."""
    found = Dual(enclose(F(1), F(2)), (UNIT,))
    for rise, step in product(((1, 2), (3, 4), (-1, 1)), ((1, 2), (-2, -1), (-1, 1), (0, 1))):
        rises, steps = enclose(*map(F, rise)), enclose(*map(F, step))
        yield f"quotient {rise} {step}", said(paper_loop._quotient, found, rises, steps)
    bounds = F(1, 2), F(3, 2)
    for low, high in ((0, 1), (1, 1), (1, 2), (0, 2), (-1, 0), (2, 3)):
        premise = Dual(enclose(F(low), F(high)), (UNIT,))
        yield f"weight {low} {high}", paper_loop._weight(premise, bounds)


def _read_law(gains: Any) -> Any:
    found = said(PaperLaw.read, as_read({"gains": gains})["gains"])
    return found if isinstance(found, str) else found.overlaps


def of_law_reading() -> Named:
    """Yield which laws are read, and as what."""
    for name in LAWS:
        yield name, PaperLaw.read(read(name)["gains"])
    for name in LAWS:
        own = document(name)["gains"]
        for key, value in own.items():
            for other in (-1, 0) if isinstance(value, (int, float)) else ("word",):
                yield f"{name}: {key} is {other}", _read_law({**own, key: other})
        for key, other in (
            ("variant", "other"), ("speed_ramp_shape", "linear"), ("speed_ramp_shape", "other"),
            ("torque_overlap", 0), ("torque_overlap", 2 * own["rated_torque"]),
            ("torque_overlap", 2 * own["rated_torque"] - 1), ("speed_overlap", 0),
            ("speed_overlap", -1),
        ):  # fmt: skip
            coupling = {**own["coupling"], key: other}
            yield f"{name}: {key} {other}", _read_law({**own, "coupling": coupling})
        yield f"{name}: winds", _read_law({**own, "cut_out": own["cut_in"]})


def of_region_reading() -> Named:
    """Yield which tables and gains of a region are read."""
    for region, key, value in (
        ("partial", "k_pitch", [0, 0, 1, 1]), ("partial", "k_pitch", [1, 1, 1, 1]),
        ("partial", "k_pitch", [1, 1, 0, 0]), ("partial", "k_speed", [1, 2, 3, 3]),
        ("partial", "k_integral", [0, 0, -1, -1]), ("partial", "k_integral", [-1, -1, 1, 1]),
        ("partial", "rules", [[0, 0], [0, 1], [1, 1], [1, 0]]), ("partial", "wind", [4]),
        ("partial", "wind", [0, 4]), ("partial", "wind", [5, 4]), ("partial", "pitch", [1]),
        ("full", "premises", {"a": [0, 0], "b": [0, 1], "d": [0, 1]}),
        ("full", "premises", {"a": [0, 1], "b": [1, 0], "d": [0, 1]}),
        ("full", "premises", {"a": [0, 1], "b": [0, 1]}),
    ):  # fmt: skip
        own = document("paper")["gains"]
        own[region][key] = value
        if key == "wind":
            count = len(value)
            own[region] |= {name: own[region][name][:count] for name in ("rotor_speed", "pitch")}
        yield f"{region}.{key} {value}", _read_law(own)


# ------------------------------------------------------------------ the claim


def cells(name: str) -> list[paper._Cell]:
    claim, law = read(name)["claims"][0], PaperLaw.read(read(name)["gains"])
    return [paper._Cell.read(cell, law, f"cells[{k}]") for k, cell in enumerate(claim["cells"])]


def of_claim(name: str, part: int) -> Named:
    """Yield what is said of each recorded cell, and of it with one number changed."""
    data = read(name)
    law, turbine = PaperLaw.read(data["gains"]), Plant.read(data["model"])
    for k, cell in list(enumerate(cells(name)))[part::3]:
        yield f"field at the centre, {k}", paper._disturbance(turbine, law, law.overlaps, cell.ends)

        def failure(cell: paper._Cell) -> Any:
            return paper._failure(turbine, law, law.overlaps, cell, "here")

        yield f"cell {k}", failure(cell)
        if k == 0:
            for what, changes in (
                ("rate", {"rate": 9 * cell.rate}),
                ("multiplier", {"multiplier": 40 * cell.multiplier}),
                ("disturbance", {"disturbance": [d / 2 for d in cell.disturbance]}),
                ("P", {"P": [[entry / 2 for entry in row] for row in cell.P]}),
                ("wind", {"ends": replace(cell.ends, wind=(cell.ends.wind[0], F(26)))}),
                ("corners", {"corners": [(low, low) for low, _ in cell.corners]}),
                ("first corner", {"corners": cell.corners[:1]}),
            ):
                yield f"{what} changed, {k}", failure(replace(cell, **changes))
        yield f"near the trim's pitch, {k}", paper._near_trim_pitch(law, cell.ends)
        for off in (F(1, 50), F(349, 10000), F(35, 1000), F(1, 20)):
            for sign in (1, -1):
                states = [[z[0], z[1] + sign * off, *z[2:]] for z in cell.ends.states]
                moved = replace(cell.ends, states=(states[0], states[1]))
                yield f"pitch {sign * off} off, {k}", paper._near_trim_pitch(law, moved)


def of_words() -> Named:
    """Yield how ranges of winds are said."""
    step = F(1, 10)
    for name, starts in (
        ("run", [F(4) + k * step for k in range(6)]),
        ("two runs", [F(4), F(5), F(6), F(8), F(10), F(12)]),
        ("pairs", [F(4), F(5), F(7), F(8), F(13)]),
        ("one", [F(4)]),
    ):
        yield f"windows {name}", paper._windows(starts, F(1, 16))
        yield f"spans {name}", paper._shown([(low, low + F(1, 16)) for low in starts])
        uneven = [(low, low + F(k + 1, 32)) for k, low in enumerate(starts)]
        yield f"uneven {name}", paper._shown(uneven)
    many = [(F(k), F(k) + F(1, 3 + k)) for k in range(1, 60)]
    even = [(low, low + F(1, 4)) for low, _ in many]
    for count in (2, 3, 4, 5, 39, 40, 41, 59):
        yield f"{count} spans", paper._shown(many[:count])
        yield f"{count} even spans", paper._shown(even[:count])
    law = PaperLaw.read(read("paper")["gains"])
    for count in (1, 3, 4, 5, 6):
        yield f"name of {count}", paper._name(law, law.overlaps, many[:count])
    for rows in (
        [[F(1), F(2)]], [[F(1), F(2), F(3)]], [[F(2), F(1)]], [[F(1), F(1)]], [[F(0), F(1)]],
        [[F(1), F(2)], [F(3), F(2)]],
    ):  # fmt: skip
        yield f"spans {len(rows)} {rows[-1]}", said(paper._spans, rows, "here")


def of_statement(name: str) -> Named:
    data = read(name)
    law, turbine = PaperLaw.read(data["gains"]), Plant.read(data["model"])
    found = cells(name)
    spans = [cell.ends.wind for cell in found]
    wide = replace(law.overlaps, torque=2 * law.overlaps.torque)
    yield "rest", paper._rest(turbine, law, law.overlaps, found[:1])
    for what, arguments in (
        ("all", (law.overlaps, found[:1], spans, [], [])),
        ("gap", (wide, found[:1], spans[:1], [(F(7), F(8))], ["one", "two"])),
        ("none", (wide, [], [], spans, [str(k) for k in range(14)])),
    ):
        yield what, paper._statement(turbine, law, *arguments)
    unproved = [{"wind": [_number(F(a)), _number(F(b))]} for a, b in ((4, 5), (6, 9))]
    for what, winds in (("beside", [(F(10), F(11))]), ("within", [(F(3), F(7))])):
        yield f"left out, {what}", paper._left_out({"unproved": unproved}, winds, "here")


def of_whole() -> Named:
    """Yield what is said of a claim with few cells, and of one that is refused at once."""
    own = document("paper")
    claim, gains = own["claims"][0], own["gains"]
    claim["cells"], claim["winds"] = claim["cells"][4:5], [claim["cells"][4]["wind"]]
    least, top = gains["pitch_min"], gains["coupling"]["top_torque"]
    half = gains["coupling"]["torque_overlap"] / 2

    def answer(**changes: Any) -> Any:
        parts = {"claim": claim, "model": own["model"], "gains": gains, **changes}
        data = as_read(parts)
        found = said(paper.check_paper, data["claim"], data["model"], data["gains"], "here")
        return found if isinstance(found, str) else (found.verdict.name, found.name, found.text)

    yield "as recorded", answer()
    no_cell = {**claim, "cells": []}
    low = claim["winds"][0][0]
    yield "no cells", answer(claim=no_cell)
    yield "wider winds", answer(claim={**claim, "winds": [[low - 1, low + 1]]})
    yield "narrow winds", answer(claim={**claim, "winds": [[low, low + 0.001]]})
    fast = {**claim["cells"][0], "decay_rate": 9}
    yield "a cell fails", answer(claim={**claim, "cells": [fast]})
    beside = {**claim, "cells": [claim["cells"][0], fast]}
    yield "a second cell fails", answer(claim=beside)
    yield "unproved", answer(claim={**no_cell, "unproved": [{"wind": [4, 5]}]})
    yield "other overlaps", answer(claim={**no_cell, "torque_overlap": 1999})
    for change in ({"pitch_min": least - 0.1}, {"pitch_max": 1.0}):
        yield f"gains {change}", answer(gains={**gains, **change})
    for torque in (top - half, top - half + 0.5):
        changed = {**gains, "rated_torque": torque}
        yield f"rated torque {torque}", answer(gains=changed, claim=no_cell)


def of_cell_reading() -> Named:
    """Yield which cells are read: sizes, signs, and a centre at the limits of pitch."""
    claim, law = read("paper")["claims"][0], PaperLaw.read(read("paper")["gains"])
    own = claim["cells"][0]

    def answer(**changes: Any) -> Any:
        found = said(paper._Cell.read, {**own, **changes}, law, "here")
        return found if isinstance(found, str) else "read"

    rows = own["centre"]
    for at in (law.pitch_min, law.pitch_max, law.pitch_max + 1, law.pitch_min - 1):
        pitched = [[z[0], _number(at), *z[2:]] for z in rows]
        yield f"centre at pitch {at}", answer(centre=pitched)
    for k in range(3):
        for value in (0, -1):
            box = [*own["box"]]
            box[k] = _number(F(value))
            yield f"box {k} is {value}", answer(box=box)
            bound = [*own["disturbance"]]
            bound[k] = _number(F(value))
            yield f"disturbance {k} is {value}", answer(disturbance=bound)
    for name in ("decay_rate", "multiplier"):
        for value in (0, -1, 1):
            yield f"{name} is {value}", answer(**{name: _number(F(value))})
    for name, winds in (("equal", (5, 5)), ("falling", (6, 5)), ("zero", (0, 5)), ("low", (1, 5))):
        yield f"winds {name}", answer(wind=[_number(F(v)) for v in winds])
    P = own["P"]
    yield "P not symmetric", answer(P=[[P[0][0], _number(F(9)), P[0][2]], *P[1:]])
    yield "P not symmetric below", answer(P=[*P[:2], [P[2][0], _number(F(9)), P[2][2]]])
    for name, changed in (("rows", P[:2]), ("columns", [row[:2] for row in P])):
        yield f"P has two {name}", answer(P=changed)
    yield "one centre", answer(centre=rows[:1])
    yield "three centres", answer(centre=[*rows, rows[0]])
    yield "short centres", answer(centre=[z[:2] for z in rows])
    yield "no corners", answer(corners=[])
    yield "nine corners", answer(corners=[own["corners"][0]] * 9)
    yield "eight corners", answer(corners=[own["corners"][0]] * 8)


def _number(value: Fraction) -> Any:
    from takagi.certificates.checker.kernel.reader import Number

    return Number(repr(float(value)))


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "paper words": of_words,
        "paper cells read": of_cell_reading,
        "paper laws read": of_law_reading,
        "paper regions read": of_region_reading,
        "paper claim": of_whole,
        "averages": of_quotients,
    }
    for law in LAWS:
        for seeds, part in product(SEEDS, range(3)):
            found[f"{law}, {seeds}, {part}"] = lambda law=law, seeds=seeds, part=part: of_boxes(
                law, seeds, part
            )
        for name, numbers in (
            ("pieces", of_pieces), ("ramps", of_ramps), ("statement", of_statement),
        ):  # fmt: skip
            found[f"{law}, {name}"] = lambda law=law, numbers=numbers: numbers(law)
        for part in range(3):
            found[f"{law}, claim, {part}"] = lambda law=law, part=part: of_claim(law, part)
    return found
