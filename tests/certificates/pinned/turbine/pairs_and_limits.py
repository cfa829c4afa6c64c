"""What has to be of one length, and numbers that are exactly at a limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import UNIT, ZERO
from takagi.certificates.checker.files import frozen_wake
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.turbine.effort_sharing import actuator_rates, wind_rate
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.equilibria import zero_count as rest_count
from takagi.certificates.checker.turbine.published import interval_matrices as interval_family
from takagi.certificates.checker.turbine.published import loop as paper_loop
from takagi.certificates.checker.turbine.published import loop_claim as paper
from takagi.certificates.checker.turbine.published.loop import Ends
from tests.certificates.pinned.turbine.coherent_numbers import other, stated, subject
from tests.certificates.pinned.turbine.inputs import read
from tests.certificates.pinned.turbine.paper_numbers import boxes, law_of, plant
from tests.certificates.pinned.turbine.values import Named
from tests.certificates.pinned.turbine.wind_rate_numbers import a_range

F = Fraction


def refused(work: Callable[..., Any], *given: Any) -> str:
    """Return whether a call refuses lengths that differ."""
    try:
        work(*given)
    except ValueError:
        return "refused"
    return "taken"


def of_lengths() -> Named:
    """Yield that rows of other lengths are never paired."""
    law = subject("torque").law
    yield (
        "steps",
        refused(actuator_rates.torque_step, replace(law, inertia=[F(1), F(2)]), [F(1), F(2)]),
    )
    whole = [[6, 1], [1, 5]]
    short_rows, short_row = [[1, 2]], [[1, 2], [3]]
    for name, low, high in (
        ("rows", whole, short_rows), ("row", whole, short_row), ("first rows", short_rows, whole),
    ):  # fmt: skip
        yield f"spare, {name}", refused(interval_family._spare, whole, 1, low, high)
        yield f"minus, {name}", refused(interval_family._minus, low, high, F(1), 1)
    yield "invariant", refused(interval_family._invariant, whole, whole, 1, 10**7, [1, 2, 3], F(1))
    entries, bounds = [[UNIT, ZERO], [ZERO, UNIT]], [[F(-2)] * 2, [F(-2)] * 2]
    tops = [[F(2)] * 2, [F(2)] * 2]
    for name, rows, lows, highs in (
        ("rows", entries[:1], bounds, tops), ("row", [[UNIT], [UNIT]], bounds, tops),
        ("high", entries, bounds, tops[:1]), ("high row", entries, bounds, [[F(2)], [F(2)]]),
    ):  # fmt: skip
        yield f"holds, {name}", refused(paper._holds, rows, lows, highs)
    parts = [Dual(UNIT, (UNIT, ZERO)), Dual(UNIT, (UNIT,))]
    yield "joined", refused(paper_loop._joined, UNIT, parts)
    yield "corners", refused(paper_loop._corner_range, {(0, 1): F(1)}, [UNIT])
    law_ = law_of("paper")
    ends = dict(boxes(law_))["slow"]
    for name, wrong in (
        ("widths", replace(ends, widths=ends.widths[:2])),
        ("states", replace(ends, states=(ends.states[0], ends.states[1][:2]))),
    ):
        yield f"box, {name}", refused(_loop, wrong)
    yield "column", refused(a_range().largest, [F(1)], F(8), F(9))
    three = Dual(ZERO, (UNIT, UNIT, UNIT))
    span = (F(0), F(1))
    yield "slopes", refused(rest_count._sign, lambda *_: three, span, span, three)
    model = read("torque")["model"]
    surface = Plant.read(model).surface
    for winds, factors in (([F(12)], [F(1), F(1)]), ([F(12), F(13)], [F(1)])):
        yield (
            f"wake {len(winds)} {len(factors)}",
            refused(
                frozen_wake.scaled_slopes,
                model,
                F("43093.55"),
                surface,
                (winds, factors),
                Path("t"),
            ),
        )


def _loop(ends: Ends) -> Any:
    law = law_of("paper")
    return paper_loop.Loop(plant(), law, law.overlaps, ends, "states")


def of_limits() -> Named:
    """Yield what is said exactly at a limit: it is kept."""
    about, rate = subject("rated"), stated("rated").sizes["wind_rate"]
    at = Loop(about, 0, rate)
    for name, limit in (
        ("pitch asked for", at.largest_pitch()),
        ("pitch reached", F(at.reached.high, 10**36)),
        ("both", max(at.largest_pitch(), F(at.reached.high, 10**36))),
    ):
        yield name, Loop(other(about, "law", pitch_max=limit), 0, rate).limits_failure()
    law = about.law
    least = law.rated_torque - at.least_torque()
    exact = other(about, "law", rated_torque=least)
    yield "no torque", (Loop(exact, 0, rate).least_torque(), Loop(exact, 0, rate).limits_failure())
    one = a_range()
    wide = replace(law, wind=[F(8), F(12)])
    number = Number
    for rate_, error in (("0.15", "1"), ("1", "0.3"), ("0.1499999", "1"), ("1", "0.2999999")):
        cell = [{"wind_rate": number(rate_), "wind_error": number(error)}]
        found = wind_rate._outside_class(replace(one, error=F(3, 20)), wide, cell, F(1))
        yield f"class {rate_} {error}", found
    data = read("torque")
    loop, wind, own = data["claims"][:3]
    flat, winds = [Number("0.09")] * 2, [Number("8.3"), Number("8.6")]
    ranges = [{**wind["ranges"][0], "wind": winds, "estimate_rate": flat, "schedule_rate": flat}]
    proved = [Claim("loop", Verdict.PROVED, ""), Claim("wind", Verdict.PROVED, "")]
    for bend in ("0.036", "0.0359999", "0.0360001"):
        wide_cell = {"pitch_rate": "9", "signal_rate": "99", "torque_rate": "1e12"}
        cell_ = {name: Number(value) for name, value in wide_cell.items()}
        claim = {**own, "cells": [{**cell_, "schedule_bend": Number(bend)}]}
        claim["torque_step"] = Number("1e12")
        claims = [loop, {**wind, "ranges": ranges}, claim]
        whole = {**data, "claims": claims}
        said_of = actuator_rates.check_actuator_rates(claim, whole, list(proved), "here")
        yield f"bend {bend}", said_of.verdict.name


def groups() -> dict[str, Any]:
    """Return the groups of answers by name."""
    return {"lengths": of_lengths, "limits": of_limits}
