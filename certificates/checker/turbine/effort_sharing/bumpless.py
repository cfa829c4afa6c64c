r"""``bumpless``: no command of the effort-sharing loop jumps, and bounds of their rates.

Torque and pitch reference are continuous in speed, integral and schedule wind: the law's tables are
linear between their nodes, and its ramp has a continuous slope.  So the largest jump of each is 0.

For V <= 1 and the wind class of the claim that ``loop`` names, in the symbols of
docs/effort-sharing-loop.md, in each wind cell:

    |beta'|     <= min(rate limit, p_zeta / (b tau))                               (pitch_rate)
    |U'|        <= gamma (B + w) + rho (|q*'| + |gamma'| p_s)
    |T_g'|      <= E F(-U_low) |U'|                                                (torque_rate)

with (e - x)' = h xi + w_e, h = (a - Gamma + nu, S, Gamma), w the claim's bound of w_e, and B
(``signal_rate``) such that B^2 P > h'h at every corner.  Torque limits can only reduce the rate.

Not promised: anything outside the set; a wind estimate that jumps where the law has no filter.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from typing import Any, ClassVar

from takagi.certificates.checker.arithmetic.effort_ramp import share
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import member, number, read_matrix
from takagi.certificates.checker.turbine.bumpless_loop import BumplessLoop
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.loop_claim import IN_WIND_CLASS
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.rotor import Span
from takagi.certificates.checker.turbine.turbine_claim import (
    row_bound,
)

NAME = "bumpless effort-sharing loop"


class CellRates:
    """The bounds from the numbers of one cell, without B.

    Attributes
    ----------
    pitch : of |beta'| [rad/s].   corners : the rows h.
    gain : gamma, at most;  drift : rho (|q*'| + |gamma'| p_s) + gamma w, the rest of |U'|.
    torque_share : E F(-U_low).
    """

    def __init__(self, at: Loop, cell: Stated, lag: Fraction, signal: Fraction) -> None:
        """Take the set's peaks: ``lag`` of the effort lag of pitch, ``signal`` of e - x."""
        law, k = at.law, at.k
        self.pitch = min(at.plant.rate_limit, lag / (at.least_b * at.plant.lag))
        ends = product(*(cell.ranges[name] for name in ("stiffness", "loop_gain", "lag_gain")))
        self.corners = [(a - G + law.nu[k], S, G) for a, G, S in ends]
        self.gain = at.over(law.gamma)[1]
        moved = abs(at.slope(law.effort)) + abs(at.slope(law.gamma)) * signal
        w = cell.drift + cell.sizes["reference_slope"] * at.rate
        self.drift = at.rate * moved + self.gain * w
        self.torque_share = law.effort_torque * share(-at.efforts[0], law.overlap)

    def torque_rate(self, signal_rate: Fraction) -> Fraction:
        """Return the bound of |T_g'| for B."""
        return self.torque_share * (self.gain * signal_rate + self.drift)


def cell_rates(subject: Subject, loop: Any, where: str) -> list[CellRates]:
    """Return the bounds from the decimals of model, gains and the loop's claim, cell by cell."""
    peaks = member(loop, "peaks", where)
    lag, signal = (number(peaks, name, where) for name in ("effort_lag", "speed_signal"))
    cells = [Stated.read(cell, where) for cell in member(loop, "cells", where)]
    return [
        CellRates(Loop(subject, k, cell.sizes["wind_rate"]), cell, lag, signal)
        for k, cell in enumerate(cells)
    ]


@dataclass(frozen=True)
class Bumpless(BumplessLoop):
    """Neither command jumps, and bounds of the pitch and torque rates; see the module."""

    loop_kind: ClassVar[str] = "coherent-loop"
    told: ClassVar[tuple[str, str, str]] = (
        NAME,
        "on the proved set and within its wind limits",
        "pitch moves",
    )
    assumes: ClassVar[tuple[str, ...]] = IN_WIND_CLASS
    members: ClassVar[dict[str, Members | None]] = {
        **plain("loop"),
        "cells": plain("pitch_rate signal_rate torque_rate"),
    }

    @cached_property
    def subject(self) -> Subject:
        """Plant and law, as the loop's claim states them."""
        return Subject.read(self.loop, self.data["model"], self.data.get("gains"), self.place)

    @cached_property
    def bounds(self) -> list[CellRates]:
        """The bounds that each cell of the loop's claim gives."""
        return cell_rates(self.subject, self.loop, self.place)

    @property
    def winds(self) -> list[Span]:
        return list(pairwise(self.subject.law.wind))

    def bounded(self, k: int, cell: Any, where: str) -> Obligations:
        return _bounded(cell, self.bounds[k], read_matrix(self.loop, "P", self.place), where)


def _bounded(cell: Any, bound: CellRates, P: Matrix, where: str) -> Obligations:
    """Yield that the stated rates of one cell are bounds."""
    pitch, B, torque = (
        number(cell, name, where) for name in ("pitch_rate", "signal_rate", "torque_rate")
    )
    yield nonnegative(min(pitch, B), "a negative bound")
    yield nonnegative(pitch - bound.pitch, "pitch may move faster than is stated")
    for h in bound.corners:
        yield positive(
            row_bound(P, Matrix.of([h]), B), "the speed signal may move faster than is stated"
        )
    failure = "the torque asked for may move faster than is stated"
    yield nonnegative(torque - bound.torque_rate(B), failure)
