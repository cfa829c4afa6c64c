r"""The response of a loop in discrete time, L(e^{j omega T}), broken at one command or at both.

    x+ = A x + B u,   -u = C x,   L(z) = C (z I - A)^-1 B

Gain, phase and disk margins mean what they mean in continuous time, up to omega = pi / T.  A delay
margin is phase over frequency: exact for a delay of whole samples, which is e^{-j omega k T}.

Source: Franklin, Powell & Workman (1998), Digital Control of Dynamic Systems, sec. 7.4; for the
disk, which asks no more of S than to be stable, ``takagi.reports.margins.disk``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.reports.margins.response import LoopResponse, grid_of_modes
from takagi.reports.margins.running_loop import RunningLoop, continuous

# Modal sums lose digits with the conditioning of the eigenvectors; beyond it, solve.
WELL_CONDITIONED = 1e9
# At a pole on the axis a loop has no finite response; the grid stays this far away, over T.
APART = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class BrokenLoops:
    """The responses of a running loop: broken at the torque, at the pitch, and at both."""

    torque: LoopResponse
    pitch: LoopResponse
    both: LoopResponse


def broken_loops(loop: RunningLoop) -> BrokenLoops:
    """Return the responses of a loop: one for each command, the other closed, and one for both."""
    A, B, C = _scaled(loop)
    T, end = loop.sample_time, float(np.pi / loop.sample_time)
    answer = _evaluator(A, B, C, T)
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


def _scaled(loop: RunningLoop) -> tuple[Floats, Floats, Floats]:
    """Return the loop with every state over its size; the responses are the same."""
    size = loop.scale
    return loop.A * size / size[:, None], loop.B / size[:, None], loop.C * size


def _evaluator(A: Floats, B: Floats, C: Floats, T: float) -> Callable[[Floats], Complex]:
    values, vectors = np.linalg.eig(A)
    modal = np.linalg.cond(vectors) < WELL_CONDITIONED
    left, right = C @ vectors, np.linalg.solve(vectors, B) if modal else B
    eye = np.eye(len(A))

    def evaluate(omega: Floats) -> Complex:
        z = np.exp(1j * T * np.asarray(omega))
        if modal:
            return np.asarray((left / (z[:, None, None] - values)) @ right, dtype=np.complex128)
        shifted = z[:, None, None] * eye - A
        inner = np.linalg.solve(shifted, np.broadcast_to(B, (len(z), *B.shape)))
        return np.asarray(C @ inner, dtype=np.complex128)

    return evaluate
