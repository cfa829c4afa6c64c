"""Claims about a conic problem: how they are read, and how a step that fails becomes a reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Self

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.claim_kind import ClaimKind
from takagi.certificates.checker.kernel.obligation import Decider, decided_exactly
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.problem.conic_problem import (
    MOST_ENTRIES,
    ConicProblem,
    Vector,
    corrected,
    read_problem,
)


@dataclass(frozen=True)
class ProblemClaim(ClaimKind):
    """A claim about the problem of ``model``.

    Attributes
    ----------
    point : the decimals that the file states: x, or the multipliers y of all blocks one after
        another.
    basis : the places of ``point`` that are corrected until the equations hold exactly.
    """

    where: str
    name: str
    problem: ConicProblem = field(repr=False)
    point: list[Fraction] = field(repr=False)
    basis: list[int] = field(repr=False)

    @classmethod
    def read(cls, claim: Any, data: Any, where: str) -> Self:
        """Return the claim; ``data`` is the whole file.

        Raises
        ------
        CertificateError : the model is another one, or a member is malformed.
        """
        problem = read_problem(data, where)
        name = reader.text(claim, "name", where)
        point = reader.numbers(claim, "point", where, cls.length(problem))
        places = reader.listed(claim, "basis", where, 0, MOST_ENTRIES)
        basis = [reader.integer({"basis": place}, "basis", where) for place in places]
        if any(not 0 <= place < len(point) for place in basis):
            raise CertificateError(f"{where}.basis: a place is out of range")
        return cls(where, name, problem, point, basis)

    @classmethod
    def length(cls, problem: ConicProblem) -> int:
        """Return the length of ``point``; unless a kind says otherwise, that of the multipliers."""
        return sum(block.length for block in problem.blocks)

    def failure(self, holds: Decider = decided_exactly) -> str:
        """Return which step is not proved; empty if all are."""
        try:
            return super().failure(holds)
        except Refused as error:
            return str(error) or "a step is refused"

    def multipliers(self, right: Sequence[Fraction]) -> list[list[Fraction]]:
        """Return y, block by block, corrected so that <A_i, y> is exactly this, for every i."""
        equations: list[Vector] = [{} for _ in self.problem.objective]
        first = 0
        for block in self.problem.blocks:
            for i, column in block.columns.items():
                for k, value in column.items():
                    equations[i][first + k] = block.weight(k) * value
            first += block.length
        return self.by_block(corrected(equations, right, self.point, self.basis))

    def by_block(self, stacked: Sequence[Fraction]) -> list[list[Fraction]]:
        """Return a vector of all blocks in parts, one a block."""
        parts, first = [], 0
        for block in self.problem.blocks:
            parts.append(list(stacked[first : first + block.length]))
            first += block.length
        return parts

    def products(self, multipliers: Sequence[Sequence[Fraction]]) -> list[Fraction]:
        """Return <A_i, y> for every variable."""
        products = [Fraction(0)] * len(self.problem.objective)
        for block, y in zip(self.problem.blocks, multipliers, strict=True):
            for i, column in block.columns.items():
                products[i] += block.product(column, y)
        return products

    def constant_product(self, multipliers: Sequence[Sequence[Fraction]]) -> Fraction:
        """Return sum_k <B_k, y_k>."""
        pairs = zip(self.problem.blocks, multipliers, strict=True)
        return sum((block.product(block.constant, y) for block, y in pairs), Fraction(0))


def require_alone(gains: Any, path: str, messages: list[str]) -> list[str]:
    """Return the messages of the verdict in the place of those about files of a law and a plant.

    Raises
    ------
    CertificateError : gains beside the problem. No claim speaks of them, so that PROVED would be
        said of any law.
    """
    if gains is not None:
        raise CertificateError(f"{path}: a certificate about a conic problem has no gains")
    return ["the verdict is about the problem inside the certificate"] if messages else []
