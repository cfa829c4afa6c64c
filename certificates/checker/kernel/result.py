"""What a check returns: a verdict per claim, and one for the certificate."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

__all__ = ["Checked", "Claim", "Verdict"]


class Verdict(Enum):
    """What may be claimed.  Only PROVED may be printed as a certificate."""

    PROVED = "Every inequality holds in rational arithmetic."
    DISPROVED = "Exact multipliers show that what was asked cannot exist."
    UNDECIDED = "Neither; what was tried is listed."


@dataclass(frozen=True)
class Claim:
    """One claim of the file: its name, the verdict on it, and why or about what."""

    name: str
    verdict: Verdict
    text: str


@dataclass(frozen=True)
class Checked:
    """The outcome of a check.

    Attributes
    ----------
    verdict : PROVED when every claim is; DISPROVED when one is; UNDECIDED otherwise.
    claims : in the file's order.
    messages : what the reader has to know, e.g. that only embedded copies were checked.
    """

    verdict: Verdict
    claims: list[Claim]
    messages: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, claims: list[Claim], messages: list[str]) -> Checked:
        verdicts = {claim.verdict for claim in claims}
        overall = Verdict.UNDECIDED
        if Verdict.DISPROVED in verdicts:
            overall = Verdict.DISPROVED
        elif verdicts == {Verdict.PROVED}:
            overall = Verdict.PROVED
        return cls(overall, claims, messages)
