r"""``observed-feedback``: the loop with u = -sum_j h_j K_j xhat, z = (x, e):

    z' = sum_ij h_i h_j [ A_i - B_i K_j   B_i K_j       ] z,
                        [ 0               A_i - L_j C_i ]

and V = z'Pz decays, P of order 2n, as in ``decay``.

The observer, its evidence and the assumptions are those of ``observer``.

Source: Tanaka and Wang (2001), chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kinds.loop_claim import matrix
from takagi.certificates.checker.kinds.observer import EXACT, Observer, joint_loops


@dataclass(frozen=True)
class ObservedFeedback(Observer):
    """V of states and errors decays for u = -K xhat; see the module."""

    P: Matrix = matrix("2n", "2n")

    def matrices(self) -> Iterator[tuple[str, Matrix]]:
        return joint_loops(self.claim, self.loop, self.where)

    def sentence(self) -> str:
        return self.decays("the loop with u = -K xhat", EXACT, "xu")
