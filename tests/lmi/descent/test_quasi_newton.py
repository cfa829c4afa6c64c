"""Descent at kinks: a published function, a convex one, walls, and its ends."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi.gains.descent import descend

Floats = NDArray[np.float64]


def valley(x: Floats) -> tuple[float, Floats]:
    """Lewis and Overton (2013), section 5.1 (recalled): 8 |x1^2 - x2| + (1 - x1)^2, least 0."""
    side = np.sign(x[0] ** 2 - x[1])
    value = 8 * abs(x[0] ** 2 - x[1]) + (1 - x[0]) ** 2
    return float(value), np.array([16 * side * x[0] - 2 * (1 - x[0]), -8 * side])


@pytest.mark.parametrize("start", [(-1.0, 1.5), (2.0, -1.0), (0.3, 0.3)])
def test_it_follows_a_valley_with_a_kink_to_its_end(start: tuple[float, float]) -> None:
    end = descend(valley, np.array(start), steps=400, enough=1e-12)

    assert end.value < 1e-5
    assert end.x == pytest.approx(np.ones(2), abs=1e-2)
    assert end.value == valley(end.x)[0]


def test_it_ends_at_the_value_that_is_enough() -> None:
    first = descend(valley, np.array([-1.0, 1.5]), steps=400, enough=1e-12, below=1.0)

    assert 1e-5 < first.value < 1.0


def test_it_never_crosses_a_wall() -> None:
    """log-barrier like: infinite for x <= 0, least at x = 1."""

    def walled(x: Floats) -> tuple[float, Floats]:
        if x[0] <= 0:
            return np.inf, np.zeros(1)
        return float(x[0] - np.log(x[0])), np.array([1 - 1 / x[0]])

    end = descend(walled, np.array([50.0]), steps=100, enough=1e-12)
    assert end.x == pytest.approx(np.ones(1), abs=1e-4)
    assert descend(walled, np.array([-1.0]), steps=100, enough=1e-12).value == np.inf
