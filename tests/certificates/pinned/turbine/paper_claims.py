"""Laws of the paper as they are read, and what is said of claims about them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.published import loop_claim as paper
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw
from takagi.certificates.checker.words.saying import in_words
from takagi.certificates.checker.words.sentences import published as words
from tests.certificates.pinned.turbine.inputs import as_read, document, read
from tests.certificates.pinned.turbine.paper_numbers import LAWS
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


def cells(name: str) -> list[paper.Cell]:
    claim, law = read(name)["claims"][0], PublishedLaw.read(read(name)["gains"])
    return [paper.Cell.read(cell, law, f"cells[{k}]") for k, cell in enumerate(claim["cells"])]


def of_claim(name: str, part: int) -> Named:
    """Yield what is said of each recorded cell, and of it with one number changed."""
    data = read(name)
    law, turbine = PublishedLaw.read(data["gains"]), Plant.read(data["model"])
    for k, cell in list(enumerate(cells(name)))[part::3]:
        yield f"field at the centre, {k}", paper._disturbance(turbine, law, law.overlaps, cell.ends)

        def failure(cell: paper.Cell) -> Any:
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
        yield f"near the trim's pitch, {k}", words._near_trim_pitch(law, cell.ends)
        for off in (F(1, 50), F(349, 10000), F(35, 1000), F(1, 20)):
            for sign in (1, -1):
                states = [[z[0], z[1] + sign * off, *z[2:]] for z in cell.ends.states]
                moved = replace(cell.ends, states=(states[0], states[1]))
                yield f"pitch {sign * off} off, {k}", words._near_trim_pitch(law, moved)


def of_words() -> Named:
    """Yield how ranges of winds are said."""
    step = F(1, 10)
    for name, starts in (
        ("run", [F(4) + k * step for k in range(6)]),
        ("two runs", [F(4), F(5), F(6), F(8), F(10), F(12)]),
        ("pairs", [F(4), F(5), F(7), F(8), F(13)]),
        ("one", [F(4)]),
    ):
        yield f"windows {name}", words._windows(starts, F(1, 16))
        yield f"spans {name}", words._shown([(low, low + F(1, 16)) for low in starts])
        uneven = [(low, low + F(k + 1, 32)) for k, low in enumerate(starts)]
        yield f"uneven {name}", words._shown(uneven)
    many = [(F(k), F(k) + F(1, 3 + k)) for k in range(1, 60)]
    even = [(low, low + F(1, 4)) for low, _ in many]
    for count in (2, 3, 4, 5, 39, 40, 41, 59):
        yield f"{count} spans", words._shown(many[:count])
        yield f"{count} even spans", words._shown(even[:count])
    law = PublishedLaw.read(read("paper")["gains"])
    for count in (1, 3, 4, 5, 6):
        yield f"name of {count}", words._name(law, law.overlaps, many[:count])
    for rows in (
        [[F(1), F(2)]], [[F(1), F(2), F(3)]], [[F(2), F(1)]], [[F(1), F(1)]], [[F(0), F(1)]],
        [[F(1), F(2)], [F(3), F(2)]],
    ):  # fmt: skip
        yield f"spans {len(rows)} {rows[-1]}", said(paper._spans, rows, "here")


def of_statement(name: str) -> Named:
    data = read(name)
    law, turbine = PublishedLaw.read(data["gains"]), Plant.read(data["model"])
    found = cells(name)
    spans = [cell.ends.wind for cell in found]
    wide = replace(law.overlaps, torque=2 * law.overlaps.torque)
    yield "rest", words._rest(turbine, law, law.overlaps, found[:1])
    for what, arguments in (
        ("all", (law.overlaps, found[:1], spans, [], [])),
        ("gap", (wide, found[:1], spans[:1], [(F(7), F(8))], ["one", "two"])),
        ("none", (wide, [], [], spans, [str(k) for k in range(14)])),
    ):
        yield what, words._statement(turbine, law, *arguments)
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
        found = said(paper.check_published, data["claim"], data["model"], data["gains"], "here")
        if isinstance(found, str):
            return found
        claimed = in_words(found)
        return claimed.verdict.name, claimed.name, claimed.text

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
    claim, law = read("paper")["claims"][0], PublishedLaw.read(read("paper")["gains"])
    own = claim["cells"][0]

    def answer(**changes: Any) -> Any:
        found = said(paper.Cell.read, {**own, **changes}, law, "here")
        return found if isinstance(found, str) else "read"

    rows = own["centre"]
    for at in (law.pitch_min, law.pitch_max, law.pitch_max + 1, law.pitch_min - 1):
        pitched = [[z[0], _number(at), *z[2:]] for z in rows]
        yield f"centre at pitch {at}", answer(centre=pitched)
    for k in (0, 1):
        one = [[*z] for z in rows]
        one[k][1] = _number(law.pitch_max + 1)
        yield f"centre {k} beyond", answer(centre=one)
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


def _read_law(gains: Any) -> Any:
    found = said(PublishedLaw.read, as_read({"gains": gains})["gains"])
    return found if isinstance(found, str) else found.overlaps


def of_law_reading() -> Named:
    """Yield which laws are read, and as what."""
    for name in LAWS:
        yield name, PublishedLaw.read(read(name)["gains"])
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
        for time in (0.5, 1) if name == LAWS[1] else ():
            yield f"{name}: tracking time {time}", _read_law({**own, "tracking_time": time})
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


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "paper words": of_words,
        "paper cells read": of_cell_reading,
        "paper laws read": of_law_reading,
        "paper regions read": of_region_reading,
        "paper claim": of_whole,
    }
    for law in LAWS:
        found[f"{law}, statement"] = lambda law=law: of_statement(law)
        for part in range(3):
            found[f"{law}, claim, {part}"] = lambda law=law, part=part: of_claim(law, part)
    return found
