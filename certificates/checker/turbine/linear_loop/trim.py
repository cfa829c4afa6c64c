r"""Turbine and law at the trim of one wind v, as exact rational numbers.

With omega*, q*, b, gamma, ... the law's tables at v, which are lines between nodes, beta* =
beta_min + psi(q*)/b, lambda = R omega*/v, c the torque constant over the inertia J, and C the
coefficient c_Q at (lambda, beta*):

    a = c R v C_lambda     sigma = -c v^2 C_beta     d = c v (2 C - lambda C_lambda)
    h = max(0, effectiveness_limit - sigma)          F = psi'(q*)
    beta*' = (F q*' - psi(q*) b'/b)/b
    residual = c v^2 C - n_g (T_rated - E psi(-q*))/J

The loop is differentiable there, which is tested: v lies between two nodes and within the limits of
the estimate, torque is above 0 and below its rated value or no feed-forward acts on it, pitch is
below its limit.  At its lower limit the law's pitch is constant: psi and its slope are 0.  The trim
is not at an edge of the table, where c_Q has slopes to one side; constant pitch may be.  The
residual is at most a tenth of the overlap eps: where the table's torques are further apart, the
loop rests at another effort, with another share F, or not at all.

Derived in docs/turbine-crossing.md.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.spline_point import ExactSurface
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.inputs import Machine

NIL = Fraction(0)
# The largest residual at a trim, as a share of the overlap.
APART = Fraction(1, 10)


@dataclass(frozen=True, kw_only=True)
class Trim:
    """The module's numbers.

    Attributes
    ----------
    wind : v [m/s].
    damping, effectiveness, by_wind : a, sigma, d, the torque's slopes over J.
    late : h, by how much the law's limit is above sigma.
    effort_unit : n_g E / J.
    share : F;  speed_slope, effort_slope : omega*', q*';  pitch_slope : beta*'.
    pitch_gain : F/b;  pitch_bend : psi b'/b^2;  gamma, nu : of the law.
    ahead : f of the torque's feed-forward;  lead : tau_lead beta*'.
    residual : the torques at the trim over J [rad/s^2].
    """

    wind: Fraction
    damping: Fraction
    effectiveness: Fraction
    by_wind: Fraction
    late: Fraction
    effort_unit: Fraction
    share: Fraction
    speed_slope: Fraction
    effort_slope: Fraction
    pitch_slope: Fraction
    pitch_gain: Fraction
    pitch_bend: Fraction
    gamma: Fraction
    nu: Fraction
    ahead: Fraction
    lead: Fraction
    residual: Fraction


def trim_at(
    plant: Plant, law: Law, machine: Machine, surface: ExactSurface, wind: Fraction
) -> Trim:
    """Return the numbers at a wind.

    Raises
    ------
    Refused : the loop has no derivative there, or the trim leaves the coefficient table.
    """
    nodes = law.wind
    k = bisect_left(nodes, wind) - 1
    if not 0 <= k < len(nodes) - 1 or wind == nodes[k + 1]:
        raise Refused("the wind is not between two nodes of the law's tables")
    if not machine.wind_limits[0] < wind < machine.wind_limits[1]:
        raise Refused("the wind is not within the limits of the estimate")
    speed, q, b, limit, gamma = (
        column[k] + law.slope(column, k) * (wind - nodes[k])
        for column in (law.speed, law.effort, law.effectiveness, law.limit, law.gamma)
    )
    shed, braked = psi(q, law.overlap), psi(-q, law.overlap)
    F, ahead = share(q, law.overlap), law.inertia[k]
    torque = law.rated_torque - law.effort_torque * braked
    if torque <= 0:
        raise Refused("torque is at zero at the trim")
    if ahead and (braked == 0 or law.inertia_limit[k] == 0):
        raise Refused("the feed-forward of the torque is at a limit at the trim")
    pitch = law.pitch_min + shed / b
    if pitch >= law.pitch_max:
        raise Refused("pitch is at its upper limit at the trim")
    ratio = plant.radius * speed / wind
    x, y = surface.x_knots, surface.y_knots
    if ratio in (x[0], x[-1]) or (shed and pitch in (y[0], y[-1])):
        raise Refused("the trim is at the edge of the coefficient table")
    C, by_ratio, by_pitch = surface.at(ratio, pitch)
    c, unit = plant.torque_per_inertia, plant.gear_per_inertia
    residual = c * wind**2 * C - unit * torque
    if abs(residual) > APART * law.overlap:
        raise Refused("there is no trim: the torques differ by over a tenth of the overlap")
    sigma = -c * wind**2 * by_pitch
    bend = shed * law.slope(law.effectiveness, k) / b**2
    turned = F * law.slope(law.effort, k) / b - bend
    return Trim(
        wind=wind,
        damping=c * plant.radius * wind * by_ratio,
        effectiveness=sigma,
        by_wind=c * wind * (2 * C - ratio * by_ratio),
        late=max(limit - sigma, NIL),
        effort_unit=unit * law.effort_torque,
        share=F,
        speed_slope=law.slope(law.speed, k),
        effort_slope=law.slope(law.effort, k),
        pitch_slope=turned,
        pitch_gain=F / b,
        pitch_bend=bend,
        gamma=gamma,
        nu=law.nu[k],
        ahead=ahead,
        lead=law.lead * turned,
        residual=residual,
    )
