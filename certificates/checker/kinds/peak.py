r"""``peak``: |y| <= gamma b at all times, from rest, for every disturbance with |w|_2 <= b.

The conditions are an invariant set of ``invariant_ellipsoid`` for |w|_2 <= b (the Euclidean norm at
each instant), and, for y = C x + D w of every blend with a share 0 <= t <= 1,

    gamma^2 b^2 [ (1 - t) P / c   0         ]
                [ 0               t I / b^2 ]  -  [C D]'[C D]  >= 0,

Then |y|^2 <= gamma^2 b^2 ((1 - t) V / c + t |w|^2 / b^2) <= gamma^2 b^2 on the set.  Where D = 0
the second block is left out, and t = 0 is best.  From rest V starts at 0, inside the set.

Evidence: that of ``invariant_ellipsoid`` with ``disturbance_norm`` = b; ``gain`` = gamma;
``share`` = t (0 when left out); the channel of ``disturbance_channel``.

Source: Abedor, Nagpal, Poolla (1996); Scherer, Gahinet, Chilali (1997).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import ClassVar

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.disturbance_channel import (
    DisturbanceChannel,
    disturbance_channels,
    entering_columns,
    with_columns,
)
from takagi.certificates.checker.kinds.invariant_ellipsoid import Disturbance, InvariantSet
from takagi.certificates.checker.kinds.loop_claim import number
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, at_most


@dataclass(frozen=True)
class Peak(InvariantSet):
    """|y| <= gain b for |w|_2 <= b; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("disturbance", "entering", "output")
    gain: Fraction = number("-", better="smaller", positive=True)
    share: Fraction | None = number(optional=True)

    @cached_property
    def disturbance(self) -> Disturbance:
        """The disturbances that the claim names; all that the model has unless it names some."""
        w, columns = super().disturbance, entering_columns(self.claim, self.loop, self.where)
        return w._replace(E=with_columns(w.E, columns), columns=columns)

    def obligations(self) -> Obligations:
        w, share = self.disturbance, self.share or Fraction(0)
        if not w.is_ball or w.bounds[0] == 0:
            raise CertificateError(
                f"{self.where}.disturbance_norm: a positive bound on |w|_2 is needed"
            )
        if not 0 <= share <= 1:
            raise CertificateError(f"{self.where}.share: 0 <= share <= 1 is needed")
        yield from super().obligations()
        for path in disturbance_channels(self.claim, self.loop, self.where):
            yield nonnegative(
                self._below_bound(path, share), f"the output exceeds its bound at {path.label}"
            )

    def _below_bound(self, path: DisturbanceChannel, share: Fraction) -> Matrix:
        """Return the module's matrix; without its second block where D = 0."""
        bound, C, D = self.disturbance.bounds[0], path.C, path.D
        state = self.gain**2 * bound**2 * (1 - share) / self.level * self.P - C.T @ C
        if D is None or not any(map(any, D.rows)):
            return state
        pushed = self.gain**2 * share * Matrix.identity(D.shape[1]) - D.T @ D
        side = -(C.T @ D)
        return Matrix.blocks([[state, side], [side.T, pushed]])

    def figures(self) -> Iterator[Figure | WindProfile]:
        yield Figure("gain", "-", self.gain, larger=False)
        yield from self._disturbance_figures()

    def sentence(self) -> str:
        loop, bound = self.loop, self.disturbance.bounds[0]
        return (
            f"|y| <= {at_most(self.gain * bound, 6)} at all times, from rest and from anywhere in "
            f"{self.set_in_words}, for |w|_2 <= {at_least(bound, 6)} at all times (gain "
            f"{at_most(self.gain, 6)}), along {words.about(loop)} "
            f"({words.rounded_channel(self.claim, loop)}); the set is invariant{self.where_valid}"
            f"{words.channel_deviations(self.claim, loop, 'x')}"
        )
