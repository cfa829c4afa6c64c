"""At which winds a joint analysis fails: three causes, told apart."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.claims.turbine.failing_winds import failing_winds
from takagi.models import Interval
from takagi.models.laws.effort_sharing import LoopCell


def cell(
    low: float,
    *,
    loop_gain: tuple[str, str] = ("0.5", "0.6"),
    integral_rate: str = "0.1",
    share_gain: tuple[str, str] = ("0", "0"),
) -> LoopCell:
    """A loop from one wind to the next half metre per second; torque alone acts unless told."""
    none = Fraction(0)
    return LoopCell(
        wind=Interval.of(low, low + 0.5),
        wind_rate=none,
        stiffness=Interval.of("-0.05"),
        loop_gain=Interval.of(*loop_gain),
        lag_gain=Interval.of("0.2"),
        share_gain=Interval.of(*share_gain),
        lag_rate=Interval.of("5"),
        integral_rate=Interval.of(integral_rate),
        effectiveness_limit=Interval.of("0.1"),
        residual=none,
        wind_gain=none,
        inertia_gain=Fraction(1),
        effectiveness_slope=none,
        reference_slope=none,
        lag_disturbance=none,
        pitch_rate=none,
    )


def test_an_unstable_wind_is_named() -> None:
    """A loop gain of the wrong sign: no LMI is needed to see it, and the worst wind is told."""
    told = failing_winds([cell(8.0), cell(8.5, loop_gain=("-0.3", "0.6")), cell(9.0)])

    assert "unstable in 1 of 3 wind cells (8.5 to 9 m/s)" in told
    assert "worst at wind 8.5 to 9 m/s" in told


def test_a_wind_without_a_function_of_its_own_is_named() -> None:
    """Gains from 0.002 to 50 with a fast integral: each corner is stable, together they are not."""
    torn = cell(8.5, loop_gain=("0.002", "50"), integral_rate="30")

    assert "at wind 8.5 to 9 m/s alone" in failing_winds([cell(8.0), torn])


def test_winds_that_do_not_share_a_function_are_named() -> None:
    """Each wind has its function; a loop a thousand times faster in its integral shares none."""
    slow = cell(8.0, loop_gain=("0.05", "0.05"), integral_rate="0.001")
    fast = cell(9.0, loop_gain=("0.05", "0.05"), integral_rate="60")

    told = failing_winds([slow, cell(8.5, loop_gain=("0.05", "0.05")), fast])

    assert "every wind has its quadratic function" in told and "winds up to" in told


def test_what_is_left_is_the_set_s_size() -> None:
    """Where one function serves all winds, the box or the wind class stands in the way."""
    assert "does not stay inside the box" in failing_winds([cell(8.0), cell(8.5)])
