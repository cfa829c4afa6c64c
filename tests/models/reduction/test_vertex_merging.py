"""Merging of nearly equal vertices: the proved error holds for all memberships and is attained."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from takagi.models import MergedModel, ModelError, Premise, TSModel, merge_vertices


def model() -> TSModel:
    """Return z1 in [0, 1] with a large effect and z2 in [0, 0.03] with a small one."""
    A = np.array([[[0, 1], [-(2 + z1), -1 - z2]] for z1 in (0, 1) for z2 in (0, 0.03)])
    B = np.array([[[0], [1 + 4 / 3 * z2]] for _ in (0, 1) for z2 in (0, 0.03)])
    return TSModel(A, B, premises=[Premise("z1", 0, 1), Premise("z2", 0, "0.03")])


def test_error_is_the_exact_distance() -> None:
    """The entries differ by 0.03 and 0.04, so the distance is 0.05 to the digit."""
    merged = merge_vertices(model(), "0.05")

    assert isinstance(merged, MergedModel)
    assert merged.error.size == Fraction(1, 20)
    assert merged.model.A.shape == (2, 2, 2)


def test_error_holds_for_random_memberships_and_a_smaller_one_does_not() -> None:
    whole = model()
    merged = merge_vertices(whole, "0.05")
    draws = np.random.default_rng(2).dirichlet(np.full(4, 0.3), size=300)
    h = np.vstack((draws, np.eye(4)))
    share = h @ merged.shares.T

    gaps = np.concatenate(
        [
            np.tensordot(h, full, axes=1) - np.tensordot(share, few, axes=1)
            for full, few in ((whole.A, merged.model.A), (whole.B, merged.model.B))
        ],
        axis=2,
    )
    norms = np.linalg.norm(gaps, axis=(1, 2))

    assert np.allclose(share.sum(axis=1), 1)
    assert norms.max() <= float(merged.error.size) + 1e-12
    assert norms.max() > 0.999 * float(merged.error.size)
    (block,) = merged.error.blocks("whole")
    allowed = np.linalg.pinv(block.D) @ gaps @ np.linalg.pinv(np.hstack((block.E, block.F)))
    assert np.linalg.norm(allowed, 2, (1, 2)).max() <= 1 + 1e-9


def test_nothing_nearer_than_the_tolerance_is_left_alone() -> None:
    merged = merge_vertices(model(), "0.049")

    assert merged.error.size == 0
    assert np.array_equal(merged.shares, np.eye(4))


def test_the_merged_model_says_in_its_source_that_it_is_one() -> None:
    assert "2 rules in the place of 4" in merge_vertices(model(), "0.05").model.source


def test_a_negative_tolerance_is_refused() -> None:
    with pytest.raises(ModelError, match="at least 0"):
        merge_vertices(model(), -1)
