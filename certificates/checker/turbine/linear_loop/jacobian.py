r"""The matrix of the turbine's loop, linearised at the trim of one mean wind U, in turbulence.

States, each as its distance from the trim at U:

    e speed, p pitch, x integral, s schedule wind, m filtered speed, o and z the observer's speed
    and wind, eta the wake's pitch, k the wake's wind, y = v - U, r = y', y_1 and y_2 of the
    band-stop

    e'   = kappa (a~ e - sigma~ p + d~ y - h~ (p - eta) + g (y - k) - E)
    p'   = (F/b u - psi b'/b^2 s + lead s' - p)/tau
    x'   = -nu error,     s' = (z - s)/tau_f
    m'   = c_l (e - 2 (1 - p_t)(y_1 - y_2) - m),   y_1' = w_t (e - y_1),   y_2' = w_t (y_1 - y_2)
    o'   = (J/J_o)(a m - sigma p + d z - E) + l_1 (m - o),     z' = l_2 (m - o)
    eta' = (U/L)(p - eta),     k' = (U/L)(y - k)
    y'   = r,     r' = -damping r - stiffness y  + noise

    error = m - omega*' s,   u = q*' s + gamma (error - x),   E = m_E ((1 - F) u - f s')

The parameters are kappa = nominal over true inertia, a~ = k_a a, sigma~ = k_s sigma, h~ = k_h h,
g = k_w d, and L.  d~ = d - (k_a - 1) a omega*' + (k_s - 1) sigma beta*': the uncertain torque is
that of the table at the trims of all winds.  The matrix is affine in each of kappa, k_a, k_s, k_h,
k_w, 1/L, the others held: for parameters in a box it lies in the hull of those of the corners.

Derived in docs/turbine-crossing.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.linear_loop.pieces import Turbulence
from takagi.certificates.checker.turbine.linear_loop.trim import Trim
from takagi.certificates.checker.turbine.running_loop.inputs import Machine
from takagi.certificates.checker.turbine.running_loop.signals import Signal, combined

(E, P, X, S, M, SEEN, Z, ETA, LATE, Y, R, FIRST, SECOND) = range(13)  # fmt: skip


def order(machine: Machine) -> int:
    """Return the number of states: 13 with a band-stop, 11 without."""
    return 13 if machine.stop else 11


def signal_row(trim: Trim, machine: Machine) -> Matrix:
    """Return h of the speed's distance from its reference at the present wind, e - omega*' y."""
    row = {E: Fraction(1), Y: -trim.speed_slope}
    return Matrix.of([[row.get(i, Fraction(0)) for i in range(order(machine))]])


def noise_square(wind: Turbulence, machine: Machine) -> Matrix:
    """Return S S': the noise enters r alone."""
    n = order(machine)
    return Matrix.of(
        [[wind.intensity if i == j == R else Fraction(0) for j in range(n)] for i in range(n)]
    )


def loop_matrix(
    trim: Trim,
    plant: Plant,
    machine: Machine,
    wind: Turbulence,
    parameters: Mapping[str, Fraction],
) -> Matrix:
    """Return A.

    Parameters
    ----------
    parameters : true over nominal ``inertia``, ``wake_length`` [m], and the factors
        ``speed_damping``, ``pitch_effectiveness``, ``wake_of_pitch``, ``wake_of_wind``.
    """
    e, p, x, s, m, o, z, eta, late, y, r = ({i: Fraction(1)} for i in range(11))
    by_speed, by_pitch = parameters["speed_damping"], parameters["pitch_effectiveness"]
    a, sigma, d = trim.damping, trim.effectiveness, trim.by_wind
    error = combined((1, m), (-trim.speed_slope, s))
    u = combined((trim.effort_slope, s), (trim.gamma, error), (-trim.gamma, x))
    rate = combined((1 / machine.wind_filter, z), (-1 / machine.wind_filter, s))
    unit = trim.effort_unit
    braking = combined((unit * (1 - trim.share), u), (-unit * trim.ahead, rate))
    # The table's torque stays that of the trims of all winds.
    tied = d - (by_speed - 1) * a * trim.speed_slope + (by_pitch - 1) * sigma * trim.pitch_slope
    torque = combined(
        (by_speed * a, e),
        (-by_pitch * sigma, p),
        (tied, y),
        (-parameters["wake_of_pitch"] * trim.late, combined((1, p), (-1, eta))),
        (parameters["wake_of_wind"] * d, combined((1, y), (-1, late))),
        (-1, braking),
    )
    asked = combined((trim.pitch_gain, u), (-trim.pitch_bend, s), (trim.lead, rate))
    known = combined((a, m), (-sigma, p), (d, z), (-1, braking))
    apart = combined((1, m), (-1, o))
    moved = trim.wind / parameters["wake_length"]
    corner, into = machine.corner, [(Fraction(1), e)]
    rows: dict[int, Signal] = {
        E: combined((1 / parameters["inertia"], torque)),
        P: combined((1 / plant.lag, combined((1, asked), (-1, p)))),
        X: combined((-trim.nu, error)),
        S: rate,
        SEEN: combined((machine.observer_inertia, known), (machine.l1, apart)),
        Z: combined((machine.l2, apart)),
        ETA: combined((moved, p), (-moved, eta)),
        LATE: combined((moved, y), (-moved, late)),
        Y: r,
        R: combined((-wind.damping, r), (-wind.stiffness, y)),
    }
    if machine.stop:
        w, passed = machine.stop
        first, second = {FIRST: Fraction(1)}, {SECOND: Fraction(1)}
        into += [(-2 * (1 - passed), first), (2 * (1 - passed), second)]
        rows[FIRST] = combined((w, e), (-w, first))
        rows[SECOND] = combined((w, first), (-w, second))
    rows[M] = combined((corner, combined(*into)), (-corner, m))
    n = order(machine)
    return Matrix.of([[rows[i].get(j, Fraction(0)) for j in range(n)] for i in range(n)])
