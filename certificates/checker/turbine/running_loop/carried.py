r"""What the gain file's rate limits may carry over where the wind passes into another cell.

In one cell the limited torque and pitch stay between the commands for the least and the greatest
feed-forward and lead of the cell (``limits``).  Another cell has other ranges of these two, and
torque or pitch may lag behind a command of the cell before.  With ranges F of this cell, F* of all
cells of the range of winds without a gap, rho the largest |v_s'| in these, and R the largest rate
of a command with the sizes of F*, what is sent is at most rho |F* beyond F| outside this cell's
commands, and comes back at the limit less R or faster: within

    D = rho |F* beyond F| / (limit - R).

So it is among the cell's commands if all feed-forwards and leads of the last D seconds were in F.
They were if the state at the shared wind was so far inside the box that D seconds earlier v_s was
in it as well, and for the lead also U and omega_m - omega* - x: for each of these rows h, with its
rate h_r,

    sqrt(h P^-1 h') + D h_r < its bound         at the winds that the cell shares with others,

in each piece of v_s - v, as h and its bound are those of the piece that the state is in there.

Derived in docs/running-rate.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.turbine.running_loop.cell import NIL, Cell, size
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.running_loop.limits import command_rates, motion

LAGS = "torque or pitch may lag behind the law where the wind enters the cell"
# What decides the feed-forward of the torque, and the lead of the pitch.
DECIDING = (("schedule",), ("schedule", "effort", "signal"))
Room = dict[str, tuple[Fraction, Fraction]]


@dataclass(frozen=True)
class Passed:
    """A cell between its neighbours.

    ``rooms`` : at its two winds, for each piece of v_s - v, of each side of the box the square of
    what the set there reaches and the bound that it must keep.
    """

    cell: Cell
    rooms: tuple[Sequence[Room], Sequence[Room]]

    @property
    def ranges(self) -> tuple[Span, Span]:
        """The feed-forward [rad/s per m/s] and the lead [rad per m/s^2], both with 0."""
        cell = self.cell
        fed = [cell.law.inertia[j] for j in cell.near]
        led = cell.lead[0] / cell.b0, cell.lead[1] / cell.b0
        return (min(NIL, *fed), max(NIL, *fed)), led


def carried_failures(run: Sequence[Passed]) -> list[tuple[Span, str]]:
    """Return the winds of the cells of a range without a gap that fail, each with the reason."""
    ranges = [one.ranges for one in run]
    whole = [_hull([both[i] for both in ranges]) for i in (0, 1)]
    law, machine = run[0].cell.law, run[0].cell.machine
    moved = [motion(one.cell) for one in run]
    rho = max(one.schedule for one in moved)
    rates = {
        "schedule": rho,
        "effort": max(one.effort for one in moved),
        "signal": max(one.signal for one in moved),
    }
    fastest = [command_rates(one.cell, *map(size, whole)) for one in run]
    limits = machine.torque_rate, run[0].cell.plant.rate_limit
    spare = [limits[i] - max(both[i] for both in fastest) for i in (0, 1)]
    found = []
    for k, one in enumerate(run):
        left = [rho * _beyond(whole[i], ranges[k][i]) for i in (0, 1)]
        left[0] *= law.effort_torque
        rooms = [*one.rooms[0]] * (k > 0) + [*one.rooms[1]] * (k < len(run) - 1)
        if not all(
            _caught_up(left[i], spare[i], rooms, {name: rates[name] for name in names})
            for i, names in enumerate(DECIDING)
        ):
            found.append((one.cell.winds, LAGS))
    return found


def _caught_up(
    left: Fraction,
    spare: Fraction,
    rooms: Sequence[Room],
    rates: dict[str, Fraction],
) -> bool:
    """Return whether a command comes back in time from ``left``, by which it may lag.

    Parameters
    ----------
    spare : its limit less the largest rate of the law's command.
    rates : of what decides the command.
    """
    if left <= 0:
        return True
    if spare <= 0:
        return False
    for room in rooms:
        for name, rate in rates.items():
            square, bound = room[name]
            inner = bound - left / spare * rate
            if inner <= 0 or square >= inner**2:
                return False
    return True


def _hull(spans: Sequence[Span]) -> Span:
    return min(low for low, _ in spans), max(high for _, high in spans)


def _beyond(whole: Span, part: Span) -> Fraction:
    """Return by how much a range goes beyond a part of it."""
    return max(whole[1] - part[1], part[0] - whole[0])
