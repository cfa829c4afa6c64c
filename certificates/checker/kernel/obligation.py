"""Obligations: what must hold for a claim, as data that each reader decides for itself.

The checker decides them in rational arithmetic (``holds``), the second checker with FLINT, and the
Coq export writes them as theorems.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Protocol

from takagi.certificates.checker.kernel.matrices import Matrix


class Relation(Enum):
    """What is required of a number, or of a symmetric matrix in the sense of definiteness."""

    POSITIVE = "> 0"
    NONNEGATIVE = ">= 0"
    NOT_POSITIVE = "not > 0"


class Obligation(Protocol):
    """One thing that must hold for a claim.

    ``failure`` : the reason that is given where it does not hold.
    """

    @property
    def failure(self) -> str: ...

    @property
    def holds(self) -> bool:
        """Whether it holds, decided in rational arithmetic."""


@dataclass(frozen=True, slots=True)
class Inequality:
    """``value`` has the relation to zero; a matrix must be symmetric as well.

    ``failure`` : the reason that is given where it does not hold; never a text of the file.
    """

    value: Matrix | Fraction | int
    relation: Relation
    failure: str

    @property
    def holds(self) -> bool:
        """Whether the obligation holds, decided in rational arithmetic."""
        value, wanted = self.value, self.relation is Relation.POSITIVE
        if not isinstance(value, Matrix):
            return value >= 0 if self.relation is Relation.NONNEGATIVE else (value > 0) == wanted
        if self.relation is Relation.NONNEGATIVE:
            return value.is_positive_semidefinite
        return value.is_symmetric and value.is_positive_definite == wanted


Obligations = Iterator[Obligation]
# Decides whether an obligation holds.
Decider = Callable[[Obligation], bool]


def decided_exactly(required: Obligation) -> bool:
    """Return whether an obligation holds, decided in rational arithmetic."""
    return required.holds


def positive(value: Matrix | Fraction | int, failure: str) -> Inequality:
    """Return the obligation value > 0; a matrix is symmetric and positive definite."""
    return Inequality(value, Relation.POSITIVE, failure)


def nonnegative(value: Matrix | Fraction | int, failure: str) -> Inequality:
    """Return the obligation value >= 0; a matrix is symmetric and positive semidefinite."""
    return Inequality(value, Relation.NONNEGATIVE, failure)


def not_positive(value: Matrix, failure: str) -> Inequality:
    """Return the obligation that a symmetric matrix is not positive definite."""
    return Inequality(value, Relation.NOT_POSITIVE, failure)


def never(failure: str) -> Inequality:
    """Return an obligation that cannot hold: the claim is not shown, for this reason."""
    return Inequality(0, Relation.POSITIVE, failure)


def first_failure(obligations: Iterable[Obligation], holds: Decider = decided_exactly) -> str:
    """Return the reason of the first obligation that does not hold; empty if all hold.

    Obligations after one that fails are not asked for: they may need that it holds.
    """
    for required in obligations:
        if not holds(required):
            # An empty reason would read as "all hold".
            return required.failure or "an obligation does not hold"
    return ""
