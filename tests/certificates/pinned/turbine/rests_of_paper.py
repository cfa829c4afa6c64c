"""Where a law of the paper may rest: what both have in common, and what is made of counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any
from unittest.mock import patch

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import (
    UNIT,
    ZERO,
    enclose,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.equilibria.one_integrator import OneIntegrator
from takagi.certificates.checker.turbine.equilibria.published import bends, published_equilibria
from takagi.certificates.checker.turbine.equilibria.published_balance import RestPlace
from takagi.certificates.checker.turbine.equilibria.two_integrators import TwoIntegrators
from takagi.certificates.checker.turbine.equilibria.zero_count import Count
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw
from tests.certificates.pinned.turbine.inputs import read
from tests.certificates.pinned.turbine.paper_numbers import LAWS
from tests.certificates.pinned.turbine.values import Named, said

F = Fraction


# Where the ramp in speed begins [rad/s]: so that pitch acts alone, and so that it hardly acts.
FULL, LATE = F(115, 100), F(127, 100)


SPAN = F(0), F(1)


@cache
def paper_turbine() -> Plant:
    return Plant.read(read("paper")["model"])


def paper_law(name: str, start: Fraction | None = None) -> PublishedLaw:
    """Return the recorded law, its ramp in speed begun elsewhere."""
    law = PublishedLaw.read(read(name)["gains"])
    if start is None:
        return law
    return replace(law, overlaps=replace(law.overlaps, start=start))


WINDS = {
    "slow": (F(6), F(301, 50)),
    "below": (F(109, 10), F(1093, 100)),
    "rated": (F(113, 10), F(1131, 100)),
    "above": (F(117, 10), F(1171, 100)),
    "fast": (F(20), F(1001, 50)),
}


def of_balance(name: str) -> Named:
    """Yield reference, coupling factor and places, which both laws share."""
    kind = OneIntegrator if name == "paper" else TwoIntegrators
    for smooth in (True, False):
        rest = kind(paper_turbine(), replace(paper_law(name), smooth=smooth))
        over = rest.law.overlaps
        for k in range(-1, 6):
            yield f"{smooth}: share {k}", rest.share(over.start + F(k, 4) * over.width)
        steps = (F(-1, 4), F(0), F(2, 5), F(1, 2), F(3, 5), F(1), F(5, 4))
        for a, b in product(steps, steps):
            if a <= b:
                span = over.start + a * over.width, over.start + b * over.width
                speed = Dual(enclose(*span), (UNIT, ZERO))
                yield f"{smooth}: share of {a} {b}", rest.share_of(speed, span)
    for where, place in (("slow", F(9, 10)), ("fast", F(3, 2))):
        winds = WINDS[where]
        region = rest.law.partial if where == "slow" else rest.law.full
        last = region.wind[-1]
        for low, high in (winds, (last - F(1, 9), last), (last, last + 1)):
            speeds = (place, place + F(1, 50), F(1, 90))
            wide = Dual(enclose(place - 1, place + 1), (UNIT, ZERO))
            at = RestPlace(rest, (low, high), speeds, wide, wide, wide)
            for own, of_state, of_trim in product((None, region), (True, False), (True, False)):
                if of_state or (of_trim and own is not None):
                    name = f"{where} {float(low):.4g}: ratio {own is None} {of_state} {of_trim}"
                    yield name, said(at._ratio, own, of_state, of_trim)
        far = RestPlace(rest, winds, (F(5), F(6), F(1, 9)), wide, wide, wide)
        yield (
            f"{where}: ratio beyond the table",
            [said(far._ratio, own, True, False) for own in (None, region)],
        )
    yield "ends", (rest.top, rest.longest, rest.shortest, rest.passing)
    for wind in (F(1), F(2), F(3), F(4), F(5), F(6), F(8), F(11), F(12), F(20)):
        yield f"reference {wind}", rest.reference(wind)
    for where, winds in WINDS.items():
        yield f"{where}: range", rest.reference_range(winds)
        yield f"{where}: speed", (rest.speed(winds), rest.speed((winds[0],) * 2))
        for pitch in ((F(0), F(1, 100)), (F(1, 5), F(2, 5))):
            at = rest.place(winds, Dual(enclose(*pitch), (ZERO, UNIT)))
            yield f"{where}: rotor at {pitch[0]}", said(getattr, at, "rotor")
            gains = [said(at.gain, f, k) for f in (0, 1) for k in range(3)]
            yield f"{where}: gains at {pitch[0]}", gains
            u = Dual(enclose(F(40000), F(44000)), (ZERO, UNIT))
            yield f"{where}: passed at {pitch[0]}", at.passed(u)
    bent = kind(rest.plant, replace(rest.law, largest_ratio=F(9)))
    for wind in (F(3), F(4), F(5), F(6), F(7)):
        yield f"bent reference {wind}", bent.reference(wind)
    yield "bends", bends(rest.plant, rest.law)


def of_refusals() -> Named:
    """Yield what is refused of winds, limits and tables."""
    for name in LAWS:
        law, plant = paper_law(name), paper_turbine()
        end = plant.surface.y.breaks[-1]
        bend = sorted(bends(plant, law))[1]
        for what, own, winds in (
            ("before cut-in", law, (law.cut_in - 1, law.cut_in)),
            ("after cut-out", law, (law.cut_out, law.cut_out + 1)),
            ("turned", law, (F(9), F(8))),
            ("a point", law, (F(9), F(9))),
            ("negative pitch", replace(law, pitch_min=F(-1, 9)), WINDS["slow"]),
            ("pitch within the table", replace(law, pitch_max=end / 2), WINDS["slow"]),
            ("over all bends", law, (law.cut_in, law.cut_out)),
            ("over a bend", law, (bend - F(1, 100), bend + F(1, 100))),
        ):
            yield f"{name}: {what}", said(published_equilibria, plant, own, winds)


def of_paper_answers() -> Named:
    """Yield what is made of the counts of both laws, and of a coupling factor that reaches 1."""
    plant = paper_turbine()
    one, two = Count(1, 1, 1, -1, ()), Count(2, 2, 1, -1, ())
    for count, trim in product((one, two), (True, None)):
        with (
            patch.object(OneIntegrator, "count", lambda *_, c=count: c),
            patch.object(OneIntegrator, "at_trim", lambda *_, t=trim: t),
        ):
            name = f"one integrator, {count.least} {trim}"
            yield name, said(published_equilibria, plant, paper_law("paper"), WINDS["slow"])
    bend = sorted(bends(plant, paper_law("paper")))[1]
    for shares, sign in product((0, F(1, 2), 1), (-1, 0, 1)):
        for other in (shares, F(1, 3)):
            calls = [shares, other]
            with (
                patch.object(TwoIntegrators, "share", lambda *_, c=calls: c.pop(0)),
                patch.object(TwoIntegrators, "count", lambda *_: one),
                patch.object(TwoIntegrators, "passes", lambda *_, s=sign: s),
                patch.object(TwoIntegrators, "continuum", lambda *_, s=sign: SPAN if s else None),
            ):  # fmt: skip
                winds = (bend - F(1, 100), bend)
                found = said(published_equilibria, plant, paper_law("paper-two-integrators"), winds)
            yield f"two integrators, {shares} {other} {sign}", found
    law = paper_law("paper")
    with patch.object(OneIntegrator, "count", lambda *_: two):
        for low, high in ((bend - 1, bend), (bend, bend + 1), (law.cut_in, law.cut_in + 1),
                          (law.cut_out - 1, law.cut_out)):  # fmt: skip
            yield (
                f"up to a bend {float(low - bend):.3g}",
                said(published_equilibria, plant, law, (low, high)),
            )
        end = plant.surface.y.breaks[-1]
        for pitch in (end, end + F(1, 10**9)):
            own = replace(law, pitch_max=pitch)
            yield (
                f"pitch to the end {pitch > end}",
                said(published_equilibria, plant, own, WINDS["slow"]),
            )
        own = replace(law, pitch_min=F(0))
        yield "pitch from zero", said(published_equilibria, plant, own, WINDS["slow"])


# Where the ramp in speed begins, None for its own start, and winds.
Case = tuple[Fraction | None, str]


def ramps(
    named: dict[str, tuple[Callable[[Fraction | None, str], Named], Sequence[Case]]],
) -> dict[str, Any]:
    """Return groups of numbers for ramps in speed that begin at one place or another."""
    found: dict[str, Any] = {}
    for what, (numbers, cases) in named.items():
        for start, where in cases:
            tag = f"{where}, ramp from {'its start' if start is None else float(start)}"
            found[f"{what}, {tag}"] = lambda n=numbers, s=start, w=where: n(s, w)
    return found


def groups() -> dict[str, Any]:
    """Return the groups of numbers by name."""
    found: dict[str, Any] = {
        "rests refused, paper": of_refusals,
        "paper answers": of_paper_answers,
    }
    for name in LAWS:
        found[f"balance, {name}"] = lambda name=name: of_balance(name)
    return found
