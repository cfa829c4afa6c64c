"""Structured gains from descents on the norm itself, and the function that shows their gamma."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from takagi.lmi.analysis.disturbance.bounded_real import bounded_real
from takagi.lmi.cone.balance import state_units
from takagi.lmi.gains.descent import Found, GainLoops, best_gains
from takagi.lmi.gains.structured.joint_steps import StepSearch, StructuredPoint
from takagi.lmi.gains.structured.local_search import LocalStart, LocalStep
from takagi.models.arrays import Floats

# How far above the norm the first function may be, relative; it only sets units.
ROOM = 1e-2


def descended(
    search: StepSearch, known: Sequence[LocalStart], *, starts: int, seed: int
) -> list[LocalStart]:
    """Return starts of least norm, the best first: of the vertices' own loops, rule by rule.

    With one rule the norm is that of the loop.  With several it is the largest of the loops
    A_i - B_i K_i, a lower bound of what one function can show for all blends.
    """
    plant = search.plant
    r, n, q = plant.E.shape
    C = np.broadcast_to(search.structure.C, (r, len(search.structure.C), n))
    bound = search.gain_bound

    def allowed(F: Floats) -> bool:
        if bound is None:
            return True
        return bool(np.linalg.norm(F @ search.structure.C, 2, axis=(1, 2)).max() <= bound)

    loops = GainLoops(
        A=plant.A,
        B1=plant.E,
        B2=-plant.B,
        C1=plant.C,
        C2=np.array(C),
        D11=plant.D11,
        D12=-plant.D12,
        D21=np.zeros((r, C.shape[1], q)),
        pattern=search.structure.pattern,
        group=search.structure.group,
        discrete=plant.sample_time is not None,
        allowed=allowed,
    )
    ends = best_gains(
        loops,
        [(start.name, search.bounded(start.F)) for start in known],
        starts=starts,
        seed=seed,
    )
    return [LocalStart(f"descent from {end.start}", end.F, _function(search, end)) for end in ends]


def shown(
    search: StepSearch, starts: Sequence[LocalStart]
) -> tuple[StructuredPoint | None, list[LocalStep]]:
    """Return the best point of given gains, with the function found for them, and a step of each.

    The gains stay as they are.
    """
    best: StructuredPoint | None = None
    steps = []
    for start in starts:
        spot = search.assessed(start.F, start.P)
        if spot is None:
            continue
        # In the states of this function the solver's numbers are near 1.
        spot = search.assessed(spot.F, spot.P, value=spot.value) or spot
        steps.append(LocalStep(start.name, search.objective, spot.value))
        if best is None or spot.value < best.value:
            best = spot
    return best, steps


def _function(search: StepSearch, end: Found) -> Floats:
    """Return P of about the right shape: of one loop by its Riccati or Lyapunov equation."""
    plant = search.plant
    K = search.structure.gains(end.F)
    A, C = plant.A - plant.B @ K, plant.C - plant.D12 @ K
    n = A.shape[1]
    step = plant.sample_time
    plain = np.diag(state_units(plant.A, None, step=step) ** -2.0)
    if len(A) > 1:
        return plain
    P = None
    if step is None:
        P = bounded_real(A[0], plant.E[0], C[0], plant.D11[0], tolerance=ROOM)
    if P is None:
        # A small multiple of I makes P definite where some states do not reach z.
        weight = C[0].T @ C[0] + 1e-6 * max(float(np.trace(C[0].T @ C[0])), 1e-300) * np.eye(n)
        solve = solve_continuous_lyapunov if step is None else solve_discrete_lyapunov
        P = np.asarray(solve(A[0].T, -weight if step is None else weight), dtype=np.float64)
    P = (P + P.T) / 2
    return P if np.isfinite(P).all() and np.linalg.eigvalsh(P)[0] > 0 else plain
