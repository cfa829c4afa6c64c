"""The effort ramp and its slope, at the ends of the ramp and inside, exactly."""

from __future__ import annotations

from fractions import Fraction

import pytest

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share


@pytest.mark.parametrize(
    ("s", "eps", "value", "slope"),
    [
        ("-3", "2", "0", "0"),
        ("-2", "2", "0", "0"),
        ("-1", "2", "1/8", "1/4"),
        ("0", "2", "1/2", "1/2"),
        ("1", "2", "9/8", "3/4"),
        ("2", "2", "2", "1"),
        ("5/2", "2", "5/2", "1"),
        ("0", "1/3", "1/12", "1/2"),
        ("1/3", "1/3", "1/3", "1"),
        ("-1/3", "1/3", "0", "0"),
    ],
)
def test_values(s: str, eps: str, value: str, slope: str) -> None:
    """(s + eps)^2 / (4 eps) and (s + eps) / (2 eps) inside, 0 below, s and 1 beyond."""
    assert psi(Fraction(s), Fraction(eps)) == Fraction(value)
    assert share(Fraction(s), Fraction(eps)) == Fraction(slope)
