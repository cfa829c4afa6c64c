"""The result of a check: a verdict per claim, and one for the certificate."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.checker.words.figure import Figures


class Verdict(Enum):
    """What may be claimed.  Only PROVED may be printed as a certificate."""

    PROVED = "Every inequality holds in rational arithmetic."
    DISPROVED = "Exact multipliers show that what was asked cannot exist."
    UNDECIDED = "Neither; what was tried is listed."


@dataclass(frozen=True)
class Claim:
    """One claim of the file: its name, its verdict, and the reason or the statement.

    ``assumes`` : the assumptions of the verdict beside the proof, as short phrases.
    ``figures`` : the proved numbers; () where it is not proved.
    """

    name: str
    verdict: Verdict
    text: str
    assumes: tuple[str, ...] = ()
    figures: Figures = ()


@dataclass(frozen=True)
class Checked:
    """The outcome of a check.

    Attributes
    ----------
    verdict : PROVED when every claim is; DISPROVED when one is; UNDECIDED otherwise.
    claims : in the file's order.
    messages : notes for the reader, e.g. that only embedded copies were checked.
    """

    verdict: Verdict
    claims: list[Claim]
    messages: list[str] = field(default_factory=list)

    @property
    def assumes(self) -> tuple[str, ...]:
        """The assumptions of the claims beside the proof, each phrase once."""
        return tuple(dict.fromkeys(phrase for claim in self.claims for phrase in claim.assumes))
