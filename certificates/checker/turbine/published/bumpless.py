r"""``bumpless`` of a published law: no command of the loop jumps, and bounds of their rates.

At a constant wind v with v_hat = v, both commands are continuous functions of the state
z = (omega, beta, x), so the largest jump of each is 0:

    f_1   0, a line or a cubic from 0 to 1 over the ramp, 1; held within [0, 1]
    phi   u, rated - (rated + h - u)^2 / 4h, rated; at u = rated -+ h, with h half the overlap, the
          pieces are rated - h and rated, exactly, for all decimals
    u     is linear in the error, pitch and x, and its gains in weights that are premises, averages
          of slopes of a C^2 surface, held within [0, 1]

They are Lipschitz too.  In a cell of the claim that ``loop`` names, y = (z - z_0)/r satisfies
y' = A y + d with |y_j| <= 1 on its set, A in the hull of the cell's corners and |d_i| bounded by
its ``disturbance``.  So along every motion from the set, with s_i the slopes of a command over the
box in units of r,

    |command'| <= sum_i |s_i| (sum_j |A_ij| + |d_i|)

Not promised: a wind that moves, a start outside the set.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative
from takagi.certificates.checker.kernel.reader import number
from takagi.certificates.checker.turbine.bumpless_loop import BumplessLoop
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.published.loop import Loop
from takagi.certificates.checker.turbine.published.loop_claim import Cell, PublishedLoop
from takagi.certificates.checker.turbine.rotor import Span

NAME = "bumpless loop of Schulte's law"
RATES = ("pitch_rate", "torque_rate")


def command_rates(loop: PublishedLoop, cell: Cell) -> list[Fraction]:
    """Return the bounds of the rates of pitch reference and torque in one cell."""
    size = range(len(cell.disturbance))
    moves = [
        bound + sum(max(max(-low[i][j], high[i][j]) for low, high in cell.corners) for j in size)
        for i, bound in enumerate(cell.disturbance)
    ]
    commands = Loop(loop.plant, loop.law, loop.overlaps, cell.ends, "states").commands()
    return [
        sum(
            (Fraction(slope.magnitude(), ONE) * move
             for slope, move in zip(command.slopes, moves, strict=True)),
            Fraction(0),
        )
        for command in commands
    ]  # fmt: skip


@dataclass(frozen=True)
class PublishedBumpless(BumplessLoop):
    """Neither command jumps, and bounds of their rates; see the module."""

    loop_kind: ClassVar[str] = "paper-loop"
    told: ClassVar[tuple[str, str, str]] = (
        NAME,
        "on the proved sets, at constant wind",
        "the pitch asked for moves",
    )
    assumes: ClassVar[tuple[str, ...]] = PublishedLoop.assumes
    members: ClassVar[dict[str, Members | None]] = {
        **plain("loop"),
        "cells": plain("pitch_rate torque_rate"),
    }

    @cached_property
    def stated(self) -> PublishedLoop:
        """The claim about the loop."""
        return PublishedLoop.read(self.loop, self.data, (), self.place)

    @property
    def winds(self) -> list[Span]:
        return [cell.ends.wind for cell in self.stated.cells]

    def bounded(self, k: int, cell: Any, where: str) -> Obligations:
        bounds = command_rates(self.stated, self.stated.cells[k])
        for name, least in zip(RATES, bounds, strict=True):
            failure = f"the {name.partition('_')[0]} asked for may move faster than is stated"
            yield nonnegative(number(cell, name, where) - least, failure)
