"""What a check returns: a verdict per claim, and one for the certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from importlib import import_module
from typing import Any

__all__ = ["Checked", "Claim", "Found", "Outcome", "Verdict", "in_words"]


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


def in_words(found: Outcome) -> Claim:
    """Return the claim with the verdict that was found, and its sentence."""
    if isinstance(found, Claim):
        return found
    words = import_module(f"takagi.certificates.checker.words.{found.words}")
    name, text = words.said(**found.given)
    return Claim(name, found.verdict, text)


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

    @classmethod
    def of(cls, found: Sequence[Outcome], notes: list[str], kinds: Sequence[str] = ()) -> Checked:
        """Return the verdict on the whole, and then each claim in words.

        Parameters
        ----------
        notes : the messages.
        kinds : of the claims, in the same order: each says what it assumes.
        """
        verdicts = {one.verdict for one in found}
        overall = Verdict.UNDECIDED
        if Verdict.DISPROVED in verdicts:
            overall = Verdict.DISPROVED
        elif verdicts == {Verdict.PROVED}:
            overall = Verdict.PROVED
        # Imported here, as all words are: no verdict depends on it.
        from takagi.certificates.checker.words.assumed import assumed

        claims = [in_words(one) for one in found]
        if kinds:
            claims = [replace(a, assumes=assumed(k)) for a, k in zip(claims, kinds, strict=True)]
        return cls(overall, claims, notes)
