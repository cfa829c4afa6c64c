"""A solver's word is never the answer: liars are found out, failures are tried again."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    EigenvalueRegion,
    Term,
    Unknown,
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
    pdc_condition,
    peak_gain,
    peak_pdc,
    time_limit,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.cone.cone_program import ConeProgram, Raw
from takagi.lmi.decision import decide as stages
from takagi.lmi.decision.decide import improve
from takagi.lmi.decision.rounds import improve_by_rounds
from takagi.lmi.solver import solve
from takagi.lmi.solver.solve import Session, attempts
from takagi.lmi.solver.time_limit import out_of_time, remaining
from takagi.models import ModelError, Premise, TSModel

pytestmark = pytest.mark.numeric


def stable() -> Condition:
    return common_lyapunov_condition(np.array([[-1.0, 2.0], [-3.0, -4.0]]))


def test_a_lying_solver_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def lying(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        honest = next(attempts(program, session))
        yield replace(honest, solver="liar", y=-honest.y, z=0 * honest.z)
        yield honest

    monkeypatch.setattr(stages, "attempts", lying)
    outcome = stages.decide(stable())

    assert [one.solver for one in outcome.tries] == ["liar", "clarabel"]
    assert outcome.tries[0].status == "Solved" and outcome.tries[0].margin < 0
    assert outcome.status == "candidate"


def test_solvers_that_return_nothing_leave_it_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def silent(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        for status in ("PrimalInfeasible", "Solved"):
            yield Raw("silent", status, np.zeros(0), np.zeros(0), 0, 0.0)

    monkeypatch.setattr(stages, "attempts", silent)
    answer = common_lyapunov(np.array([[-1.0, 2.0], [-3.0, -4.0]]))

    assert answer.status == "unknown"
    assert answer.P is None and "no solver settled it" in answer.diagnosis


def test_an_updated_solver_agrees_with_a_fresh_one() -> None:
    session = Session()
    for rate in (0.0, 1.0, 2.0):
        condition = stable().with_parameters(alpha=rate)
        kept = stages.decide(condition, session=session)
        fresh = stages.decide(condition)
        assert kept.status == fresh.status == "candidate"
        assert kept.margin == pytest.approx(fresh.margin, rel=1e-4)


def test_the_bound_is_above_the_margin() -> None:
    outcome = stages.decide(stable())

    assert outcome.margin <= outcome.bound <= outcome.margin * (1 + 1e-5)


def test_every_public_name_is_what_it_says() -> None:
    import types

    import takagi.lmi as floor

    for name in dir(floor):
        assert not isinstance(getattr(floor, name), types.ModuleType), name


A = np.array([[[0.0, 1.0], [-1.0, -0.4]], [[0.0, 1.0], [-1.5, -0.5]]])


class PanicException(BaseException):
    """It has the name of what clarabel raises where its own code panics."""


class Broken:
    def __init__(self, error: BaseException) -> None:
        self.error = error

    def solve(self) -> Any:
        raise self.error


def break_first(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    whole, left = solve._clarabel, [Broken(error)]
    monkeypatch.setattr(solve, "_clarabel", lambda *given: left.pop() if left else whole(*given))


@pytest.mark.parametrize("kept", [False, True])
def test_the_next_solver_is_asked(monkeypatch: pytest.MonkeyPatch, kept: bool) -> None:
    break_first(monkeypatch, PanicException("Eigval error"))
    session = Session() if kept else None
    found = solve_with(session)

    assert found.status == "candidate"
    assert found.tries[0].status == "failed: Eigval error"
    assert found.tries[0].margin == -np.inf


def test_a_session_forgets_what_broke(monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session()
    break_first(monkeypatch, PanicException("Eigval error"))
    solve_with(session)
    again = solve_with(session)

    assert again.status == "candidate"
    assert len(again.tries) == 1


def test_an_interrupt_is_not_held(monkeypatch: pytest.MonkeyPatch) -> None:
    break_first(monkeypatch, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        solve_with(None)


def solve_with(session: Session | None) -> Any:
    return decide(common_lyapunov_condition(A), session=session)


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


def vertices(count: int, n: int, seed: int = 2, spread: float = 0.6) -> np.ndarray:
    """Return A_i = T (E_i - I) T^-1, |E_i| <= spread < 1: T^-T T^-1 is a common P."""
    random = np.random.default_rng(seed)
    E = random.normal(size=(count, n, n))
    E *= spread / np.linalg.norm(E, 2, axis=(1, 2))[:, None, None]
    T = random.normal(size=(n, n)) + 2 * np.eye(n)
    return np.asarray(T @ (E - np.eye(n)) @ np.linalg.inv(T))


def least_trace(A: np.ndarray) -> Condition:
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
