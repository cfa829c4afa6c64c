"""A search for the state of a set at which V' is most above what ``running-rate`` claims of it.

The claim is V' <= 2 alpha (1 - V) for all states with V <= 1, winds of the cell, |v'| <= r, and all
inertia, h and L of their ranges.  With xi = C u, P^-1 = C C' and V = u'u the excess of V' is
quadratic in u for a loop that is linear.  Its greatest value on |u| <= 1 is known then, and the
nonlinear loop of ``benchmarks/turbine_running.py`` is made linear anew at each state found.  Plants
are at the corners of the family, v' = +-r.  The search finds what is false: with twice the rate V'
comes above the claim in every cell.

Source: Conn, Gould, Toint (2000), Trust Region Methods, ch. 7: a quadratic function on a ball;
recalled.
"""

from __future__ import annotations

import json
from importlib import import_module
from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.test_running_rate import Trim

motion: Any = import_module("turbine_running")
Floats = NDArray[np.float64]
STEPS = 3


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("running-rate"))[1]))


class Excess:
    """V' - 2 alpha (1 - V) = 2 u'g(u) - 2 alpha (1 - u'u) at one wind, for one plant and v'."""

    def __init__(self, stored: Any, k: int, wind: float, rate: float, decay: float, plant: Any):
        trim = Trim(stored, k)
        self.at, self.decay = motion.Motion(stored, trim.cell, wind, plant), decay
        self.here, self.least = trim.at(wind), stored["gains"]["pitch_min"]
        self.units, self.rest = np.ones(10), np.zeros(10)
        self.units[[1, 7]] = 1 / self.at.b0
        self.rest[[1, 7]] = self.at.pitch - self.here[1]
        self.rest[2] = self.at.x_rest
        self.C = np.linalg.cholesky(np.linalg.inv(trim.P(wind)))
        self.moved = rate * trim.moving(wind)
        self.change = rate / 2 * self.C.T @ trim.slope @ self.C

    def g(self, u: Floats) -> Floats:
        rates = self.at.rate((self.C @ u - self.rest) / self.units) * self.units
        found = np.linalg.solve(self.C, rates - self.moved) + self.change @ u
        return np.asarray(found, dtype=np.float64)

    def value(self, u: Floats) -> float:
        """Return it; minus infinity where pitch is below its limit, which is no start."""
        if self.here[1] + (self.C @ u)[1] < self.least:
            return -np.inf
        return float(2 * u @ self.g(u) - 2 * self.decay * (1 - u @ u))

    def next(self, u: Floats) -> Floats:
        """Return where it is greatest on |u| <= 1 for the loop made linear at u."""
        G = np.array([(self.g(u + h) - self.g(u - h)) / 2e-4 for h in 1e-4 * np.eye(10)]).T
        values, axes = np.linalg.eigh(G + G.T + 2 * self.decay * np.eye(10))
        b = axes.T @ (self.g(u) - G @ u)

        def beyond(shift: float) -> float:
            return float(np.linalg.norm(b / (shift - values))) - 1

        least = max(values[-1], 0.0) + 1e-9
        shift = least if beyond(least) <= 0 else brentq(beyond, least, least + 1e3)
        return np.asarray(axes @ (b / (shift - values)), dtype=np.float64)


def most(stored: Any, k: int, faster: float = 1.0) -> float:
    """Return the greatest excess found in a cell, with a multiple of its rate of the wind."""
    cell, found = stored["claims"][0]["cells"][k], -np.inf
    low, high = cell["wind"]
    for i, (inertia, late, sign) in enumerate(product((0.9, 1.1), (0.0, 1.0), (-1, 1))):
        plant = motion.Plant(inertia, (40.0, 80.0)[(i // 2) % 2], late)
        wind, rate = low + (high - low) * (i + 0.5) / 8, sign * faster * cell["wind_rate"]
        excess = Excess(stored, k, wind, rate, cell["decay_rate"], plant)
        u = np.zeros(10)
        for _ in range(STEPS):
            u = excess.next(u)
            found = max(found, excess.value(u))
    return found


@pytest.mark.parametrize("k", range(6))
def test_no_state_of_a_set_is_above_the_claim(stored: dict[str, Any], k: int) -> None:
    """And the search is no blunt one: there is such a state for twice the rate."""
    assert most(stored, k) < 0
    assert most(stored, k, faster=2) > 0.01
