"""Definiteness by characteristic polynomials, against elimination and on known matrices."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from flint import fmpz_mat
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker.arithmetic.interval import enclose
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Inequality,
    Relation,
    nonnegative,
    not_positive,
    positive,
)
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.evaluate import Evaluator
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.plant_claim import Enclosure
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.cross_check.ball_ranges import keeps_bounds
from takagi.certificates.cross_check.comparison import FlintDecider, is_definite
from tests.certificates.test_found_by_broken_lines import graph_of

entries = st.integers(-9, 9)


def decided(value: Any, relation: Relation) -> bool:
    required = Inequality(value, relation, "it does not hold")
    answer = FlintDecider()(required)
    assert answer is required.holds
    return answer


@given(st.integers(1, 5), st.data())
def test_random_matrices_as_by_all_principal_minors(n: int, data: Any) -> None:
    """Sylvester: definite exactly if the leading minors are positive; over any denominator."""
    rows = [[0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            rows[i][j] = rows[j][i] = data.draw(entries)
        rows[i][i] += data.draw(st.integers(0, 25))
    minors = [fmpz_mat([row[:k] for row in rows[:k]]).det() for k in range(1, n + 1)]
    matrix = Matrix(rows, data.draw(st.integers(1, 50)))

    definite = min(minors) > 0
    assert decided(matrix, Relation.POSITIVE) is definite
    assert decided(matrix, Relation.NOT_POSITIVE) is not definite
    assert decided(matrix, Relation.NONNEGATIVE) or not definite


@given(st.lists(st.lists(entries, min_size=3, max_size=3), min_size=1, max_size=4))
def test_a_gram_matrix_is_semidefinite(vectors: list[list[int]]) -> None:
    """G = V V' >= 0, singular with more vectors than dimensions; then G - I/1000 is not."""
    gram = [[sum(a * b for a, b in zip(u, v, strict=True)) for v in vectors] for u in vectors]

    assert decided(Matrix(gram), Relation.NONNEGATIVE)
    if fmpz_mat(gram).det() == 0:
        less = Matrix(gram) - Fraction(1, 1000) * Matrix.identity(len(gram))
        assert not decided(Matrix(gram), Relation.POSITIVE)
        assert not decided(less, Relation.NONNEGATIVE)


@pytest.mark.parametrize("over", [10**30, -(10**30)])
def test_a_hair_on_both_sides_of_the_threshold(over: int) -> None:
    """[[1, 1], [1, 1 + e]] is definite exactly for e > 0."""
    size = abs(over)
    matrix = Matrix([[size, size], [size, size + over // size]], size)

    assert decided(matrix, Relation.POSITIVE) is (over > 0)
    assert decided(matrix, Relation.NONNEGATIVE) is (over > 0)


@pytest.mark.parametrize("rows", [[[2, 1], [0, 2]], [[-2, 1], [0, -2]]])
@pytest.mark.parametrize("relation", Relation)
def test_a_matrix_that_is_not_symmetric_has_no_relation(
    rows: list[list[int]], relation: Relation
) -> None:
    assert not decided(Matrix(rows), relation)


def test_negative_eigenvalues_of_even_number_are_seen() -> None:
    """det > 0 alone says nothing."""
    assert not is_definite(fmpz_mat([[-1, 0], [0, -1]]), strict=False)


@pytest.mark.parametrize(("value", "answers"), [(-1, (False, False)), (0, (False, True))])
def test_numbers(value: int, answers: tuple[bool, bool]) -> None:
    small = Fraction(value, 10**40)
    assert decided(small, Relation.POSITIVE) is answers[0]
    assert decided(small, Relation.NONNEGATIVE) is answers[1]
    assert decided(small + Fraction(2, 10**40), Relation.POSITIVE)


def test_what_was_decided_is_counted() -> None:
    decider = FlintDecider()
    for required in (positive(Matrix([[1]]), "a"), not_positive(Matrix([[0]]), "b")):
        assert decider(required)
    assert decider(nonnegative(Fraction(0), "c"))
    assert (decider.matrices, decider.numbers, decider.ranges, decider.left_open) == (2, 1, 0, 0)


INSIDE = Fraction(1, 10**7)


def enclosure(
    text: str, lower: Fraction | str, upper: Fraction | str, low: str = "-1", high: str = "2"
) -> Enclosure:
    """Return lower <= expression <= upper, for x and y in [low, high]."""
    graph, root = graph_of(text)
    side = Fraction(low), Fraction(high)
    evaluator = Evaluator(graph, {}, {"x": side, "y": side})
    ranges = Ranges(evaluator, Algebra(graph, {}), {name: enclose(*side) for name in "xy"})
    return Enclosure(ranges, root, Fraction(lower), Fraction(upper), "it")


# An expression and its range over -1 <= x, y <= 2, exact, or over another side, rounded outward.
ATTAINED = [
    ("x", "-1", "2", "-1", "2"),
    ("x^2", "0", "4", "-1", "2"),
    ("x - x", "0", "0", "-1", "2"),
    ("x*y", "-2", "4", "-1", "2"),
    ("x^2 - x + y", "-5/4", "4", "-1", "2"),
    ("1/(2 + x)", "1/4", "1", "-1", "2"),
    ("x^3/7", "-1/7", "8/7", "-1", "2"),
    ("x*(1 - x)", "-2", "1/4", "-1", "2"),
    ("1/(2 + cos(3*x))", "1/3", "1", "-1", "2"),
    ("sqrt(x^2 + 9/4)", "3/2", "5/2", "-1", "2"),
    ("(x + 1)/(x + 2)", "0", "3/4", "-1", "2"),
    # A quotient by x that has a limit at 0.
    ("sin(x)/x", "0.8414709848", "1", "-1", "1"),
    ("(1 - cos(x))/x^2", "0.4596976941", "0.5", "-1", "1"),
    ("(exp(x) - 1)/x", "0.6321205588", "1.7182818285", "-1", "1"),
    ("(x - sin(x))/x^3", "0.1585290151", "0.1666666667", "-1", "1"),
    ("(x^2 + y*x)/x", "-2", "2", "-1", "1"),
    ("sqrt(x)", "1", "1.4142135624", "1", "2"),
    ("x^(3/2)", "1", "2.8284271248", "1", "2"),
    ("x^(1/3)", "1", "1.2599210499", "1", "2"),
    ("x^(0 - 2)", "1/4", "1", "1", "2"),
    ("log(x)", "0", "0.6931471806", "1", "2"),
    ("atan(x)", "0.7853981633", "1.1071487178", "1", "2"),
    ("pi*x", "3.1415926535", "6.2831853072", "1", "2"),
]


@pytest.mark.parametrize(("text", "lower", "upper", "low", "high"), ATTAINED)
def test_bounds_that_are_attained_are_kept(
    text: str, lower: str, upper: str, low: str, high: str
) -> None:
    """At an end or at an interior extremum; an end moved inward by 1e-7 is left."""
    assert keeps_bounds(enclosure(text, lower, upper, low, high)) is True
    assert keeps_bounds(enclosure(text, lower, Fraction(upper) - INSIDE, low, high)) is False
    assert keeps_bounds(enclosure(text, Fraction(lower) + INSIDE, upper, low, high)) is False


@pytest.mark.parametrize(
    "text", ["1/x", "cos(x)/x", "log(x)", "sqrt(x)", "0*log(x)", "tan(2*x)", "asin(x)", "x/x^3"]
)
def test_what_has_no_value_somewhere_is_not_said_to_keep_bounds(text: str) -> None:
    assert keeps_bounds(enclosure(text, "-1000", "1000")) is not True


@pytest.mark.parametrize(
    ("text", "lower", "upper"),
    [("x/10^22", "0", "0"), ("x^2", "1e-40", "1"), ("0*x", "1e-40", "1")],
)
def test_small_ranges_are_no_tolerance(text: str, lower: str, upper: str) -> None:
    """A bound is granted a share of its own size, never an absolute number."""
    assert keeps_bounds(enclosure(text, lower, upper, "-1", "1")) is not True


def test_a_steep_function_on_a_wide_box() -> None:
    """exp(100 x) + 1 is a ball with 0 inside until the box is small."""
    assert keeps_bounds(enclosure("tanh(50*x)", "-1", "1", "-2", "2")) is not False


def test_a_bound_is_kept_up_to_the_stated_tolerance() -> None:
    """Balls are not exact: 1e-20 is granted, and 1e-19 is not."""
    for less, answer in ((Fraction(1, 10**21), True), (Fraction(1, 10**19), False)):
        assert keeps_bounds(enclosure("x + exp(0*y)", "0", 3 - less)) is answer


@given(st.integers(-300, 299), st.integers(1, 200), st.integers(-50, 50))
def test_no_false_bound_is_kept(low: int, width: int, shift: int) -> None:
    """x^3 - 3 x: its range is known from its ends and its extrema at -1 and 1."""
    ends = Fraction(low, 100), Fraction(low + width, 100)
    points = [*ends, *(Fraction(p) for p in (-1, 1) if ends[0] <= p <= ends[1])]
    values = [p**3 - 3 * p for p in points]
    lower, upper = min(values), max(values) + Fraction(shift, 10**6)
    if lower <= upper:
        required = enclosure("x^3 - 3*x", lower, upper, str(ends[0]), str(ends[1]))
        assert keeps_bounds(required) is (shift >= 0)


def test_what_balls_do_not_settle_is_left_to_the_checker() -> None:
    """A kink; other obligations are no ranges."""
    required, decider = enclosure("abs(x)", "0", "2"), FlintDecider()

    assert keeps_bounds(required) is None
    assert decider(required) and decider.left_open == 1
    with pytest.raises(Refused):
        decider(enclosure("abs(x)", "0", "1.9"))
    assert keeps_bounds(positive(1, "a number")) is None
    assert decider(enclosure("x", "-1", "2")) and decider.ranges == 1
