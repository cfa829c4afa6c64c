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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, product
from typing import Any, ClassVar, Self

from takagi.certificates.checker.arithmetic.effort_ramp import share
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import listed, member, number, read_matrix
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.loop_claim import IN_WIND_CLASS
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.rotor import Span
from takagi.certificates.checker.turbine.turbine_claim import (
    TurbineClaim,
    prerequisite_claim,
    row_bound,
)
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rates import beyond_words
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly, range_around

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
class Bumpless(TurbineClaim):
    """Neither command jumps, and bounds of the pitch and torque rates; see the module.

    Attributes
    ----------
    loop : the claim that this one names, of the kind ``loop_kind``.
    told : name, where the bounds hold, and the rate of what is bounded for pitch, in words.
    """

    loop: Any
    unproved: str

    loop_kind: ClassVar[str] = "coherent-loop"
    told: ClassVar[tuple[str, str, str]] = (NAME, "on the proved set and within its wind limits",
                                            "pitch moves")  # fmt: skip
    assumes: ClassVar[tuple[str, ...]] = IN_WIND_CLASS
    members: ClassVar[dict[str, Members | None]] = {
        **plain("loop"),
        "cells": plain("pitch_rate signal_rate torque_rate"),
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim; ``earlier`` are the verdicts on the claims before it.

        Raises
        ------
        CertificateError : a part is missing or malformed.
        """
        loop, unproved = prerequisite_claim(claim, data, earlier, where, "loop", cls.loop_kind)
        return cls(claim, data, where, cls.told[0], loop, unproved)

    @cached_property
    def subject(self) -> Subject:
        """Plant and law, as the loop's claim states them."""
        return Subject.read(self.loop, self.data["model"], self.data.get("gains"), self._place)

    @cached_property
    def bounds(self) -> Sequence[Any]:
        """The bounds that each cell of the loop's claim gives."""
        return cell_rates(self.subject, self.loop, self._place)

    @property
    def winds(self) -> list[Span]:
        """The wind cells of the loop's claim [m/s]."""
        return list(pairwise(self.subject.law.wind))

    @property
    def cells(self) -> list[Any]:
        """The cells of the claim, one for each of the loop's."""
        return listed(self.claim, "cells", self.where, len(self.bounds), len(self.bounds))

    @property
    def _place(self) -> str:
        return f"claims[{self.claim['loop']}]"

    def premises(self) -> Obligations:
        if self.unproved:
            yield never(self.unproved)

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        for k, (cell, wind) in enumerate(zip(self.cells, self.winds, strict=True)):
            required = self.bounded(cell, self.bounds[k], f"{self.where}.cells[{k}]")
            yield f"wind {range_around(*wind)} m/s: ", required

    def bounded(self, cell: Any, bound: Any, where: str) -> Obligations:
        """Yield that the stated rates of one cell are bounds."""
        return _bounded(cell, bound, read_matrix(self.loop, "P", self._place), where)

    def figures(self) -> Iterator[Figure | WindProfile]:
        yield Figure("largest jump of torque", "N m", Fraction(0), larger=False)
        yield Figure("largest jump of the pitch reference", "rad", Fraction(0), larger=False)
        for name, unit in (("pitch_rate", "rad/s"), ("torque_rate", "N m/s")):
            largest = max(number(cell, name, self.where) for cell in self.cells)
            yield Figure(f"largest {name.replace('_', ' ')}", unit, largest, larger=False)

    def sentence(self) -> str:
        where, data, cells = self.where, self.data, self.cells
        pitch, torque = (
            [number(cell, name, where) for cell in cells] for name in ("pitch_rate", "torque_rate")
        )
        pitch_limit, torque_limit = (
            number(data["model"], f"{name}_rate_limit", "model") for name in ("pitch", "torque")
        )
        within = [rate <= torque_limit for rate in torque]
        # A limit is rounded down; a value stated to be below it is compared after rounding.
        limit = at_least(pitch_limit, 6)
        below = sum(rate < Fraction(limit) for rate in pitch)
        return (
            f"{self.told[1]}, under what the claim about these "
            "assumes, neither the torque asked for nor the pitch asked for jumps (0 N m, 0 rad); "
            f"of {len(cells)} wind cells: {self.told[2]} at most "
            f"at {at_most(max(pitch), 6)} rad/s, and in {below} stays below the drive's limit of "
            f"{limit} rad/s; the torque asked for moves at most at "
            f"{at_most(max(torque), 4)} N m/s, and in "
            f"{sum(within)} within the turbine's limit of {exactly(torque_limit)} N m/s"
            f"{beyond_words(within, self.winds)}"
        )


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
