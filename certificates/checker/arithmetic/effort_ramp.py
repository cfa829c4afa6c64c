r"""The ramp that shares one effort between two actuators, and its slope.

    psi(s) = 0                      s <= -eps
             (s + eps)^2 / (4 eps)  -eps <= s <= eps
             s                      eps <= s

Both are nondecreasing in s, so their range over an interval is given by its ends.
"""

from __future__ import annotations

from fractions import Fraction


def psi(s: Fraction, eps: Fraction) -> Fraction:
    """Return the effort ramp."""
    if s <= -eps:
        return Fraction(0)
    return s if s >= eps else (s + eps) ** 2 / (4 * eps)


def share(s: Fraction, eps: Fraction) -> Fraction:
    """Return the ramp's slope, in [0, 1]."""
    return min(max((s + eps) / (2 * eps), Fraction(0)), Fraction(1))
