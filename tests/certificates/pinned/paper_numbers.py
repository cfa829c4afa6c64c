"""Numbers of the loop with a law of the paper: its brackets over boxes, and its claim."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.turbine import paper
from takagi.certificates.checker.turbine.coherent_inputs import Plant
from takagi.certificates.checker.turbine.paper_inputs import PaperLaw, Region
from takagi.certificates.checker.turbine.paper_loop import Ends, Loop, interpolated
from tests.certificates.pinned.inputs import Document, as_read, document
from tests.certificates.pinned.values import Named, said

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
            Ends((F(v1), F(v2)), ends.states, ends.widths), "states" if v1 != v2 else "none",
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


# ------------------------------------------------------------------ the claim


def cells(name: str) -> list[paper._Cell]:
    claim, law = read(name)["claims"][0], PaperLaw.read(read(name)["gains"])
    return [paper._Cell.read(cell, law, f"cells[{k}]") for k, cell in enumerate(claim["cells"])]


def of_claim(name: str) -> Named:
    """Yield what is said of each recorded cell, and of it with one number changed."""
    data = read(name)
    law, turbine = PaperLaw.read(data["gains"]), Plant.read(data["model"])
    for k, cell in enumerate(cells(name)):
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
    for count in (2, 3, 4, 5, 39, 40, 41, 59):
        yield f"{count} spans", paper._shown(many[:count])
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
    for name, winds in (("equal", (5, 5)), ("falling", (6, 5)), ("zero", (0, 5))):
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
    found: dict[str, Any] = {"paper words": of_words, "paper cells read": of_cell_reading}
    for law in LAWS:
        for seeds, part in product(SEEDS, range(3)):
            found[f"{law}, {seeds}, {part}"] = lambda law=law, seeds=seeds, part=part: of_boxes(
                law, seeds, part
            )
        for name, numbers in (
            ("pieces", of_pieces), ("claim", of_claim), ("statement", of_statement),
        ):  # fmt: skip
            found[f"{law}, {name}"] = lambda law=law, numbers=numbers: numbers(law)
    return found
