"""A bound on the objective in the user's units: of answers and designs, on both sides, exactly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from takagi.lmi import (
    decide,
    exact_no,
    h2_norm,
    h2_pdc,
    hinf_norm,
    hinf_pdc,
    lqr_pdc,
    objective_below,
    pdc,
    peak_pdc,
)
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import family_gain

# A drive in rpm and kN, far from units of order one: x1' = x2, x2' = -4 x1 - 0.8 x2 in SI.
SIZES = np.diag([1e-3, 9.55])
A = SIZES @ np.array([[0.0, 1.0], [-4.0, -0.8]]) @ np.linalg.inv(SIZES)
E = SIZES @ np.array([[0.0], [1.0]]) * 1e3
C = np.array([[1.0, 0.0]]) @ np.linalg.inv(SIZES) * 1e-6
MODEL = TSModel([A], [E / 50], C=[C], E=[E])
# The output, and the input in a weight at which the two cost about the same.
PERFORMANCE = (np.vstack([C, np.zeros((1, 2))]), np.array([[0.0], [1e-5]]))


def gain_of(answer: Any) -> float:
    """What the answer says in the user's units."""
    return float(answer.gain)


@pytest.mark.parametrize(
    "ask",
    [
        lambda: hinf_norm(MODEL),
        lambda: h2_norm(MODEL),
        lambda: family_gain(MODEL),
        lambda: hinf_pdc(MODEL, performance=PERFORMANCE),
        lambda: h2_pdc(MODEL, performance=PERFORMANCE),
        lambda: peak_pdc(MODEL, performance=PERFORMANCE, decay_rate=0.5),
    ],
    ids=["hinf_norm", "h2_norm", "robust", "hinf_pdc", "h2_pdc", "peak_pdc"],
)
def test_a_gain_is_bounded_in_the_units_in_which_it_is_given(ask: Callable[[], Any]) -> None:
    answer = ask()
    gain = gain_of(answer)

    assert decide(objective_below(answer, 1.01 * gain)).status == "candidate"
    assert decide(objective_below(answer, 0.98 * gain)).status == "infeasible"


def test_the_h_infinity_norm_is_bounded_from_below_by_exact_multipliers() -> None:
    """0.999 of the peak of the frequency response: proved, in the drive's own units."""
    w = np.linspace(1.5, 2.5, 20_001)
    peak = max(abs((C @ np.linalg.solve(1j * v * np.eye(2) - A, E))[0, 0]) for v in w)

    no = exact_no(objective_below(hinf_norm(MODEL), 0.999 * peak))

    assert no is not None and no.holds
    assert f"gain below {0.999 * peak:.6g}" in str(no)


def test_the_least_cost_is_riccatis_in_the_units_of_the_weights() -> None:
    """A'P + PA - PBB'P/R + Q = 0: trace P from both sides, of the design and not of its LMIs."""
    B, Q, R = E / 50, np.diag([1e6, 1.0]), np.array([[1e-3]])
    least = float(np.trace(solve_continuous_are(A, B, Q, R)))
    design = lqr_pdc(MODEL, Q, R)

    assert design.cost == pytest.approx(least, rel=1e-3)
    assert decide(objective_below(design, 1.01 * least)).status == "candidate"
    no = exact_no(objective_below(design, 0.98 * least))
    assert no is not None and no.holds


def test_a_direct_path_is_not_undercut() -> None:
    """``peak_pdc`` adds the norm of D11: below it nothing can be asked."""
    model = TSModel([A], [E / 50], C=[C], E=[E])
    direct = (*PERFORMANCE, np.array([[0.5], [0.0]]))
    design = peak_pdc(model, performance=direct, decay_rate=0.5)

    with pytest.raises(ModelError, match="above 0.5, which a direct path adds"):
        objective_below(design, 0.4)


def test_what_minimised_nothing_is_refused() -> None:
    """A design at a decay rate has gains of least effort, which is no quantity of its own."""
    with pytest.raises(ModelError, match="minimised no gain and no cost"):
        objective_below(pdc(MODEL), 1.0)
    with pytest.raises(ModelError, match="the gain is -1; it must be positive"):
        objective_below(hinf_norm(MODEL), -1.0)
