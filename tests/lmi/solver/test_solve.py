"""A solver's word is never the answer: liars are found out, failures are tried again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from takagi.lmi import (
    Condition,
    common_lyapunov,
    common_lyapunov_condition,
    decide,
)
from takagi.lmi.cone.cone_program import ConeProgram, Raw
from takagi.lmi.decision import decide as stages
from takagi.lmi.solver import solve
from takagi.lmi.solver.solve import Session, attempts


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
    """Weak duality: no P has a larger margin than the multipliers allow."""
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
    """Let the first clarabel that is set up break down."""
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
