r"""``turbulence-speed``: in T s of turbulence the rotor reaches a speed X with probability <= p.

The wind is U + y with y' = r and dr = -(g r + k y) dt + s dW from rest, g > 0; in the stationary
process y has the deviation and r the rms that the claim states.  With probability at least 1 - p
|y| stays below b = highest_wind - U for T (Rice's formula, as in ``crossing-probability``).  With
kappa the greatest nominal over true inertia, D the claim's ``window``, N steps d_i = i D/N, let

    delta = delay kappa (greatest T_r/J at any speed)         omega - omega_m <= delta,
    G     the greatest T_r/J at speeds from X - D to X,      G_X the one at X,
    T(m)  what the law asks for at least while omega_m >= m (``sent``),
    T_X   the least of T(X - d_(i+1) - delta) + rate d_i/(kappa G), and of rate D/(kappa G),

rate the gain file's limit for the torque; ``torque_excess`` is added to the three T_r/J.  When
omega reaches X for the first time, the torque is at least T_X.  So it does not if

    G_X < n_g T_X/J .

Nothing is assumed of the wind estimate but that it is at least ``least_estimate``; a smaller one
ends the claim.  Theorem and proof: docs/turbulence-speed.md.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.kinds.crossing_probability import crossing_bound
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.overspeed.rotor_torque import (
    greatest,
    greatest_at_any_speed,
)
from takagi.certificates.checker.turbine.overspeed.sent import LeastTorque
from takagi.certificates.checker.turbine.overspeed.speed_inputs import StatedSpeed, Turbulence
from takagi.certificates.checker.turbine.running_loop.cell import down

STEPS = 16


def check_turbulence_speed(claim: Any, data: Any, where: str) -> Found:
    """Return the verdict on one claim; ``data`` is the whole file.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    stated = StatedSpeed.read(claim, data, where)
    try:
        failure = speed_failure(stated)
    except Refused as reason:
        failure = str(reason)
    said = {"stated": stated}
    if failure:
        return Found(Verdict.UNDECIDED, "turbulence_speed", said | {"failure": failure})
    return Found(Verdict.PROVED, "turbulence_speed", said)


def speed_failure(stated: StatedSpeed) -> str:
    """Return what is not shown, or nothing."""
    mean, law = stated.wind.mean, stated.law
    if not max(stated.least_estimate, law.wind[0]) <= mean <= law.wind[-1]:
        return "the mean wind is not among the schedule winds"
    if not mean < stated.highest <= 2 * mean:
        return "the highest wind is not between the mean wind and twice that"
    if not speed_at(law, mean) < stated.speed:
        return "the rotor starts at the speed or above"
    bound = probability_bound(stated.wind, stated.highest, stated.horizon)
    if bound is None or bound > stated.probability:
        return "the bound of the probability is above the claim's"
    if not is_held(stated):
        return "the rotor's torque may be above the generator's"
    return ""


def probability_bound(wind: Turbulence, highest: Fraction, horizon: Fraction) -> Fraction | None:
    """Return a bound of the probability that the wind reaches ``highest``.

    None where that is less than a standard deviation above the mean wind.
    """
    b = highest - wind.mean
    if b < wind.deviation:
        return None
    return crossing_bound(
        ratio=b**2 / (2 * wind.deviation**2),
        rate=(wind.rate / wind.deviation) ** 2,
        horizon=horizon,
    )


def is_held(stated: StatedSpeed) -> bool:
    """Return whether the generator's torque is shown to be above the rotor's at the speed."""
    plant, X, D, highest = stated.plant, stated.speed, stated.window, stated.highest
    anywhere = greatest_at_any_speed(plant, highest) + stated.excess
    past = greatest(plant, (X - D, X), highest) + stated.excess
    driving = greatest(plant, (X, X), highest) + stated.excess
    if past <= 0:
        return False
    measured = down(X - stated.delay * stated.kappa * anywhere)
    # How much the torque rises, at its limit, while the rotor gains 1 rad/s.
    steep = down(stated.torque_rate / (stated.kappa * past))
    asked = LeastTorque(stated.law, stated.least_estimate)
    step = D / STEPS
    torque = min(
        steep * D,
        *(asked.above(measured - (i + 1) * step) + steep * i * step for i in range(STEPS)),
    )
    return driving < torque * plant.gear_per_inertia


def speed_at(law: Law, wind: Fraction) -> Fraction:
    """Return omega* at a wind of the tables [rad/s]."""
    k = max(i for i, node in enumerate(law.wind[:-1]) if node <= wind)
    return law.speed[k] + law.slope(law.speed, k) * (wind - law.wind[k])
