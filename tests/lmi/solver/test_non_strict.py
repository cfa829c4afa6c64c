"""Non-strict LMIs: no part of the margin, but kept to a stated tolerance, in all units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

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
    exact_no,
    extreme_parameter,
    optimise,
    optimise_by_rounds,
    pdc_condition,
)
from takagi.lmi.condition.evaluate import margin, shares
from takagi.lmi.cone.cone_program import ConeProgram, Raw
from takagi.lmi.decision import decide as stages
from takagi.lmi.solver.solve import Session, attempts
from takagi.models import ModelError, TSModel

X = Unknown("x", 1, 1)
ONE = np.ones((1, 1, 1))


def side(name: str, slope: float, level: float, **kind: Any) -> LMI:
    return LMI(
        name=name,
        blocks=(1,),
        terms=(Term(unknown=X, left=slope * ONE),),
        constants=(Constant(value=level * ONE),),
        **kind,
    )


def between(low: float, high: float, **kind: Any) -> Condition:
    kind = kind or {"strict": False}
    return Condition(
        name="between",
        unknowns=(X,),
        lmis=(side("low", 1.0, -low, **kind), side("high", -1.0, high, **kind)),
        objective={"x": ONE},
    )


def limited(scale: float = 1.0, **kind: Any) -> Condition:
    model = TSModel([[[0.0, 1.0], [1.0, 0.0]]], [[[0.0], [1.0]]])
    condition = pdc_condition(model, relaxation="common-gain")
    Q, M = (next(u for u in condition.unknowns if u.name == name) for name in "QM")
    one = np.eye(2)[None]
    floor = LMI(
        name="initial states",
        blocks=(2,),
        terms=(Term(unknown=Q, left=one, right=one),),
        constants=(Constant(value=-0.1 * scale**2 * one),),
        strict=False,
    )
    limit = LMI(
        name="input limit",
        blocks=(1, 2),
        terms=(
            Term(unknown=M, left=np.ones((1, 1, 1)), right=one, at=(0, 1)),
            Term(unknown=Q, left=one, right=one, at=(1, 1)),
        ),
        constants=(Constant(value=np.full((1, 1, 1), scale**2)),),
        **kind,
    )
    return condition.with_lmis(floor, limit)


def overdriven(values: dict[str, np.ndarray]) -> float:
    M, Q = values["M"][0], values["Q"][0]
    return float((M @ np.linalg.solve(Q, M.T))[0, 0])


# ------------------------------------------------------------------ every LMI is checked


@pytest.mark.parametrize("kind", [{"weight": 0.0}, {"weight": 0}])
def test_an_input_limit_that_is_broken_is_no_candidate(
    monkeypatch: pytest.MonkeyPatch, kind: dict[str, float]
) -> None:
    """A solver that breaks the limit by 9.8%, all else with a margin: the next one is asked."""
    condition = limited(**kind)
    honest = decide(condition)
    assert honest.status == "candidate" and overdriven(dict(honest.values)) <= 1 + 1e-6

    def greedy(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
        raw = next(attempts(program, session))
        y = raw.y.copy()
        u = np.sqrt(overdriven(dict(honest.values)))
        # The unknowns are Q, M and what the effort needs; M alone is made larger.
        y[3:5] *= 1.098 / u
        yield replace(raw, solver="greedy", y=y)
        yield raw

    monkeypatch.setattr(stages, "attempts", greedy)
    outcome = decide(condition)

    assert [one.solver for one in outcome.tries] == ["greedy", "clarabel"]
    assert outcome.tries[0].margin < 0
    assert outcome.status == "candidate" and overdriven(dict(outcome.values)) <= 1 + 1e-6


def test_how_far_is_the_tolerance_that_is_stated() -> None:
    """Half a tolerance outside holds, three of them do not; another one may be given."""
    condition = between(0.0, 2.0)
    for times, good in ((0.5, True), (1.9, True), (3.0, False)):
        held = margin(condition, {"x": 2.0 * (1 + times * 1e-7) * ONE})
        assert (held >= 0) == good, times
    loose = between(0.0, 2.0, strict=False, tolerance=0.1)
    assert margin(loose, {"x": 2.0 * 1.098 * ONE}) >= 0
    assert margin(loose, {"x": 2.0 * 1.3 * ONE}) < 0


@pytest.mark.parametrize("scale", [2.0**-30, 1.0, 2.0**20])
def test_the_tolerance_is_a_share_in_all_units(scale: float) -> None:
    M, Q = np.array([[[-0.9, -0.9]]]), np.eye(2)[None]
    shown = []
    for one in (1.0, scale):
        condition = limited(one, strict=False)
        values = {"M": M * one**2, "Q": Q * one**2}
        shown.append(shares(condition, condition.lmis[-1], values))
    assert shown[1] == pytest.approx(shown[0], rel=1e-12)
    assert shown[0][0] == pytest.approx(1 - 0.9 * np.sqrt(2), rel=1e-12)


def test_a_search_over_a_parameter_keeps_them_too() -> None:
    A = np.array([[[-1.0, 0.5], [0.0, -2.0]]])
    condition = common_lyapunov_condition(A)
    assert [lmi.strict for lmi in condition.lmis].count(False) == 1

    with pytest.raises(ModelError, match="feasible at no value"):
        extreme_parameter(condition, "alpha", start={"P": 3.0 * np.eye(2)[None]})
    found = extreme_parameter(condition, "alpha", start={"P": np.eye(2)[None]})
    assert found.value == pytest.approx(1.0, rel=1e-4)


# ------------------------------------------------------------------ none of them is strict


@pytest.mark.parametrize("solve", [decide, decide_by_rounds, optimise, optimise_by_rounds])
@pytest.mark.parametrize("kind", [{"weight": 0.0}, {"strict": False}])
def test_without_a_strict_one_there_is_an_answer(solve: Any, kind: dict[str, Any]) -> None:
    """Room, a single point, nothing by 10% and by 1e-4: each has its status."""
    for low, high, status in (
        (1.0, 2.0, "candidate"),
        (1e6, 1e6, "candidate"),
        (1.0, 0.9, "infeasible"),
        (1.0, 0.9999, "infeasible"),
    ):
        outcome = solve(between(low, high, **kind))
        assert outcome.status == status, (low, high)
        if status == "candidate":
            assert outcome.margin >= 0
            assert low * (1 - 2e-7) <= outcome.values["x"][0, 0, 0] <= high * (1 + 2e-7)


def test_a_contradiction_by_less_than_can_be_told_is_unknown() -> None:
    """A millionth: no values hold to a ten-millionth, and no bound is as sharp as that."""
    assert decide(between(1.0, 1.0 - 1e-6)).status == "unknown"


def test_non_strict_lmis_that_contradict_one_another_beside_a_strict_one() -> None:
    condition = between(2.0, 1.0)
    condition = replace(condition, lmis=(*condition.lmis, side("up", 1.0, 0.0)))
    outcome = decide(condition)

    assert outcome.status == "infeasible" and len(outcome.tries) == 1


def test_without_an_lmi_there_is_nothing_to_miss() -> None:
    assert margin(Condition(name="nothing", unknowns=(X,), lmis=()), {"x": ONE}) == 0.0


# ------------------------------------------------------------------ the other readers


def test_exact_multipliers_know_the_kind() -> None:
    """1 <= x <= 1 can be satisfied, 1 < x <= 1 cannot; nor can 1 <= x <= 1 - 1e-9."""
    strict = replace(between(1.0, 1.0), lmis=(side("low", 1.0, -1.0), between(1, 1).lmis[1]))
    no = exact_no(strict)

    assert exact_no(between(1.0, 1.0)) is None
    assert no is not None and no.holds
    assert no.multipliers["low"][0, 0, 0] > Fraction(0)
    less = exact_no(between(1.0, 1.0 - 1e-9))
    assert less is not None and less.holds


# ------------------------------------------------------------------ the kind itself


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ({"weight": -1.0}, "weight is -1.0; a positive number is needed, or strict=False"),
        ({"weight": np.nan}, "weight is nan"),
        ({"weight": np.inf}, "weight is inf"),
        ({"strict": False, "tolerance": -1e-9}, "tolerance is -1e-09"),
        ({"strict": False, "tolerance": 1.0}, "tolerance is 1.0"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(kind: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        side("a", 1.0, 0.0, **kind)


def test_an_answer_just_outside_a_non_strict_lmi_is_moved_inside(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nearly the least x, without another solver: the first step towards the start that holds."""
    condition = Condition(
        name="least x above two",
        unknowns=(X,),
        lmis=(
            side("positive", 1.0, 0.0),
            side("floor", 1.0, -2.0, strict=False),
            side("high", -1.0, 4.0),
        ),
        objective={"x": ONE},
    )
    start = decide(condition)
    solver = attempts
    asked: list[float] = []

    def short(by: float) -> None:
        def fell_short(program: ConeProgram) -> Iterator[Raw]:
            for raw in solver(program):
                asked.append(by)
                yield replace(raw, y=raw.y * (1.0 - by))

        monkeypatch.setattr(stages, "attempts", fell_short)

    short(1e-6)
    near = stages.improve(condition, start)
    assert len(asked) == 1
    assert 2.0 * (1.0 - 1e-8) <= near.values["x"][0, 0, 0] <= 2.0 * (1.0 + 1e-4)
    assert near.objective < start.values["x"][0, 0, 0]
    short(1.0)
    far = stages.improve(condition, start)
    assert far.values["x"][0, 0, 0] <= start.values["x"][0, 0, 0]
    assert margin(condition, far.values) > 0.0
