r"""``optimum-bound``: no solution of the problem is better than this.

Let y be multipliers, y_k in the dual cone of K_k, with <A_i, y> = c_i for every variable.  For
every solution x

    c'x + c_0 - sum_k <S_k(x), y_k> = c_0 - sum_k <B_k, y_k>,    and each <S_k, y_k> >= 0,

so that c'x + c_0 >= c_0 - sum_k <B_k, y_k> (weak duality).  The file states decimals for y, and the
checker changes those of ``basis`` until the equations hold exactly.

With ``radius`` R the claim is about the solutions with |x_i| <= R alone.  Then the equations need
not hold: c'x differs from sum_i <A_i, y> x_i by at most R sum_i |c_i - <A_i, y>|, which is taken
off.

Source: Jansson, Chaykin, Keil (2007), SIAM J. Numer. Anal. 46(1), Rigorous error bounds for the
optimal value in semidefinite programming; here the equations are solved exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.problem.conic_problem import inside_cones
from takagi.certificates.checker.problem.problem_claim import ProblemClaim
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, at_most

DIGITS = 10


@dataclass(frozen=True)
class OptimumBound(ProblemClaim):
    """c_0 - <B, y> is a bound of the optimum; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("radius",)
    radius: Fraction | None = None

    @classmethod
    def read(cls, claim: Any, data: Any, where: str) -> Self:
        read = super().read(claim, data, where)
        if "radius" not in claim:
            return read
        return replace(read, radius=reader.positive(claim, "radius", where))

    @cached_property
    def y(self) -> list[list[Fraction]]:
        """The multipliers, block by block."""
        if self.radius is not None:
            return self.by_block(self.point)
        return self.multipliers(self.problem.objective)

    def obligations(self) -> Obligations:
        # Computed here, where a number with too many digits is a step that fails.
        _ = self.bound
        yield from inside_cones(self.problem.blocks, self.y, "the multiplier")

    @cached_property
    def bound(self) -> Fraction:
        """c_0 - sum_k <B_k, y_k>, less what the equations miss."""
        bound = self.problem.offset - self.constant_product(self.y)
        if self.radius is not None:
            products = self.products(self.y)
            pairs = zip(self.problem.objective, products, strict=True)
            bound -= self.radius * sum((abs(c - p) for c, p in pairs), Fraction(0))
        return bound

    def sentence(self) -> str:
        which = "every solution"
        if self.radius is not None:
            which += f" whose variables are at most {at_least(self.radius, DIGITS)} in size"
        if self.problem.maximised:
            return f"{which} has a value of at most {at_most(-self.bound, DIGITS)}"
        return f"{which} has a value of at least {at_least(self.bound, DIGITS)}"

    def figures(self) -> Iterator[Figure | WindProfile]:
        maximised = self.problem.maximised
        value = -self.bound if maximised else self.bound
        yield Figure("bound of the optimum", "-", value, larger=not maximised)
        if self.radius is not None:
            yield Figure("size of the variables", "-", self.radius)
