"""Exact matrices: against numpy's arrays of fractions."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.certificates import CertificateError
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


@given(st.integers(1, 10**30), st.integers(1, 10**30))
def test_a_positive_factor_changes_no_sign(above: int, below: int) -> None:
    """[[2, 1], [1, 1]] is positive definite, [[1, 1], [1, 1]] semidefinite, at any scale."""
    factor = Fraction(above, below)
    definite, edge = factor * Matrix([[2, 1], [1, 1]]), factor * Matrix([[1, 1], [1, 1]])

    assert definite.is_positive_definite
    assert not (-definite).is_positive_semidefinite
    assert edge.is_positive_semidefinite
    assert not edge.is_positive_definite
    assert not Matrix([[2, 1], [0, 1]]).is_positive_definite


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_a_stack_has_matrices_of_one_shape_and_a_refusal_names_the_other(wrong: int) -> None:
    stack: list[Any] = [[[Number("1"), Number("2")]] for _ in range(3)]
    assert [m.shape for m in read_stack({"A": stack}, "A", "model")] == [(1, 2)] * 3

    stack[wrong] = [[Number("1")]] if wrong else "none"
    with pytest.raises(CertificateError, match=rf"^model\.A\.{wrong}\b"):
        read_stack({"A": stack}, "A", "model")
