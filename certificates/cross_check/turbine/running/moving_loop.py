r"""``running-rate``: in moving wind the loop keeps a set around the trim at the present wind.

P(v) is linear between the winds at which it is stated.  In a cell [a, b], for P and tau at a and b,
for v' = -r and r, and for every part of v_s - v and every piece of the share of pitch, the form of
``moving_rates`` is positive definite with D = v' (P(b) - P(a)) / (b - a) and the weights 2 alpha (1
- k) / r^2 of v' and 2 alpha k of the residual; and b^2 P - h'h is for every side of the box.  Then
V' <= 2 alpha (1 - V) while |v'| <= r.  ``entering`` has what is asked at a wind that two cells
share.  The theorem is in docs/running-rate.md.
"""

from __future__ import annotations

from itertools import pairwise
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
from takagi.certificates.cross_check.turbine.running.cell import RunningCell
from takagi.certificates.cross_check.turbine.running.entering import Entered, entering
from takagi.certificates.cross_check.turbine.running.machine import Machine, box, same_controller
from takagi.certificates.cross_check.turbine.running.moving_form import functions_by_wind
from takagi.certificates.cross_check.turbine.running.moving_rates import (
    MOVING,
    MOVING_NAMES,
    MovingRates,
)
from takagi.certificates.cross_check.turbine.running.rates import Row
from takagi.certificates.cross_check.turbine.running.running_loop import (
    MOST_CELLS,
    MOST_PIECES,
    same_winds,
)
from takagi.certificates.cross_check.turbine.running.shortened import shortened
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

PITCH_STATES, MOST_CUTS = (1, 7), 15


def moving_loop(claim: Any, document: Any) -> Obligations:
    """Yield the conditions of the module's text."""
    model, gains = entry(document, "model"), entry(document, "gains")
    rotor, machine = Rotor(model, gains), Machine(claim, model, gains)
    if not same_controller(claim, document):
        raise Refusal("observer or filters are not the controller's")
    cells, functions = entry(claim, "cells"), functions_by_wind(claim, machine.states)
    if not isinstance(cells, list) or len(cells) not in range(1, MOST_CELLS + 1):
        raise Refusal(f"cells: 1 to {MOST_CELLS} are needed")
    winds = [rationals(cell, "wind", 2) for cell in cells]
    same_winds(claim, winds)
    if any(low < rational(one, "wind") < high for one in claim["functions"] for low, high in winds):
        raise Refusal("functions: one at a wind inside a cell, so that P is not linear over it")
    entered: list[Entered] = []
    for number, cell in enumerate(cells, start=1):
        yield from _cell(rotor, machine, cell, functions, f"cell {number}", entered)
    if len(entered) == len(cells):
        yield from entering(entered)


def _cell(
    rotor: Rotor,
    machine: Machine,
    stated: Any,
    functions: dict[str, fmpq_mat],
    label: str,
    entered: list[Entered],
) -> Obligations:
    """Yield the conditions of one cell, and add it to those that the wind may enter."""
    low, high = rationals(stated, "wind", 2)
    if str(low) not in functions or str(high) not in functions:
        raise Refusal(f"{label}: a function at both winds is needed")
    alpha, rate, k = (
        rational(stated, name) for name in ("decay_rate", "wind_rate", "residual_share")
    )
    if alpha <= 0 or rate <= 0 or k <= 0 or k >= 1:
        raise Refusal(f"{label}: rates above 0, and a share between 0 and 1, are needed")
    sides = box(stated)
    lags = _lags(stated, sides["schedule"], label)
    pieces = entry(stated, "multipliers")
    shares = len(pieces) // len(lags) if isinstance(pieces, list) else 0
    if shares not in range(1, MOST_PIECES + 1) or len(pieces) != shares * len(lags):
        raise Refusal(f"{label}: multipliers of 1 to {MOST_PIECES} pieces are needed")
    try:
        cell = RunningCell(rotor, machine, low, high, sides)
        parts = [cell if lag is None else cell.part(*lag) for lag in lags]
        factors = [part.factors() | {MOVING: part.trim_slope()} for part in parts]
        limits = cell.limits()
    except Outside as reason:
        yield Fact(f"{label}: enclosure ({reason})", False)
        return
    for name, holds in limits:
        yield Fact(f"{label}: {name}", holds)
    ends = [_per_effort(functions[str(v)], cell.b0) for v in (low, high)]
    for P in ends:
        yield Definite(f"{label}: P", P)
    change = scaled(rate / (high - low), ends[1] - ends[0])
    weights = 2 * alpha * (1 - k) / rate**2, 2 * alpha * k
    width = (cell.share.high - cell.share.low) / shares
    every: list[tuple[str, Row, fmpq]] = []
    for i, piece in enumerate(pieces):
        which, j = divmod(i, shares)
        share = NumberRange(cell.share.low + width * j, cell.share.low + width * (j + 1))
        loop = MovingRates(parts[which], factors[which], share)
        taus = [_multipliers(piece, loop, end, label) for end in (0, 1)]
        yield Fact(f"{label}: multipliers", min(min(tau.values()) for tau in taus) > 0)
        if j == 0:
            yield from _box(loop, ends, label)
            every += loop.sides()
        for P, tau in zip(ends, taus, strict=True):
            for sign in (fmpq(1), fmpq(-1)):
                shift = scaled(2 * alpha, P) + scaled(sign, change)
                yield Definite(f"{label}: set", shortened(loop.form(P, tau, shift, weights)))
    entered.append(Entered(cell, ends, every, label))


def _lags(stated: Any, side: fmpq, label: str) -> list[tuple[fmpq, fmpq] | None]:
    """Return the parts of v_s - v that the cuts make; None, the whole, where there are none."""
    if not isinstance(stated, dict) or "schedule_cuts" not in stated:
        return [None]
    cuts = rationals(stated, "schedule_cuts")
    found = list(pairwise([-side, *cuts, side]))
    if not 1 <= len(cuts) <= MOST_CUTS or any(a >= b for a, b in found):
        raise Refusal(f"{label}: 1 to {MOST_CUTS} cuts that increase inside the box are needed")
    return [*found]


def _multipliers(piece: Any, loop: MovingRates, end: int, label: str) -> dict[str, fmpq]:
    """Return the multiplier of each factor at one end of the cell: the piece has two of each."""
    if not isinstance(piece, dict) or not set(piece) <= set(MOVING_NAMES):
        raise Refusal(f"{label}: multipliers by the names of factors are needed")
    if any(name not in piece for name in MOVING_NAMES if any(loop.outer[name])):
        raise Refusal(f"{label}: a factor without a multiplier")
    return {name: rationals(piece, name, 2)[end] for name in piece}


def _box(loop: MovingRates, ends: list[fmpq_mat], label: str) -> Obligations:
    for name, row, bound in loop.sides():
        yield Fact(f"{label}: side {name}", bound > 0)
        h = fmpq_mat([row])
        for P in ends:
            inside = scaled(bound**2, P) - transposed(h) * h
            yield Definite(f"{label}: width of {name}", inside)


def _per_effort(P: fmpq_mat, b0: fmpq) -> fmpq_mat:
    """Return P for pitch states times b_0, of one whose pitch states are in rad."""
    n = P.nrows()
    unit = [1 / b0 if i in PITCH_STATES else fmpq(1) for i in range(n)]
    return fmpq_mat([[unit[i] * P[i, j] * unit[j] for j in range(n)] for i in range(n)])
