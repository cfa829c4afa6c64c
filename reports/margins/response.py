"""L(j omega) of a square loop, on a grid that is fine near its modes.

A loop is given in the convention of negative feedback: the closed loop is 1 + L = 0, and the
sensitivity is S = (I + L)^-1.

In discrete time it is L(e^{j omega T}), broken at one command or at both:

    x+ = A x + B u,   -u = C x,   L(z) = C (z I - A)^-1 B

Gain, phase and disk margins mean what they mean in continuous time, up to omega = pi / T.  A delay
margin is phase over frequency: exact for a delay of whole samples, which is e^{-j omega k T}.

Source: Franklin, Powell & Workman (1998), Digital Control of Dynamic Systems, sec. 7.4; for the
disk, which asks no more of S than to be stable, ``takagi.reports.margins.margins``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from takagi.models.arrays import Complex, Floats

if TYPE_CHECKING:
    from takagi.reports.margins.running_loop import RunningLoop

POINTS_PER_DECADE = 150
# A pole nearer than this to the axis, relative to the fastest pole, counts as lying at zero.
ORIGIN = 1e-9
# An undamped loop has no finite response at its own frequency; this far beside it there is one.
NUDGE = 1e-9
# Frequencies of a loop in discrete time.
POINTS = 1200
# From so many points on the Schur form is faster than a solution at each.
MANY = 20


@dataclass(frozen=True, eq=False)
class LoopResponse:
    """A loop as margins read it.

    Attributes
    ----------
    evaluate : omega (k,) [rad/s] -> L(j omega) (k, m, m).
    frequencies : increasing grid [rad/s]; begins with 0 where L(0) is finite.
    at_infinity : L(j inf) (m, m), or None where it is not known; of a loop in discrete time, L at
        ``end``.
    stable : whether all closed-loop poles lie in the open left half-plane.
    end : the highest frequency [rad/s]: inf, or pi / T of a loop in discrete time.
    """

    evaluate: Callable[[Floats], Complex]
    frequencies: Floats
    at_infinity: Complex | None
    stable: bool
    end: float = float("inf")

    @cached_property
    def values(self) -> Complex:
        """L on the grid, (k, m, m); every margin begins with it."""
        return np.concatenate([self.evaluate(self.frequencies[:1]), self.values_beyond])

    @cached_property
    def values_beyond(self) -> Complex:
        """L on the grid without its first frequency, where L may have no value, (k - 1, m, m)."""
        return self.evaluate(self.frequencies[1:])


def continuous_response(A: Floats, B: Floats, C: Floats) -> LoopResponse:
    """Return the response of L(s) = C (s I - A)^-1 B, which has as many inputs as outputs."""
    transfer, open_modes = _transfer(A, B, C), np.linalg.eigvals(A)
    closed_modes = np.linalg.eigvals(A - B @ C)

    def evaluate(omega: Floats) -> Complex:
        try:
            return transfer(1j * np.asarray(omega))
        except np.linalg.LinAlgError:
            # A pole on the axis has no finite response: a little beside it there is one.
            return transfer(1j * (np.asarray(omega) * (1 + NUDGE) + NUDGE))

    return LoopResponse(
        evaluate=evaluate,
        frequencies=grid_of_modes(np.concatenate([open_modes, closed_modes]), open_modes),
        at_infinity=np.zeros((len(C), len(C)), dtype=np.complex128),
        stable=bool(np.all(closed_modes.real < 0)),
    )


def sampled_response(A: Floats, B: Floats, C: Floats, T: float, *, stable: bool) -> LoopResponse:
    """Return L(e^{j omega T}) of L(z) = C (z I - A)^-1 B, from slow to pi / T [rad/s].

    The end is left out: poles at -1 lie there.
    """
    transfer = _transfer(A, B, C)
    return LoopResponse(
        evaluate=lambda omega: transfer(np.exp(1j * T * np.asarray(omega))),
        frequencies=np.geomspace(1e-4, 1 - 1e-6, POINTS) * np.pi / T,
        at_infinity=None,
        stable=stable,
    )


def _transfer(A: Floats, B: Floats, C: Floats) -> Callable[[Any], Complex]:
    """Return complex points z (k,) -> C (z I - A)^-1 B at each, (k, m, m).

    Of many points by the Schur form A = Q T Q^H, all of them in each step of the substitution.
    """
    from scipy.linalg import schur

    @cache
    def schur_form() -> tuple[Complex, Complex, Complex]:
        T, Q = schur(A, output="complex")
        return T, Q.conj().T @ B, C @ Q

    eye = np.eye(len(A))

    def at(points: Any) -> Complex:
        if len(points) >= MANY:
            return _triangular(points, *schur_form())
        shifted = points[:, None, None] * eye - A
        inner = np.linalg.solve(shifted, np.broadcast_to(B, (len(points), *B.shape)))
        return np.asarray(C @ inner, dtype=np.complex128)

    return at


def _triangular(points: Any, T: Complex, entering: Complex, leaving: Complex) -> Complex:
    shifted = points - np.diag(T)[:, None]
    if not shifted.all():
        raise np.linalg.LinAlgError("a point is an eigenvalue")
    n, k, m = len(T), len(points), entering.shape[1]
    inner = np.empty((n, k, m), dtype=np.complex128)
    for i in reversed(range(n)):
        later = T[i, i + 1 :] @ inner[i + 1 :].reshape(n - i - 1, k * m)
        inner[i] = (entering[i] + later.reshape(k, m)) / shifted[i][:, None]
    return np.asarray(np.einsum("pn,nkm->kpm", leaving, inner), dtype=np.complex128)


def grid_of_modes(modes: Any, open_modes: Any) -> Floats:
    """Return frequencies [rad/s] that resolve the modes of a loop [1/s].

    150 points a decade from a hundredth of the slowest to a hundred times the fastest mode, and
    a cluster as wide as the damping around each lightly damped mode.  0 comes first unless the
    open loop, whose modes are ``open_modes``, has a pole there.
    """
    size = np.abs(modes)
    fast = max(float(size.max()), 1e-6)
    lively = modes[size > ORIGIN * fast]
    slow = float(np.abs(lively).min()) if lively.size else fast
    low, high = 1e-2 * slow, 1e2 * fast
    count = int(np.ceil(POINTS_PER_DECADE * np.log10(high / low)))
    parts = [np.geomspace(low, high, count)]
    for mode in lively[(lively.imag > 0) & (np.abs(lively.real) < 0.3 * np.abs(lively))]:
        width = max(abs(mode.real), 1e-7 * abs(mode))
        # An even count leaves the centre out, where an undamped mode has no finite response.
        parts.append(abs(mode) + width * np.sinh(np.linspace(-6.0, 6.0, 120)))
    grid = np.unique(np.concatenate(parts))
    undamped = np.abs(modes[np.abs(modes.real) <= ORIGIN * np.abs(modes)])
    near = np.abs(grid[:, None] - undamped) <= ORIGIN * undamped
    grid = grid[(grid >= low) & ~near.any(axis=1)]
    at_origin = np.abs(open_modes).min() <= ORIGIN * fast
    return grid if at_origin else np.concatenate([[0.0], grid])


def largest(height: Callable[[Complex], Floats], response: LoopResponse) -> tuple[float, float]:
    """Return (sup height, its frequency [rad/s]), refined around the grid's four highest peaks.

    ``height`` : of L (k, m, m), (k,).
    """
    from scipy.optimize import minimize_scalar

    grid = response.frequencies
    values = height(response.values)
    best, where = float(values.max()), float(grid[int(values.argmax())])
    inner = np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])) + 1
    for k in inner[np.argsort(values[inner])][-4:]:
        found = minimize_scalar(
            lambda w: -float(height(response.evaluate(np.array([w])))[0]),
            bounds=(grid[k - 1], grid[k + 1]),
            method="bounded",
            options={"xatol": 1e-10 * float(grid[k])},
        )
        if -float(found.fun) > best:
            best, where = -float(found.fun), float(found.x)
    if response.at_infinity is not None:
        at_end = float(height(response.at_infinity[None])[0])
        best, where = (at_end, response.end) if at_end > best else (best, where)
    return best, where


# Modal sums lose digits with the conditioning of the eigenvectors; beyond it, solve.
WELL_CONDITIONED = 1e9
# At a pole on the axis a loop has no finite response; the grid stays this far away, over T.
APART = 1e-9


class BrokenLoops(NamedTuple):
    """The responses of a running loop: broken at the torque, at the pitch, and at both."""

    torque: LoopResponse
    pitch: LoopResponse
    both: LoopResponse


def broken_loops(loop: RunningLoop) -> BrokenLoops:
    """Return the responses of a loop: one for each command, the other closed, and one for both."""
    from takagi.reports.margins.running_loop import continuous

    # Every state over its size; the responses are the same.
    size, T, end = loop.scale, loop.sample_time, float(np.pi / loop.sample_time)
    A, B, C = loop.A * size / size[:, None], loop.B / size[:, None], loop.C * size
    answer = _sampled_evaluator(A, B, C, T)
    stable = bool(np.all(np.abs(loop.multipliers) < 1))
    alone = [A - B[:, [1 - i]] @ C[[1 - i]] for i in (0, 1)]
    closed = np.linalg.eigvals(A - B @ C)

    def response(evaluate: Callable[[Floats], Complex], opened: Floats) -> LoopResponse:
        open_modes = continuous(np.linalg.eigvals(opened).astype(np.complex128), T)
        modes = np.concatenate([open_modes, continuous(closed.astype(np.complex128), T)])
        grid = grid_of_modes(modes, open_modes)
        last = evaluate(np.array([end]))[0].real.astype(np.complex128)
        return LoopResponse(evaluate, grid[grid < end * (1 - APART)], last, stable, end)

    def one(i: int) -> LoopResponse:
        def evaluate(omega: Floats) -> Complex:
            # The other loop closed: a Schur complement of I + L.
            L, j = answer(omega), 1 - i
            rest = L[:, i, j] * L[:, j, i] / (1 + L[:, j, j])
            return np.asarray((L[:, i, i] - rest)[:, None, None], dtype=np.complex128)

        return response(evaluate, alone[i])

    return BrokenLoops(one(0), one(1), response(answer, A))


def _sampled_evaluator(A: Floats, B: Floats, C: Floats, T: float) -> Callable[[Floats], Complex]:
    values, vectors = np.linalg.eig(A)
    if not np.linalg.cond(vectors) < WELL_CONDITIONED:
        transfer = _transfer(A, B, C)
        return lambda omega: transfer(np.exp(1j * T * np.asarray(omega)))
    left, right = C @ vectors, np.linalg.solve(vectors, B)

    def evaluate(omega: Floats) -> Complex:
        z = np.exp(1j * T * np.asarray(omega))
        return np.asarray((left / (z[:, None, None] - values)) @ right, dtype=np.complex128)

    return evaluate
