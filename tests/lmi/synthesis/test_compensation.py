"""Gains by parallel distributed compensation: relaxations, limits, a reasoned no."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import h2_pdc, hinf_pdc, lqr_pdc, observer, pdc
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import blended_rates, pendulum, tanaka_wang_rules

ALL = ("common-gain", "wang-tanaka-griffin", "tanaka-wang", "tuan", "kim-lee", "liu-zhang")


@pytest.mark.parametrize("relaxation", [*ALL, "polya-0", "polya-3"])
def test_two_rules_have_gains_by_every_relaxation(relaxation: str) -> None:
    """Tanaka and Wang (2001), page 58: feasible, even with one gain; decay holds for all blends."""
    model = tanaka_wang_rules()
    design = pdc(model, decay_rate=0.5, relaxation=relaxation)

    assert design.gains is not None and design.gains.shape == (2, 1, 2)
    assert blended_rates(model, design).min() >= 0.5
    if relaxation == "common-gain":
        np.testing.assert_array_equal(design.gains[0], design.gains[1])


def test_limits_hold_on_the_ellipsoid() -> None:
    """|K_i x| <= 300 on x' P x <= 1, which holds the initial box and lies in the state box."""
    box = np.array([0.3, 0.5])
    design = pdc(
        pendulum(), decay_rate=0.5, input_limit=[300.0], initial_box=box, state_box=[1.0, np.inf]
    )
    K, P = design.require()
    Q = np.linalg.inv(P)

    assert np.sqrt(np.diagonal(K @ Q @ K.transpose(0, 2, 1), axis1=1, axis2=2)).max() <= 300
    assert np.sqrt(Q[0, 0]) <= 1
    for corner in (box, box * [1, -1]):
        assert corner @ P @ corner <= 1
    assert blended_rates(pendulum(), design).min() >= 0.5


def test_a_limit_too_tight_is_a_no_that_names_it() -> None:
    """30 N cannot hold the pendulum from that box; the diagnosis names limit or initial state."""
    design = pdc(pendulum(), decay_rate=0.5, input_limit=[30.0], initial_box=[0.3, 0.5])

    assert design.status == "infeasible"
    assert "initial state" in design.answer.diagnosis or "limit of input" in design.answer.diagnosis
    with pytest.raises(ModelError, match="no gains were found"):
        design.require()


def test_gains_keep_their_bound_in_the_models_units() -> None:
    """The bound is on the gains as they are handed out, not on scaled ones."""
    free = pdc(pendulum(), decay_rate=0.5)
    bound = pdc(pendulum(), decay_rate=0.5, gain_bound=150.0)

    assert np.linalg.norm(free.require()[0], 2, axis=(1, 2)).max() > 150
    assert np.linalg.norm(bound.require()[0], 2, axis=(1, 2)).max() <= 150


def test_units_of_states_and_inputs_do_not_matter() -> None:
    plain = pdc(pendulum(), decay_rate=1.0)
    S, T = np.array([2.0**10, 2.0**-3]), 2.0**12
    other = TSModel(pendulum().A * S / S[:, None], pendulum().B * T / S[:, None])
    K, _ = pdc(other, decay_rate=1.0).require()

    np.testing.assert_allclose(K * T / S, plain.require()[0], rtol=1e-3)


def test_a_gain_that_is_rounding_is_zero() -> None:
    """Two plants side by side share no state: each input's gain on the other's is exactly zero."""
    model = TSModel([np.diag([1.0, -2.0, 3.0])], np.eye(3)[:, [0, 2]], C=np.eye(3), E=np.eye(3))
    output = (np.eye(5)[:, :3], np.eye(5)[:, 3:])
    found = (
        pdc(model, decay_rate=0.5),
        lqr_pdc(model, np.eye(3), np.eye(2)),
        hinf_pdc(model, performance=output, tolerance=0.1),
        h2_pdc(model, performance=output),
    )

    for one in found:
        assert np.count_nonzero(one.require()[0]) == 2
    assert np.count_nonzero(observer(model, decay_rate=0.5).require()[0]) == 3
