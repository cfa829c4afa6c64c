"""The ramp by which two actuators share one effort, with FLINT's rationals."""

from __future__ import annotations

from flint import fmpq

ZERO, FULL = fmpq(0), fmpq(1)


def ramp(s: fmpq, eps: fmpq) -> fmpq:
    """Return psi: 0 for s <= -eps, (s + eps)^2 / (4 eps) between, s for s >= eps."""
    if -eps < s < eps:
        return (s + eps) ** 2 / (4 * eps)
    return max(s, ZERO)


def ramp_slope(s: fmpq, eps: fmpq) -> fmpq:
    """Return F = psi', which is in [0, 1] and does not decrease."""
    return max(ZERO, min(FULL, (s / eps + 1) / 2))


def ramp_secant(s: fmpq, rest: fmpq, eps: fmpq) -> fmpq:
    """Return the secant slope of psi from ``rest`` to s; where they are equal, F."""
    return ramp_slope(s, eps) if s == rest else (ramp(s, eps) - ramp(rest, eps)) / (s - rest)
