"""The equilibria of a loop with references, as a function of the signals.

They are approximated by a linear function of the signals,

    Xhat(s) = X* + D (s - s*),    uhat(s) = u* - K (Xhat(s) - X*),

or by one with the products of two signals besides, where s are the references, the other
disturbances with a range, and uncertain parameters.  The true equilibria are nonlinear functions of
s where the plant is nonlinear; D is fitted to them over the ranges.  A law with measured outputs
has the plant's own states from an observer, whose estimate is a state of the loop too.  The
residuals of the equations at (Xhat, uhat) are computed on a grid in floating point; the checker
proves their bounds.  X* is the origin of these functions; the plant need not rest there exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement, product

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.intervals.interval import rational
from takagi.models.plant.plant import Plant, numeric
from takagi.models.tracking import held_rests, signals_of

POINTS, MOST_POINTS = 41, 4_000
# A residual between the grid points may be larger than on the grid by this share.
WIDER = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class ConstantObserver:
    """s' = A s + B (u - u*) + L (y - y* - C s): an estimate of the plant's own states.

    Attributes
    ----------
    A, B, C, L : (n, n), (n, m), (p, n) and (n, p), short decimals.
    measured : names of the p outputs y.
    """

    A: Floats
    B: Floats
    C: Floats
    L: Floats
    measured: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class EquilibriumLine:
    """Xhat(s) - X* as a function of the signals, its residuals, and the ranges that it needs.

    Attributes
    ----------
    D : (n, s), short decimals; with an observer the rows of its estimate come last.
    Q : (n, s (s + 1) / 2) factors of products of two deviations, (1, 1), (1, 2), ..., (2, 2), ...;
        None for a linear function.
    sides : ranges of the signals' deviations from rest.
    state_range, input_range : (least, greatest) deviation of each state and input over the ranges.
    residuals : (n,) largest |F_k| over the ranges.
    """

    D: Floats
    Q: Floats | None
    sides: tuple[tuple[float, float], ...]
    state_range: list[tuple[float, float]]
    input_range: list[tuple[float, float]]
    residuals: Floats

    def slopes(self, j: int) -> Floats:
        """Return the derivatives of Xhat by signal j at the corners of the signals, as rows."""
        if self.Q is None:
            return self.D[:, j][None]
        pairs = _pairs(len(self.sides))
        slopes_at_corners = []
        for corner in product(*self.sides):
            by = [(a == j) * corner[b] + (b == j) * corner[a] for a, b in pairs]
            slopes_at_corners.append(self.D[:, j] + self.Q @ np.array(by))
        return np.array(slopes_at_corners)


def placed_gain(plant: Plant, gain: Floats, observer: ConstantObserver | None) -> Floats:
    """Return K (m, N) of u - u* = -K z with z = (X, s): own states' columns act on s."""
    if observer is None:
        return gain
    own_columns = plant.own_states
    inner = gain.copy()
    inner[:, own_columns] = 0.0
    return np.hstack([inner, gain[:, own_columns]])


def equilibrium_line(
    plant: Plant, gain: Floats, observer: ConstantObserver | None = None, *, curved: bool = False
) -> EquilibriumLine:
    """Return the function for a plant with references under u = u* - K (X - X*).

    An observer's estimate stands in the place of the plant's own states; a ``curved`` function has
    products of two signals.
    """
    signals = signals_of(plant)
    sides = tuple(
        (float(v.range.lower - v.rest), float(v.range.upper - v.rest)) for v in signals if v.range
    )
    rows = _right_sides(plant, observer)
    line = _fitted(plant, gain, observer, sides, curved=curved)
    ends = _feature_ends(sides, curved=curved)
    K = placed_gain(plant, gain, observer)
    n = len(plant.states)
    count = max(2, min(POINTS, int(MOST_POINTS ** (1 / len(sides)))))
    largest = np.zeros(len(line))
    for point in product(*(np.linspace(low, high, count) for low, high in sides)):
        z = line @ _features(np.array(point), curved=curved)
        with np.errstate(all="ignore"):
            largest = np.maximum(largest, np.abs(rows(z[:n], z[n:], -K @ z, np.array(point))))
    return EquilibriumLine(
        line[:, : len(sides)],
        line[:, len(sides) :] if curved else None,
        sides,
        [_range(row, ends) for row in line[:n]],
        [_range(row, ends) for row in -K @ line],
        largest * (1 + WIDER),
    )


def _right_sides(
    plant: Plant, observer: ConstantObserver | None
) -> Callable[[Floats, Floats, Floats, Floats], Floats]:
    """Return (X - X*, s, u - u*, deviations of signals) -> X' and s'."""
    signals = signals_of(plant)
    values = plant.rationals
    values |= {v.symbol: rational(v.rest) for v in plant.disturbances if v.range is None}
    listed = (*plant.states, *plant.inputs, *signals)
    right_sides = numeric(plant.equations, [v.symbol for v in listed], values)
    at_rest = np.array([float(v.rest) for v in listed])
    outputs = _outputs(plant, observer)

    def rates(X: Floats, s: Floats, u: Floats, r: Floats) -> Floats:
        state_rates = right_sides(*(at_rest + np.concatenate([X, u, r])))
        if observer is None:
            return state_rates
        gap = outputs(X) - observer.C @ s
        return np.concatenate([state_rates, observer.A @ s + observer.B @ u + observer.L @ gap])

    return rates


def _outputs(plant: Plant, observer: ConstantObserver | None) -> Callable[[Floats], Floats]:
    """Return X - X* -> y - y* of what the observer measures."""
    if observer is None:
        return lambda X: X[:0]
    output_expressions = {y.name: y.expression for y in plant.outputs}
    rows = [output_expressions[name] for name in observer.measured]
    function = numeric(rows, [v.symbol for v in plant.states], plant.rationals)
    at_rest = np.array([float(v.rest) for v in plant.states])
    resting = function(*at_rest)
    return lambda X: function(*(at_rest + X)) - resting


def _features(point: Floats, *, curved: bool) -> Floats:
    if not curved:
        return point
    products = [point[a] * point[b] for a, b in _pairs(len(point))]
    return np.concatenate([point, products])


def _pairs(count: int) -> list[tuple[int, int]]:
    return list(combinations_with_replacement(range(count), 2))


def _feature_ends(
    sides: tuple[tuple[float, float], ...], *, curved: bool
) -> tuple[tuple[float, float], ...]:
    """Return the ranges of the deviations, and of their products."""
    ends_found = list(sides)
    for a, b in _pairs(len(sides)) if curved else ():
        ends = [x * y for x in sides[a] for y in sides[b]]
        crosses = a == b and sides[a][0] <= 0 <= sides[a][1]
        ends_found.append((0.0 if crosses else min(ends), max(ends)))
    return tuple(ends_found)


def _fitted(
    plant: Plant,
    gain: Floats,
    observer: ConstantObserver | None,
    sides: tuple[tuple[float, float], ...],
    *,
    curved: bool,
) -> Floats:
    """Return [D Q]: of the equilibria, and states of the law that give their inputs."""
    rests = held_rests(plant, inside=curved)
    n_own = len(plant.states) - len(plant.references)
    points = np.array([
        _features(point - rests.points[0], curved=curved) for point in rests.points[1:]
    ])  # fmt: skip
    values = rests.values[1:] - rests.values[0]
    fitted = np.linalg.lstsq(points, values, rcond=None)[0].T
    plant_states, inputs = fitted[:n_own], fitted[n_own:]
    law_states = plant_states
    if observer is not None:
        outputs_of = _outputs(plant, observer)
        nothing = np.zeros(len(plant.references))
        outputs = np.array(
            [outputs_of(np.concatenate([value[:n_own], nothing])) for value in values]
        )
        y = np.linalg.lstsq(points, outputs, rcond=None)[0].T
        inner = observer.A - observer.L @ observer.C
        law_states = -np.linalg.solve(inner, observer.B @ inputs + observer.L @ y)
    # K_x x + K_xi xi = -u; the least-squares solution if there are more inputs than references.
    integral = -np.linalg.lstsq(gain[:, n_own:], inputs + gain[:, :n_own] @ law_states, rcond=None)[
        0
    ]
    line = np.vstack(
        [plant_states, integral] if observer is None else [plant_states, integral, law_states]
    )
    blocks = [line[:, : len(sides)], line[:, len(sides) :]]
    sizes = [np.abs(coefficients).max() if coefficients.size else 1.0 for coefficients in blocks]
    return np.hstack([
        np.array([[_short(value, size or 1.0) for value in row] for row in coefficients]).reshape(
            coefficients.shape
        )
        for coefficients, size in zip(blocks, sizes, strict=True)
    ])  # fmt: skip


def _short(value: float, size: float) -> float:
    # Entries that are zero but for rounding become zeros, and the others decimals that can be
    # stated.
    return 0.0 if abs(value) < 1e-12 * size else float(f"{value:.9g}")


def _range(row: Floats, sides: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    ends = [(float(s) * low, float(s) * high) for s, (low, high) in zip(row, sides, strict=True)]
    return sum(min(pair) for pair in ends), sum(max(pair) for pair in ends)
