r"""Proof that the limits missing in the running loop's equations are not reached on the set.

Torque's lower limit, pitch's upper one, the integral's, and the gain file's limits of the rates of
torque and pitch.  With rho = (estimate + schedule) / tau_f >= |v_s'|, on the set

    |U'| <= |q*'| rho + |gamma'| rho (signal + |x_rest|)
            + gamma (measured_rate + |omega*'| rho + nu (measured + |omega*'| schedule))

and

    |T'| <= E F(-U) |U'|
    |beta_ref'| <= (F(U) |U'| + psi(U) |b'| rho / b) / b .

Both commands are continuous.  If both rates are within the gain file's limits, what is sent is what
the law asks for.
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
    given_up = law.effort_torque * psi(-cell.efforts[0], law.overlap)
    yield nonnegative(law.rated_torque - given_up, "negative torque may be demanded")
    asked = cell.shed[1] / cell.b_reach[0] + law.pitch_min
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
    law, sides, rate = cell.law, cell.sides, cell.schedule_rate
    w, q, gamma = (size(cell.slopes(column)) for column in (law.speed, law.effort, law.gamma))
    error = sides.measured + w * sides.schedule
    signal = sides.measured_rate + w * rate + cell.steps(law.nu)[1] * error
    effort = (q + gamma * (sides.signal + cell.rest_integral)) * rate
    effort += cell.over(law.gamma, cell.reach)[1] * signal
    least, bend = cell.b_reach[0], size(cell.slopes(law.effectiveness))
    torque = share(-cell.efforts[0], law.overlap) * effort
    pitch = (cell.ramp_share[1] * effort + cell.shed[1] * bend * rate / least) / least
    return law.effort_torque * torque, pitch
