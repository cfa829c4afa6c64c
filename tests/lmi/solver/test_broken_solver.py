"""A solver that breaks down is an answer that says nothing; the next one is asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.lmi import common_lyapunov_condition, decide
from takagi.lmi.solver import solve
from takagi.lmi.solver.solve import Session

A = np.array([[[0.0, 1.0], [-1.0, -0.4]], [[0.0, 1.0], [-1.5, -0.5]]])


class PanicException(BaseException):
    """It has the name of what clarabel raises where its own code panics."""


class Broken:
    """A solver that breaks down."""

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
    """The answer is the same, and the tries say what happened."""
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
