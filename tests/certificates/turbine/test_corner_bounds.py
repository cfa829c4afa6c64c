"""The corners of a wind cell: what a moving schedule adds, and which way bounds are rounded."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.corners import BOUNDS, Corners, Stated

# A cell without a residual whose one free coefficient is the lag's rate T.  P was searched for:
# it decreases along the loop for T from 0.5 to 1 1/s, and not for T = 1.5 1/s.
COEFFICIENTS = {"stiffness": "-0.2", "loop_gain": "0.5", "lag_gain": "0.1", "share_gain": "-0.6"}
INTEGRAL_RATE = Fraction("0.2")
ROWS = (("4.25", "3.6", "-1.59"), ("3.6", "3.96", "-0.89"), ("-1.59", "-0.89", "5.81"))
P = Matrix.of([[Fraction(entry) for entry in row] for row in ROWS])
ALPHA = Fraction("0.01")


def corners(lag_rate: tuple[str, str], **sizes: str) -> Stated:
    """Return the cell with a range of T [1/s] and the sizes that are not zero."""
    stated = {name: [Fraction(value)] * 2 for name, value in COEFFICIENTS.items()}
    stated["lag_rate"] = [Fraction(value) for value in lag_rate]
    bounds = {name: Fraction(sizes.get(name, "0")) for name in BOUNDS}
    bounds |= {"integral_rate": INTEGRAL_RATE, "multiplier": ALPHA, "decay_rate": Fraction(0)}
    return Stated(stated, bounds, "cell")


def decided(cell: Stated, error: Any = 0, rate: Any = 0) -> str:
    """Return what fails in a wind class."""
    class_ = {"wind_error": Fraction(error), "wind_rate": Fraction(rate)}
    return first_failure(Corners(replace(cell, sizes=cell.sizes | class_)).obligations(P))


def test_a_moving_schedule_raises_the_lags_rate_too() -> None:
    """T - (b'/b) v_s' has both signs: its upper end, 1.5 1/s here, is not in the decreasing set."""
    turning = {"effectiveness_slope": "0.5"}

    assert decided(corners(("0.5", "1")), rate=1) == ""
    assert decided(corners(("1", "1"), **turning), rate=0) == ""
    assert "invariance" in decided(corners(("1", "1"), **turning), rate=1)
    assert "invariance" in decided(corners(("0.75", "0.75"), **turning), rate="1.5")


def test_a_range_of_lags_is_widened_at_both_ends() -> None:
    """From 0.6 - 0.5 to 1 + 0.5 1/s; taken inward it would be 0.5 to 1.1 1/s, where V falls."""
    turning = {"effectiveness_slope": "0.5"}

    assert decided(corners(("0.6", "1")), rate=1) == ""
    assert "invariance" in decided(corners(("0.6", "1"), **turning), rate=1)


def test_a_moving_schedule_lowers_the_lags_rate() -> None:
    """The other end: 0.9 - 1.2 < 0 makes the lag unstable."""
    turning = {"effectiveness_slope": "1.2"}

    assert decided(corners(("0.9", "0.9"), **turning), rate="0.05") == ""
    assert "invariance" in decided(corners(("0.9", "0.9"), **turning), rate=1)


@pytest.mark.parametrize("part", ["wind error", "wind rate", "turning", "lag disturbance"])
def test_disturbances_are_rounded_up(part: str) -> None:
    """Half a unit of the seventh decimal beyond the largest that the set withstands.

    So is (b'/b) v_s', by which a moving schedule turns the lag.
    """

    def failing(units: Fraction) -> str:
        size = units / 10**7
        if part == "wind error":
            found = corners(("1", "1"), inertia_gain="1", wind_gain="1")
            return decided(found, error=size)
        if part == "wind rate":
            found = corners(("1", "1"), reference_slope="1")
            return decided(found, rate=size)
        if part == "turning":
            return decided(corners(("1", "1"), effectiveness_slope="1"), rate=size)
        return decided(corners(("1", "1"), lag_disturbance=str(size)))

    low, high = 0, 10**7
    assert failing(Fraction(low)) == "" and failing(Fraction(high))
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if failing(Fraction(middle)) else (middle, high)

    assert failing(Fraction(low)) == ""
    assert "invariance" in failing(low + Fraction(1, 1000))
    assert "invariance" in failing(low + Fraction(1, 2))


def test_the_rest_is_rounded_outward() -> None:
    """P_33 (kappa r)^2 < Gamma^2 with r rounded up: at the last unit that is inside, not beyond."""
    P33, unit = P[2, 2], Fraction(1, 10**7)
    r = Fraction(0)
    step = Fraction(1)
    while step >= unit:
        while P33 * (r + step) ** 2 < Fraction(COEFFICIENTS["loop_gain"]) ** 2:
            r += step
        step /= 10

    def failing(residual: Fraction) -> str:
        return decided(corners(("1", "1"), inertia_gain="1", residual=str(residual)))

    assert "equilibrium" not in failing(r)
    assert "equilibrium" in failing(r + unit / 2)
