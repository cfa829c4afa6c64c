r"""Check that an ellipsoid {x'Px <= c} lies in the box where the model represents its plant.

    |a x| <= b on the ellipsoid   exactly when   c a P^-1 a' <= b^2:   [[P, a'], [a, b^2 / c]] >= 0

for P > 0, by Schur.  The box of a model has ranges of states, which the ellipsoid must satisfy, and
of inputs, which u = -K_j x must satisfy for every gain (u = 0 without gains). Ranges of
disturbances are bounded by the claim or assumed. Ranges of other signals in the premises are
assumed, and the verdict names them.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.2.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Inequality,
    Obligations,
    never,
    nonnegative,
)
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded

Range = tuple[Fraction, Fraction]


def read_box(
    model: Any, states: tuple[str, ...], where: str
) -> tuple[tuple[Range | None, ...], dict[str, Range]]:
    """Return the range of every state, and those of other variables."""
    sides = model["box"]
    if not isinstance(sides, dict):
        raise CertificateError(f"{where}.box: an object of ranges is needed")
    ranges = {}
    for name in sides:
        # Sentences and messages print a name unchanged.
        if not name or not name.isprintable():
            raise CertificateError(f"{where}.box: {name[:60]!a} is no name of printable text")
        ends = reader.numbers(sides, name, f"{where}.box", 2)
        reader.increasing(ends, f"{where}.box.{name!a}")
        ranges[name] = (ends[0], ends[1])
    return tuple(ranges.pop(name, None) for name in states), ranges


def reaches_at_most(
    P: Matrix, level: Fraction, row: Matrix, limit: Fraction, failure: str
) -> Inequality:
    """Return the obligation |row x| <= limit wherever x'Px <= level, for P > 0 and level > 0."""
    if limit < 0:
        return never(failure)
    corner = Matrix.of([[limit**2 / level]])
    return nonnegative(Matrix.blocks([[P, row.T], [row, corner]]), failure)


def inside_box(
    loop: PolytopicLoop, P: Matrix, level: Fraction, added: Sequence[Fraction] = ()
) -> Obligations:
    """Yield what keeps {x'Px <= level} inside the box.

    Parameters
    ----------
    added : bounds on what is added to each input from outside, (m,); () for nothing.
    """
    identity = Matrix.identity(loop.order)
    if len({*loop.states, *loop.inputs}) < len(loop.states) + len(loop.inputs):
        yield never(
            "a state and an input have one name, so that the box does not say which it bounds"
        )
    if not {*loop.states}.isdisjoint(loop.disturbances):
        yield never(
            "a state and a disturbance have one name, and the box does not say which it bounds"
        )
    bounded(len(loop.box) + len(bounded_inputs(loop)) * len(loop.K), loop.order + 1)
    for k, side in enumerate(loop.box):
        if side is not None:
            failure = f"the ellipsoid may leave the range of {loop.states[k]} in the model's box"
            yield reaches_at_most(P, level, identity.row(k), half_width(side), failure)
    for k, side in bounded_inputs(loop).items():
        room = half_width(side) - (added[k] if added else 0)
        name = loop.inputs[k]
        yield nonnegative(room, f"what is added to {name} may leave its range in the model's box")
        for j, gain in enumerate(loop.K):
            failure = f"gain {j + 1} may take {name} out of its range in the model's box"
            yield reaches_at_most(P, level, gain.row(k), room, failure)


def bounded_inputs(loop: PolytopicLoop) -> dict[int, Range]:
    """Return the ranges of the inputs that the box bounds, by the input's place."""
    return {
        loop.inputs.index(name): side
        for name, side in (loop.other_box or {}).items()
        if name in loop.inputs
    }


def disturbances_in_range(loop: PolytopicLoop, bounds: Sequence[Fraction]) -> Obligations:
    """Yield what keeps each disturbance with |w_k| <= bounds_k in its range of the box.

    A signal that only schedules (its column of E is zero) is left to ``words.loop_words``.
    """
    pushing_names = pushing(loop)
    for name, side in (loop.other_box or {}).items():
        if name in pushing_names:
            room = half_width(side) - bounds[loop.disturbances.index(name)]
            yield nonnegative(room, f"{name} is bounded less tightly than in the model's box")


def pushing(loop: PolytopicLoop) -> set[str]:
    """Return the disturbances with a nonzero column of E."""
    return {
        name
        for k, name in enumerate(loop.disturbances)
        if any(row[k] for E in loop.E for row in E.rows)
    }


def half_width(side: Range) -> Fraction:
    """Return the largest b with [-b, b] in the range; negative where 0 is outside."""
    return min(-side[0], side[1])
