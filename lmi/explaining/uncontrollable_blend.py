"""A blend of the rules that no gains can help: one of its modes is out of every input's reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import nnls

from takagi.lmi.answer import Answer
from takagi.models.arrays import Floats

# Multipliers of about one direction, and a mode that is out of reach to solver accuracy.
ONE_DIRECTION, REACH = 1e-3, 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class UncontrollableBlend:
    """At sum_i h_i A_i, sum_i h_i B_i the mode of this eigenvalue is moved by no input.

    Attributes
    ----------
    weights : (r,) h.
    eigenvalue : lambda, with v' A(h) = lambda v' and v' B(h) = 0 to solver accuracy.
    direction : (n,) v, its largest entry 1.
    """

    weights: Floats
    eigenvalue: float
    direction: Floats

    def __str__(self) -> str:
        order = [k for k in np.argsort(-self.weights) if self.weights[k] > 1e-3]
        blend = " + ".join(f"{self.weights[k]:.3g} rule {k + 1}" for k in order)
        return f"at {blend} no input moves the mode at {self.eigenvalue:.4g}, by any gains"


def uncontrollable_blend(answer: Answer, model: Any) -> UncontrollableBlend | None:
    """Return the blend that explains a no to gains, where its multipliers are of one direction v.

    Given v, h and lambda solve the linear equations sum_i h_i A_i' v = lambda v and
    sum_i h_i B_i' v = 0 with h >= 0, sum h = 1: nonnegative least squares.  Memberships are taken
    to be free; where they are products a blend may never occur.  Floating point, no proof.
    """
    Z = answer.multipliers.get("Q positive definite")
    if Z is None or answer.coordinates is None or len(answer.coordinates) != Z.shape[1]:
        return None
    values, vectors = np.linalg.eigh(Z[0])
    if values[-1] <= 0 or (len(values) > 1 and values[-2] > ONE_DIRECTION * values[-1]):
        return None
    s, v = answer.coordinates, vectors[:, -1]
    A, B = np.asarray(model.A, dtype=np.float64), np.asarray(model.B, dtype=np.float64)
    scaled_A, scaled_B = A * s / s[:, None], B / s[:, None]
    size = float(np.abs(scaled_A).max()) or 1.0
    reach = np.einsum("rnm,n->mr", scaled_B, v) / np.abs(scaled_B).max(axis=(0, 1))[:, None]
    drift = np.einsum("rnk,n->kr", scaled_A, v) / size
    # Unknowns h, and lambda / size as the difference of two nonnegative numbers.
    both = np.zeros((len(v) + len(reach) + 1, len(A) + 2))
    both[: len(v), : len(A)], both[len(v) : -1, : len(A)] = drift, reach
    both[: len(v), -2], both[: len(v), -1] = -v, v
    both[-1, : len(A)] = 1.0
    found, residual = nnls(both, np.eye(len(both))[-1])
    eigenvalue = float(found[-2] - found[-1]) * size
    if residual > REACH or not _slow(eigenvalue, answer):
        return None
    weights, direction = found[: len(A)], v / s
    return UncontrollableBlend(
        weights / weights.sum(), eigenvalue, direction / direction[np.argmax(np.abs(direction))]
    )


def _slow(eigenvalue: float, answer: Answer) -> bool:
    """Return whether the mode is slower than the condition asks for: then there is no solution."""
    asked = {} if answer.condition is None else answer.condition.parameters
    if "contraction" in asked:
        return eigenvalue**2 >= asked["contraction"] - REACH
    return eigenvalue >= -asked.get("alpha", 0.0) - REACH * max(1.0, abs(eigenvalue))
