r"""The frozen wake of a turbine file that states a factor kappa: dP/dbeta at each of its winds v.

    beta* = the largest pitch with k v^2 c_Q(lambda, beta*) = n_g T_rated
    dP/dbeta = kappa omega_rated k v^2 dc_Q/dbeta(lambda, beta*)

    lambda = omega_rated R / v,   k = 1/2 rho pi R^3

The root is searched from the top of the pitch range downwards. The enclosure of c_Q proves that no
piece above it contains a root, so it is the largest one.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, point
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.checker.kernel.reader import number
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused

# Width at which the bisection for the trim pitch ends, in rad: far below any stated decimal.
NARROW = Fraction(1, 2**44)
EDGE = Fraction(1, 10**20)


def scaled_slopes(
    model: Any,
    rated_torque: Fraction,
    spline: Spline,
    stated: tuple[list[Fraction], list[Fraction]],
    path: Path,
) -> list[Fraction]:
    """Return dP/dbeta [W/rad] at each wind of (winds, factors).

    Raises
    ------
    CertificateError : a wind at which no pitch balances rated torque, or outside the table.
    """
    radius, speed = (number(model, key, "model") for key in ("rotor_radius", "rated_rotor_speed"))
    constant = number(model, "torque_constant", "model")
    needed = number(model, "gear_ratio", "model") * rated_torque
    low = number(model, "pitch_min", "model")
    # The table's last knot is rounded in fixed point, so the range stays slightly inside.
    high = min(number(model, "pitch_max", "model"), spline.y.breaks[-1] - EDGE)
    found = []
    for wind, factor in zip(*stated, strict=True):
        try:
            ratio = point(speed * radius / wind)
            pitch = _largest_root(spline, ratio, needed / (constant * wind**2), low, high)
            slope = spline.bounds(ratio, pitch, 0, 1)
        except (Refused, ZeroDivisionError) as error:
            raise CertificateError(
                f"{path}: frozen_wake.factor at {float(wind):g} m/s: {error}"
            ) from error
        found.append(factor * speed * constant * wind**2 * Fraction(sum(slope), 2 * ONE))
    return found


def _largest_root(
    spline: Spline, ratio: Interval, needed: Fraction, low: Fraction, high: Fraction
) -> Interval:
    """Return a short bracket of the largest pitch at which c_Q is not certainly below needed."""
    if not _below(spline, ratio, point(high), needed):
        raise Refused("the largest pitch still leaves too much torque")
    # Pieces to examine, the highest last; a piece that may contain a root is halved.
    waiting = [(low, high)]
    while waiting:
        left, right = waiting.pop()
        if _below(spline, ratio, enclose(left, right), needed):
            continue
        if right - left <= NARROW:
            return enclose(left, right)
        middle = (left + right) / 2
        waiting += [(left, middle), (middle, right)]
    raise Refused("no pitch gives rated torque there; a factor is stated from rated wind on")


def _below(spline: Spline, ratio: Interval, pitch: Interval, needed: Fraction) -> bool:
    """Return whether c_Q is certainly below ``needed`` on the piece."""
    return spline.bounds(ratio, pitch)[1] * needed.denominator < needed.numerator * ONE
