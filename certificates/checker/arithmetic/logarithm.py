"""log, the hyperbolic functions and erf, at points and on intervals; see ``elementary``."""

from __future__ import annotations

from math import isqrt

from takagi.certificates.checker.arithmetic.exponential import FINE, LARGEST, exp_at
from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.arithmetic.monotone import PAD, PI_FINE, increasing
from takagi.certificates.checker.kernel.refusal import Refused

ERF_ENDS = 10 * FINE  # beyond 10, erf is 1 to within e^-100 < 10^-43


def log_at(x: int) -> tuple[int, int]:
    """Return a bracket of log(x) = log(m) + k log 2 with m in [1/2, 2]."""
    if x <= 0:
        raise Refused("log of what may not be positive")
    k = x.bit_length() - FINE.bit_length()
    m = x >> k if k >= 0 else x << -k
    # Shifting right drops less than one unit of m >= 1/2: two units of the logarithm.
    value = 2 * _artanh_small((m - FINE) * FINE // (m + FINE)) + 2 * k * _artanh_small(FINE // 3)
    pad = PAD * (2 + 2 * abs(k))
    return value - pad, value + pad


def _artanh_small(u: int) -> int:
    """Return sum u^(2 i + 1) / (2 i + 1) for |u| <= 1/3, to within PAD / 2."""
    sign, power = (-1 if u < 0 else 1), abs(u)
    square, total, n = power * power // FINE, 0, 1
    while power:
        total += power // n
        power = power * square // FINE
        n += 2
    return sign * total


def _of_exp(x: int) -> tuple[int, int, int, int]:
    """Return brackets of e^x and of e^-x for x >= 0."""
    low, high = exp_at(x)
    return low, high, FINE * FINE // high, -(-FINE * FINE // low)


def sinh_at(x: int) -> tuple[int, int]:
    if x < 0:
        low, high = sinh_at(-x)
        return -high, -low
    low, high, under, over = _of_exp(x)
    return (low - over) // 2, -(-(high - under) // 2)


def hyperbolic_cosine(a: Interval) -> Interval:
    """Return cosh, which is least at 0."""
    low, high = increasing(_cosh_at, ONE)(Interval(a.least(), a.magnitude()))
    return Interval(max(ONE, low), high)


def _cosh_at(x: int) -> tuple[int, int]:
    low, high, under, over = _of_exp(x)
    return (low + under) // 2, -(-(high + over) // 2)


def hyperbolic_tangent(a: Interval) -> Interval:
    """Return tanh, within [-1, 1]."""
    low, high = increasing(_tanh_at)(a)
    return Interval(max(low, -ONE), min(high, ONE))


def _tanh_at(x: int) -> tuple[int, int]:
    """Return a bracket of tanh x = 1 - 2 / (e^(2 x) + 1)."""
    if x < 0:
        low, high = _tanh_at(-x)
        return -high, -low
    if 2 * x > LARGEST:
        return FINE - 1, FINE
    low, high = exp_at(2 * x)
    return FINE - -(-2 * FINE * FINE // (low + FINE)), FINE - 2 * FINE * FINE // (high + FINE)


def asinh_at(x: int) -> tuple[int, int]:
    """Return a bracket of asinh x = log(x + sqrt(x^2 + 1)), x >= 0, and odd."""
    if x < 0:
        low, high = asinh_at(-x)
        return -high, -low
    argument = x + isqrt(x * x + FINE * FINE)
    return log_at(argument)[0], log_at(argument + 1)[1]


def acosh_at(x: int) -> tuple[int, int]:
    """Return a bracket of acosh x = log(x + sqrt(x^2 - 1))."""
    if x < FINE:
        raise Refused("acosh below 1")
    argument = x + isqrt(x * x - FINE * FINE)
    return log_at(argument)[0], log_at(argument + 1)[1]


def atanh_at(x: int) -> tuple[int, int]:
    """Return a bracket of atanh x = log((1 + x) / (1 - x)) / 2."""
    if abs(x) >= FINE:
        raise Refused("atanh of what may reach 1")
    argument = (FINE + x) * FINE // (FINE - x)
    if argument <= 0:
        raise Refused("atanh of what may reach -1")
    return log_at(argument)[0] // 2, -(-log_at(argument + 1)[1] // 2)


def error_function(a: Interval) -> Interval:
    """Return erf, within [-1, 1]."""
    low, high = increasing(_erf_at)(a)
    return Interval(max(low, -ONE), min(high, ONE))


def _erf_at(x: int) -> tuple[int, int]:
    """Return a bracket of erf x = 2/sqrt(pi) e^(-x^2) sum_n 2^n x^(2n+1) / (1 3 ... (2n+1))."""
    if x < 0:
        low, high = _erf_at(-x)
        return -high, -low
    if x > ERF_ENDS:
        return FINE - FINE // 10**43, FINE
    square = x * x // FINE
    total, term, n = 0, x, 0
    while term:
        total += term
        n += 1
        term = term * 2 * square // (FINE * (2 * n + 1))
    # x <= 10: below 1000 terms, the largest below e^100 x; each carries the rounding of x^2 and of
    # its own divisions, fewer than 1000 units relative to FINE, so that 10^7 bounds them all.
    total_above = total + total * 10**7 // FINE + 10**7
    # Over e^(x^2), not times e^(-x^2), of which few digits are left on the grid.
    over, under = exp_at(square + 1)[1], exp_at(square)[0]
    front = isqrt(4 * FINE**3 // PI_FINE)  # 2 / sqrt(pi) FINE, to within two units
    return total * (front - 2) // over, -(-total_above * (front + 2) // under)
