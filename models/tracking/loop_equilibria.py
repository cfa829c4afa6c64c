r"""Equilibria of a loop with integral action, approximated by a linear function of the signals.

    Xhat(s) = X* + D (s - s*),    uhat(s) = u* - K D (s - s*)

The signals s are the references, the other disturbances with a range, and uncertain parameters.
The true equilibria are nonlinear functions of s where the plant is nonlinear; D has the slopes of
their chords over the ranges.  The residuals of the equations at (Xhat, uhat) are computed here on a
grid in floating point; the checker proves their bounds.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.plant.plant import Plant
from takagi.models.tracking.held_rests import held_rests, signals_of

if TYPE_CHECKING:
    pass

POINTS, MOST_POINTS = 41, 4_000
# A residual between the grid points may be larger than on the grid by this share.
WIDER = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class EquilibriumLine:
    """The linear function, its residuals, and the ranges that it needs.

    Attributes
    ----------
    D : (n, s), short decimals.
    sides : ranges of the signals' deviations from rest.
    state_range, input_range : (least, greatest) deviation of each state and input over the ranges.
    residuals : (n,) largest |F_k| over the ranges.
    """

    D: Floats
    sides: tuple[tuple[float, float], ...]
    state_range: list[tuple[float, float]]
    input_range: list[tuple[float, float]]
    residuals: Floats


def equilibrium_line(plant: Plant, gain: Floats) -> EquilibriumLine:
    """Return the linear function for a plant with references under u = u* - K (X - X*)."""
    import sympy as sp

    signals = signals_of(plant)
    sides = tuple(
        (float(v.range.lower - v.rest), float(v.range.upper - v.rest)) for v in signals if v.range
    )
    D = _slopes(plant, gain)
    state_range = [_range(row, sides) for row in D]
    input_range = [_range(row, sides) for row in -gain @ D]
    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    values |= {
        v.symbol: sp.Rational(*v.rest.as_integer_ratio())
        for v in plant.disturbances
        if v.range is None
    }
    symbols = [v.symbol for v in (*plant.states, *plant.inputs, *signals)]
    rows = [sp.sympify(row).subs(values) for row in plant.equations]
    right = sp.lambdify(symbols, rows, modules=["scipy", "numpy"])
    still = np.array([float(v.rest) for v in (*plant.states, *plant.inputs, *signals)])
    count = max(2, min(POINTS, int(MOST_POINTS ** (1 / len(sides)))))
    largest = np.zeros(len(rows))
    for point in product(*(np.linspace(low, high, count) for low, high in sides)):
        r = np.array(point)
        place = still + np.concatenate([D @ r, -gain @ D @ r, r])
        with np.errstate(all="ignore"):
            largest = np.maximum(largest, np.abs(np.array(right(*place), dtype=np.float64)))
    return EquilibriumLine(D, sides, state_range, input_range, largest * (1 + WIDER))


def _slopes(plant: Plant, gain: Floats) -> Floats:
    """Return D: chord slopes of the equilibria, and integral states that give their inputs."""
    rests = held_rests(plant)
    n_own = len(plant.states) - len(plant.references)
    points = rests.points - rests.points[0]
    values = rests.values - rests.values[0]
    chords = np.linalg.lstsq(points[1:], values[1:], rcond=None)[0].T
    own, inputs = chords[:n_own], chords[n_own:]
    # K_x D_x + K_xi D_xi = -U; the least-squares solution if there are more inputs than references.
    integral = -np.linalg.lstsq(gain[:, n_own:], inputs + gain[:, :n_own] @ own, rcond=None)[0]
    D = np.vstack([own, integral])
    size = np.abs(D).max() or 1.0
    return np.array([[_short(value, size) for value in row] for row in D])


def _short(value: float, size: float) -> float:
    # Entries that are zero but for rounding become zeros, and the others decimals that can be
    # stated.
    return 0.0 if abs(value) < 1e-12 * size else float(f"{value:.9g}")


def _range(row: Floats, sides: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    ends = [(float(s) * low, float(s) * high) for s, (low, high) in zip(row, sides, strict=True)]
    return sum(min(pair) for pair in ends), sum(max(pair) for pair in ends)
