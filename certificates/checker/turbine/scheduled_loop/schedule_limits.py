r"""Proof that limits which the loop about the schedule wind leaves out are not reached on the set.

Pitch's two limits, the drive's rate limit, and the gain file's limit of the rate of the pitch that
is sent.  With rho = estimate / tau_f >= |v_s'|, on the set

    |v_s''| <= (l_2 innovation + rho) / tau_f
    |beta_c'| <= (|beta*'| + |G'| signal) rho + G (measured_rate + nu measured) + |lead| |v_s''|

for every fixed factor of the lead.  If that is within the limit,
what is sent stays between the commands for the least and for the greatest lead, also after a node
of the tables at which the lead jumps.  Torque is at its rated value all the time.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.interval import point
from takagi.certificates.checker.turbine.running_loop.cell import size
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.scheduled_loop.schedule_cell import ScheduleCell


def schedule_limit_failure(cell: ScheduleCell, lead: Span) -> str:
    """Return the limit that may be reached, or nothing.

    Parameters
    ----------
    lead : the range of the pitch lead, of all cells that the schedule wind may pass.
    """
    law, plant, sides = cell.law, cell.plant, cell.sides
    led = size(lead) * cell.schedule_rate
    away = cell.gain[1] * sides.signal + led
    low, high = cell.pitches_at_trim
    if low - away < law.pitch_min or high + away > law.pitch_max:
        return "pitch beyond its limits may be demanded"
    band = cell.pitches
    if band.low < point(law.pitch_min).high or band.high > point(law.pitch_max).low:
        return "pitch may reach its limits"
    if sides.drive > plant.rate_limit * plant.lag:
        return "the drive may reach its rate limit"
    if sent_rate(cell, lead) > plant.rate_limit:
        return "pitch may reach the gain file's rate limit"
    return ""


def sent_rate(cell: ScheduleCell, lead: Span) -> Fraction:
    """Return a bound of the rate of a command with a fixed lead [rad/s]."""
    law, sides, machine, rate = cell.law, cell.sides, cell.machine, cell.schedule_rate
    turned = (machine.l2 * sides.innovation + rate) / machine.wind_filter
    steep = size(cell.pitch_slope) + size(cell.gain_slope) * sides.signal
    moved = sides.measured_rate + law.nu[cell.k] * sides.measured
    return steep * rate + cell.gain[1] * moved + size(lead) * turned
