r"""``turbulence-speed``: turbulence drives the rotor to a speed with a small probability.

With probability 1 - p the wind stays below v_h (Rice).  Near the speed X the law asks for a torque
that is bounded below at all schedule winds.  The rotor comes near so slowly, and the torque follows
so fast, that at X the generator takes more than the rotor gives.  Symbols and theorem are in
docs/turbulence-speed.md.
"""

from __future__ import annotations

from typing import Any

from flint import arb, ctx, fmpq

from takagi.certificates.cross_check.kernel.obligation import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import Refusal, entry, rational, rationals
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.overspeed.asked import Asked
from takagi.certificates.cross_check.turbine.overspeed.driven import driven, driven_at_all
from takagi.certificates.cross_check.turbine.running.machine import same_controller
from takagi.certificates.cross_check.turbine.surface import Outside

BITS = 256  # of the balls
POSITIVE = ("highest_wind", "least_estimate", "window", "speed", "horizon", "probability")
STEPS = 16


def seldom_reached(claim: Any, document: Any) -> Obligations:
    """Yield the conditions of the theorem."""
    model, gains = entry(document, "model"), entry(document, "gains")
    rotor, tau = Rotor(model, gains), rational(gains, "wind_filter")
    torque_rate = rational(model, "torque_rate_limit")
    top, first, D, X, T, p = (rational(claim, name) for name in POSITIVE)
    U, sigma, rate = (
        rational(entry(claim, "wind"), name) for name in ("mean", "deviation", "rate")
    )
    if min((top, first, D, X, T, p, U, sigma, rate, tau, torque_rate)) <= 0 or p >= 1:
        raise Refusal("a number of the claim or of the loop that is not positive, or p not below 1")
    if D >= X:
        raise Refusal("window: below the speed")
    family = entry(claim, "uncertainty")
    light, heavy = rationals(family, "inertia", 2)
    extra = rational(family, "torque_excess")
    if light <= 0 or heavy < light or extra < 0:
        raise Refusal("inertia: 0 < low <= high; torque_excess: not negative")
    if not same_controller(claim, document, ("measurement",)):
        raise Refusal("filters are not the controller's")
    lag = _lag(entry(claim, "measurement"))

    inside = max(first, rotor.wind[0]) <= U <= rotor.wind[-1]
    yield Fact("the mean wind is a schedule wind", inside)
    yield Fact("the wind keeps its sign", U < top <= 2 * U)
    yield Fact("the rotor starts below the speed", _reference(rotor, U) < X)
    yield Fact("the wind is high by a deviation or more", top - U >= sigma)
    yield Fact("probability", _at_most(top - U, sigma, rate, T, p))

    try:
        asked = Asked(rotor, first)
    except Outside:
        yield Fact("there are schedule winds", False)
        return
    late = lag * (driven_at_all(rotor, top) + extra) / light
    past = (driven(rotor, X - D, X, top) + extra) / light
    yield Fact("the rotor may speed up", past > 0)
    slowly = torque_rate / past
    had = [
        asked.torque(X - late - D * (i + 1) / STEPS) + slowly * D * i / STEPS for i in range(STEPS)
    ]
    braking = rotor.n_over_J * min(slowly * D, *had)
    yield Fact("the generator holds the rotor", driven(rotor, X, X, top) + extra < braking)


def _lag(filters: Any) -> fmpq:
    """Return the integral of 1 less the step response of the filters of the measured speed."""
    corner = rational(filters, "speed_filter")
    if corner <= 0:
        raise Refusal("speed_filter: above 0")
    if "torsion_filter" not in filters:
        return 1 / corner
    stop = filters["torsion_filter"]
    frequency, passed = rational(stop, "frequency"), rational(stop, "passed")
    if frequency <= 0 or passed < 0 or passed > 1:
        raise Refusal("torsion_filter: a positive frequency, and a share from 0 to 1")
    return 1 / corner + 2 * (1 - passed) / frequency


def _reference(rotor: Rotor, wind: fmpq) -> fmpq:
    """Return omega* at a wind of the tables, by the line of an interval that holds it."""
    for k, (a, b) in enumerate(zip(rotor.wind[:-1], rotor.wind[1:], strict=True)):
        if a <= wind <= b:
            found: fmpq = (rotor.speed[k] * (b - wind) + rotor.speed[k + 1] * (wind - a)) / (b - a)
            return found
    # Outside the tables another condition has failed.
    return max(rotor.speed)


def _at_most(b: fmpq, sigma: fmpq, rate: fmpq, T: fmpq, p: fmpq) -> bool:
    """Return whether exp(-xi) (1/sqrt(pi xi) + T rate/(pi sigma)) is certainly at most p."""
    if b <= 0:
        return False
    before, ctx.prec = ctx.prec, BITS
    try:
        xi, pi = arb(b * b / (2 * sigma * sigma)), arb.pi()
        bound = (-xi).exp() * (1 / (pi * xi).sqrt() + arb(T * rate / sigma) / pi)
        return bool(bound <= arb(p))
    finally:
        ctx.prec = before
