r"""``running-loop``: the loop with observer and filters settles at constant winds, cell by cell.

For every piece of the share of pitch the matrix of ``rates`` is positive definite, b^2 P - h'h is
for every side of the box, and the limits that the equations leave out are not reached.  Then
V = xi'P xi falls from 1 at least as exp(-2 alpha t).  The theorem is in docs/running-loop.md.
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
    rational_row,
    rationals,
    table,
)
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.running.cell import RunningCell
from takagi.certificates.cross_check.turbine.running.machine import Machine, box, same_controller
from takagi.certificates.cross_check.turbine.running.rates import (
    NAMES,
    RunningRates,
    shortened,
)
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

MOST_CELLS, MOST_PIECES = 500, 8


def running_loop(claim: Any, document: Any) -> Obligations:
    """Yield the conditions of the module's text."""
    model, gains = entry(document, "model"), entry(document, "gains")
    rotor, machine = Rotor(model, gains), Machine(claim, model, gains)
    if not same_controller(claim, document):
        raise Refusal("observer or filters are not the controller's")
    alpha = rational(claim, "decay_rate")
    yield Fact("a rate above 0", alpha > 0)
    cells = entry(claim, "cells")
    if not isinstance(cells, list) or len(cells) not in range(1, MOST_CELLS + 1):
        raise Refusal(f"cells: 1 to {MOST_CELLS} are needed")
    _same_winds(claim, [rationals(cell, "wind", 2) for cell in cells])
    for number, cell in enumerate(cells, start=1):
        yield from _cell(rotor, machine, cell, alpha, f"cell {number}")


def _same_winds(claim: Any, cells: list[list[fmpq]]) -> None:
    """Refuse cells that overlap, are not in order, or cover other winds than the claim states."""
    ends = [end for pair in cells for end in pair]
    if any(a >= b for a, b in cells) or sorted(ends) != ends:
        raise Refusal("cells: winds that rise from cell to cell are needed")
    # The ends that remain when those common to two cells are removed.
    left = [end for end in ends if ends.count(end) == 1]
    listed = entry(claim, "winds")
    if not isinstance(listed, list):
        raise Refusal("winds: a list of ranges is needed")
    if [end for pair in listed for end in rational_row(pair, "winds", 2)] != left:
        raise Refusal("winds: not those of the cells")


def _cell(rotor: Rotor, machine: Machine, stated: Any, alpha: fmpq, label: str) -> Obligations:
    n = machine.states
    P = table(stated, "P", (n, n))
    yield Definite(f"{label}: P", P)
    pieces = entry(stated, "multipliers")
    if not isinstance(pieces, list) or len(pieces) not in range(1, MOST_PIECES + 1):
        raise Refusal(f"{label}: multipliers of 1 to {MOST_PIECES} pieces are needed")
    try:
        low, high = rationals(stated, "wind", 2)
        cell = RunningCell(rotor, machine, low, high, box(stated))
        factors = cell.factors()
        limits = cell.limits()
    except Outside as reason:
        yield Fact(f"{label}: enclosure ({reason})", False)
        return
    for name, holds in limits:
        yield Fact(f"{label}: {name}", holds)
    width = (cell.share.high - cell.share.low) / len(pieces)
    for i, piece in enumerate(pieces):
        share = NumberRange(cell.share.low + width * i, cell.share.low + width * (i + 1))
        loop = RunningRates(cell, factors, share)
        tau = _multipliers(piece, loop, label)
        yield Fact(f"{label}: multipliers", min(tau.values()) > 0)
        if i == 0:
            for name, row, bound in loop.sides():
                yield Fact(f"{label}: side {name}", bound > 0)
                h = fmpq_mat([row])
                inside = scaled(bound**2, P) - transposed(h) * h
                yield Definite(f"{label}: width of {name}", inside)
        yield Definite(f"{label}: decay", shortened(loop.falling(P, tau, alpha)))


def _multipliers(piece: Any, loop: RunningRates, label: str) -> dict[str, fmpq]:
    """Return the multiplier of each factor that is not a single number."""
    if not isinstance(piece, dict) or not set(piece) <= set(NAMES):
        raise Refusal(f"{label}: multipliers by the names of factors are needed")
    found = {name: rational(piece, name) for name in piece}
    if any(name not in found for name in NAMES if any(loop.outer[name])):
        raise Refusal(f"{label}: a factor without a multiplier")
    return found
