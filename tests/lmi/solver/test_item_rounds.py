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
    hinf_norm_condition,
    optimise,
    optimise_by_rounds,
)
from takagi.lmi.condition import margin
from takagi.lmi.decision import item_rounds
from takagi.lmi.decision.item_rounds import ALL_AT_ONCE

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


def disc(count: int, *, weight: float = 1.0) -> Condition:
    """Return: largest x + y in the polygon cos(a_k) x + sin(a_k) y <= 1, one LMI of 1 x 1 items."""
    angle = 2 * np.pi * np.arange(count) / count
    z = Unknown("z", 1, 1, count=2)
    normals = np.concatenate([np.cos(angle), np.sin(angle)])[:, None, None]
    sides = LMI(
        name="side",
        blocks=(1,),
        terms=(
            Term(
                unknown=z,
                left=-normals,
                items=np.tile(np.arange(count), 2),
                members=np.repeat([0, 1], count),
            ),
        ),
        constants=(Constant(value=np.ones((1, 1, 1))),),
        count=count,
        weight=weight,
    )
    box = LMI(
        name="box",
        blocks=(1, 1),
        terms=(
            Term(unknown=z, left=-np.ones((1, 1, 1)), at=(0, 0)),
            Term(unknown=z, left=-np.ones((1, 1, 1)), at=(1, 1), members=np.ones(1, dtype=np.intp)),
        ),
        constants=(Constant(value=4.0 * np.eye(2)[None], at=None),),
    )
    cost = -np.ones((2, 1, 1))
    return Condition(name="polygon", unknowns=(z,), lmis=(sides, box), objective={"z": cost})


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
    """The same yes and no as with every vertex given, on both sides."""
    verdicts = []
    for rate in (0.0, 0.05, 0.5, 1.5):
        condition = common_lyapunov_condition(vertices(100, 3), decay_rate=rate)
        verdicts.append(decide_by_rounds(condition).status)
        assert verdicts[-1] == decide(condition).status
    assert set(verdicts) == {"candidate", "infeasible"}


@pytest.mark.parametrize("count", [60, 1000])
def test_the_least_objective_is_that_of_all(count: int) -> None:
    """Trace objective: near the least over all, and the bound below both."""
    condition = least_trace(vertices(count, 4))
    found = optimise_by_rounds(condition)

    assert found.settled and margin(condition, found.values) > 0
    assert found.margin == pytest.approx(margin(condition, found.values), rel=1e-6)
    if count == 60:
        assert found.objective == pytest.approx(optimise(condition).objective, rel=1e-4)
    assert found.least <= found.objective * (1 + 1e-6)


def test_a_norm_over_many_vertices() -> None:
    """Another condition, another unknown: the L2 gain bound of 80 vertices, all at once and not."""
    random = np.random.default_rng(7)
    A = vertices(80, 3)
    condition = hinf_norm_condition(A, B=random.normal(size=(3, 1)), C=random.normal(size=(1, 3)))
    found, whole = optimise_by_rounds(condition), optimise(condition)

    assert found.settled and whole.settled
    assert found.objective == pytest.approx(whole.objective, rel=1e-4)


@pytest.mark.parametrize("weight", [1.0, 0.0])
def test_a_polygon_with_its_known_corner(weight: float) -> None:
    """Largest x + y in a regular polygon of 4000 sides: sqrt(2) / cos(angle to the next normal)."""
    count = 4000
    off = np.abs(np.pi / 4 - 2 * np.pi * np.arange(count) / count).min()
    found = optimise_by_rounds(disc(count, weight=weight))

    assert off < 1e-12 and found.settled
    assert -found.objective == pytest.approx(np.sqrt(2), rel=1e-4)
    assert sum(found.values["z"][:, 0, 0] ** 2) <= 1 + 1e-4


def test_too_few_items_to_bound_the_objective() -> None:
    """Items that leave it unbounded are joined by others until it is not."""
    condition = disc(200)
    condition = Condition(
        name="polygon",
        unknowns=condition.unknowns,
        lmis=(condition.lmis[0],),
        objective=condition.objective,
    )
    some = item_rounds._Some.of(condition)
    some.chosen = {0: np.array([100, 101])}
    item_rounds._touching(some)

    assert len(some.chosen[0]) > 2
    assert -optimise(some.condition()).objective == pytest.approx(np.sqrt(2), rel=1e-2)


def test_a_short_condition_is_solved_as_it_is() -> None:
    """Nothing is left out below the threshold: the very same program."""
    condition = common_lyapunov_condition(vertices(ALL_AT_ONCE, 3))

    assert decide_by_rounds(condition).margin == decide(condition).margin


def test_the_solver_is_given_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 2000 items less than a tenth ever reach it."""
    largest: list[int] = []

    def recording(condition: Condition, **options: object) -> object:
        largest.append(condition.lmis[-1].count)
        return decide(condition)

    monkeypatch.setattr(item_rounds, "decide", recording)
    assert decide_by_rounds(common_lyapunov_condition(vertices(2000, 4))).status == "candidate"
    assert max(largest) < 200


def test_parameters_are_handed_on() -> None:
    """The decay rate is that of the call, in the solve and in the check of what was left out."""
    condition = common_lyapunov_condition(vertices(200, 3))
    found = decide_by_rounds(condition, parameters={"alpha": 0.1})

    assert found.margin == pytest.approx(
        margin(condition.with_parameters(alpha=0.1), found.values), rel=1e-9
    )
    assert decide_by_rounds(condition, parameters={"alpha": 5.0}).status == "infeasible"
