"""A plant's linear loops at rest and at vertices, and a linear-quadratic regulator beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from takagi.certificates.claims.certification import certify
from takagi.certificates.design.plant.candidates import regulator_gain
from takagi.certificates.design.plant.gain_task import rounded_gains
from takagi.certificates.design.plant.result import PlantDesign
from takagi.certificates.requests.invariant_ellipsoid import InvariantEllipsoid
from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.reports.loops.plant_claims import SETTLED, half_widths
from takagi.reports.loops.plant_loop import PlantLoop, largest_commands, plant_loop, proved_claims
from takagi.reports.margins.margins import Margins, loop_margins
from takagi.reports.margins.response import LoopResponse, continuous_response, sampled_response

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

    Parameters
    ----------
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


# With more, the set of the regulator takes longer than a few seconds to seek and prove.
MOST_RULES, MOST_STATES = 16, 6


@dataclass(frozen=True, slots=True, eq=False)
class Regulator:
    """The regulator u = u* - K (x - x*) beside the design's law at rest.

    Attributes
    ----------
    gain : K (m, n) of the regulator.
    poles, own_poles : of the two linear loops at rest.
    states, inputs : (n,) and (m,): the sizes that the weights are made of, SI.
    starts : (n,) how far each state alone may start off rest in the set that is proved for the
        regulator; None where none is proved.
    sought : whether that set was sought.
    """

    gain: Floats
    poles: Complex
    own_poles: Complex
    states: Floats
    inputs: Floats
    starts: Floats | None
    sought: bool

    def settling(self, *, of_design: bool, step: float | None) -> float | None:
        """Return the time [s] in which the slowest mode of a linear loop falls to 2 %."""
        poles = self.own_poles if of_design else self.poles
        if step is None:
            rate = float(-poles.real.max())
        else:
            rate = float(-np.log(np.maximum(np.abs(poles).max(), 1e-300)) / step)
        return float(-np.log(SETTLED) / rate) if rate > 0 else None


@lru_cache(maxsize=4)
def regulator(design: PlantDesign) -> Regulator | None:
    """Return the regulator beside a design; None without inputs, sizes or a stabilising solution.

    A plant behind a blend has none, because one of its inputs is the rate of an effort; nor has a
    law with outputs, whose observer or controller a regulator of all states does not need.
    """
    loop = plant_loop(design)
    sizes = design.regulator_sizes or _sizes(loop)
    special = loop.blend is not None or loop.observed is not None
    if loop.gains is None or special or loop.plant.integrators or sizes is None:
        return None
    rest, design_gain = loop.at_rest()
    assert design_gain is not None
    states, inputs = sizes
    gain = regulator_gain(rest.A, rest.B, states, inputs, loop.model.sample_time)
    if gain is None:
        return None
    gain = rounded_gains(gain[None], 4)[0]
    sought = len(loop.model.rules) <= MOST_RULES and len(loop.names) <= MOST_STATES
    return Regulator(
        gain,
        np.linalg.eigvals(rest.A - rest.B @ gain).astype(np.complex128),
        np.linalg.eigvals(rest.A - rest.B @ design_gain).astype(np.complex128),
        states,
        inputs,
        _starts(design, gain) if sought else None,
        sought,
    )


def regulator_loop(loop: PlantLoop, beside: Regulator) -> PlantLoop:
    """Return the plant under the regulator; the design's set and function are left out."""
    gains = np.broadcast_to(beside.gain, (len(loop.model.rules), *beside.gain.shape))
    return replace(
        loop, gains=gains, P=None, level=None, level_proved=False, decay_rate=None, decay_P=None
    )


def _sizes(loop: PlantLoop) -> tuple[Floats, Floats] | None:
    """Return the sizes of states and inputs for the weights; None where one has none."""
    model, reach = loop.model, half_widths(loop)
    states = _halves(loop, model.states, reach)
    commands = [size for _, size in largest_commands(loop)] if reach is not None else None
    inputs = _halves(loop, model.inputs, None if commands is None else np.array(commands))
    return None if states is None or inputs is None else (states, inputs)


def _halves(loop: PlantLoop, labels: tuple[str, ...], instead: Floats | None) -> Floats | None:
    widths = []
    for k, label in enumerate(labels):
        ends = loop.model.box.get(label)
        if ends is not None:
            widths.append(min(abs(float(end)) for end in ends))
        elif instead is not None:
            widths.append(float(instead[k]))
        else:
            return None
    sizes = np.array(widths)
    return sizes if sizes.size and np.all(np.isfinite(sizes) & (sizes > 0)) else None


def _starts(design: PlantDesign, gain: Floats) -> Floats | None:
    """Return how far each state alone may start in the set that is proved for a gain."""
    try:
        certified = certify(design.model, gain, claims=[InvariantEllipsoid()])
    except ModelError:
        return None
    kinds = proved_claims(certified.document, certified.checked)
    sets = [claim for claim in kinds if claim["kind"] == "invariant-ellipsoid"]
    if not sets or not all(claim.verdict.name == "PROVED" for claim in certified.checked.claims):
        return None
    P, level = sets[0]["P"], Fraction(str(sets[0]["level"]))
    return np.array([float(level / Fraction(str(P[k][k]))) ** 0.5 for k in range(len(P))])
