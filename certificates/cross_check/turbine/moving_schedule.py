r"""The effect of a schedule wind with rate up to rho in one cell, after the feed-forward.

Let N = F(U) (q*' + gamma' s) - psi(U) b'/b, |s| <= box, and theta the lead divided by the pitch
drive's tau.  The stated numbers of a cell must enclose:

    T    in [h, 1] / tau,  h = min(1, (limit - theta rho |N / b|) b tau / zeta)
    |b'/b|,  |omega*' - kappa m mu f|  with mu from min(1, g / |f| rho, psi(-U_high) / |f| rho)
    |w_zeta| <= max(|1 - theta| rho |N|, sup(rho |N| - psi(U) / tau))

Torque must stay above 0, and the pitch command below the largest pitch.  Derived in
docs/effort-sharing-loop.md, sections Speed, Effort lag and Invariance.
"""

from __future__ import annotations

from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.obligation import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import rational, rationals
from takagi.certificates.cross_check.turbine.effort_ramp import ramp
from takagi.certificates.cross_check.turbine.numbers import WindCell
from takagi.certificates.cross_check.turbine.surface import NumberRange

ZERO, FULL = fmpq(0), fmpq(1)


def schedule(at: WindCell, cell: Any, label: str) -> Obligations:
    """Yield that the stated numbers of a cell enclose the effects of a moving schedule wind."""
    turbine, rho = at.turbine, rational(cell, "wind_rate")
    yield Fact(f"{label}: wind rate", rho >= 0)
    tau, theta = turbine.drive, turbine.lead / turbine.drive
    N = asked_slope(at)
    led = theta * rho * (N / at.b).size
    room = (turbine.rate_limit - led) * at.b.low * tau / turbine.effort_lag
    yield Fact(f"{label}: the lead is below the pitch rate limit", room > 0)
    low, high = rationals(cell, "lag_rate", 2)
    yield Fact(f"{label}: range of lag_rate", low <= min(FULL, room) / tau <= FULL / tau <= high)

    turning = abs(at.slope(turbine.effectiveness)) / at.b.low
    left = abs(FULL - theta) * rho * N.size
    if theta > 0:
        left = max(left, _cut(at, rho, turning))
    for name, size in (
        ("effectiveness_slope", turning),
        ("reference_slope", _left_of_reference(at, rho)),
        ("lag_disturbance", left),
    ):
        yield Fact(f"{label}: size of {name}", size <= rational(cell, name))

    reach = min(abs(turbine.ahead[at.k]) * rho, turbine.ahead_limit[at.k])
    relief = ramp(-at.efforts.low, turbine.overlap) + reach
    yield Fact(f"{label}: torque above 0", turbine.torque >= turbine.per_effort * relief)
    pitch = turbine.pitch_min + at.shed.high / at.b.low + tau * led
    yield Fact(f"{label}: pitch asked for below its limit", pitch <= turbine.pitch_max)


def asked_slope(at: WindCell) -> NumberRange:
    """Return the range of N."""
    turbine = at.turbine
    s = NumberRange(-turbine.speed_signal, turbine.speed_signal)
    q1, b1 = at.slope(turbine.effort), at.slope(turbine.effectiveness)
    moved = s.times(at.slope(turbine.proportional)) + NumberRange(q1, q1)
    return at.share * moved - at.shed * (NumberRange(b1, b1) / at.b)


def _left_of_reference(at: WindCell, rho: fmpq) -> fmpq:
    """Return the largest |omega*' - kappa m mu f|, at an end of kappa mu."""
    turbine = at.turbine
    f, mu = turbine.ahead[at.k], FULL
    if f != 0 and rho > 0:
        spare = ramp(-at.efforts.high, turbine.overlap)
        mu = min(FULL, turbine.ahead_limit[at.k] / abs(f * rho), spare / abs(f * rho))
    through = NumberRange(at.kappa.low * mu, at.kappa.high)
    w1 = at.slope(turbine.speed)
    return (NumberRange(w1, w1) - through.times(turbine.m * f)).size


def _cut(at: WindCell, rho: fmpq, turning: fmpq) -> fmpq:
    """Return the supremum over U of A F - c psi, or 0 where it is negative.

    c = 1/tau - rho |b'/b|; it bounds w_zeta where the lower pitch limit cuts off the lead.  On the
    ramp psi = eps F^2; beyond it F = 1 and psi = U.
    """
    turbine, eps = at.turbine, at.turbine.overlap
    moved = abs(at.slope(turbine.effort))
    moved += abs(at.slope(turbine.proportional)) * turbine.speed_signal
    A, c = rho * moved, 1 / turbine.drive - rho * turning
    F = at.share
    if c <= 0:
        return max(ZERO, A * F.high - c * at.shed.high)
    if at.efforts.low >= eps:
        return max(ZERO, A - c * at.shed.low)
    # A parabola in F that opens downward is largest at its top, or at the end next to the top.
    top = max(F.low, min(F.high, A / (2 * c * eps)))
    return max(ZERO, A * top - c * eps * top**2)
