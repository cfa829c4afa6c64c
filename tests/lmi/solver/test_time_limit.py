"""``time_limit``: every public function that runs a solver ends in time and says so."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    EigenvalueRegion,
    common_lyapunov,
    common_lyapunov_condition,
    d_stability,
    decide,
    decide_by_rounds,
    fuzzy_lyapunov,
    h2_norm,
    h2_pdc,
    hinf_norm,
    hinf_norm_condition,
    hinf_pdc,
    lqr_pdc,
    max_decay_rate,
    observer,
    optimise,
    optimise_by_rounds,
    pdc,
    peak_gain,
    peak_pdc,
    time_limit,
)
from takagi.lmi.solver.time_limit import out_of_time, remaining
from takagi.models import ModelError, Premise, TSModel

A = np.array([[[0.0, 1.0], [-1.0, -0.4]], [[0.0, 1.0], [-1.5, -0.5]]])
PLANT = TSModel(
    A,
    [[0.0], [1.0]],
    C=[[1.0, 0.0], [0.0, 0.0]],
    D=[[0.0], [0.1]],
    E=[[0.0], [1.0]],
    premises=[Premise("t", 0, 1)],
)
SEEN = TSModel(A, PLANT.B, C=[[1.0, 0.0]])
LEAST = hinf_norm_condition(PLANT)
ASKED: dict[str, Callable[..., Any]] = {
    "common_lyapunov": lambda: common_lyapunov(A),
    "max_decay_rate": lambda: max_decay_rate(A),
    "d_stability": lambda: d_stability(A, EigenvalueRegion.half_plane(0.01)),
    "hinf_norm": lambda: hinf_norm(PLANT),
    "h2_norm": lambda: h2_norm(PLANT),
    "peak_gain": lambda: peak_gain(PLANT),
    "fuzzy_lyapunov": lambda: fuzzy_lyapunov(PLANT, rate_bounds=[1.0]),
    "pdc": lambda: pdc(PLANT),
    "lqr_pdc": lambda: lqr_pdc(PLANT, np.eye(2), np.eye(1)),
    "observer": lambda: observer(SEEN, decay_rate=0.1),
    "hinf_pdc": lambda: hinf_pdc(PLANT),
    "h2_pdc": lambda: h2_pdc(PLANT),
    "peak_pdc": lambda: peak_pdc(PLANT),
    "decide": lambda: decide(common_lyapunov_condition(A)),
    "optimise": lambda: optimise(LEAST),
    "decide_by_rounds": lambda: decide_by_rounds(common_lyapunov_condition(A)),
    "optimise_by_rounds": lambda: optimise_by_rounds(LEAST),
}


@pytest.mark.parametrize("name", ASKED)
def test_without_time_nothing_is_known(name: str) -> None:
    with time_limit(1e-9) as budget:
        assert ASKED[name]().status == "unknown"
    assert budget.stopped


@pytest.mark.parametrize("name", ["hinf_pdc", "optimise", "pdc", "hinf_norm"])
def test_with_time_enough_the_answer_is_the_same(name: str) -> None:
    with time_limit(1e4) as budget:
        bounded = ASKED[name]()
    assert bounded.status == ASKED[name]().status == "candidate"
    assert not budget.stopped


@pytest.mark.parametrize("wrong", [0.0, -1.0, "long", float("nan")])
def test_a_limit_that_is_no_time_is_refused(wrong: Any) -> None:
    with pytest.raises(ModelError, match="time_limit is"), time_limit(wrong):
        pass


def test_a_question_inside_another_shares_its_time() -> None:
    """The inner one may ask for more; it gets what is left, and the outer one learns of its end."""
    with time_limit(0.01) as outer:
        with time_limit(1e3):
            left = remaining()
            assert left is not None and left <= 0.01
            time.sleep(left)
            assert out_of_time()
        assert outer.stopped
    assert remaining() is None
