r"""``no-solution``: no x satisfies the constraints.

Let y be multipliers in the dual cones with <A_i, y> = 0 for every variable.  Then <S(x), y> =
<B, y> for every x, and S(x) in the cones needs <S(x), y> >= 0: with <B, y> < 0 there is no such x
(Farkas).  The file states decimals for y, and the checker changes those of ``basis`` until the
equations hold exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.kernel.obligation import Obligations, positive
from takagi.certificates.checker.problem.conic_problem import inside_cones
from takagi.certificates.checker.problem.problem_claim import ProblemClaim


@dataclass(frozen=True)
class NoSolution(ProblemClaim):
    """The constraints contradict one another; see the module."""

    def obligations(self) -> Obligations:
        y = self.multipliers([Fraction(0)] * len(self.problem.objective))
        yield from inside_cones(self.problem.blocks, y, "the multiplier")
        yield positive(-self.constant_product(y), "the multipliers contradict no solution")

    def sentence(self) -> str:
        return "no point satisfies the constraints: exact multipliers contradict every one"
