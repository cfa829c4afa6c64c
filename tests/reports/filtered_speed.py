"""The filter of the measured speed, written down once more for the tests: one recursion.

A pole q is P(z) = (1 - q) / (1 - q/z).  The band-stop is 1 - 2 (1 - p) (P - P^2) with
q = exp(-T w), the low-pass P with q = exp(-T c).  Their product is brought over one
denominator here, where the program of the gain file keeps each pole by itself.
"""

from __future__ import annotations

from math import exp

import numpy as np

from takagi.models.simulation.turbine_plant import SpeedFilter


class FilteredSpeed:
    """What law and observer read, from a first speed at rest on."""

    def __init__(self, filters: SpeedFilter, sample_time: float, speed: float) -> None:
        slow, fast = exp(-sample_time * filters.corner), exp(-sample_time * filters.stop)
        pole = np.array([1.0, -fast])
        both = np.polymul(pole, pole)
        taken = 2 * (1 - filters.passed) if filters.stop else 0.0
        # P - P^2 in powers of 1/z, over (1 - q/z)^2.
        difference = (1 - fast) * np.array([fast, -fast, 0.0])
        self.numerator = (1 - slow) * (both - taken * difference)
        self.denominator = np.polymul(both, [1.0, -slow])
        self.inputs, self.outputs = [speed] * 2, [speed] * 3

    def __call__(self, measured: float) -> float:
        """Return what is read at this sample."""
        inputs = [measured, *self.inputs]
        found = float(self.numerator @ inputs - self.denominator[1:] @ self.outputs)
        self.inputs, self.outputs = inputs[:2], [found, *self.outputs[:2]]
        return found
