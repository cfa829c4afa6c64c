r"""From many starts: a stable loop first, then a descent on its norm, and on with the best.

The starts that the caller knows come first, then F = 0, then F drawn at random, in turn in the
units that were given, with normal entries, and in units of the plant's own, in which an entry of
size one moves the loop about as much as it moves by itself, with a size from four decades.  (A
descent by BFGS depends on the units by its first step alone.)  Every start gets some steps; the
better ones go on, fewer and fewer.  Then the best is shaken: entries are changed at random by some
per cent, and the descent begins again, because it may have stopped at a kink short of a minimum.

Where the norm only falls towards its infimum as F grows without bound, F would end at the size
where rounding stops it.  So log |G| + SIZE_PENALTY log(1 + |F|^2) is minimised: a gain a
thousand times larger has to be worth half a per cent.

Numbers are drawn from ``seed`` alone, so that the same question has the same answer twice.

Source: Burke, Henrion, Lewis, Overton (2006), 5th IFAC Symposium on Robust Control Design, for the
two stages.

Descent by BFGS with a weak Wolfe line search, which also works where the function has kinks.

Source: Lewis and Overton (2013), Mathematical Programming 141: the line search is their algorithm
2.6, by bisection, and the update is the usual one; no smoothness is assumed, and none is promised
of the end.

Loops that are affine in a gain F, u = F y, with the gradients of norm and slowest mode.

    A(F) = A + B2 F C2     B(F) = B1 + B2 F D21     C(F) = C1 + D12 F C2     D(F) = D11 + D12 F D21

Let s be the point of the imaginary axis (of the unit circle, in discrete time) where the largest
singular value sigma of G(s) is reached, with the unit vectors v, w of w' G v = sigma.  Where sigma
is simple and s the only such point,

    d sigma / d F_kl = Re(a_k b_l),   a = w' (C(F) Phi B2 + D12),   b = (C2 Phi B(F) + D21) v,

Phi = (s I - A(F))^-1.  Of a simple eigenvalue with the left and right vectors y, x,
d lambda / d F_kl = (y' B2)_k (C2 x)_l / (y' x).  With several systems the largest value counts.

Source: Apkarian and Noll (2006), IEEE Trans. Automatic Control 51(1), section III, for the norm;
Burke, Lewis, Overton (2003), Linear Algebra and its Applications 367, for the slowest mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from takagi.lmi.analysis.disturbance.loop_norm import Peak, largest_gain, response
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.solver.time_limit import out_of_time
from takagi.models.arrays import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GainLoops:
    """Systems i = 1 ... r with u = F_g(i) y, F zero off the pattern.

    Attributes
    ----------
    A, B1, B2 : (r, n, n), (r, n, q), (r, n, m).
    C1, D11, D12 : (r, p, n), (r, p, q), (r, p, m).
    C2, D21 : (r, k, n), (r, k, q).
    pattern : (m, k), True where F may differ from zero.
    group : (r,), the number of the F that each system uses.
    discrete : x+ in the place of x'.
    allowed : whether F (groups, m, k) may be used; the norm of another F counts as infinite.
    """

    A: Floats
    B1: Floats
    B2: Floats
    C1: Floats
    C2: Floats
    D11: Floats
    D12: Floats
    D21: Floats
    pattern: NDArray[np.bool_]
    group: Indices
    discrete: bool = False
    allowed: Callable[[Floats], bool] = field(default=lambda F: True)

    @property
    def count(self) -> int:
        """Return the number of free entries of all gains."""
        return (int(self.group.max()) + 1) * int(self.pattern.sum())

    def gains(self, entries: Floats) -> Floats:
        """Return F, (groups, m, k), from its free entries."""
        F = np.zeros((int(self.group.max()) + 1, *self.pattern.shape))
        F[:, self.pattern] = entries.reshape(len(F), -1)
        return F

    def entries(self, F: Floats) -> Floats:
        """Return the free entries of F, as one vector."""
        return np.asarray(F[:, self.pattern].reshape(-1))

    def closed(self, F: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return A, B, C, D of the closed loops."""
        vertex_gains = F[self.group]
        return (
            self.A + self.B2 @ vertex_gains @ self.C2,
            self.B1 + self.B2 @ vertex_gains @ self.D21,
            self.C1 + self.D12 @ vertex_gains @ self.C2,
            self.D11 + self.D12 @ vertex_gains @ self.D21,
        )

    def slowest(self, entries: Floats) -> tuple[float, Floats]:
        """Return the largest real part of the poles, or their largest modulus less 1; gradient."""
        F = self.gains(entries)
        if self._beyond(F):
            return np.inf, np.zeros_like(entries)
        worst, gradient = -np.inf, np.zeros_like(F)
        for i, A in enumerate(self.closed(F)[0]):
            values, left_vectors, right_vectors = eig(A, left=True, right=True)
            sizes = np.abs(values) - 1.0 if self.discrete else values.real
            k = int(np.argmax(sizes))
            if sizes[k] <= worst:
                continue
            worst = float(sizes[k])
            y, x = left_vectors[:, k].conj(), right_vectors[:, k]
            turn = values[k].conj() / (abs(values[k]) or 1.0) if self.discrete else 1.0
            between = y @ x
            slope = np.outer(y @ self.B2[i], self.C2[i] @ x)
            # Two poles that meet have no gradient; the line search passes them.
            slope = slope * (turn / between) if abs(between) > 1e-14 else np.zeros_like(slope)
            gradient = np.zeros_like(F)
            gradient[self.group[i]] = slope.real
        return worst, self.entries(gradient)

    def norm(self, entries: Floats) -> tuple[float, Floats]:
        """Return the logarithm of the largest norm, and its gradient; inf where not stable."""
        F = self.gains(entries)
        if self._beyond(F):
            return np.inf, np.zeros_like(entries)
        loops = self.closed(F)
        worst, at = Peak(0.0, 0.0), 0
        for i in range(len(self.A)):
            A, B, C, D = (matrix[i] for matrix in loops)
            peak = _discrete_gain(A, B, C, D) if self.discrete else largest_gain(A, B, C, D)
            if not np.isfinite(peak.gain):
                return np.inf, np.zeros_like(entries)
            if peak.gain >= worst.gain:
                worst, at = peak, i
        gradient = np.zeros_like(F)
        gradient[self.group[at]] = self._slope(at, loops, worst.frequency)
        # A least norm of zero is approached, never reached.
        size = max(worst.gain, 1e-300)
        return float(np.log(size)), self.entries(gradient) / size

    def _beyond(self, F: Floats) -> bool:
        return not (np.isfinite(F).all() and self.allowed(F))

    def _slope(
        self, i: int, loops: tuple[Floats, Floats, Floats, Floats], frequency: float
    ) -> Floats:
        A, B, C, D = (matrix[i] for matrix in loops)
        if np.isinf(frequency) and not self.discrete:
            # The direct term: Phi is 0.
            from_input, to_output, response_matrix = self.D12[i], self.D21[i], D
        else:
            s = _on_circle(frequency) if self.discrete else 1j * frequency
            point = np.array([s])
            response_matrix = response(A, B, C, D, point)[0]
            from_input = response(A, self.B2[i], C, self.D12[i], point)[0]
            to_output = response(A, B, self.C2[i], self.D21[i], point)[0]
        left_vectors, _, right_vectors = np.linalg.svd(response_matrix)
        a, b = left_vectors[:, 0].conj() @ from_input, to_output @ right_vectors[0].conj()
        return np.asarray(np.outer(a, b).real)


def _on_circle(frequency: float) -> complex:
    """Return z = (1 + s) / (1 - s) at s = jw."""
    return -1.0 + 0j if np.isinf(frequency) else (1 + 1j * frequency) / (1 - 1j * frequency)


def _discrete_gain(A: Floats, B: Floats, C: Floats, D: Floats) -> Peak:
    """Return the norm over the unit circle: that of the bilinear transform, z = (1 + s)/(1 - s)."""
    eye = np.eye(len(A))
    if not np.abs(np.linalg.eigvals(A)).max() < 1.0:
        return Peak(np.inf, 0.0)
    back = np.linalg.inv(A + eye)
    root = np.sqrt(2.0)
    return largest_gain(back @ (A - eye), root * back @ B, root * C @ back, D - C @ back @ B)


Function: TypeAlias = Callable[[Floats], tuple[float, Floats]]

# The line search: the share of the slope that the value has to gain, and that may remain.
GAINED, REMAINING = 1e-4, 0.5
BISECTIONS = 50
# An interval this short, relative to x, is at a kink: nothing more is to be found in it.
SHORT = 1e-9
# The descent ends where so many steps together gained less than was asked for.
WINDOW = 15


class Descent(NamedTuple):
    """Where a descent ended, and the value there."""

    x: Floats
    value: float


class _Step(NamedTuple):
    x: Floats
    value: float
    gradient: Floats


def descend(
    function: Function, x: Floats, *, steps: int, enough: float, below: float = -np.inf
) -> Descent:
    """Return the end of a descent from x.

    Parameters
    ----------
    function : x to (value, gradient); a value of inf is a wall.
    steps : the most steps.
    enough : the descent ends where ``WINDOW`` steps together gained less than this.
    below : it also ends at a value below this one.
    """
    value, gradient = function(x)
    here = _Step(x, value, gradient)
    if not np.isfinite(value):
        return Descent(x, value)
    inverse: Floats | None = None
    values = [value]
    for _ in range(steps):
        if here.value < below or not here.gradient.any():
            break
        step = None if inverse is None else _searched(function, here, -inverse @ here.gradient)
        if step is None:
            # A fresh start along the gradient, once the curvature is of no use.
            inverse = None
            size = float(np.linalg.norm(here.gradient))
            step = _searched(function, here, -here.gradient / max(size, 1.0))
        if step is None:
            break
        inverse = _updated(inverse, step.x - here.x, step.gradient - here.gradient)
        here = step
        values.append(here.value)
        if len(values) > WINDOW and values[-1 - WINDOW] - here.value < enough:
            break
    return Descent(here.x, here.value)


def _searched(function: Function, here: _Step, direction: Floats) -> _Step | None:
    """Return a point along the direction with a lower value and a flatter slope; None if none."""
    slope = float(here.gradient @ direction)
    if not slope < 0 or not np.isfinite(direction).all():
        return None
    low, high, length = 0.0, np.inf, 1.0
    reach, size = float(np.linalg.norm(direction)), float(np.linalg.norm(here.x)) + SHORT
    lower: _Step | None = None
    for _ in range(BISECTIONS):
        x = here.x + length * direction
        value, gradient = function(x)
        # The comparison is written so that a value that is not a number counts as too large.
        if not value <= here.value + GAINED * length * slope:
            high = length
        else:
            lower = _Step(x, value, gradient)
            if gradient @ direction >= REMAINING * slope:
                return lower
            low = length
        length = 2.0 * low if np.isinf(high) else (low + high) / 2.0
        if (high - low) * reach < SHORT * size:
            break
    # The value falls, but the slope stays steep: a kink was not passed.
    return lower if lower is not None and lower.value < here.value else None


def _updated(inverse: Floats | None, step: Floats, gradient_change: Floats) -> Floats:
    """Return the inverse Hessian after a step; it stays positive definite."""
    along = float(step @ gradient_change)
    eye = np.eye(len(step))
    # Without positive curvature along the step the update would lose definiteness; it is left out.
    if not along > 0:
        return eye if inverse is None else inverse
    if inverse is None:
        # The first inverse Hessian gets the size that the first step has shown (Nocedal and Wright,
        # 6.20).
        inverse = eye * (along / float(gradient_change @ gradient_change))
    projection = eye - np.outer(step, gradient_change) / along
    updated = projection @ inverse @ projection.T + np.outer(step, step) / along
    return updated if np.isfinite(updated).all() else eye


# Steps towards a stable loop, and the decay rate, relative to how fast the plant moves, with which
# the norm takes over: where a loop is hardly stable its norm is nearly infinite.
SETTLING, SETTLED = 200, 1e-3
# Rounds of the descent on the norm: how many of the best starts take part, steps, and the gain of
# the norm's logarithm over some steps with which each ends.
ROUNDS = ((None, 100, 1e-3), (6, 240, 1e-4), (2, 1500, 1e-6))
# Decades of the sizes of random gains in the plant's own units.
LOW, HIGH = -2.0, 2.0
# What the size of F costs.
SIZE_PENALTY = 3e-4
# By how much entries are shaken, relative, one after the other, with how many steps.
SHAKEN, STEPS = (0.3, 0.1, 0.03, 0.3, 0.1), 300


@dataclass(frozen=True, slots=True)
class Found:
    """A gain F (groups, m, k), the norm of its loop, and the start that led to it."""

    F: Floats
    norm: float
    start: str


@dataclass(frozen=True, slots=True, eq=False)
class _Units:
    """F = inputs Fhat / outputs, and the plant in these units."""

    loops: GainLoops
    inputs: Floats
    outputs: Floats
    speed: float


def best_gains(
    loops: GainLoops, named_gains: Sequence[tuple[str, Floats]], *, starts: int, seed: int
) -> list[Found]:
    """Return the gains that the best starts lead to, the best first; empty if none is stable.

    Parameters
    ----------
    named_gains : names and gains F (groups, m, k) to start from, as well as F = 0.
    starts : the number of random gains to start from.
    seed : of their numbers.
    """
    scaled_units, plain = _units_of(loops), _given_units(loops)
    spots: list[_Spot] = []
    for name, units, entries in _starts((scaled_units, plain), named_gains, starts, seed):
        if out_of_time():
            break
        stable = _settled(units, entries)
        if stable is not None:
            value = units.loops.norm(stable)[0] + SIZE_PENALTY * float(
                np.log(1.0 + stable @ stable)
            )
            spots.append(_Spot(units, stable, value, name))
    for spot_count, steps, enough in ROUNDS:
        spots = [_descended(spot, steps, enough) for spot in spots[:spot_count]]
        spots.sort(key=lambda spot: spot.value)
    # The best of all, shaken.
    if spots:
        spots[0] = _shaken(spots[0], np.random.default_rng(seed))
    return [spot.result() for spot in spots if np.isfinite(spot.value)]


@dataclass(frozen=True, slots=True, eq=False)
class _Spot:
    """Entries of F in units of a start, and what is minimised there."""

    units: _Units
    entries: Floats
    value: float
    start: str

    def result(self) -> Found:
        """Return the gains in the units that were given."""
        F = self.units.loops.gains(self.entries)
        F = F * self.units.inputs[:, None] / self.units.outputs
        return Found(F, float(np.exp(self.units.loops.norm(self.entries)[0])), self.start)


def _cost(units: _Units, entries: Floats) -> tuple[float, Floats]:
    if out_of_time():
        # A wall: the line search ends, and the descent with it.
        return np.inf, np.zeros_like(entries)
    value, gradient = units.loops.norm(entries)
    size = 1.0 + float(entries @ entries)
    return value + SIZE_PENALTY * float(
        np.log(size)
    ), gradient + 2.0 * SIZE_PENALTY * entries / size


def _descended(spot: _Spot, steps: int, enough: float) -> _Spot:
    """Return the spot after a descent; as it is where the time is up."""
    if out_of_time():
        return spot
    end = descend(partial(_cost, spot.units), spot.entries, steps=steps, enough=enough)
    if not end.value < spot.value:
        return spot
    return replace(spot, entries=end.x, value=end.value)


def _shaken(spot: _Spot, rng: np.random.Generator) -> _Spot:
    for share in SHAKEN:
        perturbed = spot.entries * (1.0 + share * rng.standard_normal(len(spot.entries)))
        # A change by tens of per cent may have made the loop unstable, where its norm is infinite.
        stable = _settled(spot.units, perturbed)
        if stable is None:
            continue
        second = _descended(replace(spot, entries=stable), STEPS, ROUNDS[-1][2])
        if second.value < spot.value:
            spot = second
    return spot


def _units_of(loops: GainLoops) -> _Units:
    """Return the loops in states of like size, with inputs and outputs of order one."""
    step = 1.0 if loops.discrete else None
    s = state_units(loops.A, None, step=step)
    A = loops.A * s / s[:, None]
    B2, C2 = loops.B2 / s[:, None], loops.C2 * s
    size = float(np.linalg.norm(motion(A, step), 2, axis=(1, 2)).max()) or 1.0
    reach = np.linalg.norm(B2, axis=1).max(axis=0)
    output_sizes = np.linalg.norm(C2, axis=2).max(axis=0)
    inputs = size / np.where(reach > 0, reach, size)
    outputs = np.where(output_sizes > 0, output_sizes, 1.0)
    inside = replace(
        loops,
        A=A,
        B1=loops.B1 / s[:, None],
        B2=B2 * inputs,
        C1=loops.C1 * s,
        C2=C2 / outputs[:, None],
        D12=loops.D12 * inputs,
        D21=loops.D21 / outputs[:, None],
        allowed=lambda F: loops.allowed(F * inputs[:, None] / outputs),
    )
    return _Units(inside, inputs, outputs, size)


def _given_units(loops: GainLoops) -> _Units:
    step = 1.0 if loops.discrete else None
    size = float(np.linalg.norm(motion(loops.A, step), 2, axis=(1, 2)).max())
    m, k = loops.pattern.shape
    return _Units(loops, np.ones(m), np.ones(k), size or 1.0)


def _starts(
    units: tuple[_Units, _Units], named_gains: Sequence[tuple[str, Floats]], starts: int, seed: int
) -> Iterator[tuple[str, _Units, Floats]]:
    scaled_units, plain = units
    count = scaled_units.loops.count
    for name, F in named_gains:
        yield (
            name,
            scaled_units,
            scaled_units.loops.entries(F * scaled_units.outputs / scaled_units.inputs[:, None]),
        )
    yield "no control", scaled_units, np.zeros(count)
    rng = np.random.default_rng(seed)
    for number in range(starts):
        size, entries = 10.0 ** rng.uniform(LOW, HIGH), rng.standard_normal(count)
        name = f"random {number + 1}"
        yield (
            (name, scaled_units, size * entries / np.sqrt(count))
            if number % 2
            else (name, plain, entries)
        )


def _settled(units: _Units, entries: Floats) -> Floats | None:
    """Return entries of a stable loop, where the slowest mode can be moved so far; else None."""
    stable_value = -SETTLED * (1.0 if units.loops.discrete else units.speed)
    value, _ = units.loops.slowest(entries)
    if value < stable_value:
        return entries
    end = descend(
        units.loops.slowest, entries, steps=SETTLING, enough=1e-6 * units.speed, below=stable_value
    )
    return end.x if end.value < 0 else None
