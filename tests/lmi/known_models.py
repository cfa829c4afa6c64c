"""Models of the literature that many tests of gains use, and the values of their designs."""

from __future__ import annotations

import numpy as np

from takagi.lmi import Answer, Design
from takagi.models import TSModel


def three_rules(b: float) -> TSModel:
    """Kim and Lee (2000), IEEE Trans. Fuzzy Systems 8(5), with a = 2: separates the relaxations."""
    return TSModel(
        [[[1.59, -7.29], [0.01, 0]], [[0.02, -4.64], [0.35, 0.21]], [[-2.0, -4.33], [0, 0.05]]],
        [[[1.0], [0.0]], [[8.0], [0.0]], [[6.0 - b], [-1.0]]],
    )


def pendulum(step: float | None = None) -> TSModel:
    """Return two rules of a pendulum on a cart; by Euler's rule in discrete time."""
    A = np.array([[[0.0, 1.0], [17.3, 0.0]], [[0.0, 1.0], [9.4, 0.0]]])
    B = np.array([[[0.0], [-0.177]], [[0.0], [-0.1]]])
    if step is None:
        return TSModel(A, B)
    return TSModel(np.eye(2) + step * A, step * B, sample_time=step)


def gain_of(answer: Answer) -> float:
    """Return the gain of an answer that must have one."""
    assert answer.status == "candidate", answer.diagnosis
    assert answer.gain is not None
    return answer.gain


def cost_of(design: Design) -> float:
    """Return the cost of a design that must have one."""
    assert design.status == "candidate", design.answer.diagnosis
    assert design.cost is not None
    return design.cost
