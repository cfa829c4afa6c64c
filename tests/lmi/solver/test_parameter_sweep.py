"""A sweep is one assembly and one set-up, and says what separate calls say."""

from __future__ import annotations

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
    optimise,
    sweep,
)
from takagi.models import ModelError

SLOW = np.array([[-1.0, 2.0], [-3.0, -4.0]])


def least_trace(A: np.ndarray) -> Condition:
    """Return: least tr P with P >= I and A'P + PA + 2 alpha P <= 0."""
    n = len(A)
    P, one = Unknown("P", n, n, symmetric=True), np.eye(n)[None]
    floor = LMI(
        name="floor",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=one),),
        constants=(Constant(value=-one),),
    )
    decay = LMI(
        name="decay",
        blocks=(n,),
        terms=(
            Term(unknown=P, left=one, right=A[None], plus_transpose=True),
            Term(unknown=P, left=2 * one, right=one, parameter="alpha"),
        ),
        sign=-1,
    )
    return Condition(
        name="least trace",
        unknowns=(P,),
        lmis=(floor, decay),
        objective={"P": one},
        parameters={"alpha": 0.0},
    )


def test_a_sweep_says_what_separate_calls_say() -> None:
    """Beyond the abscissa, -2.5, there is no P: the verdict turns where the eigenvalue says."""
    condition = common_lyapunov_condition(SLOW)
    limit = -np.linalg.eigvals(SLOW).real.max()
    for rate, outcome in sweep(condition, "alpha", [0.0, 1.0, limit - 1e-2, limit + 1e-2, 0.5]):
        alone = decide(condition.with_parameters(alpha=rate))
        assert outcome.status == alone.status
        assert outcome.status == ("candidate" if rate < limit else "infeasible")
        assert outcome.margin == pytest.approx(alone.margin, rel=1e-4, abs=1e-8)


def test_the_least_objective_along_a_sweep() -> None:
    """With ``optimise``: what is asked for costs more the faster the decay, and all is settled."""
    found = list(sweep(least_trace(SLOW), "alpha", [0.0, 1.0, 2.0], stage=optimise))
    alone = [optimise(least_trace(SLOW).with_parameters(alpha=rate)) for rate, _ in found]

    assert all(outcome.settled for _, outcome in found)
    traces = [outcome.objective for _, outcome in found]
    assert traces == sorted(traces) and traces[0] < traces[-1]
    assert traces == pytest.approx([outcome.objective for outcome in alone], rel=1e-4)


def test_values_may_depend_on_outcomes() -> None:
    """A bisection is a sweep whose values are made on the way."""
    bracket = [0.0, 5.0]

    def middle() -> Any:
        while bracket[1] - bracket[0] > 1e-4:
            yield sum(bracket) / 2

    for rate, outcome in sweep(common_lyapunov_condition(SLOW), "alpha", middle()):
        bracket[0 if outcome.status == "candidate" else 1] = rate

    assert bracket[0] == pytest.approx(2.5, abs=2e-4)


def test_a_parameter_that_is_not_there() -> None:
    """Named, with those that are; at the call, not at the first value."""
    with pytest.raises(ModelError, match="no parameter 'beta'.*alpha"):
        sweep(common_lyapunov_condition(SLOW), "beta", [0.0])


def test_a_value_that_is_no_number() -> None:
    """Refused when it is met."""
    with pytest.raises(ModelError, match="alpha"):
        list(sweep(common_lyapunov_condition(SLOW), "alpha", [float("nan")]))
