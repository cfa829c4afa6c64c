"""What the claims ``bumpless`` of both laws say: no command jumps, and bounds of the rates.

The theorem of each law stands beside its loop.  The claim holds where the claim that ``loop`` names
does, cell by cell.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.obligation import Obligations, never
from takagi.certificates.checker.kernel.reader import listed, number
from takagi.certificates.checker.turbine.rotor import Span
from takagi.certificates.checker.turbine.turbine_claim import TurbineClaim, prerequisite_claim
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rates import beyond_words
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly, range_around


@dataclass(frozen=True)
class BumplessLoop(TurbineClaim):
    """Neither command jumps, and bounds of the rates of pitch and torque.

    Attributes
    ----------
    loop : the claim that this one names, of the kind ``loop_kind``.
    told : name, where the bounds hold, and the rate of what is bounded for pitch, in words.
    """

    loop: Any
    unproved: str

    loop_kind: ClassVar[str]
    told: ClassVar[tuple[str, str, str]]

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim; ``earlier`` are the verdicts on the claims before it.

        Raises
        ------
        CertificateError : a part is missing or malformed.
        """
        loop, unproved = prerequisite_claim(claim, data, earlier, where, "loop", cls.loop_kind)
        return cls(claim, data, where, cls.told[0], loop, unproved)

    @property
    @abstractmethod
    def winds(self) -> list[Span]:
        """The wind cells of the loop's claim [m/s]."""

    @abstractmethod
    def bounded(self, k: int, cell: Any, where: str) -> Obligations:
        """Yield that the rates which cell k states are bounds."""

    @property
    def cells(self) -> list[Any]:
        """The cells of the claim, one for each of the loop's."""
        return listed(self.claim, "cells", self.where, len(self.winds), len(self.winds))

    @property
    def place(self) -> str:
        """Where the loop's claim stands in the file."""
        return f"claims[{self.claim['loop']}]"

    def premises(self) -> Obligations:
        if self.unproved:
            yield never(self.unproved)

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        for k, (cell, wind) in enumerate(zip(self.cells, self.winds, strict=True)):
            required = self.bounded(k, cell, f"{self.where}.cells[{k}]")
            yield f"wind {range_around(*wind)} m/s: ", required

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
