"""Plants of COMPleib in their own units, without sdpa: the least norms, moderate gains, few solves.

Source: F. Leibfritz (2004), COMPleib, release 1.1: AC4 (Fares, Apkarian and Noll, a missile) and
DIS5 (decentralised).  Their least norms by all states are the limits of the Riccati equations.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import H2Norm, L2Gain, Peak
from takagi.lmi import h2_pdc, hinf_pdc, pdc, peak_pdc
from takagi.lmi.cone.balance import balanced_states
from takagi.lmi.solver import solve
from takagi.models import TSModel
from tests.lmi.compleib import SYSTEMS

AC4 = TSModel(
    [
        [
            [-0.876, 1.0, -0.1209, 0.0],
            [8.9117, 0.0, -130.75, 0.0],
            [0.0, 0.0, -150.0, 0.0],
            [-1.0, 0.0, 0.0, -0.05],
        ]
    ],
    [[0.0], [0.0], [150.0], [0.0]],
    E=[[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 1.0]],
)
AC4_OUTPUT = (
    [[-0.25, 0.0, 0.0, 3.487], [0.0, 0.0, -3.0, 0.0]],
    [[0.0], [3.0]],
    [[0.0, 0.25], [0.0, 0.0]],
)
AC4_LEAST = 0.557288
DIS5 = TSModel(
    [
        [
            [0.8189, 0.0863, 0.09, 0.0813],
            [0.2524, 1.0033, 0.0313, 0.2004],
            [-0.0545, 0.0102, 0.7901, -0.258],
            [-0.1918, -0.1034, 0.1602, 0.8604],
        ]
    ],
    [[0.0045, 0.0044], [0.1001, 0.01], [0.0003, -0.0136], [-0.0051, 0.0936]],
    E=[[0.0953, 0.0, 0.0], [0.0145, 0.0, 0.0], [0.0862, 0.0, 0.0], [-0.0011, 0.0, 0.0]],
)
DIS5_OUTPUT = (
    [[1.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]],
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
)
DIS5_HINF, DIS5_H2 = 27.4937, 36.0206


@pytest.fixture(autouse=True)
def without_sdpa(monkeypatch: pytest.MonkeyPatch) -> None:
    """sdpa is never needed."""
    monkeypatch.setattr(solve, "sdpa_is_installed", lambda: False)


def test_a_missile_in_its_own_units_has_its_least_norm() -> None:
    """AC4: entries from 0.05 to 150, a direct path, an input without which nothing is stable."""
    design = hinf_pdc(AC4, performance=AC4_OUTPUT)

    assert design.status == "candidate"
    assert design.gain == pytest.approx(AC4_LEAST, rel=1e-4)


@pytest.mark.parametrize(("design", "least"), [(h2_pdc, DIS5_H2), (hinf_pdc, DIS5_HINF)])
def test_a_decentralised_plant_has_its_least_norms(design: object, least: float) -> None:
    """DIS5: an input of 1 moves the states by 1e-3, and what it costs crosses with the states."""
    found = design(DIS5, performance=DIS5_OUTPUT)  # type: ignore[operator]

    assert found.status == "candidate"
    assert found.gain == pytest.approx(least, rel=2e-4)


@pytest.mark.parametrize(
    ("name", "asked", "request_of"),
    [
        *((name, hinf_pdc, L2Gain) for name in ("NN2", "DIS2", "HE1", "NN4")),
        *((name, h2_pdc, H2Norm) for name in ("NN2", "DIS2", "HE1", "NN4", "TG1")),
        ("NN2", peak_pdc, Peak),
    ],
)
def test_a_default_design_is_proved_within_a_thousandth(
    name: str, asked: Any, request_of: Any
) -> None:
    """The exact proof of the emitted gains, at most 0.1 % above the design's own bound."""
    system = SYSTEMS[name]()
    model, output = TSModel([system.A], [system.B], E=[system.B1]), (system.C1, system.D12)
    design = asked(model, performance=output)
    assert design.gain is not None

    found = certify(model, design.gains, claims=[request_of(output=output)])

    assert found.verdict is Verdict.PROVED
    claim = found.document["claims"][-1]
    assert claim.get("gain", claim.get("norm")) <= 1.001 * design.gain


def test_states_that_only_act_on_others_do_not_run_away() -> None:
    """A disturbance's model of two states drives the plant; nothing drives it back.

    Made smaller and smaller in turn, the plant's unstable mode seemed out of the input's reach.
    """
    A = np.array(
        [
            [0.01, 1.0, 0.0, 0.02, 0.0],
            [0.3, -0.7, 1.0, 0.05, 0.0],
            [0.0, 0.0, -20.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, -0.44, 0.0044],
            [0.0, 0.0, 0.0, -0.0044, -0.44],
        ]
    )
    s = balanced_states(A[None])

    assert s.max() / s.min() < 1e6
    assert pdc(TSModel([A], [[[0.0], [0.0], [20.0], [0.0], [0.0]]])).status == "candidate"
