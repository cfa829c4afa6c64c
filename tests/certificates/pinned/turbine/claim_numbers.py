"""Whole answers to a loop's claims, one exact inequality, and the frozen wake."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.checker.arithmetic.interval import enclose, point
from takagi.certificates.checker.files import frozen_wake
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.turbine.effort_sharing import actuator_rates, wind_rate
from takagi.certificates.checker.turbine.effort_sharing import prerequisite as earlier
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant, Subject
from takagi.certificates.checker.turbine.published import interval_matrices as interval_family
from takagi.certificates.checker.turbine.wind_intervals import gaps, merged
from takagi.certificates.checker.words.sentences import equilibrium
from tests.certificates.pinned.turbine.corner_numbers import largest
from tests.certificates.pinned.turbine.inputs import CELLS, Document, document, read, sealed
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


Path_ = tuple[str | int, ...]


def answers(data: Document) -> Any:
    """Return what the checker says of every claim, or why it refuses."""
    found = said(check_document, sealed(data))
    if isinstance(found, str):
        return found
    return [(claim.verdict.name, claim.name, claim.text, claim.assumes) for claim in found.claims]


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


def of_loops_that_are_proved() -> Named:
    """Yield what is said where the loop's own claim is taken as proved: no filter, little fed."""
    data = read("torque")
    claims, gains = data["claims"], data["gains"]
    proved = [Claim("loop", Verdict.PROVED, ""), Claim("wind", Verdict.PROVED, "")]
    zero = Number("0")
    still = {"pitch_lead": zero, "inertia_feedforward": [zero], "wind_filter": zero}
    for name, changes in (("as recorded", {}), ("no filter", still)):
        own = {**data, "gains": {**gains, **changes}}
        found = said(wind_rate.check_wind_rate, claims[1], own, list(proved[:1]), "here")
        yield name, found if isinstance(found, str) else (found.verdict.name, sorted(found.given))
    cell = claims[2]["cells"][0]
    for name, fed, bend in (
        ("fed", gains["inertia_feedforward"][0], cell["schedule_bend"]),
        ("fed, no bend", gains["inertia_feedforward"][0], zero),
        ("little fed, no bend", Number("0.000001"), zero),
        ("not fed, no bend", zero, zero),
    ):
        own = {**data, "gains": {**gains, "inertia_feedforward": [fed]}}
        claim = {**claims[2], "cells": [{**cell, "schedule_bend": bend}]}
        found = said(actuator_rates.check_actuator_rates, claim, own, list(proved), "here")
        told = found.given.get("failures"), found.given.get("fed"), found.given.get("kept")
        yield name, (found.verdict.name, told)


def of_two_fed_cells() -> Named:
    """Yield what is said of two cells that are fed, whose winds change at different rates."""
    data = read("torque")
    loop, wind, own = data["claims"][:3]
    gains = dict(data["gains"])
    for name, column in gains.items():
        if isinstance(column, list):
            more = float(column[-1]) * 1.001 if name != "wind" else float(column[-1]) + 0.4
            gains[name] = [*column, Number(f"{more:.7f}")]
    ranges = [{**wind["ranges"][0], "wind": [Number("8.3"), Number("8.9")]}]
    for count, name in ((2, "estimate_rate"), (2, "schedule_rate")):
        ranges[0][name] = [Number("0.01"), Number("0.09")][:count]
    wide = {"pitch_rate": "9", "signal_rate": "99", "torque_rate": "1e12"}
    proved = [Claim("loop", Verdict.PROVED, ""), Claim("wind", Verdict.PROVED, "")]
    for bends in (("9", "9"), ("0.0001", "9"), ("9", "0.0001")):
        cells = [
            {name: Number(value) for name, value in (*wide.items(), ("schedule_bend", bend))}
            for bend in bends
        ]
        claim = {**own, "cells": cells, "torque_step": Number("1e12")}
        claims = [{**loop, "cells": loop["cells"] * 2}, {**wind, "ranges": ranges}, claim]
        whole = {**data, "gains": gains, "claims": claims}
        found = said(actuator_rates.check_actuator_rates, claim, whole, list(proved), "here")
        told = found.given.get("failures"), found.given.get("fed"), found.given.get("kept")
        yield f"{bends[0]} {bends[1]}", (found.verdict.name, told)


def of_earlier() -> Named:
    data = {"claims": [{"kind": "a"}, {"kind": "b"}, {"kind": "a"}]}
    outcomes = [Claim("one", Verdict.PROVED, ""), Claim("two", Verdict.UNDECIDED, "")]
    for place, kind in product((-1, 0, 1, 2, 3), ("a", "b")):
        claim = {"loop": Number(str(place))}
        given = claim, data, list(outcomes), "here", "loop", kind
        yield f"{place} {kind}", said(unproved, *given)


def unproved(*given: Any) -> bool:
    return earlier.prerequisite_claim(*given)[1] is not None


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
    # Of three states, and not alike in any of them.
    three: dict[str, Any] = {
        "P": [[F(2), F(1, 4), F(-1, 8)], [F(1, 4), F(3), F(1, 2)], [F(-1, 8), F(1, 2), F(5)]],
        "corners": [(
            [[F(-2), F(1, 5), F(0)], [F(-1, 5), F(-3), F(1, 10)], [F(1, 10), F(0), F(-4)]],
            [[F(-19, 10), F(3, 10), F(1, 10)], [F(0), F(-29, 10), F(1, 5)],
             [F(1, 4), F(1, 10), F(-39, 10)]],
        )],
        "disturbance": [F(1, 10), F(1, 5), F(1, 20)],
    }  # fmt: skip
    yield "of three states", fails(**three)
    # The worst corner of the disturbance is another one.
    signs = (1, -1, 1), (1, 1, -1), (1, -1, -1)
    for flipped in signs:
        P3 = [[a * flipped[i] * flipped[j] for j, a in enumerate(row)]
              for i, row in enumerate(three["P"])]  # fmt: skip
        bounds = three["disturbance"]

        def together(k: int, P3: Any = P3, bounds: Any = bounds) -> bool:
            more = [F(k, 10**7) * d for d in bounds]
            return not fails(**{**three, "P": P3, "disturbance": more})

        yield f"disturbance is borne, {flipped}", largest(together, 0)
    for i in range(3):

        def borne(k: int, i: int = i) -> bool:
            bounds = [*three["disturbance"]]
            bounds[i] = F(k, 10**7)
            return not fails(**{**three, "disturbance": bounds})

        yield f"disturbance {i} is borne", largest(borne, 0)
    yield "rate is borne", largest(lambda k: not fails(**three, rate=F(k + 1, 10**7)), 0)
    yield (
        "multiplier is borne",
        largest(lambda k: not fails(**three, multiplier=F(k + 1, 10**7)), 10**7),
    )
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
        "earlier claims": of_earlier,
        "two fed cells": of_two_fed_cells,
        "loops that are proved": of_loops_that_are_proved,
        "rests told": of_words,
        "interval family": of_family,
        "frozen wake": of_wake,
    }
    for cell in CELLS:
        for first in range(5 if cell == "torque" else 1):
            found[f"whole, {cell}, {first}"] = lambda c=cell, first=first: of_whole(c, first)
        found[f"read, {cell}"] = lambda cell=cell: of_reading(cell)
    return found
