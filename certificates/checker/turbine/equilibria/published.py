r"""The equilibria of the loop with a published law at a constant wind, v_hat = v.

One integrator: x' = 0 requires e = 0. At equilibrium pitch is beta = f_1 (k_I^c x - k_p beta) held
to
its range, torque T = phi(u), u = k_I^b x.  With s = u k_I^c / (k_I^b (1 + f_1 k_p))

    beta = max(f_1 s, beta_min),     u = s (1 + f_1 k_p) k_I^b / k_I^c,
    f(s) = T_r(omega_ref, beta, v)/J - n_g phi(u)/J,

one curve that contains every equilibrium, also where f_1 = 0. For s < 0 there is no torque.

Two integrators: e = (u_1 - T)/(tau |k_I^b|) = (u_2 - beta_ref)/(tau |k_I^c|), T = phi(u_1).

    e < 0    u_1 < 0 and u_2 < beta_min: no torque at smallest pitch, T_r = 0
    e = 0    0 <= u_1 = T <= T_p = T_rated - eps_T/2;  beta = beta_min where f_1 < 1
    e > 0    with h = eps_T/2, d = tau |k_I^b| e:  T = T_rated - h (1 - sqrt(min(d, h)/h))^2,
             beta = f_1/(1 - f_1) tau |k_I^c(beta)| e held to its range

The last two join at T = T_p to one curve: s = T - T_p <= 0, then s = e.  Where f_1 = 1 and e = 0
any pitch is at rest with u_2 = beta: if T_r falls between 0 and n_g T_p for an interval of pitch,
each of its points is a rest, a continuum.

Smallest pitch must not be negative (0 <= beta_min), and u is positive for k_I^b, k_I^c < 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.equilibria.one_integrator import OneIntegrator
from takagi.certificates.checker.turbine.equilibria.two_integrators import TwoIntegrators
from takagi.certificates.checker.turbine.equilibria.zero_count import Count, Span
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw


@dataclass(frozen=True)
class PublishedEquilibria:
    """The equilibria at every wind of a cell: their number, or a continuum.

    Attributes
    ----------
    count : zeros of the balance.
    at_trim : whether the one equilibrium is the turbine's trim; None if it is not known.
    continuum : pitches [rad] each of which is at rest at every wind of the cell, if there are.
    """

    count: Count
    at_trim: bool | None = None
    continuum: Span | None = None


def published_equilibria(plant: Plant, law: PublishedLaw, winds: Span) -> PublishedEquilibria:
    """Return the counts for winds in which the reference speed is a line.

    Raises
    ------
    Refused : winds over a bend of the reference speed or outside cut-in to cut-out, a table that is
        left, gains whose signs are not known.
    """
    if not law.cut_in <= winds[0] < winds[1] <= law.cut_out:
        raise Refused("winds outside cut-in to cut-out")
    if law.pitch_min < 0:
        raise Refused("a smallest pitch below 0")
    if any(winds[0] < bend < winds[1] for bend in bends(plant, law)):
        raise Refused("winds over a bend of the reference speed")
    if law.pitch_max <= plant.surface.y.breaks[-1]:  # Pitch may then rest at its limit.
        raise Refused("a largest pitch inside the coefficient table")
    rest: OneIntegrator | TwoIntegrators
    if law.tracking_time is None:
        rest = OneIntegrator(plant, law)
        count = rest.count(winds)
        return PublishedEquilibria(count, rest.at_trim(winds) if count.exact == 1 else None)
    rest = TwoIntegrators(plant, law)
    shares = [rest.share(rest.reference(v)) for v in winds]
    if min(shares) == 1:
        found = rest.continuum(winds)
        if found is None:
            raise Refused("no interval of pitch at rest was found")
        return PublishedEquilibria(Count(2, None, 0, 0, ()), continuum=found)
    if max(shares) == 1:
        raise Refused("a coupling factor f_1 that reaches 1")
    count = rest.count(winds)
    passing = rest.passes(winds)
    return PublishedEquilibria(count, {-1: True, 0: None, 1: False}[passing])


def bends(plant: Plant, law: PublishedLaw) -> list[Fraction]:
    """Return the winds at which the reference speed bends."""
    return [
        speed * plant.radius / ratio
        for speed, ratio in (
            (law.minimum_speed, law.optimal_ratio),
            (law.setpoint, law.optimal_ratio),
            (law.minimum_speed, law.largest_ratio),
            (law.setpoint, law.largest_ratio),
        )
    ]
