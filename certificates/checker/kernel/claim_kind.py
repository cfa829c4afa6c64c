"""What a kind of claim is: fields, obligations and a sentence, in one class."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from takagi.certificates.checker.kernel.figure import Figure, WindProfile
from takagi.certificates.checker.kernel.obligation import (
    Decider,
    Obligations,
    decided_exactly,
    first_failure,
)
from takagi.certificates.checker.kernel.result import Claim, Verdict


class ClaimKind(ABC):
    """One claim of a file, read.  A subclass is a kind; its module states and proves the theorem.

    Attributes
    ----------
    name : of the claim, as it is printed.
    shows : the verdict where every obligation holds.
    assumes : the assumptions of the verdict beside the proof, as short phrases.
    asks : the members that say what the claim is about; figures are compared where these agree.
    """

    name: str
    shows: ClassVar[Verdict] = Verdict.PROVED
    assumes: ClassVar[tuple[str, ...]] = ()
    asks: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def obligations(self) -> Obligations:
        """Yield what must hold for the claim.

        Raises
        ------
        CertificateError : evidence that is missing or does not fit.
        """

    @abstractmethod
    def sentence(self) -> str:
        """Return the statement, with its numbers rounded so that it claims no more."""

    def figures(self) -> Iterator[Figure | WindProfile]:
        """Yield the numbers that are proved where every obligation holds."""
        yield from ()

    def failure(self, holds: Decider = decided_exactly) -> str:
        """Return why the claim is not shown; empty if every obligation holds."""
        return first_failure(self.obligations(), holds)


@dataclass(frozen=True)
class Decided:
    """A claim whose obligations all hold, before its sentence is written."""

    claim: ClaimKind

    @property
    def verdict(self) -> Verdict:
        return self.claim.shows


Outcome = Claim | Decided
