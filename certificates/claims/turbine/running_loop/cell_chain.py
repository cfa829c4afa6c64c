"""Cells of a chain with functions that serve them all: sought jointly, with boxes that hold them.

Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop.moving_claim import MovingCell
from takagi.certificates.checker.turbine.running_loop.signals import Rows
from takagi.certificates.claims.turbine.running_loop.candidate import Subject
from takagi.certificates.claims.turbine.running_loop.joint_program import Link, joint_functions
from takagi.certificates.claims.turbine.running_loop.moving_cell import (
    GROWTH,
    Fitted,
    Moves,
    in_decimals,
    pose,
    refitted,
    stated_cell,
    with_moves,
)
from takagi.models.arrays import Floats

# Rounds of functions, and of boxes that hold their sets.
ROUNDS = 7


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of one cell of a chain.

    Attributes
    ----------
    at : winds, rate of the wind and first box.
    decay : alpha [1/s].
    shares : of the rate, with which it may be stated.
    moves : the room that its box needs.
    """

    at: Fitted
    decay: float
    shares: Sequence[float]
    moves: Moves


def held(
    subject: Subject,
    chain: Sequence[Asked],
    first: Mapping[Fraction, Rows],
    stay: Mapping[Fraction, Rows],
) -> list[MovingCell] | None:
    """Return the cells with new functions, or None.

    Parameters
    ----------
    first, stay : P by wind, pitch states in rad: one at each end, and those that are kept.
    """
    winds = [chain[0].at.winds[0], *(one.at.winds[1] for one in chain)]
    functions = [first[v] for v in winds]
    for _ in range(ROUNDS):
        boxed = _boxed(subject, chain, functions)
        found = None if boxed is None else _functions(subject, boxed, first, stay)
        if boxed is None or found is None:
            return None
        chain, (least, functions) = boxed, found
        cells = list(_stated(subject, chain, functions)) if least >= 1 else []
        if len(cells) == len(chain):
            return cells
    return None


def _boxed(
    subject: Subject, chain: Sequence[Asked], functions: Sequence[Rows]
) -> list[Asked] | None:
    """Return the chain with boxes that hold the sets, and have room for the moves, or None."""
    found = []
    for one, pair in zip(chain, pairwise(functions), strict=True):
        at = refitted(subject, one.at, pair, GROWTH)
        try:
            sides = with_moves(subject, at.winds, at.sides, pair, one.moves)
        except Refused:
            return None
        found.append(replace(one, at=replace(at, sides=sides)))
    return found


def _functions(
    subject: Subject,
    chain: Sequence[Asked],
    first: Mapping[Fraction, Rows],
    stay: Mapping[Fraction, Rows],
) -> tuple[float, list[Rows]] | None:
    """Return how well the sets fit the boxes, and P at each end of the cells, or None."""
    links = []
    unit: Floats | None = None
    for one in chain:
        at = one.at
        posed, _ = pose(subject, at.winds, at.sides, at.rate, unit, at.cuts)
        if posed is None:
            return None
        unit = posed.unit
        moved = at.rate / float(at.winds[1] - at.winds[0])
        left = 1 - np.array([one.moves.get(name, 0.0) for name in posed.names]) / posed.bounds
        if left.min() <= 0:
            return None
        links.append(Link(posed.loops, posed.rows / left[:, None], moved, one.decay))
    if unit is None:
        return None
    scale = np.outer(unit, unit)
    winds = [chain[0].at.winds[0], *(one.at.winds[1] for one in chain)]
    given = [np.array(first[v], dtype=np.float64) * scale for v in winds]
    known = {i: given[i] for i, v in enumerate(winds) if v in stay}
    found = joint_functions(links, known, given)
    if found is None:
        return None
    least, functions = found
    return least, [
        stay[v] if v in stay else in_decimals(P / scale)
        for v, P in zip(winds, functions, strict=True)
    ]


def _stated(
    subject: Subject, chain: Sequence[Asked], functions: Sequence[Rows]
) -> Iterator[MovingCell]:
    """Yield the cells that hold with the functions at their ends, up to one that does not."""
    for one, pair in zip(chain, pairwise(functions), strict=True):
        rates = [share * one.at.rate for share in one.shares]
        stated, _ = stated_cell(subject, one.at, pair, rates)
        if stated is None:
            return
        yield stated
