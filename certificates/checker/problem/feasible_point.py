r"""``feasible-point``: the problem has a solution, and its optimum is at most the value there.

The point is x as stated; where the problem has equations (cones ``zero``), the variables of
``basis`` are changed, by the only solution of B + sum_i x_i A_i = 0 in them.  The claim is that
every S_k(x) lies in its cone, decided exactly.  So the least value of c'x + c_0 is at most that of
this x.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.problem.conic_problem import (
    ConicProblem,
    Vector,
    corrected,
    inside_cones,
    limited_sum,
)
from takagi.certificates.checker.problem.problem_claim import ProblemClaim
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, at_most

DIGITS = 10


@dataclass(frozen=True)
class FeasiblePoint(ProblemClaim):
    """A point that satisfies every constraint exactly; see the module."""

    @classmethod
    def length(cls, problem: ConicProblem) -> int:
        return len(problem.objective)

    @cached_property
    def x(self) -> list[Fraction]:
        """The point with its equations solved."""
        rows: list[Vector] = []
        right: list[Fraction] = []
        for block in self.problem.blocks:
            if block.cone == "zero":
                equations: list[Vector] = [{} for _ in range(block.length)]
                for i, column in block.columns.items():
                    for k, value in column.items():
                        equations[k][i] = value
                rows += equations
                right += [-block.constant.get(k, Fraction(0)) for k in range(block.length)]
        return corrected(rows, right, self.point, self.basis)

    def obligations(self) -> Obligations:
        # Computed here, where a number with too many digits is a step that fails.
        _ = self.value
        yield from inside_cones(self.problem.blocks, self.problem.values(self.x), "the point")

    @cached_property
    def value(self) -> Fraction:
        """c'x + c_0."""
        products = (c * x for c, x in zip(self.problem.objective, self.x, strict=True))
        return limited_sum(products) + self.problem.offset

    def sentence(self) -> str:
        value = f"at most {at_most(self.value, DIGITS)}"
        if self.problem.maximised:
            value = f"at least {at_least(-self.value, DIGITS)}"
        return f"every constraint holds at the stated point; the optimum is {value}"

    def figures(self) -> Iterator[Figure | WindProfile]:
        maximised = self.problem.maximised
        yield Figure("objective", "-", -self.value if maximised else self.value, larger=maximised)
