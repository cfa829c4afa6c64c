"""The least margins by eigenvalues agree with margins that are known exactly."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest

from takagi.reports.margins import RunningLoop, broken_loops, least_margins, loop_margins


def two_loops(torque: float, pitch: float, pole: float = 1.0) -> RunningLoop:
    """x+ = pole x + u, u = -k x in each of two loops that do not meet: the pole is at pole - k."""
    gains = np.diag([torque, pitch])
    return RunningLoop(
        wind=12.0,
        sample_time=0.02,
        A=pole * np.eye(2),
        B=np.eye(2),
        C=gains,
        scale=np.ones(2),
        kinks=(),
        rest=cast(Any, None),
    )


def kinds(loop: RunningLoop) -> set[tuple[str, str]]:
    return {(one.kind, one.command) for one in least_margins.small_margins(loop)}


@pytest.mark.parametrize(("k", "small"), [(2 / 1.19, True), (2 / 1.21, False)])
def test_the_gain_margin_of_an_integrator(k: float, small: bool) -> None:
    """x+ = x - k x is stable up to k = 2: the gain margin is 2/k, on both sides of 1.2."""
    assert least_margins.LEAST_GAIN == 1.2
    assert (("gain", "pitch") in kinds(two_loops(0.5, k))) is small
    assert (("gain", "torque") in kinds(two_loops(k, 0.5))) is small
    assert ("gain", "torque") not in kinds(two_loops(0.5, k))


@pytest.mark.parametrize(("k", "small"), [(1.19, True), (1.21, False)])
def test_a_gain_that_may_not_fall(k: float, small: bool) -> None:
    """x+ = 2 x - k x needs k above 1."""
    assert (("gain", "torque") in kinds(two_loops(k, 1.5, pole=2.0))) is small


@pytest.mark.parametrize(("degrees", "small"), [(9.0, True), (11.0, False)])
def test_the_phase_margin_of_an_integrator(degrees: float, small: bool) -> None:
    """k/(z - 1) has |L| = 1 where sin(omega T/2) = k/2, and the phase margin 90 deg - omega T/2."""
    k = 2 * math.sin(math.pi / 2 - math.radians(degrees))
    loop = two_loops(0.1, k)
    margins = loop_margins(broken_loops(loop).pitch)

    assert math.degrees(margins.phase) == pytest.approx(degrees)
    assert (("phase", "pitch") in kinds(loop)) is small
    assert math.isclose(least_margins.LEAST_PHASE, math.radians(10))


@pytest.mark.parametrize(("k", "small"), [(0.99, False), (1.01, True)])
def test_one_sample_later(k: float, small: bool) -> None:
    """z^2 - z + k = 0 has its roots inside the circle up to k = 1."""
    assert (("delay", "torque and pitch") in kinds(two_loops(k, 0.1))) is small


def test_what_is_worse_has_a_smaller_share() -> None:
    found = {one.kind: one.share for one in least_margins.small_margins(two_loops(0.1, 2 / 1.02))}
    later = {one.kind: one.share for one in least_margins.small_margins(two_loops(0.1, 2 / 1.19))}

    assert found["gain"] == 0.25 and later["gain"] == 1.0
