"""What multipliers exclude of a parameter's values, and where they exclude nothing."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import LMI, Condition, Constant, Term, Unknown, extreme_parameter
from takagi.lmi.parameter_search.largest_parameter import excluded_from

X = Unknown("X", 2, 2, symmetric=True)


def entry(k: int, factor: float = 1.0, parameter: str | None = None) -> Term:
    """Return the term factor * X_kk, times the parameter."""
    e = np.eye(2)
    return Term(
        unknown=X, left=factor * e[None, [k], :], right=e[None, :, [k]], parameter=parameter
    )


def limit(term: Term, value: NDArray[np.float64], sign: int) -> LMI:
    """Return sign (term - value) >= 0, which may be touched."""
    n = len(value)
    constant = Constant(value=-value[None])
    return LMI(
        name=f"limit {sign} {n} {value[0, 0]}",
        blocks=(n,),
        terms=(term,),
        constants=(constant,),
        sign=sign,
        strict=False,
    )


def indefinite() -> Condition:
    """Return X_11 > 0, -X_22 > theta X_11 with X_11 >= 1, X_22 >= -50, -100 I <= X <= 100 I."""
    one = np.eye(2)
    whole = Term(unknown=X, left=one[None], right=one[None])
    return Condition(
        name="an unknown that need not be positive definite",
        unknowns=(X,),
        lmis=(
            LMI(name="first", blocks=(1,), terms=(entry(0),)),
            LMI(name="main", blocks=(1,), terms=(entry(1, -1.0), entry(0, -1.0, "theta"))),
            limit(entry(0), np.array([[1.0]]), 1),
            limit(entry(1), np.array([[-50.0]]), 1),
            limit(whole, 100.0 * one, -1),
            limit(whole, -100.0 * one, 1),
        ),
        parameters={"theta": 0.0},
    )


def test_an_unknown_that_is_not_positive_is_not_excluded_by_semidefiniteness() -> None:
    """The largest theta is 50 by hand, at X_11 = 1, X_22 = -50.

    Multipliers with S0 + theta S1 = -diag(theta, 1) rule out X > 0 only, which is not asked for.
    """
    one = np.ones((1, 1, 1))
    multipliers = {"first": one, "main": one}
    assert excluded_from(indefinite(), "theta", multipliers, largest=True) == np.inf
    found = extreme_parameter(indefinite(), "theta")
    assert found.value == pytest.approx(50.0, rel=1e-4)
    assert found.bound >= 50.0 * (1 - 1e-6)


@pytest.mark.parametrize("L", [np.eye(2), np.array([[2.0, 1.0], [0.0, 0.5]])])
def test_a_congruent_of_a_positive_unknown_excludes(L: NDArray[np.float64]) -> None:
    """X > 0 and -X_22 > theta X_11: every theta >= 0 is excluded, none below."""
    positive = Term(unknown=X, left=L.T[None], right=L[None])
    plain = indefinite()
    condition = Condition(
        name="a positive definite one",
        unknowns=(X,),
        lmis=(LMI(name="positive", blocks=(2,), terms=(positive,)), plain.lmis[1]),
        parameters={"theta": 0.0},
    )
    multipliers = {"positive": np.eye(2)[None], "main": np.ones((1, 1, 1))}
    assert excluded_from(condition, "theta", multipliers, largest=True) == pytest.approx(0.0)
    singular = Term(unknown=X, left=np.ones((1, 2, 2)), right=np.ones((1, 2, 2)))
    weaker = LMI(name="positive", blocks=(2,), terms=(singular,))
    poor = Condition(
        name="positive in one direction",
        unknowns=(X,),
        lmis=(weaker, plain.lmis[1]),
        parameters={"theta": 0.0},
    )
    assert excluded_from(poor, "theta", multipliers, largest=True) == np.inf
