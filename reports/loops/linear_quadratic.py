"""A linear-quadratic regulator for the plant where it rests, to compare a design with.

Weights are Bryson's: Q = diag(1 / x_k^2), R = diag(1 / u_k^2), with the half-widths of the box of
states and the room of inputs.  A state without a range takes its half-width of the proved set, an
input without one its largest command there; where the design chose its law beside a regulator, the
sizes are those of its first candidate.  Gains and poles are floating point; the set of the
regulator is sought and proved by the same requests and the same checker as the design's, for the
gains to four digits as one gain in all rules.

Source: Bryson and Ho (1975), Applied Optimal Control, section 5.2, for the weights.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.reports.loops.plant_claims import SETTLED, half_widths
from takagi.reports.loops.plant_loop import largest_commands

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.loops.plant_loop import PlantLoop

# With more, the set of the regulator takes longer than a few seconds to seek and prove.
MOST_RULES, MOST_STATES = 16, 6


@dataclass(frozen=True, slots=True, eq=False)
class Regulator:
    """The regulator u = u* - K (x - x*) beside the design's law at rest.

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
    from takagi.certificates.design.plant.candidates import regulator_gain
    from takagi.certificates.design.plant.gains import rounded_gains
    from takagi.reports.loops.plant_loop import plant_loop

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
    from takagi.certificates.claims.certification import certify
    from takagi.certificates.requests.invariant_ellipsoid import InvariantEllipsoid
    from takagi.reports.loops.plant_loop import proved_claims

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
