"""A no of ``pdc`` is one of the condition, not of units, of Q's size, or of the effort tried."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from takagi.lmi import Condition, Outcome, decide, pdc
from takagi.lmi.gains.decay import design as compensation_design
from takagi.lmi.gains.decay import pdc as rate_search
from takagi.lmi.gains.decay.condition import decay_request
from takagi.lmi.gains.decay.design import decided, stopped_by_limit
from takagi.lmi.gains.requirements.limits import GivenLimits
from takagi.models import Floats, TSModel
from tests.lmi.known_models import torque_pendulum

pytestmark = pytest.mark.numeric


# In the proportions of the largest box in which a certain Q of the plant below is held.
BOX = np.array([0.0027, 0.0014, 2e-5])


def reach(P: Floats, box: Floats) -> float:
    corners = np.array(list(product((1.0, -1.0), repeat=len(box)))) * box
    return float(np.einsum("ti,ij,tj->t", corners, P, corners).max())


def hard() -> TSModel:
    """Two rules that gains barely serve: a margin of 1e-5 in balanced states, without limits."""
    return TSModel(
        [
            [[0.99, -1.22, -3.03], [-0.61, 0.12, 0.32], [0.06, -0.01, -0.46]],
            [[1.92, -1.27, -1.82], [-0.37, 0.38, 0.80], [-0.86, -0.31, 0.42]],
        ],
        [
            [[1.14, -0.19], [0.54, 1.78], [0.84, -0.48]],
            [[1.30, -0.49], [0.56, 1.61], [0.83, -1.36]],
        ],
    )


@pytest.mark.parametrize(
    "box", [(0.2, 0.5, 0.01), (0.02, 0.05, 0.01), (1e-3, 2e-5, 2e-8), (1e-6, 0.5, 0.01)]
)
def test_a_smaller_box_never_loses_gains(box: tuple[float, float, float]) -> None:
    half, plant = np.array(box), torque_pendulum()
    # The input is a state whose rate is the input.
    A = np.block([[plant.A, plant.B], [np.zeros((2, 1, 3))]])
    model = TSModel(A, np.tile([[0.0], [0.0], [1.0]], (2, 1, 1)))
    design = pdc(model, initial_box=half, state_box=(1.0, np.inf, 8.0))

    assert design.found
    _, P = design.require()
    axes = np.sqrt(np.diag(np.linalg.inv(P)))
    assert reach(P, half) <= 1 + 1e-9
    assert axes[0] <= 1.0 and axes[2] <= 8.0


@cache
def held(relaxation: str) -> bool:
    return pdc(hard(), relaxation=relaxation).found


@pytest.mark.parametrize("size", [0.3, 25.1, 6310.0])
@pytest.mark.parametrize("relaxation", ["wang-tanaka-griffin", "kim-lee"])
def test_a_box_alone_costs_no_gains(relaxation: str, size: float) -> None:
    """Any ellipsoid may be made larger: where there are gains, a box to start from is no reason."""
    assert held(relaxation)

    assert pdc(hard(), relaxation=relaxation, initial_box=size * BOX).status == "candidate"


@pytest.mark.parametrize(
    "limits",
    [
        {"initial_box": 0.3 * BOX},
        {"state_box": BOX},
        {"input_limit": (1e-6, 1e-3)},
        {"initial_box": 1e-9 * BOX, "state_box": BOX, "input_limit": (1e-3, 1e-3)},
    ],
    ids=["box to start from", "states", "inputs", "all, far apart"],
)
def test_gains_without_limits_are_gains_with_them_in_a_size_that_fits(
    monkeypatch: pytest.MonkeyPatch, limits: dict[str, ArrayLike]
) -> None:
    """A solver that says no to all that is limited is not believed: Q may have another size."""

    def never_with_limits(condition: Condition, **options: Any) -> Outcome:
        outcome = decide(condition, **options)
        names = {lmi.name for lmi in condition.lmis}
        if not names & {"initial state", "state box", "input limit"}:
            return outcome
        nothing = {lmi.name: np.zeros((lmi.count, lmi.size, lmi.size)) for lmi in condition.lmis}
        nothing["scale of Q"] += np.eye(3)
        return replace(outcome, status="infeasible", bound=-0.1, margin=-1.0, multipliers=nothing)

    monkeypatch.setattr(compensation_design, "decide", never_with_limits)
    design = pdc(hard(), **limits)  # type: ignore[arg-type]

    K, P = design.require()
    assert design.found
    loops = [A - B @ k for A, B, k in zip(hard().A, hard().B, K, strict=True)]
    assert all(np.linalg.eigvalsh(L.T @ P + P @ L).max() < 0 for L in loops)
    if "initial_box" in limits:
        assert reach(P, np.asarray(limits["initial_box"])) <= 1
    if "state_box" in limits:
        assert np.all(np.sqrt(np.diag(np.linalg.inv(P))) <= np.asarray(limits["state_box"]))
    if "input_limit" in limits:
        used = np.sqrt(np.einsum("rki,ij,rkj->rk", K, np.linalg.inv(P), K).max(axis=0))
        assert np.all(used <= np.asarray(limits["input_limit"]))


def test_a_no_without_limits_is_one_with_them() -> None:
    """Halfway between the rules no input moves the unstable state, in an ellipsoid of any size."""
    model = TSModel([[[1.0]], [[1.0]]], [[[1.0]], [[-1.0]]])
    design = pdc(model, initial_box=1e-6, state_box=1e6, input_limit=1e6)

    assert pdc(model).status == "infeasible"
    assert design.status == "infeasible"


def test_a_no_that_leaves_room_for_large_unknowns_is_none() -> None:
    """Multipliers that miss stationarity by 1e-2 bound nothing where Q may be a thousand."""
    task = decay_request(
        torque_pendulum(), GivenLimits(initial_box=(0.2, 0.5), input_limit=1.0), decay_rate=0.0
    )
    found = decided(task, 0.0, "wang-tanaka-griffin")
    outcome = found.outcome
    assert outcome.status == "infeasible" and outcome.bound < 0 and not stopped_by_limit(found)

    off = {name: Z.copy() for name, Z in outcome.multipliers.items()}
    off["initial state"][0, 1, 1] += 1e-2 * abs(outcome.bound)
    assert stopped_by_limit(replace(found, outcome=replace(outcome, multipliers=off)))


@pytest.mark.parametrize("slow", [1e-9, 0.0])
@pytest.mark.parametrize("state", [1e-8, 1.0, 1e8])
@pytest.mark.parametrize("moved", [1e-8, 1.0, 1e8])
def test_a_slow_plant_may_be_asked_to_be_fast(slow: float, state: float, moved: float) -> None:
    """x' = a x + b u in any units, asked for 1 1/s."""
    model = TSModel([[[slow]]], [[[state * moved]]])

    assert pdc(model, decay_rate=1.0).found


@pytest.mark.parametrize("state", [1e-8, 1.0, 1e8])
def test_inputs_are_independent_in_all_units(state: float) -> None:
    s = np.array([1.0, state])
    B = np.array([[1.0, 1.0], [0.0, 1.0]]) * s[:, None]
    A = np.array([[0.0, 1.0], [-1.0, 1.0]]) * s[:, None] / s

    assert pdc(TSModel(A[None], B[None])).found


def test_a_rate_that_no_solver_settled_is_not_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    def gives_up(*args: object, **options: object) -> object:
        outcome = decide(*args, **options)  # type: ignore[arg-type]
        return replace(outcome, status="unknown")

    def never(*args: object, **options: object) -> object:
        found = decided(*args, **options)  # type: ignore[arg-type]
        if args[1] == 0.0:
            return found
        unknown = replace(found.outcome, status="unknown")
        return replace(found, outcome=unknown)

    task = decay_request(torque_pendulum(), GivenLimits(gain_bound=30.0), decay_rate=0.0)
    true = rate_search.Largest(task, "wang-tanaka-griffin")
    monkeypatch.setattr(rate_search, "decide", gives_up)
    monkeypatch.setattr(rate_search, "decided", never)
    found = rate_search.Largest(task, "wang-tanaka-griffin")

    assert found.low < true.low <= true.high < np.inf
    assert found.high == np.inf


def test_what_the_first_solver_leaves_open_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    def gives_up(*args: object, **options: object) -> object:
        outcome = decide(*args, **options)  # type: ignore[arg-type]
        return replace(outcome, status="unknown")

    plain = pdc(torque_pendulum(), decay_rate="max", gain_bound=30.0)
    monkeypatch.setattr(rate_search, "decide", gives_up)
    other = pdc(torque_pendulum(), decay_rate="max", gain_bound=30.0)

    assert other.decay_rate == pytest.approx(plain.decay_rate, rel=1e-4)
    assert other.answer.bound < other.decay_rate * (1 + 1e-3)
