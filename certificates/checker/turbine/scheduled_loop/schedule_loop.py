r"""The loop about the trim at the schedule wind v_s, as signals with uncertain factors.

States, each less its value in the trim at v_s:

    e = omega - omega*          p = beta - beta*(v_s)        x  the law's integral
    D = v - v_s                 m = omega_m - omega*         o = omegahat - omega*
    q = vhat - v_s              eta = the wake's pitch - beta*(v_s)
    y1, y2  the two poles of the band-stop, where there is one, less omega*

with kappa nominal over true inertia, rho the tables' residual, and all of [.] from a range:

    v_s' = q / tau_f
    A    = [a] e - [sigma] p + [d] D + rho                   the torques' difference over J
    e'   = [kappa] (A - [h] (p - eta))
    p'   = y / tau - [beta*'] v_s',     y = [G] (m - x) + [lead] v_s' - p
    x'   = -nu m
    D'   = v' - v_s'
    m'   = c (e - 2 (1 - passed) (y1 - y2) - m),   y1' = w (e - y1),   y2' = w (y1 - y2)
    o'   = [J / J_o] (A + [a2] (m - e) + [d2] (q - D)) + l_1 (m - o),   q' = l_2 (m - o) - v_s'
    eta' = [wake's rate] (p - eta) - [beta*'] v_s'

Derived in docs/schedule-rate.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from takagi.certificates.checker.turbine.running_loop.cell import FULL, NIL, down, up
from takagi.certificates.checker.turbine.running_loop.equations import measured_rate, states
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.running_loop.signals import Signal, Signals, combined
from takagi.certificates.checker.turbine.scheduled_loop.schedule_cell import ScheduleCell

(E, P, X, LAG, M, SEEN, Q, ETA, FIRST, SECOND) = range(10)
# The names of the factors; each is used once.  The inputs are v' and rho over its bound.
SCHEDULE_FACTORS = frozenset({
    "stiffness", "pitch gain", "wind gain", "late pitch gain", "inertia", "pitch per signal",
    "lead", "pitch slope", "observed stiffness", "observed wind gain", "observer inertia",
    "wake rate",
})  # fmt: skip
INPUTS = 2


def schedule_factors(cell: ScheduleCell, lead: Span) -> dict[str, Span]:
    """Return each factor's range.

    Parameters
    ----------
    lead : the range of the pitch lead, of all cells that the schedule wind may pass.
    """
    machine, sides = cell.machine, cell.sides
    stiffness, pitch_gain, wind_gain = cell.slopes
    observed, observed_wind = cell.observed
    length, seen = machine.wake_length, machine.observer_inertia
    return {
        "stiffness": stiffness,
        "pitch gain": pitch_gain,
        "wind gain": wind_gain,
        "late pitch gain": (NIL, cell.late),
        "inertia": _outward((1 / machine.inertia[1], 1 / machine.inertia[0])),
        "pitch per signal": _outward(cell.gain),
        "lead": lead,
        "pitch slope": _outward(cell.pitch_slope),
        "observed stiffness": observed,
        "observed wind gain": observed_wind,
        "observer inertia": _outward((seen, seen)),
        "wake rate": _outward((
            (cell.winds[0] - sides.wind) / length[1],
            (cell.winds[1] + sides.wind) / length[0],
        )),
    }  # fmt: skip


def _outward(ends: Span) -> Span:
    """Return seven decimals, rounded outward."""
    return down(ends[0]), up(ends[1])


def schedule_equations(
    cell: ScheduleCell, span: Mapping[str, Span]
) -> tuple[Signals, list[Signal]]:
    """Return the signals and the states' rates."""
    machine, n = cell.machine, states(cell.machine)
    signals = Signals(n, INPUTS)

    def times(name: str, signal: Signal) -> Signal:
        return signals.times(name, span[name], signal)

    e, p, x, lag, m, o, q, eta = (signals.state(i) for i in range(8))
    moved = combined((1 / machine.wind_filter, q))
    table = combined(
        (1, times("stiffness", e)),
        (-1, times("pitch gain", p)),
        (1, times("wind gain", lag)),
        (cell.imbalance, signals.state(n + 1)),
    )
    behind = combined((1, p), (-1, eta))
    late = times("late pitch gain", behind)
    distance = combined(
        (1, times("pitch per signal", combined((1, m), (-1, x)))),
        (1, times("lead", moved)),
        (-1, p),
    )
    turned = times("pitch slope", moved)
    seen = combined(
        (1, table),
        (1, times("observed stiffness", combined((1, m), (-1, e)))),
        (1, times("observed wind gain", combined((1, q), (-1, lag)))),
    )
    apart = combined((1, m), (-1, o))
    found = [
        times("inertia", combined((1, table), (-1, late))),
        combined((1 / cell.plant.lag, distance), (-1, turned)),
        combined((-cell.law.nu[cell.k], m)),
        combined((1, signals.state(n)), (-1, moved)),
        measured_rate(machine),
        combined((1, times("observer inertia", seen)), (machine.l1, apart)),
        combined((machine.l2, apart), (-1, moved)),
        combined((1, times("wake rate", behind)), (-1, turned)),
    ]
    if machine.stop:
        w, first, second = machine.stop[0], signals.state(FIRST), signals.state(SECOND)
        found += [combined((w, e), (-w, first)), combined((w, first), (-w, second))]
    return signals, found


def schedule_rows(
    cell: ScheduleCell, span: Mapping[str, Span]
) -> dict[str, tuple[list[Fraction], Fraction]]:
    """Return, by side of the box, the row h and the bound of |h xi| that must hold on the set.

    The pitch that is sent less the pitch has uncertain factors.  Each is replaced by the middle of
    its range, and the bound is the side less the largest effect of the deviation from the middle.
    """
    sides, machine = cell.sides, cell.machine
    (gain, dgain), (lead, dlead) = (
        ((low + high) / 2, (high - low) / 2)
        for low, high in (span["pitch per signal"], span["lead"])
    )
    spread = dgain * sides.signal + dlead * cell.schedule_rate
    wanted: dict[str, tuple[Signal, Fraction]] = {
        "speed": ({E: FULL}, sides.speed),
        "measured": ({M: FULL}, sides.measured),
        "pitch": ({P: FULL}, sides.pitch),
        "signal": ({M: FULL, X: -FULL}, sides.signal),
        "integral": ({X: FULL}, cell.law.integral_limit),
        "wind": ({LAG: FULL}, sides.wind),
        "estimate": ({Q: FULL}, sides.estimate),
        "measured_rate": (measured_rate(machine), sides.measured_rate),
        "innovation": ({M: FULL, SEEN: -FULL}, sides.innovation),
        "drive": (
            {M: gain, X: -gain, Q: lead / machine.wind_filter, P: -FULL},
            sides.drive - spread,
        ),
    }
    count = states(machine)
    return {
        name: ([row.get(i, NIL) for i in range(count)], bound)
        for name, (row, bound) in wanted.items()
    }
