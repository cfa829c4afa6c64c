"""Energy gain together with a decay rate, limits and boxes, against trajectories and blends."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import Design, hinf_pdc
from tests.lmi.performance.disturbed import blends, gain_of, loop, two_rules

pytestmark = pytest.mark.numeric


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_a_decay_rate_holds_besides(sample_time: float | None) -> None:
    model = two_rules(sample_time)
    free = hinf_pdc(model, tolerance=0.05)
    fast = hinf_pdc(model, tolerance=0.05, decay_rate=4.0)

    def slowest(design: Design) -> float:
        poles = [np.linalg.eigvals(loop(model, design.require()[0], h)[0]) for h in blends(2, 8)]
        values = np.concatenate(poles)
        if sample_time is None:
            return float(-values.real.max())
        return float(-np.log(np.abs(values).max()) / sample_time)

    assert slowest(fast) > 4.0 > slowest(free)
    assert gain_of(fast) > 0.99 * gain_of(free)
    assert fast.decay_rate == 4.0


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_limits_hold_for_all_disturbances_of_the_energy(sample_time: float | None) -> None:
    """|u| stays within its limit on the ellipsoid that such disturbances reach, at a price."""
    model = two_rules(sample_time)
    energy = 1.0 if sample_time is None else 1.0 / sample_time
    gains = []
    for limit in (1e3, 3.0, 1.5):
        design = hinf_pdc(model, input_limit=[limit], disturbance_energy=energy)
        K, P = design.require()
        reach = [float(np.sqrt(k @ np.linalg.inv(P) @ k.T)[0, 0]) for k in K]
        assert max(reach) <= limit * (1 + 1e-6)
        gains.append(gain_of(design))

    assert gains[0] == pytest.approx(gain_of(hinf_pdc(model)), rel=2e-2)
    assert gains[0] < gains[1] < gains[2]


@pytest.mark.parametrize("sample_time", [None, 0.1])
@pytest.mark.parametrize("energy", [None, 2.0])
def test_the_function_stores_no_more_than_the_disturbance_gives(
    sample_time: float | None, energy: float | None
) -> None:
    """V with P as handed out, in the model's units: gamma |w|^2 - |z|^2 / gamma bounds its growth.

    With limits |w|^2 / W - |z|^2 / (W gamma^2), so that x' P x <= 1 up to an energy of W.
    """
    model = two_rules(sample_time)
    if energy is None:
        design = hinf_pdc(model, tolerance=0.01)
        given, shown = gain_of(design), 1 / gain_of(design)
    else:
        total = energy if sample_time is None else energy / sample_time
        design = hinf_pdc(model, tolerance=0.01, input_limit=[4.0], disturbance_energy=total)
        given, shown = 1 / total, 1 / (total * gain_of(design) ** 2)
    K, P = design.require()
    tight = -np.inf
    for h in blends(2, 6):
        A, E, C = loop(model, K, h)
        state = A.T @ P + P @ A if sample_time is None else A.T @ P @ A - P
        cross = P @ E if sample_time is None else A.T @ P @ E
        noise = np.zeros((1, 1)) if sample_time is None else E.T @ P @ E
        F = np.block([[state + shown * C.T @ C, cross], [cross.T, noise - given * np.eye(1)]])
        scale = 1 / np.sqrt(np.abs(np.diag(F)))
        tight = max(tight, float(np.linalg.eigvalsh(F * np.outer(scale, scale))[-1]))

    assert -0.2 < tight < 0


def test_limits_that_the_disturbance_breaks_are_a_reasoned_no() -> None:
    no = hinf_pdc(two_rules(), input_limit=[0.8], disturbance_energy=1.0)

    assert no.status == "infeasible"
    assert no.gains is None and no.gain is None
    assert "gains keep the limits without disturbance" in no.answer.diagnosis
    assert "the no rests on rule 2 of 2" in no.answer.diagnosis
    assert hinf_pdc(two_rules(), input_limit=[0.8], disturbance_energy=0.25).found


def test_state_and_initial_boxes_are_kept() -> None:
    design = hinf_pdc(
        two_rules(), disturbance_energy=0.1, initial_box=[0.3, 0.3], state_box=[1.0, 2.0]
    )
    _, P = design.require()
    corner = np.array([0.3, 0.3])

    assert corner @ P @ corner <= 1 + 1e-6
    assert np.all(np.diag(np.linalg.inv(P)) <= np.array([1.0, 4.0]) * (1 + 1e-6))


def test_a_gain_bound_is_kept_at_a_price() -> None:
    model = two_rules()
    free = hinf_pdc(model)
    bounded = hinf_pdc(model, gain_bound=20.0)
    norms = np.linalg.norm(bounded.require()[0], 2, axis=(1, 2))

    assert norms.max() <= 20.0
    assert gain_of(bounded) > gain_of(free)
