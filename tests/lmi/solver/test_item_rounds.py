"""Few items are given to the solver, all are looked at: the same answers, much less work."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    Term,
    Unknown,
    common_lyapunov_condition,
    decide,
    decide_by_rounds,
    optimise,
    optimise_by_rounds,
    pdc_condition,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.decision.decide import improve
from takagi.lmi.decision.rounds import improve_by_rounds
from takagi.models import TSModel

pytestmark = pytest.mark.numeric


def vertices(count: int, n: int, seed: int = 2, spread: float = 0.6) -> np.ndarray:
    """Return A_i = T (E_i - I) T^-1, |E_i| <= spread < 1: T^-T T^-1 is a common P."""
    random = np.random.default_rng(seed)
    E = random.normal(size=(count, n, n))
    E *= spread / np.linalg.norm(E, 2, axis=(1, 2))[:, None, None]
    T = random.normal(size=(n, n)) + 2 * np.eye(n)
    return np.asarray(T @ (E - np.eye(n)) @ np.linalg.inv(T))


def least_trace(A: np.ndarray) -> Condition:
    """Return: least tr P with P >= I and A_i'P + PA_i <= 0 at every vertex."""
    n = A.shape[1]
    P, one = Unknown("P", n, n, symmetric=True), np.eye(n)[None]
    floor = LMI(
        name="floor",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=one),),
        constants=(Constant(value=-one),),
    )
    vertex = LMI(
        name="vertex",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=A, plus_transpose=True),),
        sign=-1,
        count=len(A),
    )
    return Condition(name="least trace", unknowns=(P,), lmis=(floor, vertex), objective={"P": one})


def test_a_candidate_holds_at_every_item() -> None:
    """The margin is over all vertices, few of which were solved for: at least half the largest."""
    condition = common_lyapunov_condition(vertices(400, 4))
    found, all_at_once = decide_by_rounds(condition), decide(condition)

    assert found.status == "candidate"
    assert found.margin == pytest.approx(margin(condition, found.values), rel=1e-9)
    assert 0.5 * all_at_once.margin <= found.margin <= all_at_once.margin * (1 + 1e-6)


def test_one_bad_vertex_among_many_is_found() -> None:
    """The vertex that spoils it is neither slow nor far, and in no order of its own."""
    A = vertices(500, 3)
    A[311] = A[0] + 1.5 * np.abs(A[0]).max() * np.eye(3)[[1, 2, 0]]
    assert np.linalg.eigvals(A[311]).real.max() > 0
    found = decide_by_rounds(common_lyapunov_condition(A))

    assert found.status == "infeasible"
    assert found.multipliers["vertex"].shape == (500, 3, 3)
    assert np.trace(found.multipliers["vertex"][311]) > 0


def test_the_verdict_turns_where_it_turns_for_all() -> None:
    verdicts = []
    for rate in (0.0, 0.05, 0.5, 1.5):
        condition = common_lyapunov_condition(vertices(100, 3), decay_rate=rate)
        verdicts.append(decide_by_rounds(condition).status)
        assert verdicts[-1] == decide(condition).status
    assert set(verdicts) == {"candidate", "infeasible"}


@pytest.mark.parametrize("count", [60, 1000])
def test_the_least_objective_is_that_of_all(count: int) -> None:
    condition = least_trace(vertices(count, 4))
    found = optimise_by_rounds(condition)

    assert found.settled and margin(condition, found.values) > 0
    assert found.margin == pytest.approx(margin(condition, found.values), rel=1e-6)
    if count == 60:
        assert found.objective == pytest.approx(optimise(condition).objective, rel=1e-4)
    assert found.lower_bound <= found.objective * (1 + 1e-6)


def test_least_effort_by_rounds_is_that_of_all_pairs() -> None:
    """Fourteen rules, 91 pairs: the same effort, half the margin at every pair."""
    random = np.random.default_rng(4)
    A = random.normal(size=(4, 4)) / 2 + 0.02 * random.normal(size=(14, 4, 4))
    B = random.normal(size=(4, 2)) + 0.01 * random.normal(size=(14, 4, 2))
    condition = pdc_condition(TSModel(A, B))
    start = decide_by_rounds(condition, rows={"nu": 1e4})
    found, all_at_once = improve_by_rounds(condition, start), improve(condition, start)

    assert found.status == "candidate"
    assert found.objective == pytest.approx(all_at_once.objective, rel=1e-3)
    assert found.margin == pytest.approx(margin(condition, found.values), rel=1e-6)
    assert found.margin > 0.45 * start.margin
