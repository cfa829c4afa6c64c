"""What a check returns: a verdict per claim, and one for the certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

__all__ = ["Checked", "Claim", "Found", "Outcome", "Verdict"]


class Verdict(Enum):
    """What may be claimed.  Only PROVED may be printed as a certificate."""

    PROVED = "Every inequality holds in rational arithmetic."
    DISPROVED = "Exact multipliers show that what was asked cannot exist."
    UNDECIDED = "Neither; what was tried is listed."


@dataclass(frozen=True)
class Found:
    """What replaying one claim found, before it is put in words.

    Attributes
    ----------
    verdict : stands; what makes words of the rest is asked afterwards and cannot change it.
    words : the module of ``takagi.certificates.checker.words`` that says it.
    given : what that module's ``said`` is given; it returns (name, text).
    """

    verdict: Verdict
    words: str
    given: Mapping[str, Any]


@dataclass(frozen=True)
class Claim:
    """One claim of the file: its name, the verdict on it, and why or about what.

    ``assumes`` : what the verdict rests on beside the proof, as short phrases.
    """

    name: str
    verdict: Verdict
    text: str
    assumes: tuple[str, ...] = ()


Outcome = Claim | Found


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

    @property
    def assumes(self) -> tuple[str, ...]:
        """What the claims rest on beside the proof, each phrase once."""
        return tuple(dict.fromkeys(phrase for claim in self.claims for phrase in claim.assumes))
