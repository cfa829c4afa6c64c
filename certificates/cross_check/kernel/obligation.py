"""The conditions of a claim: matrices that must be definite, and facts about numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from flint import fmpq_mat

from takagi.certificates.cross_check.kernel.exact import is_definite, is_symmetric


@dataclass(frozen=True, slots=True)
class Definite:
    """``matrix`` is symmetric and positive definite, or semidefinite where ``strict`` is False.

    ``label`` contains the checker's own words and never a text from the file: a forged file could
    otherwise print misleading lines.
    """

    label: str
    matrix: fmpq_mat
    strict: bool = True

    @property
    def holds(self) -> bool:
        return is_definite(self.matrix, strict=self.strict)

    @property
    def is_symmetric(self) -> bool:
        return is_symmetric(self.matrix)


@dataclass(frozen=True, slots=True)
class Fact:
    """A decided condition other than definiteness of a matrix."""

    label: str
    holds: bool


Obligation: TypeAlias = Definite | Fact
Obligations: TypeAlias = Iterator[Obligation]
