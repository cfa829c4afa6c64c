r"""The running loop in moving wind: distances from an operating point that moves with the wind.

The point is the trim of the law's tables: omega*(v), the effort q*(v), the pitch

    beta*(v) = beta_min + psi(q*(v)) / b(v)

for drive and wake, x = 0, and v_s = vhat = v.  The states are those of ``equations``, measured from
it.  The torques at it differ by the tables' residual r(v), which is not 0, as it is at a rest; and
its own motion takes from every rate the wind's rate times the slope of the point:

    e', m', o', y1', y2'  less  omega*' v'     s', z'  less  v'     p', eta'  less  b0 beta*' v'
    beta*' = (F(q*) q*' - psi(q*) b' / b) / b

The inputs are v' and r / |r|_max, of which |r|_max is a bound over the cell.
Derived in docs/running-rate.md.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import enclose, point
from takagi.certificates.checker.turbine.running_loop.cell import FULL, Cell, span
from takagi.certificates.checker.turbine.running_loop.equations import (
    ETA,
    FACTORS,
    Factors,
    P,
    S,
    X,
    Z,
    rates_from,
    states,
)
from takagi.certificates.checker.turbine.running_loop.factors import factors
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.running_loop.signals import Rows, Signal, Signals, combined

# The factor that only the loop in moving wind has, and the number of inputs: v' and the residual.
SLOPE = "pitch slope"
MOVING_FACTORS, INPUTS = FACTORS | {SLOPE}, 2


def moving_factors(cell: Cell) -> dict[str, Span]:
    """Return the factors' ranges, with b0 beta*' over the cell's winds."""
    return factors(cell) | {SLOPE: _pitch_slope(cell)}


def _pitch_slope(cell: Cell) -> Span:
    law = cell.law
    held, shed = (enclose(*(of(q, law.overlap) for q in cell.q)) for of in (share, psi))
    steep, bend = (point(law.slope(column, cell.k)) for column in (law.effort, law.effectiveness))
    b = enclose(*cell.b)
    return span((held * steep - shed * bend / b) / b * point(cell.b0))


def moving_equations(cell: Cell, span: Factors, held: Span) -> tuple[Signals, list[Signal]]:
    """Return the signals and the states' rates for a share of pitch from ``held``."""
    n = states(cell.machine)
    signals = Signals(n, INPUTS)
    wind_rate, residual = signals.state(n), combined((cell.imbalance, signals.state(n + 1)))
    rates = rates_from(signals, cell, span, held, residual)
    pitch = signals.times(SLOPE, span[SLOPE], wind_rate)
    speed = combined((cell.law.slope(cell.law.speed, cell.k), wind_rate))
    taken = dict.fromkeys(range(n), speed)
    taken |= {P: pitch, ETA: pitch, S: wind_rate, Z: wind_rate, X: {}}
    return signals, [combined((1, rate), (-1, taken[i])) for i, rate in enumerate(rates)]


def in_units(cell: Cell, function: Rows) -> Rows:
    """Return P for the cell's states, of one whose pitch states are in rad."""
    unit = [1 / cell.b0 if i in (P, ETA) else FULL for i in range(len(function))]
    return [
        [unit[i] * entry * unit[j] for j, entry in enumerate(row)] for i, row in enumerate(function)
    ]


def drift(low: Rows, high: Rows, rate: Fraction) -> Rows:
    """Return v' dP/dv, for P linear over the cell and v' = rate times the cell's width."""
    return [
        [rate * (b - a) for a, b in zip(first, second, strict=True)]
        for first, second in zip(low, high, strict=True)
    ]
