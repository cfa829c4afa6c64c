r"""``schedule-rate``: in moving wind the loop keeps a set around the trim at the schedule wind.

P(v_s) is linear between the schedule winds at which it is stated.  In a cell [a, b], for P and tau
at a and b and for v_s' = -s and s, s = estimate / tau_f, the form of ``scheduled_rates`` is
positive definite with D = v_s' (P(b) - P(a)) / (b - a) and the weights 2 alpha (1 - k) / r^2 of v'
and 2 alpha k of the residual; and bound^2 P - h'h is for every row of the box.  Then
V' <= 2 alpha (1 - V) while |v'| <= r.  At the first and the last schedule wind of cells without a
gap the set must end before the range of the wind does.  The theorem is in docs/schedule-rate.md.
"""

from __future__ import annotations

from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import scaled, transposed
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
)
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.running.machine import Machine, box, same_controller
from takagi.certificates.cross_check.turbine.running.moving_form import functions_by_wind
from takagi.certificates.cross_check.turbine.running.running_loop import MOST_CELLS
from takagi.certificates.cross_check.turbine.running.shortened import shortened
from takagi.certificates.cross_check.turbine.scheduled.scheduled_cell import ScheduledCell
from takagi.certificates.cross_check.turbine.scheduled.scheduled_rates import (
    NAMES,
    ScheduledRates,
)
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

SIDES = (
    *("speed", "measured", "pitch", "signal", "wind", "estimate"),
    *("measured_rate", "innovation", "drive"),
)


def scheduled_loop(claim: Any, document: Any) -> Obligations:
    """Yield the conditions of the module's text."""
    model, gains = entry(document, "model"), entry(document, "gains")
    rotor, machine = Rotor(model, gains), Machine(claim, model, gains)
    if not same_controller(claim, document):
        raise Refusal("observer or filters are not the controller's")
    cells, functions = entry(claim, "cells"), functions_by_wind(claim, machine.states)
    if not isinstance(cells, list) or len(cells) not in range(1, MOST_CELLS + 1):
        raise Refusal(f"cells: 1 to {MOST_CELLS} are needed")
    stated = [rational(one, "wind") for one in claim["functions"]]
    runs: list[list[Any]] = []
    last = None
    for cell in cells:
        low, high = rationals(cell, "wind", 2)
        if low >= high or (last is not None and low < last):
            raise Refusal("cells: winds that increase, and cells in order, are needed")
        if any(low < wind < high for wind in stated):
            raise Refusal("functions: one inside a cell, so that P is not linear over it")
        if last is not None and low == last:
            runs[-1].append(cell)
        else:
            runs.append([cell])
        last = high
    winds = entry(claim, "winds")
    if not isinstance(winds, list) or len(winds) != len(runs):
        raise Refusal("winds: one range for each range of cells is needed")
    number = 1
    for row, run in zip(winds, runs, strict=True):
        start, stop = rationals({"winds": row}, "winds", 2)
        if start >= stop:
            raise Refusal("winds: two that increase are needed")
        labels = [f"cell {number + i}" for i in range(len(run))]
        number += len(run)
        yield from _run(rotor, machine, run, functions, labels)
        yield from _edges(machine, run, functions, start, stop)


def _edges(
    machine: Machine, run: list[Any], functions: dict[str, fmpq_mat], start: fmpq, stop: fmpq
) -> Obligations:
    """Yield that v - v_s cannot be as large as the wind's distance from the cells' ends."""
    first, last = rationals(run[0], "wind", 2)[0], rationals(run[-1], "wind", 2)[1]
    h = fmpq_mat([[fmpq(int(i == 3)) for i in range(machine.states)]])
    for room, wind in ((start - first, first), (last - stop, last)):
        yield Fact("the wind inside the cells", room > 0)
        inside = scaled(room**2, functions[str(wind)]) - transposed(h) * h
        yield Definite("the schedule wind stays in the cells", inside)


def _run(
    rotor: Rotor,
    machine: Machine,
    run: list[Any],
    functions: dict[str, fmpq_mat],
    labels: list[str],
) -> Obligations:
    """Yield the conditions of cells without a gap."""
    found = []
    for stated, label in zip(run, labels, strict=True):
        low, high = rationals(stated, "wind", 2)
        if str(low) not in functions or str(high) not in functions:
            raise Refusal(f"{label}: a function at both winds is needed")
        sides = box(stated, SIDES)
        try:
            found.append(ScheduledCell(rotor, machine, low, high, sides))
        except Outside as reason:
            yield Fact(f"{label}: enclosure ({reason})", False)
            return
    lead = found[0].own_lead
    for cell in found:
        lead = lead.hull(cell.own_lead)
    for cell, stated, label in zip(found, run, labels, strict=True):
        yield from _cell(cell, stated, functions, lead, label)


def _cell(
    cell: ScheduledCell,
    stated: Any,
    functions: dict[str, fmpq_mat],
    lead: NumberRange,
    label: str,
) -> Obligations:
    alpha, rate, k = (
        rational(stated, name) for name in ("decay_rate", "wind_rate", "residual_share")
    )
    if alpha <= 0 or rate <= 0 or k <= 0 or k >= 1:
        raise Refusal(f"{label}: rates above 0, and a share between 0 and 1, are needed")
    for name, holds in cell.limits(lead):
        yield Fact(f"{label}: {name}", holds)
    try:
        loop = ScheduledRates(cell, cell.factors(lead))
    except Outside as reason:
        yield Fact(f"{label}: enclosure ({reason})", False)
        return
    low, high = cell.ends
    ends = [functions[str(v)] for v in (low, high)]
    taus = [_multipliers(stated, loop, end, label) for end in (0, 1)]
    yield Fact(f"{label}: multipliers", min(min(tau.values()) for tau in taus) > 0)
    for P in ends:
        yield Definite(f"{label}: P", P)
    for name, row, bound in loop.sides():
        yield Fact(f"{label}: side {name}", bound > 0)
        h = fmpq_mat([row])
        for P in ends:
            yield Definite(f"{label}: width of {name}", scaled(bound**2, P) - transposed(h) * h)
    change = scaled(cell.rho / (high - low), ends[1] - ends[0])
    weights = 2 * alpha * (1 - k) / rate**2, 2 * alpha * k
    for P, tau in zip(ends, taus, strict=True):
        for sign in (fmpq(1), fmpq(-1)):
            shift = scaled(2 * alpha, P) + scaled(sign, change)
            yield Definite(f"{label}: set", shortened(loop.form(P, tau, shift, weights)))


def _multipliers(stated: Any, loop: ScheduledRates, end: int, label: str) -> dict[str, fmpq]:
    """Return the multiplier of each factor at one end of the cell."""
    row = entry(stated, "multipliers")
    if not isinstance(row, dict) or not set(row) <= set(NAMES):
        raise Refusal(f"{label}: multipliers by the names of factors are needed")
    if any(name not in row for name in NAMES if any(loop.outer[name])):
        raise Refusal(f"{label}: a factor without a multiplier")
    return {name: rationals(row, name, 2)[end] for name in row}
