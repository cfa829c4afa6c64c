r"""``l2-gain``: the energy of y is at most gamma^2 times that of w, from rest, along every blend.

Let V = x'Px with P > 0, gamma > 0, and V' (or V(x+) - V) = -x'Fx + 2 x'Gw + w'Hw.  The condition
for every blend is

    [ F - C'C / gamma    -G - C'D / gamma             ]
    [ .                  gamma I - H - D'D / gamma    ]  > 0,

that is, V' < gamma |w|^2 - |y|^2 / gamma for (x, w) != 0.  The left-hand side is concave in
(A, B, C, D), so that the condition holds along the loop, however fast the weights change.  The
integral over time gives |y|_2 <= gamma |w|_2 from x(0) = 0, and V(x(t)) <= gamma |w|_2^2.

With ``energy_bound`` W the claim also states that {V <= gamma W^2} lies in the model's box: for
|w|_2 <= W the state never leaves the box.  Without it the claim is about the vertices; for a plant
it holds as long as the state stays in the model's box.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2 (bounded real lemma).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, never, positive
from takagi.certificates.checker.kinds.disturbance_channel import (
    disturbance_channels,
    quadratic_change,
)
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.loop.box_of_validity import bounded_inputs, inside_box
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.rounded import at_least, at_most


@dataclass(frozen=True)
class L2Gain(LoopClaim):
    """|y|_2 <= gain |w|_2 along the loop; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("disturbance", "entering", "output")
    P: Matrix = matrix("n", "n")
    gain: Fraction = number("-", better="smaller", positive=True)
    energy_bound: Fraction | None = number("-", better="larger", positive=True, optional=True)

    def obligations(self) -> Obligations:
        loop, gain = self.loop, self.gain
        yield positive(self.P, NOT_DEFINITE)
        for path in disturbance_channels(self.claim, loop, self.where):
            F, G, H = quadratic_change(path.A, path.B, self.P, discrete=loop.is_discrete)
            C, D = path.C, path.through
            side = -(G + 1 / gain * (C.T @ D))
            corner = gain * Matrix.identity(D.shape[1]) - H - 1 / gain * (D.T @ D)
            bounded_real = Matrix.blocks([[F - 1 / gain * (C.T @ C), side], [side.T, corner]])
            yield positive(bounded_real, f"the inequality fails at {path.label}")
        if self.energy_bound is not None:
            if self.claim["disturbance"] == "inputs" and bounded_inputs(loop):
                yield never("no bound of energy keeps an input in its range")
            yield from inside_box(loop, self.P, gain * self.energy_bound**2)

    def sentence(self) -> str:
        validity = words.while_valid(self.loop)
        if self.energy_bound is not None:
            validity = (
                f"; for w of energy at most {at_least(self.energy_bound, 6)}^2 no state leaves the "
                f"model's box{words.granted(self.loop)}"
            )
        return (
            f"the energy of y is at most {at_most(self.gain, 6)}^2 times that of w, from rest, "
            f"along {words.about(self.loop)} ({words.rounded_channel(self.claim, self.loop)})"
            f"{validity}{words.channel_deviations(self.claim, self.loop)}"
        )
