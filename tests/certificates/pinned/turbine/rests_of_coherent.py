"""Numbers of the balance whose zeros are rests of the effort-sharing loop, and their counts."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any
from unittest.mock import patch

from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.equilibria import effort_sharing as coherent_rest
from takagi.certificates.checker.turbine.equilibria import equilibrium_claim as equilibrium
from takagi.certificates.checker.turbine.equilibria.effort_sharing import (
    EffortSharingEquilibria,
    _Equilibrium,
    effort_sharing_equilibria,
)
from takagi.certificates.checker.turbine.equilibria.zero_count import Count, Span
from tests.certificates.pinned.turbine.inputs import CELLS
from tests.certificates.pinned.turbine.inputs import read as coherent_read
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


def coherent_loop(cell: str) -> tuple[Plant, Law, Span]:
    data = coherent_read(cell)
    law = Law.read(data["gains"])
    return Plant.read(data["model"]), law, (law.wind[0], law.wind[1])


def of_coherent(cell: str) -> Named:
    """Yield the balance of each case over rectangles, and the counts."""
    plant, law, winds = coherent_loop(cell)
    low, high = winds
    parts = ((low, high), (low, (low + high) / 2), (low, low + (high - low) / 9))
    end = plant.surface.y.breaks[-1]
    for name, own in (
        ("recorded", law),
        ("limited", replace(law, pitch_max=F(1, 100), pitch_min=F(1, 400))),
        ("far", replace(law, effort=[e + 10 for e in law.effort])),
        ("at the table's end", replace(law, effort=[e + 10 for e in law.effort], pitch_max=end)),
        (
            "about its end",
            replace(law, effort=[e + F(5, 2) for e in law.effort], pitch_max=end + 1),
        ),
        (
            "across its end",
            replace(
                law,
                effort=[end * b for b in law.effectiveness],
                pitch_max=end + 1,
            ),
        ),
        ("slow torque", replace(law, rated_torque=law.rated_torque / 8)),
    ):
        rest = _Equilibrium(plant, own, winds)
        X = own.integral_limit
        for k, part in enumerate(parts[1:] if name != "recorded" else parts):
            if name == "recorded" or k == 0:
                for s in ((-X, -X / 2), (F(0), X / 7), (X / 9, X / 9), (-X, X)):
                    yield f"{name}: inside {k} {s[0]} {s[1]}", said(rest.inside, part, s)
            for s in ((F(5), F(6)), (F(7), F(71, 10))):
                yield f"{name}: upper {k} {s[0]}", said(rest.upper, part, s)
                yield f"{name}: lower {k} {s[0]}", said(rest.lower, part, s)


def of_coherent_counts(cell: str, common: bool) -> Named:
    yield "counts", said(effort_sharing_equilibria, *coherent_loop(cell), common=common)


def of_coherent_answers() -> Named:
    """Yield the answer to each kind of counts."""
    loop = coherent_loop("torque")
    one = Count(1, 1, -1, 1, ((F(0), F(1)),))
    two = replace(one, least=2, most=2)
    many = replace(one, least=2, most=None)
    away = replace(one, least=0, most=0, start=1, end=1, blocks=())
    other = replace(away, start=-1, end=-1)
    held = replace(away, blocks=((F(1), F(2)),))
    for inside, upper, lower in product(
        (one, two, many, replace(one, start=1, end=-1), away),
        (away, other, held, replace(away, start=0), replace(away, least=1)),
        (other, away, held, replace(other, end=0), replace(other, least=1)),
    ):
        counts = EffortSharingEquilibria(inside, upper, lower)
        with patch.object(equilibrium, "effort_sharing_equilibria", lambda *_, c=counts, **__: c):
            found = said(equilibrium._effort_sharing, *loop)
        name = " ".join(str((c.least, c.most, c.start, c.end, len(c.blocks))) for c in (
            inside, upper, lower,
        ))  # fmt: skip
        yield name, found


def of_common_counts() -> Named:
    """Yield the answer where the counts differ from those that belong to every wind."""
    loop, nothing = coherent_loop("torque"), Count(0, 0, 1, 1, ())
    for least, common in product(range(4), range(4)):

        def counts(*_: Any, least: int = least, at_all: int = common, **named: Any) -> Any:
            count = Count(at_all if named.get("common") else least, None, 0, 0, ())
            return EffortSharingEquilibria(nothing, count, nothing)

        with patch.object(equilibrium, "effort_sharing_equilibria", counts):
            yield f"{least} {common}", said(equilibrium._effort_sharing, *loop)


def of_two_cells() -> Named:
    """Yield which cell of a law's table a range of winds is in."""
    plant, law, (low, high) = coherent_loop("rated")
    middle = (low + high) / 2
    columns = ("speed", "effort", "effectiveness", "limit", "gamma")
    wide: dict[str, Any] = {
        name: [*getattr(law, name), 2 * getattr(law, name)[1]] for name in columns
    }
    two = replace(law, wind=[low, middle, high], **wide)
    for name, span in (
        ("first", (low, middle)), ("second", (middle, high)), ("within", (middle, middle + 1)),
        ("start", (low, low + F(1, 99))), ("both", (low, high)), ("end", (high, high + 1)),
    ):  # fmt: skip
        yield name, said(lambda span=span: _Equilibrium(plant, two, span).k)
    for cell, span in (("first", (low, middle)), ("second", (middle, high))):
        rest = _Equilibrium(plant, two, span)
        yield f"{cell}: columns", [rest._column(getattr(two, name), span) for name in columns]
        yield f"{cell}: speed", [rest.speed(v) for v in span]


def of_table_ends() -> Named:
    """Yield whether reference speeds near the ends of the table are looked at."""
    plant, law, winds = coherent_loop("rated")
    first, last = plant.surface.x.breaks[0], plant.surface.x.breaks[-1]

    def count(f: Any, _: Span, pieces: Any, **__: Any) -> Any:
        return f.__name__, [(piece.span, sorted(piece.signs)) for piece in pieces]

    for name, least, most in (
        ("inside", first + 1, last - 1), ("at the start", first + F(1, 10**20), last - 1),
        ("after the start", first + F(2, 10**20), last - 1), ("at the end", first + 1, last),
        ("before the end", first + 1, last - F(2, 10**20)), ("beyond", first + 1, last + 1),
        ("one", F(7), F(7)), ("last cell", last - F(1, 10), last - F(1, 20)),
        ("first cell", first + F(1, 20), first + F(1, 10)),
    ):  # fmt: skip
        speed = [ratio * v / plant.radius for ratio, v in zip((least, most), winds, strict=True)]
        for common in (False, True):
            with patch.object(coherent_rest, "count_zeros", count):
                found = said(
                    effort_sharing_equilibria,
                    plant,
                    replace(law, speed=speed),
                    winds,
                    common=common,
                )
            told = found if isinstance(found, str) else (found.inside, found.upper, found.lower)
            yield f"{name} {common}", told


def of_coherent_refusals() -> Named:
    plant, law, winds = coherent_loop("rated")
    low, high = winds
    for name, span in (
        ("below", (low - 1, low)), ("above", (high, high + 1)), ("beyond", (low, high + 1)),
        ("before", (low - 1, high)), ("none", (low, low)), ("turned", (high, low)),
    ):  # fmt: skip
        yield name, said(effort_sharing_equilibria, plant, law, span)
    for name, speed in (("slow", F(1, 100)), ("fast", F(9)), ("slow end", F(1, 3))):
        speeds = [speed, law.speed[1]] if name != "slow end" else [law.speed[0], speed]
        yield name, said(effort_sharing_equilibria, plant, replace(law, speed=speeds), winds)


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "rests refused, coherent": of_coherent_refusals,
        "coherent answers": of_coherent_answers,
        "common counts": of_common_counts,
        "two cells": of_two_cells,
        "ends of the table": of_table_ends,
    }
    for cell in CELLS:
        found[f"balance, {cell}"] = lambda cell=cell: of_coherent(cell)
    for common in (False, True):
        found[f"rests, torque, {common}"] = lambda c=common: of_coherent_counts("torque", c)
    return found
