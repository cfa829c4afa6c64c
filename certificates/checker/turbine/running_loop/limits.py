r"""Proof that the limits missing in the running loop's equations are not reached on the set.

Torque's lower limit, pitch's upper one, the integral's, and the gain file's limits of the rates of
torque and pitch.  With rho = (estimate + schedule) / tau_f >= |v_s'|, on the set

    |v_s''| <= (l_2 innovation + rho) / tau_f
    |U'| <= |q*'| rho + |gamma'| rho (signal + |x_rest|)
            + gamma (measured_rate + |omega*'| rho + nu (measured + |omega*'| schedule))

and for every fixed factor of the feed-forward, and of the lead,

    |T'| <= E (F(-U) |U'| + |feed-forward| |v_s''|)
    |beta_ref'| <= (F(U) |U'| + psi(U) |b'| rho / b) / b + |lead| |v_s''| .

If both are within the gain file's limits, the limited torque and pitch stay between the commands
for the least and for the greatest factor, also after a node of the tables at which the factor
jumps.  The equations already cover all commands between these two.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ONE, point
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative
from takagi.certificates.checker.turbine.running_loop.cell import Cell, size


def limits(cell: Cell) -> Obligations:
    """Yield that no limit is reached on the set."""
    law, sides = cell.law, cell.sides
    rate = cell.schedule_rate
    taken = max(min(abs(law.inertia[j]) * rate, law.inertia_limit[j]) for j in cell.near)
    given_up = law.effort_torque * (psi(-cell.efforts[0], law.overlap) + taken)
    yield nonnegative(law.rated_torque - given_up, "negative torque may be demanded")
    asked = cell.shed[1] / cell.b_reach[0] + law.pitch_min + size(cell.lead) * rate / cell.b0
    beyond = "pitch beyond its limit may be demanded"
    yield nonnegative(law.pitch_max - asked, beyond)
    yield nonnegative(Fraction(point(law.pitch_max).low - cell.pitches.high, ONE), beyond)
    integral = sides.integral + cell.rest_integral
    yield nonnegative(law.integral_limit - integral, "the integral may reach its limit")
    torque, pitch = command_rates(cell)
    failure = "torque may reach the gain file's rate limit"
    yield nonnegative(cell.machine.torque_rate - torque, failure)
    failure = "pitch may reach the gain file's rate limit"
    yield nonnegative(cell.plant.rate_limit - pitch, failure)


def command_rates(cell: Cell) -> tuple[Fraction, Fraction]:
    """Return bounds of |T'| [N m/s] and of |beta_ref'| [rad/s] on the set."""
    law, sides, machine, rate = cell.law, cell.sides, cell.machine, cell.schedule_rate
    turned = (machine.l2 * sides.innovation + rate) / machine.wind_filter
    w, q, gamma = (size(cell.slopes(column)) for column in (law.speed, law.effort, law.gamma))
    error = sides.measured + w * sides.schedule
    signal = sides.measured_rate + w * rate + cell.steps(law.nu)[1] * error
    effort = (q + gamma * (sides.signal + cell.rest_integral)) * rate
    effort += cell.over(law.gamma, cell.reach)[1] * signal
    fed = max(abs(law.inertia[j]) for j in cell.near)
    led = size(cell.lead) / cell.b0
    least, bend = cell.b_reach[0], size(cell.slopes(law.effectiveness))
    torque = share(-cell.efforts[0], law.overlap) * effort + fed * turned
    pitch = (cell.ramp_share[1] * effort + cell.shed[1] * bend * rate / least) / least
    return law.effort_torque * torque, pitch + led * turned
