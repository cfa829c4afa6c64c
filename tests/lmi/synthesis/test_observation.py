"""Observer gains by duality."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import max_decay_rate, observer
from takagi.models import ModelError, TSModel


def rotor_and_wind() -> TSModel:
    """Rotor speed driven by an unknown wind: e' = a e + d v, v' = 0, only the speed measured."""
    A = [[[a, d], [0.0, 0.0]] for a in (-0.5, -0.04) for d in (0.016, 0.034)]
    return TSModel(A, C=[[1.0, 0.0]], states=["rotor speed [rad/s]", "wind [m/s]"])


def test_every_blend_of_the_error_decays() -> None:
    """A(h) - L(h) C decays at the rate asked for, with the P that is handed out."""
    model = rotor_and_wind()
    design = observer(model, decay_rate=0.3)
    L, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(4), 100)
    error = np.tensordot(h, model.A, axes=1) - np.tensordot(h, L, axes=1) @ model.C[0]

    assert L.shape == (4, 2, 1)
    for matrix in error:
        inside = P @ matrix + matrix.T @ P + 0.6 * P
        assert np.linalg.eigvalsh(inside)[-1] <= 1e-12 * np.abs(inside).max()


def test_dual_analysis_agrees() -> None:
    """With equal gains in all rules, the largest common decay rate is at least the one asked."""
    model = rotor_and_wind()
    L, _ = observer(model, decay_rate=0.2, relaxation="common-gain").require()
    rate = max_decay_rate(model.A - L @ model.C).decay_rate

    assert rate is not None and rate >= 0.2


def test_outputs_speak_of_outputs() -> None:
    """Errors of an observer name outputs and C, not inputs and B."""
    with pytest.raises(ModelError, match="needs at least one|no outputs"):
        observer(TSModel([[[-1.0]]], [[[1.0]]]))
    with pytest.raises(ModelError, match="output 1 of 1: its row of C is zero"):
        observer(TSModel([[[-1.0]]], C=[[0.0]]))
    with pytest.raises(ModelError, match="vertex 1 of 1: the mode at 1.* seen in no output"):
        observer(TSModel([[[1.0, 0.0], [0.0, 2.0]]], C=[[0.0, 1.0]]))
    slow = observer(TSModel([[[-1.0, 0.0], [0.0, 2.0]]], C=[[0.0, 1.0]]), decay_rate=3.0)
    assert "no output shows the mode at -1" in slow.answer.diagnosis
