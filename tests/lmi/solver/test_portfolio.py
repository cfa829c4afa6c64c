"""Whichever solver errs first, another is asked; which is first is foretold from the sizes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from takagi.lmi import Condition, common_lyapunov_condition, hinf_norm_condition, pdc_condition
from takagi.lmi.cone.cone_program import (
    ConeProgram,
    Raw,
    SolverRow,
    assemble,
    cone_program,
    least_objective_bound,
)
from takagi.lmi.decision import decide as stages
from takagi.lmi.solver import installed_solvers, solve
from takagi.lmi.solver.solve import Session, again, attempts
from takagi.models import TSModel
from tests.lmi.solver.control import OPTIMUM, control1

pytestmark = pytest.mark.numeric

needs_sdpa = pytest.mark.skipif(
    not installed_solvers.sdpa_is_installed(), reason="sdpa-python is not installed"
)


def least_program(condition: Condition) -> ConeProgram:
    data = assemble(condition)
    return cone_program(data, data.objective, (), margin=0.0)


def margin_program(condition: Condition, *more: SolverRow) -> ConeProgram:
    data = assemble(condition)
    t = np.eye(len(data.objective) + 1)[-1]
    return cone_program(data, -t, (SolverRow(t, 1.0), *more))


def random_vertices(count: int, n: int, seed: int = 3) -> np.ndarray:
    E = np.random.default_rng(seed).normal(size=(count, n, n))
    E *= 0.8 / np.linalg.norm(E, 2, axis=(1, 2))[:, None, None]
    return np.asarray(E - np.eye(n))


def gain_condition(vertices: int, n: int, width: int) -> Condition:
    random = np.random.default_rng(4)
    A = random_vertices(vertices, n)
    return hinf_norm_condition(
        A, B=random.normal(size=(n, width)), C=random.normal(size=(width, n))
    )


def slack_condition() -> Condition:
    random = np.random.default_rng(5)
    B = random.normal(size=(10, 2)) + 0.01 * random.normal(size=(6, 10, 2))
    model = TSModel(random_vertices(6, 10), B)
    return pdc_condition(model, relaxation="tanaka-wang")


def effort(condition: Condition) -> SolverRow:
    data = assemble(condition)
    return SolverRow(np.eye(len(data.objective) + 1)[data.offsets["nu"]], 100.0)


# ------------------------------------------------------------------ a solver that errs


@pytest.mark.parametrize("whole", [False, True])
def test_control1_has_its_published_optimum(whole: bool) -> None:
    """SDPLIB 1.2 (Borchers 1999): control1 has the optimum 17.78463, in one block or two."""
    outcome = stages.optimise(control1(whole=whole))

    assert outcome.settled and outcome.margin > 0
    assert outcome.objective == pytest.approx(OPTIMUM, rel=5e-5)
    assert outcome.lower_bound <= outcome.objective


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("first", ["clarabel, chordal", "clarabel, regularised"])
def test_whichever_errs_first_the_optimum_is_the_published_one(
    monkeypatch: pytest.MonkeyPatch, first: str, whole: bool
) -> None:
    """With chordal decomposition clarabel ends at 18.06, "Solved" and feasible: found out."""

    def turned(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        raws = list(islice(attempts(program, session), 3))
        raws.sort(key=lambda raw: raw.solver != first)
        yield from raws

    monkeypatch.setattr(stages, "attempts", turned)
    outcome = stages.optimise(control1(whole=whole))

    # Both stages by the solver that was asked.
    assert [one.solver for one in outcome.tries[:2]] == [first, first]
    assert outcome.settled
    assert outcome.objective == pytest.approx(OPTIMUM, rel=5e-5)


@pytest.mark.parametrize("whole", [False, True])
def test_centring_that_fails_next_to_the_optimum_is_tried_in_better_units(
    monkeypatch: pytest.MonkeyPatch, whole: bool
) -> None:
    """Before a thousandth is given away, the same is asked where the solution is of order one."""

    def fails_closely(program: ConeProgram, name: str, session: Session | None = None) -> Raw:
        raw = again(program, name, session)
        # The second stage's rows are the margin's and the objective's.
        near = program.linear == 2 and program.b[1] < 1.0005 * OPTIMUM
        return replace(raw, y=raw.y * (1 - 1e-4)) if near else raw

    monkeypatch.setattr(stages, "again", fails_closely)
    outcome = stages.optimise(control1(whole=whole))

    assert outcome.settled
    assert outcome.objective == pytest.approx(OPTIMUM, rel=5e-5)
    assert "clarabel, rescaled" in [one.solver for one in outcome.tries]


def test_an_objective_far_above_its_bound_is_not_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    condition = gain_condition(2, 3, 1)
    honest = stages.optimise(condition)

    def lazy(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        raw = next(attempts(program, session))
        yield replace(raw, y=2.0 * raw.y) if program.linear == 0 else raw

    monkeypatch.setattr(stages, "attempts", lazy)
    monkeypatch.setattr(stages, "rescaled", lambda program, raw: None)
    outcome = stages.optimise(condition)

    assert outcome.status == "unknown" and not outcome.settled
    assert outcome.objective == pytest.approx(2.0 * honest.objective, rel=1e-2)
    assert outcome.lower_bound <= honest.objective <= outcome.objective


def test_indefinite_multipliers_bound_nothing() -> None:
    """Stationary to the last digit and 10 above the optimum, but not in the cone: set right."""
    program = least_program(gain_condition(2, 2, 2))
    raw = Session().solve(program)
    best = float(program.q @ raw.y)
    A = program.A.toarray()
    step = program.b - A @ np.linalg.lstsq(A, program.b)[0]
    false = replace(raw, z=raw.z - 10.0 * step / (program.b @ step))

    assert np.allclose(A.T @ false.z, A.T @ raw.z)
    assert -program.b @ false.z == pytest.approx(best + 10.0, rel=1e-4)
    assert least_objective_bound(program, false) <= best
    assert least_objective_bound(program, raw) == pytest.approx(best, rel=1e-5)


# ------------------------------------------------------------------ sdpa


@needs_sdpa
@pytest.mark.parametrize(
    "program",
    [
        margin_program(common_lyapunov_condition(random_vertices(6, 3))),
        least_program(gain_condition(3, 3, 2)),
        least_program(control1(whole=True)),
        # 1 x 1 cones are linear rows there.
        margin_program(common_lyapunov_condition(random_vertices(2, 1))),
    ],
    ids=["margin", "gain", "control1", "scalar"],
)
def test_sdpa_agrees_with_clarabel(program: ConeProgram) -> None:
    """Two solvers, one program: the same optimum, and multipliers of the same meaning."""
    ours, other = Session().solve(program), again(program, "sdpa")
    best = float(program.q @ ours.y)

    assert program.q @ other.y == pytest.approx(best, rel=1e-5, abs=1e-6)
    assert -program.b @ other.z == pytest.approx(best, rel=1e-5, abs=1e-6)
    assert np.abs(program.A.T @ other.z + program.q).max() < 1e-5


@pytest.mark.slow
@needs_sdpa
def test_sdpa_writes_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """Its remarks ("Strange behavior", here) would stand in the middle of somebody's JSON."""
    condition = slack_condition()
    print("before")
    again(margin_program(condition, effort(condition)), "sdpa")
    print("after")

    assert capfd.readouterr().out == "before\nafter\n"


@needs_sdpa
def test_sdpa_begins_again_when_it_does_not_move(monkeypatch: pytest.MonkeyPatch) -> None:
    """From an identity smaller than the solution sdpa takes no step; from a larger one it does."""
    n = 2
    A = np.array([[[0.0, 1.0], [-1.0, -0.1]]])
    condition = common_lyapunov_condition(A, decay_rate=0.01)
    bound = SolverRow(np.concatenate([1e-6 * np.ones(n * (n + 1) // 2), [0.0]]), 1e4)
    program = margin_program(condition, bound)
    best = again(program, "clarabel").y[-1]
    monkeypatch.setattr(installed_solvers, "SMALLEST_BEGINNING", 0.0)
    monkeypatch.setattr(installed_solvers, "BEGINNINGS", (1e-9,))
    stuck = installed_solvers.with_sdpa(program)
    monkeypatch.setattr(installed_solvers, "BEGINNINGS", (1e-9, 1e2))

    assert stuck.iterations < installed_solvers.STUCK
    assert installed_solvers.with_sdpa(program).y[-1] == pytest.approx(best, abs=1e-5)


# ------------------------------------------------------------------ which is first


def test_without_sdpa_clarabel_is_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solve, "sdpa_is_installed", lambda: False)
    monkeypatch.setattr(solve, "prefers_sdpa", lambda found: True)
    program = least_program(gain_condition(2, 5, 3))

    assert next(attempts(program)).solver == "clarabel"


# ------------------------------------------------------------------ elimination
