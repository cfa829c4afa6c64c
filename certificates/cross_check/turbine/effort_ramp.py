"""The ramp by which two actuators share one effort, on the second checker's rationals."""

from __future__ import annotations

from flint import fmpq

ZERO, FULL = fmpq(0), fmpq(1)


def ramp(s: fmpq, eps: fmpq) -> fmpq:
    """Return psi: 0 up to -eps, (s + eps)^2 / (4 eps) to eps, s beyond."""
    if -eps < s < eps:
        return (s + eps) ** 2 / (4 * eps)
    return max(s, ZERO)


def ramp_slope(s: fmpq, eps: fmpq) -> fmpq:
    """Return F = psi', which does not fall."""
    return max(ZERO, min(FULL, (s / eps + 1) / 2))


def ramp_secant(s: fmpq, rest: fmpq, eps: fmpq) -> fmpq:
    """Return the slope of psi from ``rest`` to s; F where they are one."""
    return ramp_slope(s, eps) if s == rest else (ramp(s, eps) - ramp(rest, eps)) / (s - rest)
