"""The error as norm-bounded uncertainty: exact containment, and neither structure is idle."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.lmi import NormBounded, max_decay_rate, robust_lyapunov
from takagi.models import ModelError, NormBlock, Premise, TSModel, reduce_rules
from takagi.models.reduction.exact_residual import root_above
from takagi.models.reduction.norm_block import block_around, entry_blocks


def rationals(array: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.empty(array.shape, dtype=object)
    for index, value in np.ndenumerate(array):
        found[index] = Fraction(str(value))
    return found


def drawn(seed: int, count: int, n: int, m: int) -> np.ndarray:
    """Return matrices with some zero rows and columns, and rows of very different size."""
    chance = np.random.default_rng(seed)
    values = chance.normal(size=(count, n, n + m)) * 10.0 ** chance.integers(-4, 4, size=(n, 1))
    values *= chance.random(size=(n, n + m)) < 0.6
    return np.round(values, 9)


def delta(block: NormBlock, X: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.linalg.pinv(block.D) @ X @ np.linalg.pinv(np.hstack((block.E, block.F)))
    return found


@given(seed=st.integers(0, 10**6), n=st.integers(1, 4), m=st.integers(0, 2))
def test_one_block_reaches_every_matrix_with_a_delta_of_norm_one(seed: int, n: int, m: int) -> None:
    X = drawn(seed, 3, n, m)
    blocks = block_around(rationals(X), n)

    if not X.any():
        assert blocks == ()
        return
    (block,) = blocks
    W = np.hstack((block.E, block.F))
    largest = 0.0
    for matrix in X:
        found = delta(block, matrix)
        assert np.allclose(block.D @ found @ W, matrix, atol=1e-9 * np.abs(X).max(), rtol=1e-6)
        largest = max(largest, float(np.linalg.norm(found)))
    assert 1 - 1e-5 <= largest <= 1 + 1e-6


@given(seed=st.integers(0, 10**6))
def test_entries_are_as_large_as_the_largest_of_each(seed: int) -> None:
    X = drawn(seed, 4, 3, 1)

    blocks = entry_blocks(rationals(X), 3)
    total = sum((np.abs(b.D @ np.hstack((b.E, b.F))) for b in blocks), np.zeros((3, 4)))

    assert np.allclose(total, np.abs(X).max(axis=0), rtol=1e-12)
    assert np.all(total >= np.abs(X).max(axis=0))
    assert len(blocks) == np.count_nonzero(X.any(axis=0))


def test_a_difference_along_one_direction_costs_one_direction() -> None:
    """X = (0, 3; 0, 4)' [1 2 2]: D [E F] of the first direction is X itself, to a millionth."""
    X = np.array([[[3.0, 6, 6], [4, 8, 8]]])

    (block,) = block_around(rationals(X), 2)

    first = np.outer(block.D[:, 0], np.hstack((block.E, block.F))[0])
    assert np.allclose(np.abs(first), X[0], rtol=1e-5)
    assert np.abs(block.D[:, 1]).max() < 1e-4


def row(size: float) -> TSModel:
    """Return x'' = -(2 + size z)(x + x'), |z| <= 1: one premise that moves two entries."""
    A = [[[0, 1], [-2 - size * z, -2 - size * z]] for z in (-1, 1)]
    return TSModel(np.array(A, dtype=float), premises=[Premise("z", -1, 1)])


def status(size: float, structure: str) -> str:
    reduced = reduce_rules(row(size), 10)
    assert len(reduced.model.rules) == 1
    blocks = reduced.error.blocks(structure)  # type: ignore[arg-type]
    return robust_lyapunov(reduced.model, [NormBounded(*block) for block in blocks]).status


def test_the_whole_block_knows_that_entries_move_together() -> None:
    """One Delta for the row x + x' is exact: size < 1 / max |g (s + 1)|, g = 1 / (s^2 + 2 s + 2).

    By the small-gain theorem (Khargonekar, Petersen, Zhou 1990) that is when P exists.  Entries
    that move independently are stable only for size < 1 / max |g| (1 + |s|), which is less.
    """
    s = 1j * np.linspace(0, 10, 20001)
    g = np.abs(1 / (s**2 + 2 * s + 2))
    limit, separate = 1 / (g * np.abs(s + 1)).max(), 1 / (g * (1 + np.abs(s))).max()

    assert status(limit - 0.02, "whole") == "candidate"
    assert status(limit + 0.02, "whole") == "infeasible"
    assert status(separate - 0.02, "entries") == "candidate"
    assert status(separate + 0.02, "entries") == "infeasible"
    assert separate < limit - 0.4


def test_without_its_error_the_reduced_model_claims_what_the_original_denies() -> None:
    """size = 2.5: the mean is stable, the original's vertex with z = -1 is not."""
    reduced = reduce_rules(row(2.5), 10)

    assert float(max_decay_rate(reduced.model).decay_rate or 0) > 0.9
    assert float(max_decay_rate(row(2.5)).decay_rate or 0) < 0
    assert status(2.5, "whole") == status(2.5, "entries") == "infeasible"


def test_parts_tell_which_matrix_loses_what() -> None:
    """A loses 0.3, C loses 0.4, together 0.5."""
    model = TSModel(
        [[[-1.3]], [[-0.7]]], C=[[[1.4]], [[0.6]]], B=[[1.0]], premises=[Premise("z", 0, 1)]
    )

    error = reduce_rules(model, 1).error

    assert error.size == Fraction(1, 2)
    assert dict(error.parts) == {"A": Fraction(3, 10), "C": Fraction(2, 5), "B": 0, "D": 0, "E": 0}


@given(st.fractions(min_value=0, max_value=10**6))
def test_the_root_is_rounded_up_and_close(squared: Fraction) -> None:
    root = root_above(squared)

    assert root**2 >= squared
    assert float(root) == pytest.approx(float(squared) ** 0.5, rel=1e-14)


def test_tiny_roots_keep_their_digits_and_squares_are_exact() -> None:
    assert float(root_above(Fraction(2, 10**60))) == pytest.approx(2**0.5 * 1e-30, rel=1e-15)
    assert root_above(Fraction(1, 400)) == Fraction(1, 20)


def test_misuse_is_refused() -> None:
    with pytest.raises(ModelError, match="'whole' or 'entries'"):
        reduce_rules(row(1), 10).error.blocks("both")  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="no real root"):
        root_above(Fraction(-1))
