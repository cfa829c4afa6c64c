"""From disturbance to output: one path through the vertices, checked, and in units of order one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.analysis.quadratic import common_lyapunov, slow_vertex, vertex_weight
from takagi.lmi.answer import Answer
from takagi.lmi.intake import Vertices, vertex_stack
from takagi.lmi.solver.balance import nearest_power
from takagi.lmi.solver.diagnosis import binding_items
from takagi.lmi.solver.stages import Outcome
from takagi.lmi.term import Condition
from takagi.models.errors import ModelError
from takagi.models.vertex_arrays import vertex_arrays

__all__ = ["Channel", "Units", "answer_without", "channel_of", "hopeless_vertex", "near_least"]

Floats: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """xdot = sum_i h_i (A_i x + B_i w), y = sum_i h_i (C_i x + D_i w).

    Attributes
    ----------
    A, B, C, D : (r, n, n), (r, n, q), (r, p, n), (r, p, q).
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats

    def scaled(self, units: Units) -> Channel:
        """Return the path in the given units; each number is multiplied by powers of two."""
        s = units.states
        return Channel(
            self.A * s / s[:, None] / units.rate,
            self.B / s[:, None] * (units.disturbance / units.rate),
            self.C * s / units.output,
            self.D * (units.disturbance / units.output),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Units:
    """x = states xhat, w = disturbance what, y = output yhat, and time in 1 / rate.

    Attributes
    ----------
    states : (n,) powers of two, as are the others.
    """

    states: Floats
    rate: float
    disturbance: float
    output: float

    @classmethod
    def of(cls, channel: Channel, states: Floats) -> Units:
        """Return the units in which |A| is about 1, |B| and |C| alike, and the gain about 1."""
        s = states
        rate = _power(vertex_weight(channel.A * s / s[:, None]) / 2)
        plain = channel.scaled(cls(states, rate, 1.0, 1.0))
        reach, shown = float(np.abs(plain.B).max()), float(np.abs(plain.C).max())
        gain = _largest_response(plain)
        if gain == 0.0 or not np.isfinite(gain):
            gain = reach * shown or 1.0
        # w scaled by d and y by c multiply the gain by d / c and P by c / d.
        ratio = np.sqrt(shown / reach) if reach and shown else 1.0
        disturbance = _power(ratio / np.sqrt(gain))
        output = _power(ratio * np.sqrt(gain))
        return cls(states, rate, disturbance, output)


def channel_of(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
) -> Channel:
    """Return the path E (or B, where there is no E) to C, of a model or of matrices.

    Parameters
    ----------
    model : A (r, n, n), C (r, p, n), and E (r, n, q) or B (r, n, m) with D (r, p, m); or A itself,
        (r, n, n) or (n, n).
    B, C, D : with A itself only; (r, ., .), or (., .) for the same in every vertex.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, or a path that is
        zero at every vertex.
    """
    A = vertex_stack(model).astype(np.float64)
    given = {"B": B, "C": C, "D": D, "E": None}
    if hasattr(model, "A"):
        extra = [letter for letter, value in given.items() if value is not None]
        if extra:
            raise ModelError(
                f"a model and {', '.join(extra)} were given; give the model alone, or A, B, C, D "
                "as arrays"
            )
        given = {letter: getattr(model, letter, None) for letter in given}
    if given["C"] is None or 0 in np.shape(given["C"]):
        raise ModelError("there is no output; C is needed, (p, n) or one for each vertex")
    disturbed = given["E"] is not None and 0 not in np.shape(given["E"])
    if not disturbed and (given["B"] is None or 0 in np.shape(given["B"])):
        raise ModelError("there is no disturbance and no input; E (or B) is needed")
    # What the input does to the output is no part of the path from E.
    unused = ("B", "D") if disturbed else ("E",)
    arrays, _ = vertex_arrays(
        A,
        {letter: None if letter in unused else value for letter, value in given.items()},
        dict.fromkeys(("states", "inputs", "outputs", "disturbances")),
    )
    C_ = arrays["C"]
    W = arrays["E"] if disturbed else arrays["B"]
    through = np.zeros((len(A), C_.shape[1], W.shape[2])) if disturbed else arrays["D"]
    if not (through.any() or (W.any() and C_.any())):
        name = ("E" if disturbed else "B") if not W.any() else "C"
        raise ModelError(
            f"{name} is zero at every vertex, so nothing reaches the output; the gain is 0"
        )
    return Channel(A, W, C_, through)


def hopeless_vertex(channel: Channel, states: Floats) -> str:
    """Return why no bound can be finite: a vertex that is not stable; empty when all are."""
    found = slow_vertex(channel.A * states / states[:, None], 0.0)
    if found is None:
        return ""
    vertex, eigenvalue, _ = found
    return (
        f"vertex {vertex + 1} of {len(channel.A)} is not stable: its eigenvalue {eigenvalue:.6g} "
        "does not decay, so no bound is finite; stabilise it, or shrink the box so that this "
        "vertex moves"
    )


def near_least(outcome: Outcome) -> bool:
    """Return whether the outcome is a candidate whose objective is near its least value.

    Where no solver gets near it, ``optimise`` returns unknowns that only satisfy the condition:
    a bound too, but possibly a thousand times the least one, so it is not passed off as that.
    """
    return outcome.status == "candidate" and bool(np.isfinite(outcome.objective))


def answer_without(
    channel: Channel, states: Floats, condition: Condition, outcome: Outcome
) -> Answer:
    """Return the answer where no bound was found: no common P at all, or no solver settled it."""
    stable = common_lyapunov(channel.A, scales=states)
    no = stable.status == "infeasible"
    why = (
        "the vertices have a common P, so a bound exists, but"
        if stable.found
        else "whether the vertices have a common P is not settled, and"
    )
    diagnosis = f"{why} no solver came near the least one; give scales, or leave out fast states"
    if no and stable.condition is not None:
        binding = binding_items(stable.condition, stable.multipliers, "vertex")
        diagnosis = (
            f"no bound by one quadratic function, for there is no common P: {binding}; shrink the "
            "box that these vertices span, or stabilise them with a margin"
        )
    return Answer(
        status="infeasible" if no else "unknown",
        P=None,
        margin=stable.margin if no else min(outcome.margin, 0.0),
        bound=stable.bound if no else np.inf,
        multipliers=stable.multipliers if no else {},
        coordinates=states,
        condition=stable.condition if no else condition,
        diagnosis=diagnosis,
        tries=(*outcome.tries, *stable.tries),
    )


def _power(value: float) -> float:
    return float(nearest_power(np.array([value]))[0])


def _largest_response(channel: Channel) -> float:
    """Return the largest singular value of the vertices' responses, at their own frequencies."""
    A, B, C, D = channel.A, channel.B, channel.C, channel.D
    poles = np.linalg.eigvals(A)
    rates = np.concatenate([np.zeros((len(A), 1)), np.abs(poles.imag), np.abs(poles)], axis=1)
    one = np.eye(A.shape[1])
    through = float(np.linalg.norm(D, 2, axis=(1, 2)).max())
    with np.errstate(all="ignore"):
        try:
            inside = 1j * rates[:, :, None, None] * one - A[:, None]
            response = C[:, None] @ np.linalg.solve(inside, B[:, None]) + D[:, None]
        except np.linalg.LinAlgError:
            return through
    return max(through, float(np.linalg.norm(response, 2, axis=(2, 3)).max()))
