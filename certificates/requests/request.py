"""A request, and the result of an attempt to prove it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any, ClassVar

import numpy as np

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """A claim with its evidence, and the checker's verdict on it.

    Attributes
    ----------
    claim : as it goes into the file: name, kind, evidence.
    checked : the checker's verdict on it.
    tried : what was tried, in words, in order; the last is the claim.
    solver : the candidate's solver in its own words.
    """

    claim: Mapping[str, Any]
    checked: Claim
    tried: tuple[str, ...] = ()
    solver: str = ""

    @property
    def proved(self) -> bool:
        return self.checked.verdict is Verdict.PROVED


class Request(ABC):
    """A requested claim about a loop: a frozen dataclass whose fields are the requirements.

    ``includes_decay`` : the claim holds only where one P decreases at all blends of the loop.
    """

    includes_decay: ClassVar[bool] = False
    __slots__ = ()

    @abstractmethod
    def attempt(self, loop: ClaimedLoop) -> Attempt:
        """Return the best attempt: proved if it can be, else the last one that failed.

        Raises
        ------
        ModelError : the request makes no sense for this loop.
        """


def first_proved(
    loop: ClaimedLoop,
    claims: Iterable[tuple[str, Mapping[str, Any]]],
    solver: str = "",
    *,
    idle: tuple[str, Mapping[str, Any]] | None = None,
    cannot_hold: Callable[[Mapping[str, Any]], bool] = lambda claim: False,
) -> Attempt:
    """Return the first of (words, claim) that the checker proves, else the last.

    The strongest claim comes first; the weaker ones are computed only when they are needed.

    Parameters
    ----------
    idle : taken where there are no claims; it states the reason.
    cannot_hold : skips claims that fail in floating point, which saves exact arithmetic; the last
        claim is always given to the checker.
    """
    tried: list[str] = []
    claims = iter(claims)
    first = next(claims, idle)
    assert first is not None  # without an idle claim there is always another
    for words, claim in chain([first], claims):
        if cannot_hold(claim):
            checked = None
            tried.append(f"{words}: fails in floats")
            continue
        claim, checked = loop.with_pieces(claim)
        cut = claim.get("halvings", ())
        tried.append(f"{words}, on {cut.count([])} pieces of the weights" if cut else words)
        if checked.verdict is Verdict.PROVED:
            break
    if checked is None:
        claim, checked = loop.with_pieces(claim)
    return Attempt(claim, checked, tuple(tried), solver)


def require_positive(**numbers: float | None) -> None:
    """Refuse a number that is not positive and finite; None stands for one that is searched."""
    for name, value in numbers.items():
        if value is not None and not (np.isfinite(value) and value > 0):
            raise ModelError(f"{name} = {value!r} was given; a positive number is needed")


def require_rate(rate: float | None) -> None:
    """Refuse a decay rate below 0, or one that is not finite."""
    if rate is not None and not (np.isfinite(rate) and rate >= 0):
        raise ModelError(f"decay_rate = {rate!r} was given; a number >= 0 [1/s] is needed")
