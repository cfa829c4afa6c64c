r"""``running-loop``: the loop with observer and filters settles at constant winds, cell by cell.

For every piece of the share of pitch the matrix below is positive definite, b^2 P - h'h is
for every side of the box, and the limits that the equations leave out are not reached.  Then
V = xi'P xi falls from 1 at least as exp(-2 alpha t).  The theorem is in docs/running-loop.md.

The running loop as rows over its states and its uncertain products.

A row is a vector over (xi, w_1 .. w_k).  A factor of [l, u] times a row y is

    (l + u) / 2 y + w_i,      w_i^2 <= z_i^2,  z_i = (u - l) / 2 y .

With F the rows of xi', Z those of z and T = diag(tau) the decay inequality is

    [ -2 alpha P   0 ]     [ P F ]   [ P F ]'
    [     0        T ]  -  [  0  ] - [  0  ]   -  Z' T Z  >  0 .

Its fractions are long.  With D diagonal, its entries powers of 2 such that the diagonal of D M D is
about 2^BITS, let S_ij be the greatest integer at or below (D M D)_ij.  Then D M D = S + E, E
symmetric with entries from 0 to 1, and |x'Ex| <= n x'x.  So if S - n I is positive definite, M is
positive definite (``shortened``).
"""

from __future__ import annotations

from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    Definite,
    Fact,
    Obligations,
    diagonal,
    entries,
    scaled,
    transposed,
)
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rational_row,
    rationals,
    table,
)
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.running_cell import (
    Machine,
    RunningCell,
    box,
    same_controller,
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


Row = list[fmpq]
BITS = 44
NAMES = (
    "speed slope",
    "effort slope",
    "gamma",
    "share",
    "held estimate",
    "feed-forward",
    "pitch per effort",
    "pitch by schedule",
    "lead",
    "integral rate",
    "stiffness",
    "pitch gain",
    "late pitch gain",
    "inertia",
    "observed stiffness",
    "wind gain",
    "observer inertia",
    "wake rate",
    "drive",
)


class RunningRates:
    """xi' of one cell for a share of pitch from ``share``; every name has its own w."""

    def __init__(self, cell: RunningCell, factors: dict[str, NumberRange], share: NumberRange):
        self.cell, self.spans = cell, factors | {"share": share}
        self.n = cell.machine.states
        self.width = self.n + len(NAMES)
        self.outer: dict[str, Row] = {}
        self.rates = self._equations()

    def _state(self, i: int) -> Row:
        return [fmpq(int(i == j)) for j in range(self.width)]

    def _times(self, name: str, row: Row) -> Row:
        """Return an uncertain factor times a row, with the factor's own w."""
        span = self.spans[name]
        middle, half = (span.low + span.high) / 2, (span.high - span.low) / 2
        self.outer[name] = [half * y for y in row]
        found = [middle * y for y in row]
        found[self.n + NAMES.index(name)] += 1
        return found

    def _equations(self) -> list[Row]:
        machine, rotor, times = self.cell.machine, self.cell.rotor, self._times
        e, p, x, s, m, o, z, eta = (self._state(i) for i in range(8))
        error = _less(m, times("speed slope", s))
        u = _sum(times("effort slope", s), times("gamma", _less(error, x)))
        g = times("share", u)
        rate = _by(1 / machine.lag, _less(times("held estimate", z), s))
        load = _by(rotor.m, _less(_less(u, g), times("feed-forward", rate)))
        table = _less(times("stiffness", e), times("pitch gain", p))
        late = times("late pitch gain", _less(p, eta))
        asked = _less(times("pitch per effort", g), times("pitch by schedule", s))
        distance = _less(_sum(asked, times("lead", rate)), p)
        seen = _sum(table, times("observed stiffness", _less(m, e)))
        seen = _less(_sum(seen, times("wind gain", z)), load)
        gap = _less(m, o)
        found = [
            times("inertia", _less(_less(table, late), load)),
            _by(1 / rotor.drive, times("drive", distance)),
            _by(fmpq(-1), times("integral rate", error)),
            rate,
            self.filtered_rate(),
            _sum(times("observer inertia", seen), _by(machine.l1, gap)),
            _by(machine.l2, gap),
            times("wake rate", _less(p, eta)),
        ]
        if machine.stop is not None:
            w, first, second = machine.stop[0], self._state(8), self._state(9)
            found += [_by(w, _less(e, first)), _by(w, _less(first, second))]
        return found

    def filtered_rate(self) -> Row:
        """Return m' = c_l (e - 2 (1 - p_t) (y_1 - y_2) - m)."""
        machine, into = self.cell.machine, self._state(0)
        if machine.stop is not None:
            left = 2 * (1 - machine.stop[1])
            into = _less(into, _by(left, _less(self._state(8), self._state(9))))
        return _by(machine.corner, _less(into, self._state(4)))

    def falling(self, P: fmpq_mat, tau: dict[str, fmpq], alpha: fmpq) -> fmpq_mat:
        """Return the matrix of the module; a factor that is a single number needs no tau."""
        used = [name for name in NAMES if any(self.outer[name])]
        kept = [*range(self.n), *(self.n + NAMES.index(name) for name in used)]
        F = fmpq_mat([[row[j] for j in kept] for row in self.rates])
        size, T = len(kept), diagonal([tau[name] for name in used])
        found = entries(P * F)
        both = fmpq_mat(found + [[fmpq(0)] * size for _ in used])
        diag = [
            [-2 * alpha * P[i, j] if max(i, j) < self.n else fmpq(0) for j in range(size)]
            for i in range(size)
        ]
        for i, name in enumerate(used):
            diag[self.n + i][self.n + i] = tau[name]
        Z = fmpq_mat([[self.outer[name][j] for j in kept] for name in used])
        return fmpq_mat(diag) - both - transposed(both) - transposed(Z) * T * Z

    def sides(self) -> list[tuple[str, Row, fmpq]]:
        """Return (side, row over the states, bound): the box needs |row xi| below the bound."""
        box = self.cell.box
        e, p, x, s, m, o, z, _ = (self._state(i)[: self.n] for i in range(8))
        middle, half = {}, {}
        for name in ("speed slope", "gamma", "effort slope"):
            span = self.spans[name]
            middle[name], half[name] = (span.low + span.high) / 2, (span.high - span.low) / 2
        signal = _less(_less(m, x), _by(middle["speed slope"], s))
        effort = _sum(_by(middle["effort slope"], s), _by(middle["gamma"], signal))
        off = half["speed slope"] * box["schedule"]
        more = half["effort slope"] * box["schedule"] + half["gamma"] * box["signal"]
        more += middle["gamma"] * off
        plain = (("speed", e), ("measured", m), ("pitch", p), ("schedule", s), ("estimate", z))
        found = [(name, row, box[name]) for name, row in (*plain, ("integral", x))]
        found.append(("measured_rate", self.filtered_rate()[: self.n], box["measured_rate"]))
        found.append(("innovation", _less(m, o), box["innovation"]))
        found.append(("signal", signal, box["signal"] - off))
        found.append(("effort", effort, box["effort"] - more))
        return found


def _sum(a: Row, b: Row) -> Row:
    return [x + y for x, y in zip(a, b, strict=True)]


def _less(a: Row, b: Row) -> Row:
    return [x - y for x, y in zip(a, b, strict=True)]


def _by(factor: fmpq, row: Row) -> Row:
    return [factor * y for y in row]


def shortened(matrix: fmpq_mat) -> fmpq_mat:
    """Return S - n I of the module's text; the matrix itself where a diagonal entry is not > 0."""
    n = matrix.nrows()
    diagonal = [matrix[i, i] for i in range(n)]
    if min(diagonal) <= 0:
        return matrix
    powers = [(BITS - _power(value)) // 2 for value in diagonal]
    rows = [[fmpq(0)] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            value = matrix[i, j] * fmpq(2) ** (powers[i] + powers[j])
            rows[i][j] = rows[j][i] = fmpq(int(value.p) // int(value.q) - n * int(i == j))
    return fmpq_mat(rows)


def _power(value: fmpq) -> int:
    """Return about the power of 2 that a positive number is."""
    return int(value.p).bit_length() - int(value.q).bit_length()
