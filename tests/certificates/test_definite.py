"""Exact definiteness: against sympy and against principal minors, and at exactly singular ones."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from itertools import combinations

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker.kernel.definite import positive_definite_integers
from takagi.certificates.checker.kernel.matrices import Matrix

Rows = list[list[int]]
ENTRIES = st.integers(-9, 9)

positive_semidefinite_integers = partial(positive_definite_integers, zero_passes=True)


@st.composite
def symmetric(draw: st.DrawFn, largest: int = 5) -> Rows:
    """Return a symmetric integer matrix, lifted so that both answers occur."""
    n = draw(st.integers(1, largest))
    lift = draw(st.integers(0, 25))
    M = [[0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            M[i][j] = M[j][i] = draw(ENTRIES) + lift * (i == j)
    return M


@st.composite
def singular(draw: st.DrawFn) -> Rows:
    """Return F F' with fewer columns than rows: semidefinite, with determinant exactly zero."""
    n = draw(st.integers(2, 5))
    scale = 10 ** draw(st.integers(0, 20))
    F = [[draw(ENTRIES) * scale for _ in range(n - 1)] for _ in range(n)]
    return [[sum(a * b for a, b in zip(p, q, strict=True)) for q in F] for p in F]


def fractions(M: Rows, below: int = 1) -> list[list[Fraction]]:
    return [[Fraction(entry, below) for entry in row] for row in M]


@given(symmetric())
def test_definite_as_sympy_says(M: Rows) -> None:
    """Bareiss' pivots give sympy's answer."""
    assert positive_definite_integers(M) == sympy.Matrix(M).is_positive_definite
    assert Matrix.of(fractions(M, 7)).is_positive_definite == positive_definite_integers(M)


@given(symmetric(4))
def test_semidefinite_as_all_principal_minors_say(M: Rows) -> None:
    """A symmetric matrix is semidefinite iff every principal minor, not only leading, is >= 0."""
    n, whole = len(M), sympy.Matrix(M)
    minors = [
        whole.extract(list(rows), list(rows)).det()
        for size in range(1, n + 1)
        for rows in combinations(range(n), size)
    ]

    assert positive_semidefinite_integers(M) == all(minor >= 0 for minor in minors)


@pytest.mark.parametrize(
    ("M", "expected"),
    [
        ([[0, 1], [1, 0]], False),
        ([[0, 1], [1, 5]], False),
        ([[0, 0, 1], [0, 0, 0], [1, 0, 7]], False),
        ([[4, 2, 0], [2, 1, 1], [0, 1, 9]], False),
        ([[0, 0], [0, 1]], True),
        ([[4, 2, 0], [2, 1, 0], [0, 0, 9]], True),
        ([[0]], True),
    ],
)
def test_a_zero_pivot_needs_a_zero_column(M: Rows, expected: bool) -> None:
    """An entry below a zero pivot makes an eigenvalue negative, at any row."""
    assert positive_semidefinite_integers(M) is expected


def test_pivots_stay_minors() -> None:
    """I + 1 1' of order 60 has minors k + 1: without Bareiss' division they have 2^k digits."""
    assert positive_definite_integers([[1 + (i == j) for j in range(60)] for i in range(60)])


@given(singular())
def test_exactly_singular_is_not_positive_definite(M: Rows) -> None:
    """F F' of deficient rank is semidefinite and never definite, however large its entries."""
    assert not Matrix.of(fractions(M)).is_positive_definite
    assert positive_semidefinite_integers(M)


@given(singular(), st.integers(1, 30))
def test_a_hair_decides(M: Rows, digits: int) -> None:
    """A singular matrix plus 10^-k I is definite, minus 10^-k I not even semidefinite."""
    hair = Fraction(1, 10**digits)
    above, below = (
        [[Fraction(M[i][j]) + s * hair * (i == j) for j in range(len(M))] for i in range(len(M))]
        for s in (1, -1)
    )

    assert Matrix.of(above).is_positive_definite
    assert not Matrix.of(below).is_positive_semidefinite


@pytest.mark.parametrize("M", [[[1, 2], [3, 4]], [[1, 2]], [], [[1], [2]], [[2, 1], [0, 2]]])
def test_what_is_not_symmetric_is_not_definite(M: Rows) -> None:
    """Ragged, empty or unsymmetric is never definite: x'Mx would only see the symmetric part."""
    assert not Matrix.of(fractions(M)).is_positive_definite


def test_a_matrix_of_fractions_keeps_the_ratio() -> None:
    """1/6 and 3/4 become 2 and 9 twelfths."""
    assert Matrix.of([[Fraction(1, 6), Fraction(3, 4)]]) == Matrix([[2, 9]], 12)
