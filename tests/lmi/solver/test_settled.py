"""An optimum that no solver came near is "unknown", with the two numbers that say so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from takagi.lmi import (
    LMI,
    Condition,
    Constant,
    Outcome,
    Term,
    Unknown,
    hinf_norm,
    hinf_pdc,
    pose,
    trace,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.cone.cone_program import ConeProgram, Raw
from takagi.lmi.decision import decide as stages
from takagi.lmi.decision.outcome import LARGEST_GAP, measured
from takagi.lmi.solver.solve import Session, again, attempts
from takagi.models import TSModel

pytestmark = pytest.mark.numeric

A = np.array([[[-1.0, 2.0], [-3.0, -4.0]]])
ONE = np.eye(2)[None]


def least_trace(*, unit: float = 1.0, shift: float = 1.0) -> Condition:
    P = Unknown("P", 2, 2, symmetric=True)
    floor = LMI(name="P", blocks=(2,), terms=(Term(unknown=P, left=ONE, right=ONE),))
    vertex = LMI(
        name="vertex",
        blocks=(2,),
        terms=(Term(unknown=P, left=ONE, right=A, plus_transpose=True),),
        constants=(Constant(value=shift * ONE),),
        sign=-1,
    )
    return Condition(
        name="least trace", unknowns=(P,), lmis=(floor, vertex), objective={"P": unit * ONE}
    )


def lyapunov_trace() -> float:
    kronecker = np.kron(np.eye(2), A[0].T) + np.kron(A[0].T, np.eye(2))
    return float(np.trace(np.linalg.solve(kronecker, -np.eye(2).ravel()).reshape(2, 2)))


@pytest.fixture(autouse=True)
def no_second_units(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the solve in the answer's own units: it finds the optimum that is to be missed."""
    monkeypatch.setattr(stages, "rescaled", lambda program, raw: None)


def off_by(factor: float) -> object:
    """Return solvers that all stop at a multiple of the least values, with honest multipliers."""

    def lazy(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        raw = next(attempts(program, session))
        # A margin that is asked for is a program with linear rows: those are left alone.
        yield replace(raw, y=factor * raw.y) if program.linear == 0 else raw

    return lazy


# ------------------------------------------------------------------ the gap, and the tolerance


def outcome_at(objective: float, least: float) -> Outcome:
    values = {"P": ONE * objective / 2}
    return Outcome("candidate", values, 1.0, np.inf, {}, (), objective=objective, lower_bound=least)


@pytest.mark.parametrize("slack", [1e-6, 1e-2, 0.3])
@pytest.mark.parametrize("least", [1.0, 0.0197, -5.0, 3e27])
def test_the_gap_is_measured_against_the_bound(slack: float, least: float) -> None:
    tolerance = max(slack, LARGEST_GAP)
    inside = outcome_at(least + 0.999 * tolerance * abs(least), least)
    outside = outcome_at(least + 1.001 * tolerance * abs(least), least)

    assert measured(least_trace(), inside, slack).settled
    assert not measured(least_trace(), outside, slack).settled


@pytest.mark.parametrize("slack", [1e-2, 1.0, 10.0])
def test_an_objective_is_not_near_by_its_own_size(slack: float) -> None:
    """3e27 found where the least is 0.0197, at any slack that was ever used."""
    assert not measured(least_trace(), outcome_at(3e27, 0.0197), slack).settled


def test_nothing_is_settled_without_a_bound() -> None:
    """An objective alone says nothing; nor does one far below a bound that must be wrong."""
    assert not measured(least_trace(), outcome_at(1.0, -np.inf), 1e-2).settled


def test_what_cannot_be_told_from_zero_is_zero() -> None:
    """The floor is in unknowns of order one, so it goes with the size of the cost."""
    for unit in (1e-6, 1.0, 1e6):
        posed = least_trace(unit=unit)
        assert measured(posed, outcome_at(1e-8 * unit, -9e-9 * unit), 1e-6).settled
        assert not measured(posed, outcome_at(1e-7 * unit, -9e-9 * unit), 1e-6).settled


# ------------------------------------------------------------------ minimising


@pytest.mark.parametrize("unit", [1e-9, 1e-4, 1.0, 1e6])
def test_a_candidate_is_the_least_in_any_unit_of_the_cost(unit: float) -> None:
    outcome = stages.optimise(least_trace(unit=unit))

    if outcome.status == "candidate":
        assert outcome.objective == pytest.approx(unit * lyapunov_trace(), rel=1e-3)
    else:
        assert outcome.status == "unknown" and "was found" in outcome.reason
    assert unit < 1e-3 or outcome.status == "candidate"


def test_a_least_objective_of_zero_is_found() -> None:
    """P > 0 alone: the least trace is 0, and relative to that nothing is near."""
    condition = least_trace()
    condition = replace(condition, lmis=condition.lmis[:1])
    outcome = stages.optimise(condition)

    assert outcome.status == "candidate"
    assert abs(outcome.objective) < 1e-6


P = Unknown("P", 2, 2, symmetric=True)
G = Unknown("g", 1, 1)


@pytest.mark.parametrize(
    "condition",
    [
        pose(P >> np.eye(2), minimise=-trace(P)),
        pose(P >> np.eye(2), G <= trace(P), minimise=-G),
        pose(P >> np.eye(2), trace(P) == G, minimise=-G),
        pose(P >> np.eye(2), minimise=np.array([[1.0, 0]]) @ P @ np.array([[0], [1.0]])),
    ],
)
def test_an_objective_without_a_least_value_is_unbounded(condition: Condition) -> None:
    outcome = stages.optimise(condition)

    assert outcome.status == "unbounded" and "falls without end" in outcome.reason
    assert outcome.objective == -np.inf and not outcome.values
    assert margin(condition, outcome.feasible) >= 0


def test_an_objective_that_equalities_fix_is_settled() -> None:
    """Nothing of it is left free: trace P = 3."""
    outcome = stages.optimise(
        pose(P >> np.eye(2) / 2, P << 3 * np.eye(2), trace(P) == 3, minimise=trace(P))
    )

    assert outcome.status == "candidate" and outcome.objective == pytest.approx(3)


@pytest.mark.parametrize("factor", [1.01, 2.0, 1e27])
def test_far_above_its_bound_it_is_unknown(monkeypatch: pytest.MonkeyPatch, factor: float) -> None:
    condition = least_trace()
    monkeypatch.setattr(stages, "attempts", off_by(factor))
    outcome = stages.optimise(condition)

    assert outcome.status == "unknown" and not outcome.settled
    assert f"{outcome.objective:.5g} was found" in outcome.reason
    assert f"no less than {outcome.lower_bound:.5g}" in outcome.reason
    assert outcome.lower_bound <= lyapunov_trace() < outcome.objective
    assert margin(condition, outcome.feasible) > 0


def test_within_the_tolerance_that_was_asked_for_it_is_a_candidate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Solvers that are 0.05% and 0.5% off, where 1% was asked for and where a millionth was."""
    monkeypatch.setattr(stages, "attempts", off_by(1.0005))
    assert stages.optimise(least_trace(), slack=1e-2).status == "candidate"
    assert stages.optimise(least_trace(), slack=1e-6).status == "candidate"

    monkeypatch.setattr(stages, "attempts", off_by(1.005))
    assert stages.optimise(least_trace(), slack=2e-2).status == "candidate"
    assert stages.optimise(least_trace(), slack=1e-6).status == "unknown"


def test_the_second_stage_takes_no_more_than_the_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    """It finds a margin only at 11 times the least objective: nobody asked for that."""

    def reluctant(program: ConeProgram, name: str, session: Session | None = None) -> Raw:
        raw = again(program, name, session)
        generous = program.b[1] > 5 * lyapunov_trace()
        return raw if generous else replace(raw, y=-raw.y)

    monkeypatch.setattr(stages, "again", reluctant)
    outcome = stages.optimise(least_trace(), slack=1e-2)

    assert outcome.status != "candidate" or outcome.objective <= 1.01 * lyapunov_trace()


def test_a_bound_above_what_was_found_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Multipliers ten times too large "prove" that nothing is below 10: they are dropped."""

    def boasting(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        for number, raw in enumerate(attempts(program, session)):
            yield replace(raw, z=10.0 * raw.z) if number == 0 and program.linear == 0 else raw

    monkeypatch.setattr(stages, "attempts", boasting)
    monkeypatch.setattr(stages, "least_objective_bound", lambda program, raw: -program.b @ raw.z)
    outcome = stages.optimise(least_trace())

    assert outcome.status == "candidate"
    assert outcome.lower_bound <= outcome.objective == pytest.approx(lyapunov_trace(), rel=1e-3)


# ------------------------------------------------------------------ what is made of it

PLANT = TSModel([[[0.0, 1.0], [2.0, -1.0]]], [[[0.0], [1.0]]], E=[[[0.0], [1.0]]])
PERFORMANCE = (np.array([[1.0, 0.0], [0.0, 0.0]]), np.array([[0.0], [0.3]]))


def test_no_gains_and_no_gain_far_above_the_least(monkeypatch: pytest.MonkeyPatch) -> None:
    """``hinf_pdc``: "unknown", with what was found and the bound in the model's units."""
    honest = hinf_pdc(PLANT, performance=PERFORMANCE, tolerance=1e-2)
    assert honest.gain is not None
    monkeypatch.setattr(stages, "attempts", off_by(3.0))
    design = hinf_pdc(PLANT, performance=PERFORMANCE, tolerance=1e-2)

    assert design.status == "unknown" and design.gains is None and design.gain is None
    assert "was found, the least is no less than" in design.answer.diagnosis
    least = float(design.answer.diagnosis.split("no less than ")[1].split(";")[0])
    assert 0.9 * honest.gain <= least <= honest.gain * (1 + 1e-3)
    condition = design.answer.condition
    assert condition is not None and margin(condition, design.answer.feasible) > 0


def test_a_norm_that_p_shows_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """P is right and the objective beside it ten times too large: P decides."""
    B, C = np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    honest = hinf_norm(A[0], B=B, C=C)

    def careless(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        raw = next(attempts(program, session))
        y = raw.y.copy()
        # The last unknown is gamma.
        y[-1] *= 10.0
        yield replace(raw, y=y) if program.linear == 0 else raw

    monkeypatch.setattr(stages, "attempts", careless)
    monkeypatch.setattr(stages, "again", lambda program, name, session=None: broken(program))
    answer = hinf_norm(A[0], B=B, C=C)

    assert answer.status == "candidate"
    assert answer.gain == pytest.approx(honest.gain, rel=1e-3)


def broken(program: ConeProgram) -> Raw:
    return Raw("broken", "NumericalError", np.zeros(0), np.zeros(0), 0, 0.0)
