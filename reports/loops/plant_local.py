r"""The linear loops of a plant: at its rest and at the vertices, their poles and margins.

A loop is broken at input k while the others stay closed: L_k(s) = K_k (s I - A + B' K')^{-1} B_k,
with B' K' of the other inputs (negative feedback).  In discrete time s is replaced by
z = e^{j omega T}.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.reports.margins.margins import Margins, loop_margins
from takagi.reports.margins.response import LoopResponse, continuous_response, sampled_response

if TYPE_CHECKING:
    from takagi.reports.loops.plant_loop import PlantLoop

# Loops at vertices are listed up to this many rules.
LISTED = 32


@dataclass(frozen=True, slots=True, eq=False)
class PlantLocalLoop:
    """One loop: where, broken at which input, its response and margins, and the closed poles."""

    place: str
    input: str
    response: LoopResponse
    margins: Margins
    poles: Complex


def local_loops(loop: PlantLoop) -> tuple[PlantLocalLoop, ...]:
    """Return the loops at rest, then at each of several vertices with its own gain.

    None for an analysis.

    Vertices are corners of the premises' ranges: the plant need not reach them.  Of a law with
    outputs only the loop at rest: plant and observer in a row.
    """
    loops = rest_loops(loop)
    rules = len(loop.model.rules)
    if loop.gains is None or loop.observed is not None or not 1 < rules <= LISTED:
        return loops
    stacks = zip(loop.model.A, loop.model.B, loop.gains, strict=True)
    for i, (A, B, K) in enumerate(stacks, 1):
        loops += _at_each_input(loop, f"vertex {i}", A, B, K)
    return loops


def rest_loops(loop: PlantLoop, gain: Floats | None = None) -> tuple[PlantLocalLoop, ...]:
    """Return the loops at rest, one for each input; none for an analysis.

    gain : K (m, n) of another law of all states; None for the design's own law.
    """
    return _rest_loops(loop, None if gain is None else tuple(map(tuple, gain.tolist())))


@lru_cache(maxsize=8)
def _rest_loops(
    loop: PlantLoop, given: tuple[tuple[float, ...], ...] | None
) -> tuple[PlantLocalLoop, ...]:
    if loop.gains is None:
        return ()
    if loop.observed is not None:
        h = loop.memberships(np.zeros(len(loop.names)))
        return _at_each_input(loop, "rest", *loop.observed.joint(h))
    rest, K = loop.at_rest()
    assert K is not None
    return _at_each_input(loop, "rest", rest.A, rest.B, K if given is None else np.array(given))


def _at_each_input(
    loop: PlantLoop, location: str, A: Floats, B: Floats, K: Floats
) -> tuple[PlantLocalLoop, ...]:
    # The rates of a controller's states are no inputs of the plant.
    inputs = [k for k in range(B.shape[1] - len(loop.plant.integrators)) if np.any(K[k])]
    return tuple(_broken(loop, location, A, B, K, k) for k in inputs)


def _broken(
    loop: PlantLoop, location: str, A: Floats, B: Floats, K: Floats, k: int
) -> PlantLocalLoop:
    closed_inputs = [j for j in range(B.shape[1]) if j != k]
    inner = A - B[:, closed_inputs] @ K[closed_inputs]
    closed = A - B @ K
    poles = np.linalg.eigvals(closed).astype(np.complex128)
    step, broken = loop.model.sample_time, (inner, B[:, [k]], K[[k]])
    if step is None:
        response = continuous_response(*broken)
    else:
        response = sampled_response(*broken, step, stable=bool(np.all(np.abs(poles) < 1)))
    return PlantLocalLoop(location, loop.model.inputs[k], response, loop_margins(response), poles)


def common_frequencies(loops: Sequence[PlantLocalLoop]) -> Floats:
    """Return one grid for all loops, from a hundredth of the lowest crossover to 30 highest."""
    crossovers = [w for local_loop in loops for w in local_loop.margins.crossovers]
    ends = [local_loop.response.frequencies for local_loop in loops]
    low = min(crossovers) / 100 if crossovers else min(float(e[e > 0][0]) for e in ends)
    high = 30 * max(crossovers) if crossovers else max(float(e[-1]) for e in ends)
    if any(local_loop.response.at_infinity is None for local_loop in loops):
        high = min(high, min(float(e[-1]) for e in ends))
    return np.geomspace(low, max(high, 10 * low), 700)
