r"""Where the wind enters a cell, torque and pitch must be among the commands of that cell.

F is the range of the feed-forward, or of the lead, in a cell, F* in all cells of a range of winds
without a gap, rho the largest |v_s'| and R the largest rate of the command, with sizes of F*, in
these.  What is sent is at most e = rho |F* beyond F| outside the commands of the cell, and returns
in D = e / (limit - R).  For the row h of v_s, and for the lead also those of U and of
omega_m - omega* - x, each with its rate h_r,

    h P^-1 h' < (b - D h_r)^2

at each wind that the cell shares with another: then all of the last D seconds was in F.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import scaled, transposed
from takagi.certificates.cross_check.kernel.obligation import Definite, Fact, Obligation
from takagi.certificates.cross_check.turbine.running.cell import RunningCell
from takagi.certificates.cross_check.turbine.running.rates import Row
from takagi.certificates.cross_check.turbine.surface import NumberRange

MOVED = {"torque": ("schedule",), "pitch": ("schedule", "effort", "signal")}


@dataclass(frozen=True)
class Entered:
    """A cell, its functions at both winds, and the rows of its box with their bounds, by piece."""

    cell: RunningCell
    ends: list[fmpq_mat]
    sides: list[tuple[str, Row, fmpq]]
    label: str

    def fed(self) -> NumberRange:
        zero = NumberRange(fmpq(0), fmpq(0))
        return self.cell.step(self.cell.rotor.ahead).hull(zero)

    def led(self) -> NumberRange:
        return self.cell.lead().times(1 / self.cell.b0)


def entering(cells: list[Entered]) -> Iterator[Obligation]:
    """Yield the conditions of the module's text, for each range of winds without a gap."""
    start = 0
    for k in range(1, len(cells) + 1):
        if k == len(cells) or cells[k].cell.v.low != cells[k - 1].cell.v.high:
            if k - start > 1:
                yield from _range(cells[start:k])
            start = k


def _range(cells: list[Entered]) -> Iterator[Obligation]:
    rotor, machine = cells[0].cell.rotor, cells[0].cell.machine
    every = {
        "torque": [one.fed().times(rotor.per_effort) for one in cells],
        "pitch": [one.led() for one in cells],
    }
    whole = {name: _around(spans) for name, spans in every.items()}
    speeds = [one.cell.speeds() for one in cells]
    fastest = {name: max(one[name] for one in speeds) for name in MOVED["pitch"]}
    sizes = whole["torque"].size / rotor.per_effort, whole["pitch"].size
    rates = [one.cell.command_rates(*sizes) for one in cells]
    spare = {
        "torque": machine.torque_rate - max(torque for torque, _ in rates),
        "pitch": rotor.rate_limit - max(pitch for _, pitch in rates),
    }
    for k, one in enumerate(cells):
        shared = ([one.ends[0]] if k > 0 else []) + ([one.ends[1]] if k + 1 < len(cells) else [])
        for command, rows in MOVED.items():
            own = every[command][k]
            beyond = max(whole[command].high - own.high, own.low - whole[command].low)
            if beyond == 0:
                continue
            yield Fact(f"{one.label}: {command} comes back", spare[command] > 0)
            if spare[command] <= 0:
                continue
            lag = fastest["schedule"] * beyond / spare[command]
            yield from _inside(one, shared, {name: lag * fastest[name] for name in rows})


def _inside(one: Entered, shared: list[fmpq_mat], moved: dict[str, fmpq]) -> Iterator[Obligation]:
    """Yield that the sets at shared winds keep the box, less what its rows move by."""
    for name, row, bound in one.sides:
        if name not in moved:
            continue
        left = bound - moved[name]
        yield Fact(f"{one.label}: entered, side {name}", left > 0)
        h = fmpq_mat([row])
        for P in shared:
            inside = scaled(left**2, P) - transposed(h) * h
            yield Definite(f"{one.label}: entered, width of {name}", inside)


def _around(spans: list[NumberRange]) -> NumberRange:
    found = spans[0]
    for span in spans[1:]:
        found = found.hull(span)
    return found
