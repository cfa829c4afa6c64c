"""Exact reasons for a no: what they prove, on both sides of thresholds, and what breaks them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.lmi import (
    LMI,
    Alternative,
    Condition,
    Constant,
    Term,
    Unknown,
    common_lyapunov,
    common_lyapunov_condition,
    decide,
    exact_matrices,
    exact_no,
    pdc_condition,
    rigorous_no,
)
from takagi.lmi.condition.term import Array
from takagi.lmi.refutation.exact_algebra import is_definite, is_semidefinite
from takagi.models import Floats, ModelError, TSModel


def fraction_array(rows: object) -> Array:
    given_ = np.array(rows, dtype=object)
    exact = np.empty(given_.shape, dtype=object)
    for index, entry in np.ndenumerate(given_):
        exact[index] = Fraction(entry)
    return exact


def dayawansa_martin(a: Fraction) -> Array:
    return fraction_array([[[-1, -1], [1, -1]], [[-1, -a], [1 / a, -1]]])


def lpj12(change: Fraction) -> Array:
    return fraction_array([[[-2, 4], [-1, -2]], [[-2, 4], [-1 - change, -2]]])


def fixed_gain_loops(b: Fraction, a: Fraction = Fraction(1)) -> Array:
    """Return G11 = G22 and (G12 + G21) / 2 of the two-rule problem with poles placed at -2, -2."""
    A1, A2 = fraction_array([[2, -10], [1, 0]]), fraction_array([[a, -10], [1, 0]])
    B1, B2 = fraction_array([[1], [0]]), fraction_array([[b], [0]])
    F1, F2 = fraction_array([[6, -6]]), fraction_array([[(a + 4) / b, -6 / b]])
    return np.stack([A1 - B1 @ F1, (A1 - B1 @ F2 + A2 - B2 @ F1) / 2])


def exactly_holds(condition: Condition, values: dict[str, Floats]) -> bool:
    return all(
        (is_definite if lmi.strict else is_semidefinite)(F)
        for lmi in condition.lmis
        for F in exact_matrices(condition, lmi, values)
    )


@pytest.mark.parametrize(
    ("vertices", "feasible", "infeasible"),
    [
        # Dayawansa and Martin (1999): a common P exists exactly for a < 3 + sqrt(8) = 5.82842712...
        (dayawansa_martin, Fraction("5.828427"), Fraction("5.828428")),
        # Shorten and Narendra (2002): exactly for a change below 4 + 4 sqrt(2) = 9.65685425...
        (lpj12, Fraction("9.656853"), Fraction("9.656855")),
        # G12 + G21 is stable exactly for b + 1/b < 10/3; at b = 3 it is singular.
        (fixed_gain_loops, Fraction("2.99999"), Fraction(3)),
    ],
)
def test_both_sides_of_a_threshold_exactly(
    vertices: Callable[[Fraction], Array], feasible: Fraction, infeasible: Fraction
) -> None:
    yes = common_lyapunov_condition(vertices(feasible))
    no = common_lyapunov_condition(vertices(infeasible))

    assert exactly_holds(yes, dict(decide(yes).values))
    assert exact_no(yes) is None
    alternative = exact_no(no)
    assert alternative is not None and alternative.holds
    assert "contradict" in str(alternative)


def test_a_decay_rate_is_ruled_out_where_it_is_reached() -> None:
    """Eigenvalues -5/2 +- j sqrt(15)/2: 2.5 is not below 2.5, and 2.4999 is."""
    condition = common_lyapunov_condition([[-1.0, 2.0], [-3.0, -4.0]])
    slower = condition.with_parameters(alpha=2.4999)

    assert exact_no(condition, parameters={"alpha": Fraction(5, 2)}) is not None
    assert exact_no(condition, parameters={"alpha": Fraction("2.4999")}) is None
    assert exactly_holds(slower, dict(decide(slower).values))


def test_a_parameter_counts_as_the_rational_that_is_given() -> None:
    """A scalar with rate 1/10: the float 0.1 is a hair above, so it is excluded and 1/10 is too."""
    condition = common_lyapunov_condition(fraction_array([[[Fraction(-1, 10)]]]))
    hair = Fraction(1, 10**30)

    assert exact_no(condition, parameters={"alpha": Fraction(1, 10)}) is not None
    assert exact_no(condition.with_parameters(alpha=0.1)) is not None
    assert exact_no(condition, parameters={"alpha": Fraction(1, 10) - hair}) is None


@pytest.mark.parametrize(
    "A",
    [
        # A pendulum upright: one eigenvalue of each sign, both irrational.
        [[0.0, 1.0], [9.81, -0.1]],
        [[0.0, 1.0], [2.0, 0.0]],
        # Exactly undamped, and an integrator.
        [[0.0, 1.0], [-2.5, 0.0]],
        [[0.0, 1.0], [0.0, -1.0]],
        # All modes grow.
        [[1.0, 1.0], [0.0, 2.0]],
    ],
)
def test_a_vertex_that_is_not_stable_is_ruled_out(A: list[list[float]]) -> None:
    stable = np.diag([-1.0, -2.0])
    alternative = rigorous_no(common_lyapunov(np.array([stable, A])))

    assert alternative is not None and alternative.holds
    assert "no unknowns satisfy it" in str(alternative)


@pytest.mark.parametrize(
    "A", [[[0.0, 1.0], [1.0, 0.5]], [[0.5, 1.0], [0.0, 1.0]], [[0.0, -1.5], [1.0, 0.0]]]
)
def test_a_vertex_outside_the_unit_disc_is_ruled_out(A: list[list[float]]) -> None:
    """Eigenvalues (1 +- sqrt 17) / 4, irrational; 1, exactly; and a pair of size 1.22."""
    stable = 0.5 * np.eye(2)
    alternative = rigorous_no(common_lyapunov(np.array([stable, A]), sample_time=0.1))

    assert alternative is not None and alternative.holds
    assert (
        rigorous_no(common_lyapunov(np.array([stable, A]), sample_time=0.1, decay_rate=-3.0))
        is None
    )


def test_an_indefinite_function_must_decay_and_must_be_indefinite() -> None:
    """Lyapunov's instability theorem: the function of one matrix says nothing about another."""
    saddle = common_lyapunov_condition([[0.0, 1.0], [2.0, 0.0]])
    found = exact_no(saddle)
    assert found is not None and not found.multipliers
    P = found.function["P"]

    assert Alternative(condition=saddle, function={"P": 2 * P}).holds
    assert "no vertex decays" in Alternative(condition=saddle, function={"P": -P}).fault()
    stable = common_lyapunov_condition([[0.0, 1.0], [-2.0, -1.0]])
    assert not Alternative(condition=stable, function={"P": P}).holds
    definite = decide(stable).values["P"]
    assert "positive definite" in Alternative(condition=stable, function={"P": definite}).fault()
    skewed = P.copy()
    skewed[0, 0, 1] += 1
    assert "not symmetric" in Alternative(condition=saddle, function={"P": skewed}).fault()
    assert "(1, 2, 2)" in Alternative(condition=saddle, function={"P": P[0]}).fault()
    gains = pdc_condition(TSModel([[[1.0]]], [[[1.0]]]))
    assert "single symmetric unknown" in Alternative(condition=gains, function={"Q": P}).fault()


def test_a_function_proves_nothing_where_singular_ones_may_satisfy_the_item() -> None:
    """F(P) = p11 I is positive for diag(1, -1), which is indefinite, and for I as well."""
    P = Unknown("P", 2, 2, symmetric=True)
    one, first = np.eye(2)[None], np.array([[[1.0, 0.0], [0.0, 0.0]]])
    second = np.array([[[0.0, 1.0], [0.0, 0.0]]])
    positive = LMI(
        name="P positive definite", blocks=(2,), terms=(Term(unknown=P, left=one, right=one),)
    )
    corner = LMI(
        name="corner",
        blocks=(2,),
        terms=tuple(Term(unknown=P, left=R.transpose(0, 2, 1), right=R) for R in (first, second)),
    )
    condition = Condition(name="corner", unknowns=(P,), lmis=(positive, corner))
    indefinite = fraction_array([[[1, 0], [0, -1]]])

    assert exactly_holds(condition, {"P": np.eye(2)[None]})
    assert is_definite(exact_matrices(condition, corner, {"P": indefinite})[0])
    assert not Alternative(condition=condition, function={"P": indefinite}).holds
    assert exact_no(condition) is None


def proof() -> Alternative:
    found = exact_no(common_lyapunov_condition(dayawansa_martin(Fraction(7))))
    assert found is not None
    return found


def test_the_multipliers_are_checked_against_another_reader() -> None:
    """For any P the sum of <sign F_k(P), Z_k> is zero, by ``exact_matrices``."""
    found = proof()
    P = fraction_array([[["1/3", "-2"], ["-2", "5/7"]]])
    total = sum(
        (exact_matrices(found.condition, lmi, {"P": P}) * found.multipliers[lmi.name]).sum()
        for lmi in found.condition.lmis
        if lmi.name != "scale of P"
    )

    assert total == 0
    assert not found.multipliers["scale of P"].any()


@pytest.mark.parametrize("item", [0, 1])
@pytest.mark.parametrize(("row", "column"), [(0, 0), (0, 1), (1, 1)])
def test_a_multiplier_that_was_tampered_with_is_refused(item: int, row: int, column: int) -> None:
    """By one part in 10^40, which no floating point could see."""
    found = proof()
    changed = {name: Z.copy() for name, Z in found.multipliers.items()}
    Z = changed["vertex"][item]
    Z[row, column] *= 1 + Fraction(1, 10**40)
    Z[column, row] = Z[row, column]

    assert found.holds
    assert "depends on P" in replace(found, multipliers=changed).fault()


def test_each_requirement_is_checked_by_itself() -> None:
    found = proof()
    zero = {name: 0 * Z for name, Z in found.multipliers.items()}
    assert "all zero" in replace(found, multipliers=zero).fault()
    negative = {name: -Z for name, Z in found.multipliers.items()}
    assert "not positive semidefinite" in replace(found, multipliers=negative).fault()
    skewed = {name: Z.copy() for name, Z in found.multipliers.items()}
    skewed["vertex"][0, 0, 1] += 1
    assert "not symmetric" in replace(found, multipliers=skewed).fault()
    scaled = {**found.multipliers, "scale of P": np.ones((1, 2, 2))}
    assert not replace(found, multipliers=scaled).holds
    feasible = common_lyapunov_condition(dayawansa_martin(Fraction(5)))
    assert not replace(found, condition=feasible).holds
    assert "nothing is shown" in str(replace(found, condition=feasible))
    with pytest.raises(ModelError, match="there is no LMI 'vertices'"):
        replace(found, multipliers={"vertices": np.zeros((2, 2, 2))}).fault()
    with pytest.raises(ModelError, match=r"shape \(1, 2, 2\); \(2, 2, 2\) is needed"):
        replace(found, multipliers={"vertex": np.zeros((1, 2, 2))}).fault()


def test_a_positive_constant_is_no_contradiction() -> None:
    """Z for P <= I alone, with one for P > 0 that cancels P: the sum is a positive number."""
    condition = common_lyapunov_condition([[-1.0]])
    one = np.ones((1, 1, 1))
    faults = Alternative(
        condition=condition, multipliers={"scale of P": one, "P positive definite": one}
    ).fault()

    assert "must not be positive" in faults


def interval(lower: float, upper: float, weight: float) -> Condition:
    x = Unknown("x", 1, 1)
    one = np.ones((1, 1, 1))

    def half(name: str, sign: int, end: float) -> LMI:
        return LMI(
            name=name,
            blocks=(1,),
            terms=(Term(unknown=x, left=one),),
            constants=(Constant(value=-end * one),),
            sign=sign,
            weight=weight,
        )

    return Condition(
        name="interval", unknowns=(x,), lmis=(half("above", 1, lower), half("below", -1, upper))
    )


def test_inequalities_that_may_be_touched_contradict_one_another_only_with_a_gap() -> None:
    """x >= 1 and x <= 1 hold at 1; x > 1 and x < 1 nowhere; x >= 1 and x <= 1 - 2^-40 nowhere."""
    both = {"above": np.ones((1, 1, 1)), "below": np.ones((1, 1, 1))}
    touched = Alternative(condition=interval(1.0, 1.0, 0.0), multipliers=both)

    assert "strict LMIs are all zero" in touched.fault()
    assert exact_no(interval(1.0, 1.0, 0.0)) is None
    assert Alternative(condition=interval(1.0, 1.0, 1.0), multipliers=both).holds
    assert exact_no(interval(1.0, 1.0, 1.0)) is not None
    assert Alternative(condition=interval(1.0, 1.0 - 2.0**-40, 0.0), multipliers=both).holds
    assert exact_no(interval(1.0, 0.5, 0.0)) is not None
    assert exact_no(interval(0.5, 1.0, 1.0)) is None


@st.composite
def integer_pairs(draw: st.DrawFn) -> Array:
    entries = st.integers(-4, 4)
    return np.array(draw(st.lists(entries, min_size=8, max_size=8)), dtype=float).reshape(2, 2, 2)


@given(integer_pairs())
def test_never_both_a_proof_and_a_solution(A: Floats) -> None:
    """Shorten and Narendra (2002): a common P iff neither A1 A2 nor A1 A2^-1 has one below zero."""
    condition = common_lyapunov_condition(A)
    outcome = decide(condition)
    proof_ = exact_no(condition, outcome.multipliers)

    if outcome.status == "candidate" and exactly_holds(condition, dict(outcome.values)):
        assert proof_ is None
        assert exact_no(condition) is None
    if np.linalg.eigvals(A).real.max() < -1e-6:
        products = np.linalg.eigvals(np.array([A[0] @ A[1], A[0] @ np.linalg.inv(A[1])]))
        if ((products.imag == 0) & (products.real < -1e-6)).any():
            assert proof_ is not None
        elif not ((np.abs(products.imag) < 1e-3) & (products.real < 1e-3)).any():
            assert outcome.status == "candidate"
    elif np.linalg.eigvals(A).real.max() > 1e-6:
        assert proof_ is not None


@given(st.data())
def test_definiteness_is_exact_whatever_the_size_of_the_entries(data: st.DataObject) -> None:
    """L D L' with known D, in numbers of many digits: definite, singular or indefinite."""
    n = data.draw(st.integers(1, 5))
    pivots = data.draw(st.lists(st.integers(-1, 2), min_size=n, max_size=n))
    entries = data.draw(st.lists(st.integers(-3, 3), min_size=n * n, max_size=n * n))
    power = data.draw(st.integers(0, 400))
    L = np.array(entries, dtype=object).reshape(n, n)
    L = np.where(np.tri(n, k=-1, dtype=bool), L, 0) + np.diag([1] * n).astype(object)
    M = (L * np.array(pivots, dtype=object)) @ L.T * (3**power) * Fraction(1, 7)
    hair = Fraction(1, 11**200)

    assert is_definite(M) == (min(pivots) > 0)
    assert is_semidefinite(M) == (min(pivots) >= 0)
    assert is_definite(M + hair * np.eye(n, dtype=object)) == (min(pivots) >= 0)
    assert not is_semidefinite(M - hair * np.eye(n, dtype=object)) or min(pivots) > 0


@pytest.mark.parametrize(
    "rows",
    [
        # A zero pivot with something beside it.
        [[0, 1], [1, 0]],
        [[0, 1], [1, 5]],
        # The leading 96 bits, rounded down, are those of a definite matrix.
        [[2**200, 2**200 - 1], [2**200 - 1, 2**200 - 3]],
    ],
)
def test_matrices_that_look_semidefinite_and_are_not(rows: list[list[int]]) -> None:
    M = fraction_array(rows)

    assert M[0, 0] * M[1, 1] - M[0, 1] ** 2 < 0
    assert not is_semidefinite(M)
    assert not is_definite(M)
