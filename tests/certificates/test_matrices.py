"""Exact matrices: the ring of arrays of fractions, and definiteness against sympy and minors."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.certificates import CertificateError
from takagi.certificates.checker.kernel.definite import positive_definite_integers
from takagi.certificates.checker.kernel.matrices import Matrix, mean
from takagi.certificates.checker.kernel.reader import Number, read_stack
from takagi.certificates.checker.kernel.refusal import Refused

NUMBERS = st.fractions(-9, 9, max_denominator=30)


@st.composite
def arrays(draw: st.DrawFn, rows: int, columns: int) -> NDArray[np.object_]:
    return np.array([[draw(NUMBERS) for _ in range(columns)] for _ in range(rows)], dtype=object)


def same(found: Matrix, wanted: NDArray[np.object_]) -> bool:
    rows, columns = found.shape
    entries = [[found[i, j] for j in range(columns)] for i in range(rows)]
    return found.below > 0 and bool(np.all(np.array(entries, dtype=object) == wanted))


@given(arrays(2, 3), arrays(2, 3), arrays(3, 2), NUMBERS)
def test_the_ring_is_that_of_arrays_of_fractions(
    X: NDArray[np.object_], Y: NDArray[np.object_], Z: NDArray[np.object_], factor: Fraction
) -> None:
    """Sums, products, multiples, transposes, means and blocks, two ways."""
    x, y, z = (Matrix.of(one.tolist()) for one in (X, Y, Z))

    assert same(x + y, X + Y)
    assert same(x - y, X - Y)
    assert same(-x, -X)
    assert same(factor * x, factor * X)
    assert same(x @ z, X @ Z)
    assert same(x.T, X.T)
    assert same((x + y).reduced(), X + Y)
    assert same(mean([x, y, y]), (X + 2 * Y) / 3)
    assert same(Matrix.blocks([[x, x @ z], [y, -(y @ z)]]), np.block([[X, X @ Z], [Y, -(Y @ Z)]]))


@pytest.mark.parametrize("columns", [1, 3])
def test_shapes_that_do_not_fit_are_refused(columns: int) -> None:
    """Nothing is cut to the smaller shape in silence."""
    x, one = Matrix([[1] * columns]), Matrix.identity(2)

    operations: tuple[Callable[[], Matrix], ...] = (
        lambda: one + x,
        lambda: one @ x,
        lambda: Matrix.blocks([[one, x]]),
        lambda: Matrix.blocks([[one], [x]]),
    )
    for operation in operations:
        with pytest.raises(Refused):
            operation()


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_a_stack_has_matrices_of_one_shape_and_a_refusal_names_the_other(wrong: int) -> None:
    stack: list[Any] = [[[Number("1"), Number("2")]] for _ in range(3)]
    assert [m.shape for m in read_stack({"A": stack}, "A", "model")] == [(1, 2)] * 3

    stack[wrong] = [[Number("1")]] if wrong else "none"
    with pytest.raises(CertificateError, match=rf"^model\.A\.{wrong}\b"):
        read_stack({"A": stack}, "A", "model")


Rows = list[list[int]]
ENTRIES = st.integers(-9, 9)

positive_semidefinite_integers = partial(positive_definite_integers, zero_passes=True)


@st.composite
def symmetric(draw: st.DrawFn, largest: int = 5) -> Rows:
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
    assert positive_semidefinite_integers(M) and not positive_definite_integers(M)


@pytest.mark.parametrize("M", [[[1, 2], [3, 4]], [[1, 2]], [], [[1], [2]], [[2, 1], [0, 2]]])
def test_what_is_not_symmetric_is_not_definite(M: Rows) -> None:
    """Ragged, empty or unsymmetric is never definite: x'Mx would only see the symmetric part."""
    assert not Matrix.of(fractions(M)).is_positive_definite


def test_a_matrix_of_fractions_keeps_the_ratio() -> None:
    """1/6 and 3/4 become 2 and 9 twelfths."""
    assert Matrix.of([[Fraction(1, 6), Fraction(3, 4)]]) == Matrix([[2, 9]], 12)


def test_more_work_than_a_minute_is_refused_before_it_begins() -> None:
    """80^4 times 300 bits is more than 10^10; 80^4 times 200 bits is not."""
    large = [[(1 << 300) * (i == j) for j in range(80)] for i in range(80)]
    with pytest.raises(Refused, match="too large"):
        positive_definite_integers(large)
    assert positive_definite_integers([[entry >> 100 for entry in row] for row in large])
