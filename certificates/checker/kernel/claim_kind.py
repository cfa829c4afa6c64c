"""What a kind of claim is: fields, obligations and a sentence, in one class."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from takagi.certificates.checker.kernel.obligation import (
    Decider,
    Obligations,
    decided_exactly,
    first_failure,
)
from takagi.certificates.checker.kernel.result import Claim, Verdict

if TYPE_CHECKING:
    # Figures are made when the verdicts are final, as all words are.
    from takagi.certificates.checker.words.figure import Figure, WindProfile


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
class Outcome:
    """A claim with the reason why it is not shown, which is empty if it is."""

    claim: ClaimKind
    failure: str = ""

    @property
    def verdict(self) -> Verdict:
        return Verdict.UNDECIDED if self.failure else self.claim.shows

    def in_words(self) -> Claim:
        """Return the claim with its verdict, its sentence and its figures."""
        claim, why = self.claim, self.failure
        figures = () if why else tuple(claim.figures())
        return Claim(claim.name, self.verdict, why or claim.sentence(), claim.assumes, figures)
