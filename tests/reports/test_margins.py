"""Margins of one loop, and the turbine's loops at a trim."""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.reports.margins.margins import loop_margins
from tests.reports.control_loops import response_of


def ziegler_nichols_loop() -> Any:
    """Process and PI controller of Skogestad & Postlethwaite (2005), section 2.4."""
    s = control.tf("s")
    return 3 * (1 - 2 * s) / ((5 * s + 1) * (10 * s + 1)) * (2.5 / 2.2) * (1 + 1 / (12.7 * s))


def is_stable(loop: Any) -> bool:
    """Whether the loop is stable when closed, from the poles alone."""
    return bool(np.all(control.feedback(loop, 1).poles().real < 0))


def test_textbook_loop_has_the_published_margins_and_peaks() -> None:
    """Skogestad & Postlethwaite (2005), 2.4: GM 1.63, PM 19.4 deg, M_s 3.92, M_t 3.35, w_B 0.14."""
    found = loop_margins(response_of(ziegler_nichols_loop()))

    assert found.stable
    assert found.gain_increase == pytest.approx(1.63, abs=0.006)
    assert np.degrees(found.phase) == pytest.approx(19.4, abs=0.06)
    # The book's controller gain is printed to three figures; the peaks move by 0.02 within that.
    assert found.sensitivity_peak == pytest.approx(3.92, abs=0.02)
    assert found.complementary_peak == pytest.approx(3.35, abs=0.02)
    assert found.bandwidth == pytest.approx(0.14, abs=0.005)
    assert found.gain_decrease == 0


@settings(derandomize=True, max_examples=20, deadline=None)
@given(gain=st.floats(0.01, 100.0))
def test_integrator_has_ninety_degrees_and_a_quarter_turn_of_delay(gain: float) -> None:
    """L = k/s: crossover k, phase margin pi/2, delay margin pi/(2k), M_s = 1, no gain margin."""
    found = loop_margins(response_of(control.tf(gain, [1, 0])))

    assert found.crossover == pytest.approx(gain, rel=1e-9)
    assert found.phase == pytest.approx(np.pi / 2, rel=1e-9)
    assert found.delay == pytest.approx(np.pi / 2 / gain, rel=1e-9)
    assert found.sensitivity_peak == pytest.approx(1.0, abs=1e-3)
    assert found.bandwidth == pytest.approx(gain, rel=1e-9)
    assert (found.gain_decrease, found.gain_increase) == (0.0, np.inf)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(
    gain=st.floats(0.1, 20.0),
    lag=st.floats(0.05, 5.0),
    frequency=st.floats(0.5, 10.0),
    damping=st.floats(0.02, 1.5),
)
def test_margins_agree_with_the_polynomial_method(
    gain: float, lag: float, frequency: float, damping: float
) -> None:
    """python-control finds the same margins from polynomial roots, where the loop is stable."""
    mode = control.tf(frequency**2, [1, 2 * damping * frequency, frequency**2])
    loop = control.tf(gain, [lag, 1]) * mode
    found = loop_margins(response_of(loop))

    assert found.stable == is_stable(loop)
    if not found.stable:
        assert (found.gain_increase, found.phase, found.delay, found.disk.alpha) == (1, 0, 0, 0)
        assert found.sensitivity_peak == np.inf
        return
    gains, phases, _, _, _, _ = control.stability_margins(loop, returnall=True)
    upward = [factor for factor in gains if factor > 1]
    assert found.gain_increase == pytest.approx(min(upward, default=np.inf), rel=1e-6)
    if len(phases):
        assert np.degrees(found.phase) == pytest.approx(np.min(np.abs(phases)), rel=1e-5, abs=1e-5)


def test_unstable_plant_has_a_gain_it_may_not_fall_below() -> None:
    """L = 2/(s - 1): 1 + g L = 0 at s = 0 for g = 1/2; |L| = 1 at sqrt 3, 60 degrees away."""
    found = loop_margins(response_of(control.tf(2, [1, -1])))

    assert found.stable
    assert found.gain_decrease == pytest.approx(0.5, rel=1e-12)
    assert found.gain_decrease_frequency == 0
    assert found.phase == pytest.approx(np.pi / 3, rel=1e-9)
