"""Numbers of claims that rest on the coherent loop's, of one exact inequality, and of the wake."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

from takagi.certificates.checker.arithmetic.interval import enclose, point
from takagi.certificates.checker.kernel.certificate import check_document
from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.turbine import (
    actuator_rates,
    earlier,
    equilibrium,
    frozen_wake,
    interval_family,
    wind_rate,
)
from takagi.certificates.checker.turbine.coherent_inputs import Law, Plant, Subject
from takagi.certificates.checker.turbine.spans import gaps, merged
from takagi.certificates.checker.turbine.wind_rate import Range
from tests.certificates.pinned.turbine.coherent_numbers import read, subject
from tests.certificates.pinned.turbine.inputs import CELLS, Document, document, sealed
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction
Path_ = tuple[str | int, ...]


def answers(data: Document) -> Any:
    """Return what the checker says of every claim, or why it refuses."""
    found = said(check_document, sealed(data))
    if isinstance(found, str):
        return found
    return [(claim.verdict.name, claim.name, claim.text, claim.assumes) for claim in found.claims]


# ------------------------------------------------------------------ rates of actuators


def of_actuators(cell: str) -> Named:
    """Yield what a cell's numbers bound, and on which side of a bound a stated one is."""
    about, claims = subject(cell), read(cell)["claims"]
    own = next(c for c in claims if c["kind"] == "actuator-rates")
    for name, gains in (
        ("recorded", about.law),
        ("fed", replace(about.law, inertia=[F(-1, 7)], inertia_limit=[F(1, 90)])),
        ("not fed", replace(about.law, inertia=[F(1, 7)], inertia_limit=[F(0)])),
        ("leading", replace(about.law, lead=about.plant.lag)),
    ):
        (bound,) = actuator_rates.cell_rates(replace(about, law=gains), claims[0], "here")
        yield f"{name}: pitch", bound.pitch
        yield f"{name}: corners", bound.corners
        yield f"{name}: the rest", (bound.gain, bound.drift, bound.torque_share, bound.fed)
        yield f"{name}: torque", bound.torque_rate(F(1, 5), F(3, 7))
    (bound,) = actuator_rates.cell_rates(about, claims[0], "here")
    P = [[F(entry) for entry in row] for row in claims[0]["P"]]
    stated = own["cells"][0]
    yield "as recorded", actuator_rates._failure(stated, bound, P, "here")
    for name in ("pitch_rate", "signal_rate", "schedule_bend", "torque_rate"):
        for value in ("0", "-1", str(round(float(stated[name]) * 0.99, 7)), "1000000"):
            changed = {**stated, name: type(stated[name])(value)}
            yield f"{name} {value}", actuator_rates._failure(changed, bound, P, "here")


def of_steps() -> Named:
    law = subject("torque").law
    for f, g, rates in (
        ((F(1, 5), F(0)), (F(1, 90), F(0)), (F(1, 10), F(1, 10))),
        ((F(1, 5), F(-1, 9)), (F(1, 90), F(1, 70)), (F(1, 10), F(1, 20))),
        ((F(1, 5), F(1, 5)), (F(1, 90), F(1, 90)), (F(1, 10), F(1, 20))),
        ((F(0), F(1, 3), F(2, 3)), (F(1, 9), F(1, 80), F(1, 7)), (F(1, 90), F(1, 80), F(1, 100))),
        ((F(0), F(0)), (F(0), F(1)), (F(1), F(1))),
        ((F(3), F(-3)), (F(1, 2), F(1, 4)), (F(1), F(1, 7))),
    ):
        own = replace(law, inertia=list(f), inertia_limit=list(g))
        yield f"{f} {g}", actuator_rates.torque_step(own, list(rates))
    for value, limit in product((-3, -1, 0, 1, 3), (0, 1, 2)):
        yield f"held {value} {limit}", actuator_rates._held(F(value), F(limit))


# ------------------------------------------------------------------ rates of the wind


def a_range() -> Range:
    wind = [F(8), F(9), F(19, 2), F(12)]
    estimate = [F(1, 5), F(1, 4), F(3, 10), F(1, 10)]
    return Range(wind, estimate, [F(1, 10), F(3, 20), F(1, 20), F(1, 8)], F(1, 9))


def of_ranges() -> Named:
    one = a_range()
    for s in (F(7), F(8), F(17, 2), F(9), F(37, 4), F(19, 2), F(10), F(12), F(13)):
        yield f"at {s}", (one.at(one.estimate, s), one.at(one.schedule, s))
    ends = (F(7), F(8), F(9), F(28, 3), F(12), F(14))
    for low, high in product(ends, ends):
        if low <= high:
            yield f"largest {low} {high}", one.largest(one.schedule, low, high)
            yield f"bend {low} {high}", [one.bend(low, high, F(k, 10)) for k in (1, 50)]
    for filter_ in (F(1, 1000), F(1, 10), F(1, 2), F(1), F(5)):
        for share in (F(0), F(1, 20), F(1, 8), F(1, 2), F(9, 10), F(1)):
            slower = replace(one, estimate=[share * r for r in one.estimate])
            yield f"left behind {filter_} {share}", wind_rate.left_behind(slower, filter_)
        for i, sign in product(range(3), (1, -1)):
            yield f"bends {filter_} {i} {sign}", list(wind_rate._bends(one, i, sign * filter_))
    for falling in ([F(3, 10), F(1, 10), F(1, 50), F(1, 90)], [F(1, 90), F(1, 50), F(1, 4), F(9)]):
        moved = replace(one, schedule=falling)
        yield (
            f"left behind {falling[0]}",
            [
                wind_rate.left_behind(replace(moved, estimate=[F(1, k)] * 4), F(1))
                for k in (3, 9, 99)
            ],
        )


def of_classes() -> Named:
    """Yield where a range leaves the wind class of the loop's cells."""
    one, law = a_range(), subject("torque").law
    number = type(read("torque")["claims"][0]["P"][0][0])
    for name, nodes in (
        ("same", [F(8), F(10), F(12)]), ("wider", [F(7), F(9), F(13)]),
        ("narrower", [F(8), F(9), F(11)]), ("above", [F(17, 2), F(12)]),
        ("many", [F(6), F(7), F(8), F(9), F(12), F(13)]),
    ):  # fmt: skip
        own = replace(law, wind=nodes)
        for rate, error, filter_ in (
            ("0.2", "9", F(1)), ("0.15", "9", F(1)), ("0.1499", "9", F(1)), ("0.125", "9", F(1)),
            ("1", "0.27", F(1)), ("1", "0.26", F(1)), ("1", "0.23", F(1)), ("1", "0.4", F(2)),
        ):  # fmt: skip
            cell = {"wind_rate": number(rate), "wind_error": number(error)}
            cells = [cell] * (len(nodes) - 1)
            found = wind_rate._outside_class(one, own, cells, filter_)
            yield f"{name} {rate} {error} {filter_}", found
        last = [*cells[:-1], {"wind_rate": number("0.1"), "wind_error": number("9")}]
        yield f"{name}, last", wind_rate._outside_class(one, own, last, F(1))
        first = [{"wind_rate": number("0.1"), "wind_error": number("9")}, *cells[1:]]
        yield f"{name}, first", wind_rate._outside_class(one, own, first, F(1))


def of_range_reading() -> Named:
    from takagi.certificates.checker.kernel.reader import Number

    def row(*values: str) -> list[Number]:
        return [Number(value) for value in values]

    own = {
        "wind": row("8", "9"),
        "estimate_rate": row("0.1", "0.2"),
        "schedule_rate": row("0.1", "0.3"),
        "estimate_error": Number("0.5"),
    }
    for name, changes in (
        ("itself", {}),
        ("falling", {"wind": row("9", "8")}),
        ("equal", {"wind": row("9", "9")}),
        ("one wind", {name: row("1") for name in ("wind", "estimate_rate", "schedule_rate")}),
        ("short", {"estimate_rate": row("1")}),
        ("long", {"schedule_rate": row("1", "2", "3")}),
        ("negative error", {"estimate_error": Number("-0.1")}),
        ("negative estimate", {"estimate_rate": row("0.1", "-0.1")}),
        ("negative schedule", {"schedule_rate": row("-0.1", "0.1")}),
        ("zeros", {"estimate_rate": row("0", "0"), "schedule_rate": row("0", "0"),
                   "estimate_error": Number("0")}),
    ):  # fmt: skip
        yield name, said(Range.read, {**own, **changes}, "here")
    for count in (0, 1, 20, 21):
        yield f"{count} ranges", said(wind_rate.read_ranges, {"ranges": [own] * count}, "here")


# ------------------------------------------------------------------ whole claims


CHANGES: tuple[tuple[str, Path_, Any], ...] = (
    ("as recorded", ("model", "kind"), "turbine"),
    ("loop unproved", ("claims", 0, "cells", 0, "decay_rate"), 9),
    ("wind rate unproved", ("claims", 1, "ranges", 0, "estimate_error"), 9),
    ("estimate faster", ("claims", 1, "ranges", 0, "estimate_rate"), None),
    ("no filter", ("gains",), {"wind_filter": 0}),
    (
        "no filter, nothing fed",
        ("gains",),
        {
            "wind_filter": 0,
            "pitch_lead": 0,
            "inertia_feedforward": [0],
        },
    ),
    ("torque step", ("claims", 2, "torque_step"), -1e-9),
    ("schedule bend", ("claims", 2, "cells", 0, "schedule_bend"), 0),
    ("pitch rate", ("claims", 2, "cells", 0, "pitch_rate"), 0.001),
    ("later claim", ("claims", 1, "loop"), 1),
    ("no claim", ("claims", 1, "loop"), -1),
    ("another kind", ("claims", 2, "loop"), 1),
    ("another wind rate", ("claims", 2, "wind_rate"), 0),
    ("rests", ("claims", 3, "cells", 0, "rests"), "several"),
)


def of_whole(cell: str, first: int = 0) -> Named:
    """Yield every answer to a certificate of the loop and the claims that rest on it."""
    for name, path, value in CHANGES[first::5] if cell == "torque" else CHANGES[:1]:
        kinds = ("coherent-loop", "wind-rate", "actuator-rates")
        data = document(cell, *kinds, *(["equilibrium"] if name == "rests" else []))
        holder: Any = data
        for step in path[:-1]:
            holder = holder[step]
        own = holder[path[-1]]
        if isinstance(value, dict):
            own |= value
        else:
            holder[path[-1]] = [9 * entry for entry in own] if value is None else value
        yield name, answers(data)


def of_earlier() -> Named:
    data = {"claims": [{"kind": "a"}, {"kind": "b"}, {"kind": "a"}]}
    from takagi.certificates.checker.kernel.reader import Number

    outcomes = [Claim("one", Verdict.PROVED, ""), Claim("two", Verdict.UNDECIDED, "")]
    for place, kind in product((-1, 0, 1, 2, 3), ("a", "b")):
        claim = {"loop": Number(str(place))}
        given = claim, data, list(outcomes), "here", "loop", kind
        yield f"{place} {kind}", said(unproved, *given)


def unproved(*given: Any) -> bool:
    return earlier.earlier_claim(*given)[1] is not None


def of_words() -> Named:
    """Yield how rests are told, and ranges of winds."""
    spans = [(F(3) + F(k, 3), F(3) + F(k + 1, 3)) for k in range(0, 60, 2)]
    for count in (1, 11, 12, 13, 30):
        yield f"{count} spans", equilibrium._shown(spans[:count])
    known = (F(3), F(25))
    for name, proved in (
        ("all", [(known, "one")]),
        ("parts", [((F(3), F(4)), "one"), ((F(4), F(6)), "one"), ((F(9), F(25)), "none")]),
        ("none", []),
    ):
        yield name, equilibrium._parts(proved, known)
    rows = ((1, 2), (2, 3), (5, 6), (4, 7), (9, 9), (8, 10), (0, 1))
    lists = [[(F(a), F(b)) for a, b in rows[:count]] for count in range(8)]
    for found in lists:
        yield f"merged {len(found)}", merged(found)
        for span in ((F(0), F(12)), (F(2), F(5)), (F(3), F(4)), (F(11), F(13)), (F(5), F(6))):
            yield f"gaps {len(found)} {span[0]}", gaps(span, merged(found))


# ------------------------------------------------------------------ one exact inequality


def of_family() -> Named:
    """Yield the integers of the inequality for an interval family, and its thresholds."""
    P = [[F(3), F(1, 2)], [F(1, 2), F(5, 2)]]
    low = [[F(-2), F(1, 10)], [F(-1, 5), F(-3)]]
    high = [[F(-19, 10), F(3, 10)], [F(1, 10), F(-5, 2)]]
    whole, scale = [[6, 1], [1, 5]], 2
    least, most = ([[int(a * 10**7) for a in row] for row in rows] for rows in (low, high))
    spare, factor = interval_family._spare(whole, scale, least, most)
    yield "spare", (spare, factor)
    yield "minus", interval_family._minus(spare, whole, F(3, 7), factor // scale)
    for alpha, delta in product((F(1, 100), F(1, 2), F(3)), ([0, 0], [10**6, 10**6], [10**7, 0])):
        held = interval_family._invariant(spare, whole, scale, factor, delta, alpha)
        yield f"invariant {alpha} {delta}", held

    def fails(**changes: Any) -> Any:
        own = {"P": P, "corners": [(low, high)], "disturbance": [F(1, 10), F(1, 10)],
               "rate": F(1), "multiplier": F(1)}  # fmt: skip
        return said(interval_family.contraction_failure, **{**own, **changes}, where="here")

    yield "itself", fails()
    for k in range(0, 40, 2):
        yield f"rate {k}", fails(rate=F(k, 20))
        yield f"multiplier {k}", fails(multiplier=F(k + 1, 8))
        yield f"disturbance {k}", fails(disturbance=[F(k, 10), F(k, 20)])
        yield f"P {k}", fails(P=[[F(k + 1, 8) * entry for entry in row] for row in P])
    wide = [[a + F(9, 10) for a in row] for row in high]
    yield "wide", fails(corners=[(low, wide)])
    yield "two corners", fails(corners=[(low, high), (low, wide)])
    yield "turned", fails(corners=[(high, low)])
    yield "eight places", fails(disturbance=[F(1, 10**8), F(0)])
    yield "eight places of A", fails(corners=[(low, [[F(1, 10**8)] * 2] * 2)])
    for value in (F(1, 10**7), F(1, 10**8), F(-3, 2)):
        yield f"over the unit {value}", said(interval_family._over_unit, value, "here")


# ------------------------------------------------------------------ the frozen wake


def of_wake() -> Named:
    """Yield the largest pitch that balances rated torque, and the slope there."""
    model, place = read("torque")["model"], Path("turbine.toml")
    spline, torque = Plant.read(model).surface, F("43093.55")
    for wind, factor in ((F(12), F(1)), (F(18), F(3, 4)), (F(25), F(2))):
        stated = [wind], [factor]
        yield (
            f"slope at {wind}",
            said(frozen_wake.scaled_slopes, model, torque, spline, stated, place),
        )
    for wind, factor in ((F(8), F(1)), (F(60), F(1)), (F(2), F(1)), (F(0), F(1))):
        yield (
            f"no slope at {wind}",
            said(frozen_wake.scaled_slopes, model, torque, spline, ([wind], [factor]), place),
        )
    ratio = point(F(6))
    for needed in (F(1, 100), F(1, 20), F(-1), F(1)):
        for low, high in ((F(0), F(1, 4)), (F(1, 10), F(1, 2)), (F(0), F(1, 1000))):
            yield (
                f"root {needed} {low} {high}",
                said(frozen_wake._largest_root, spline, ratio, needed, low, high),
            )
            pitch = enclose(low, high)
            yield f"below {needed} {low} {high}", frozen_wake._below(spline, ratio, pitch, needed)


# ------------------------------------------------------------------ reading


def of_reading(cell: str) -> Named:
    """Yield plant, law, box and uncertainty as they are read."""
    data = read(cell)
    plant = Plant.read(data["model"])
    yield "plant", [getattr(plant, name) for name in (
        "torque_per_inertia", "gear_per_inertia", "radius", "lag", "rate_limit", "rated_speed",
        "pitch_min", "pitch_max",
    )]  # fmt: skip
    law = Law.read(data["gains"])
    yield "law", law
    yield "slopes", [law.slope(column, 0) for column in (law.speed, law.effort, law.gamma)]
    about = Subject.read(data["claims"][0], data["model"], data["gains"], "here")
    yield "box", (about.box, about.uncertainty, about.uncertainty.kappa)


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "torque steps": of_steps,
        "ranges of winds": of_ranges,
        "wind classes": of_classes,
        "ranges read": of_range_reading,
        "earlier claims": of_earlier,
        "rests told": of_words,
        "interval family": of_family,
        "frozen wake": of_wake,
    }
    for cell in CELLS:
        found[f"actuators, {cell}"] = lambda cell=cell: of_actuators(cell)
        for first in range(5 if cell == "torque" else 1):
            found[f"whole, {cell}, {first}"] = lambda c=cell, first=first: of_whole(c, first)
        found[f"read, {cell}"] = lambda cell=cell: of_reading(cell)
    return found
