"""Numbers of claims about the rates of winds and actuators."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

from takagi.certificates.checker.turbine.effort_sharing import actuator_rates, wind_rate
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range
from tests.certificates.pinned.turbine.coherent_numbers import subject
from tests.certificates.pinned.turbine.inputs import CELLS, read
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


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


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "torque steps": of_steps,
        "ranges of winds": of_ranges,
        "wind classes": of_classes,
        "ranges read": of_range_reading,
    }
    for cell in CELLS:
        found[f"actuators, {cell}"] = lambda cell=cell: of_actuators(cell)
    return found
