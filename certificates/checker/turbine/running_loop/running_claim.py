r"""``running-loop``: the turbine's loop as it runs, with its observer, settles at constant winds.

The loop has the law, the gain file's observer, its filters of the measured speed and of the wind
estimate, its limits of rates, the pitch drive and one state of the wake (``equations``).  In each
cell of winds, with a box around the rest, every factor of the loop is enclosed over the box, and,
exactly, for every piece of the share of pitch

    -(2 xi'P xi' + 2 alpha xi'P xi + sum tau_i (z_i^2 - w_i^2)) > 0  for all (xi, w) but zero,
    side^2 P > h'h                                                   for every side of the box.

Then at every constant wind of the cell no motion leaves V = xi'P xi <= 1, and V falls at least as
exp(-2 alpha t).  The claim states cells, sides, P, tau and alpha; all else is computed here.

Evidence: ``winds`` (ranges that the cells cover exactly), ``decay_rate``, ``uncertainty``
(``inertia``, ``wake_length``), ``observer``, ``measurement``, ``cells`` of ``wind``, ``sides``,
``P`` and ``multipliers``, for each piece by the factor's name.

Not promised: varying winds; motions that start outside the sets; a sampled law; noise; a
second-order pitch drive; a torque lag; flexible shaft, tower or blades.

Theorem and assumptions: docs/running-loop.md; proofs: ``cell``, ``equations``, ``limits``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, never, positive
from takagi.certificates.checker.kernel.reader import listed, matrix, member, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell, cut, factors
from takagi.certificates.checker.turbine.running_loop.equations import (
    FACTORS,
    Rows,
    decay_form,
    equations,
    rounded_form,
    rows,
    states,
)
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    Sides,
    Span,
    other_than_the_controller,
)
from takagi.certificates.checker.turbine.running_loop.limits import limits
from takagi.certificates.checker.turbine.turbine_claim import (
    DRIVES,
    PROGRAM,
    RIGID,
    TurbineClaim,
    row_bound,
)
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import range_within
from takagi.certificates.checker.words.running_loop import loop_name, loop_sentence

MOST_CELLS, MOST_PIECES = 500, 8


@dataclass(frozen=True)
class StatedCell:
    """One cell as the claim states it."""

    winds: Span
    sides: Sides
    P: Rows
    multipliers: list[dict[str, Fraction]]

    @classmethod
    def read(cls, stated: Any, order: int, where: str) -> StatedCell:
        """Return it; refuses winds that do not increase and a P of another size."""
        low, high = numbers(stated, "wind", where, 2)
        if not low < high:
            raise CertificateError(f"{where}.wind: the two winds must increase")
        P = matrix(stated, "P", where)
        if len(P) != order or len(P[0]) != order:
            raise CertificateError(f"{where}.P: {order} rows of {order} numbers are needed")
        pieces = listed(stated, "multipliers", where, 1, MOST_PIECES)
        rows = []
        for i, row in enumerate(pieces):
            place = f"{where}.multipliers[{i}]"
            if not isinstance(row, dict) or not set(row) <= FACTORS:
                raise CertificateError(f"{place}: numbers by the names of the factors are needed")
            rows.append({name: number(row, name, place) for name in row})
        return cls((low, high), Sides.read(stated, where), P, rows)


@dataclass(frozen=True)
class RunningLoop(TurbineClaim):
    """The loop as it runs settles at constant winds; see the module."""

    plant: Plant
    law: Law
    machine: Machine
    decay_rate: Fraction
    cells: list[StatedCell]
    winds: list[Span]

    assumes: ClassVar[tuple[str, ...]] = (
        "constant wind",
        "start with V <= 1 in the set of that wind cell, pitch at or above its lower limit, "
        "schedule wind within the tables, and what is sent equal to what the law asks for",
        "c_P of the table",
        "wake with one state, which answers to pitch alone",
        "torque without delay, and known to the observer",
        DRIVES[1],
        RIGID[0],
        PROGRAM[0],
        "speed measured exactly before its filters, pitch exactly",
    )
    members: ClassVar[dict[str, Members | None]] = {
        **plain("winds decay_rate"),
        "observer": plain("l1 l2 wind_limits"),
        "measurement": {"speed_filter": {}, "torsion_filter": plain("frequency passed")},
        "uncertainty": plain("inertia wake_length"),
        "cells": {
            **plain("wind P"),
            "sides": plain(
                "speed measured pitch signal effort schedule estimate integral measured_rate"
            ),
            # The reader of ``multipliers`` refuses a name that is not a factor's.
            "multipliers": None,
        },
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim.

        Raises
        ------
        CertificateError : a part is missing or is not what it has to be; also an observer or
            filters that are not those of the certificate's ``controller``.
        """
        model, gains = member(data, "model", "certificate"), member(data, "gains", "certificate")
        plant, law = Plant.read(model), Law.read(gains)
        if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
            raise CertificateError("gains: pitch limits differ from the model's")
        machine = Machine.read(claim, model, gains, where)
        if other := other_than_the_controller(claim, data, where):
            raise CertificateError(f"{where}.{other}")
        decay_rate = number(claim, "decay_rate", where)
        cells = [
            StatedCell.read(cell, states(machine), f"{where}.cells[{i}]")
            for i, cell in enumerate(listed(claim, "cells", where, 1, MOST_CELLS))
        ]
        winds = _stated_winds(claim, cells, where)
        name = loop_name(law, winds)
        return cls(claim, data, where, name, plant, law, machine, decay_rate, cells, winds)

    def premises(self) -> Obligations:
        yield positive(self.decay_rate, "not proved: no rate is claimed")

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        for cell in self.cells:
            required = cell_obligations(self.plant, self.law, self.machine, cell, self.decay_rate)
            yield f"wind {range_within(*cell.winds)} m/s: ", required

    def figures(self) -> Iterator[Figure | WindProfile]:
        boxes = sorted((*cell.winds, cell.sides.estimate) for cell in self.cells)
        yield Figure("decay rate with the observer", "1/s", self.decay_rate)
        covered = sum((high - low for low, high, _ in boxes), Fraction(0))
        yield Figure("winds covered with the observer", "m/s", covered)
        yield WindProfile("box of the wind estimate", "m/s", tuple(boxes))

    def sentence(self) -> str:
        shapes = [Matrix.of(cell.P) for cell in self.cells]
        return loop_sentence(self.law, self.winds, self.machine, self.decay_rate, shapes)


def _stated_winds(claim: Any, cells: Sequence[StatedCell], where: str) -> list[Span]:
    """Return the claim's ranges of winds; refuses cells that do not cover exactly these.

    The cells come in the order of their winds and do not overlap.
    """
    ranges: list[Span] = []
    for row in listed(claim, "winds", where, 1, MOST_CELLS):
        low, high = numbers({"winds": row}, "winds", where, 2)
        ranges.append((low, high))
    covered: list[Span] = []
    for one in cells:
        low, high = one.winds
        if covered and low < covered[-1][1]:
            raise CertificateError(f"{where}.cells: the cells overlap, or are not in order")
        if covered and low == covered[-1][1]:
            covered[-1] = (covered[-1][0], high)
        else:
            covered.append((low, high))
    if covered != ranges:
        raise CertificateError(f"{where}.winds: these are not just the winds of the cells")
    return ranges


def cell_obligations(
    plant: Plant, law: Law, machine: Machine, stated: StatedCell, decay: Fraction
) -> Obligations:
    """Yield what must hold in one cell.

    Raises
    ------
    Refused : an enclosure that is refused.
    """
    cell = Cell(plant, law, machine, stated.winds, stated.sides)
    span = factors(cell)
    yield from limits(cell)
    yield from inside_box(cell, span, stated.P)
    parts = cut(cell.ramp_share, len(stated.multipliers))
    for tau, held in zip(stated.multipliers, parts, strict=True):
        signals, rates = equations(cell, span, held)
        for name in signals.names:
            if name not in tau:
                yield never(f"there is no multiplier of the {name}")
        yield positive(min(tau.values()), "a multiplier is not positive")
        weights = [tau[name] for name in signals.names]
        falling = decay_form(signals, rates, stated.P, weights, decay)
        yield positive(rounded_form(falling), "the decay inequality fails")


def inside_box(cell: Cell, span: dict[str, Span], P: Rows) -> Obligations:
    """Yield P > 0, and that {V <= 1} does not leave any side of the box: side^2 P > h'h."""
    shape = Matrix.of(P)
    yield positive(shape, "P is not symmetric positive definite")
    for name, (h, bound) in rows(cell, span).items():
        failure = f"the set leaves its box in {name.replace('_', ' ')}"
        yield positive(bound, failure)
        yield positive(rounded_form(row_bound(shape, Matrix.of([h]), bound).rows), failure)
