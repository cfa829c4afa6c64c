"""``time_limit``: every public function that runs a solver ends in time and says why."""

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
    polynomial_lyapunov,
)
from takagi.lmi.solver.time_limit import limited, out_of_time, remaining
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
    "common_lyapunov": lambda **k: common_lyapunov(A, **k),
    "max_decay_rate": lambda **k: max_decay_rate(A, **k),
    "d_stability": lambda **k: d_stability(A, EigenvalueRegion.half_plane(0.01), **k),
    "hinf_norm": lambda **k: hinf_norm(PLANT, **k),
    "h2_norm": lambda **k: h2_norm(PLANT, **k),
    "peak_gain": lambda **k: peak_gain(PLANT, **k),
    "polynomial_lyapunov": lambda **k: polynomial_lyapunov(PLANT, **k),
    "fuzzy_lyapunov": lambda **k: fuzzy_lyapunov(PLANT, rate_bounds=[1.0], **k),
    "pdc": lambda **k: pdc(PLANT, **k),
    "lqr_pdc": lambda **k: lqr_pdc(PLANT, np.eye(2), np.eye(1), **k),
    "observer": lambda **k: observer(SEEN, decay_rate=0.1, **k),
    "hinf_pdc": lambda **k: hinf_pdc(PLANT, **k),
    "h2_pdc": lambda **k: h2_pdc(PLANT, **k),
    "peak_pdc": lambda **k: peak_pdc(PLANT, **k),
    "decide": lambda **k: decide(common_lyapunov_condition(A), **k),
    "optimise": lambda **k: optimise(LEAST, **k),
    "decide_by_rounds": lambda **k: decide_by_rounds(common_lyapunov_condition(A), **k),
    "optimise_by_rounds": lambda **k: optimise_by_rounds(LEAST, **k),
}


def words(answer: Any) -> str:
    """Return why an answer, a design or an outcome is unknown."""
    inside = getattr(answer, "answer", answer)
    return str(getattr(inside, "diagnosis", "") or getattr(inside, "reason", ""))


@pytest.mark.parametrize("name", ASKED)
def test_without_time_nothing_is_known_and_it_is_said(name: str) -> None:
    """A nanosecond is over before the first call: "unknown", not "infeasible", not an error."""
    found = ASKED[name](time_limit=1e-9)

    assert found.status == "unknown"
    assert "stopped by the time limit of 1e-09 s" in words(found)


@pytest.mark.parametrize("name", ["hinf_pdc", "optimise", "pdc", "hinf_norm"])
def test_with_time_enough_the_answer_is_the_same(name: str) -> None:
    """A limit that is not reached changes no digit."""
    free, bounded = ASKED[name](), ASKED[name](time_limit=1e4)

    assert bounded.status == free.status == "candidate"
    assert words(bounded) == words(free) == ""


def test_a_limit_that_is_no_time_is_refused() -> None:
    """Zero, a negative number, and what is not a number."""
    for wrong in (0.0, -1.0, "long", float("nan")):
        with pytest.raises(ModelError, match="time_limit is"):
            common_lyapunov(A, time_limit=wrong)  # type: ignore[arg-type]


def test_a_question_inside_another_shares_its_time() -> None:
    """The inner one may ask for more; it gets what is left, and the outer one learns of its end."""

    @limited
    def inner(*, time_limit: float | None = None) -> float:
        left = remaining()
        assert left is not None
        time.sleep(left)
        assert out_of_time()
        return left

    @limited
    def outer(*, time_limit: float | None = None) -> float:
        left = inner(time_limit=1e3)
        assert out_of_time()
        return left

    assert outer(time_limit=0.01) <= 0.01
    assert remaining() is None
