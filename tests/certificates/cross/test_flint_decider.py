"""Definiteness by characteristic polynomials, against elimination and on known matrices."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from flint import fmpz_mat
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Inequality,
    Relation,
    nonnegative,
    not_positive,
    positive,
)
from takagi.certificates.cross_check.flint_decider import FlintDecider, is_definite

entries = st.integers(-9, 9)


def decided(value: Any, relation: Relation) -> bool:
    """Return FLINT's answer, which has to be the one of elimination."""
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
