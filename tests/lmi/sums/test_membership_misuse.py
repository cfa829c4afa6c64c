"""Knowledge of the memberships that cannot be: what was given, what is needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.lmi import with_overlap, with_shape
from takagi.models import ModelError
from tests.lmi.sums.known import known_sum, random_theta


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ([[1.0, 0.1]], r"shape \(1, 2\); \(2, 2\) is needed"),
        ([[1.0, -0.1], [-0.1, 1.0]], r"bounds\[0, 1\] is -0.1; 0 or more"),
        ([[1.0, np.nan], [0.1, 1.0]], r"bounds\[0, 1\] is nan"),
        ([[1.0, 0.2], [0.1, 1.0]], r"not symmetric: \[0, 1\] is 0.2, \[1, 0\] is 0.1"),
        ([[0.2, 0.1], [0.1, 0.2]], "sum to 0.6, but the products h_i h_j to 1"),
        ([[0.0, 0.25], [0.25, 1.0]], "rule 1 never acts; leave it out"),
        ([["a", "b"], ["c", "d"]], "cannot be read as a matrix of numbers"),
    ],
)
def test_bounds_that_make_no_sense(bounds: list[list[float]], message: str) -> None:
    """What was given, what is needed."""
    loop, _ = known_sum(random_theta(0, 2, 1))

    with pytest.raises(ModelError, match=message):
        with_overlap(loop, bounds)


def test_other_knowledge_that_makes_no_sense() -> None:
    """Numbers of rules, and forms."""
    loop, _ = known_sum(random_theta(0, 2, 1))
    with pytest.raises(ModelError, match="active_rules is 3; 1 ... 2 rules"):
        with_overlap(loop, active_rules=3)
    with pytest.raises(ModelError, match="forms are not symmetric"):
        with_shape(loop, [[[0.0, 1.0], [0.0, 0.0]]])
    with pytest.raises(ModelError, match=r"forms have shape \(2, 2\)"):
        with_shape(loop, np.eye(2))
    with pytest.raises(ModelError, match="symmetric, with every rule active by itself"):
        replace(loop, active=np.array([[True, False], [True, True]]))
