"""Claims about a turbine's loop: every part that fails is named, not the first one alone."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, ClassVar

from takagi.certificates.checker.kernel.claim_kind import ClaimKind, Outcome
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Decider,
    Obligations,
    decided_exactly,
    first_failure,
    never,
)
from takagi.certificates.checker.kernel.reader import integer, member, number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.turbine.members import Members, refuse_unread
from takagi.certificates.checker.turbine.rotor import Span
from takagi.certificates.checker.words.figure import WindProfile

MOST_REASONS = 12
# Effects that the model of the machine omits.
RIGID = ("rigid shaft, tower and blades", "wake without states of its own")
# A gain file's program limits the rates of torque and pitch; these kinds have the drive's alone.
DRIVES = (
    "torque without delay, and commands without a limit of their rates",
    "first-order pitch drive",
)
PROGRAM = ("continuous time", "exact speed")
# Of a law with set-points at run time.
AT_RATED = "speed and power set-points that lower neither speed nor torque"


@dataclass(frozen=True)
class TurbineClaim(ClaimKind):
    """A claim about a turbine's loop.

    Attributes
    ----------
    claim, data, where : the claim, the whole file, and the claim's place for messages.
    members : what the claim may have; a further member is refused.
    at_rated : whether set-points at run time must lower nothing.
    """

    claim: Any = field(repr=False)
    data: Any = field(repr=False)
    where: str
    name: str
    members: ClassVar[Mapping[str, Members | None]]
    at_rated: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.at_rated and "setpoints" in self.data.get("gains", ()):
            object.__setattr__(self, "assumes", (*self.assumes, AT_RATED))

    def premises(self) -> Obligations:
        """Yield what the parts need; where it fails, no part is looked at."""
        return iter(())

    @abstractmethod
    def parts(self) -> Iterator[tuple[str, Obligations]]:
        """Yield where a part is, in words, and its obligations; most parts are wind cells."""

    def obligations(self) -> Obligations:
        yield from self.premises()
        for _, required in self.parts():
            yield from refusal_fails(required)

    def failure(self, holds: Decider = decided_exactly) -> str:
        """Return why the claim is not shown, with each part that fails.

        Raises
        ------
        CertificateError : also for a member that nothing reads.
        """
        reason = first_failure(self.premises(), holds) or self.parts_failure(holds)
        refuse_unread(self.members, self.claim, self.data, self.where)
        return reason

    def parts_failure(self, holds: Decider) -> str:
        """Return why the parts are not shown; empty if all are."""
        reasons = list(self.failures(holds).values())
        if not reasons:
            return ""
        more = f" (+{len(reasons) - MOST_REASONS} more)" if len(reasons) > MOST_REASONS else ""
        return self.not_proved() + "; ".join(reasons[:MOST_REASONS]) + more

    def failures(self, holds: Decider) -> dict[int, str]:
        """Return where and why a part is not shown, by the number of the part."""
        reasons = {}
        for k, (place, required) in enumerate(self.parts()):
            if reason := first_failure(refusal_fails(required), holds):
                reasons[k] = f"{place}{reason}"
        return reasons

    def not_proved(self) -> str:
        """Return the words before the reasons."""
        return "not proved: "


def profile(name: str, unit: str, cells: Sequence[Any], key: str) -> WindProfile:
    """Return one number of every wind cell over the winds."""
    rows = ((*numbers(cell, "wind", "cell", 2), number(cell, key, "cell")) for cell in cells)
    return WindProfile(name, unit, tuple(sorted((low, high, value) for low, high, value in rows)))


def row_bound(P: Matrix, h: Matrix, bound: Fraction) -> Matrix:
    """Return [[P, h'], [h, bound^2]]; where it is > 0, |h xi| < bound wherever xi'P xi <= 1."""
    return Matrix.blocks([[P, h.T], [h, Matrix.of([[bound**2]])]])


def refusal_fails(required: Obligations) -> Obligations:
    """Yield the obligations; an enclosure that is refused becomes one that cannot hold."""
    try:
        yield from required
    except Refused as error:
        yield never(str(error))


def prerequisite_claim(
    claim: Any, data: Any, earlier: Sequence[Outcome], where: str, member_name: str, kind: str
) -> tuple[Any, str]:
    """Return the claim on which one depends, which a member names, and why it is not PROVED.

    Parameters
    ----------
    earlier : the verdicts on the claims before this one; a later one has none yet.
    kind : that the claim must be of.

    Raises
    ------
    CertificateError : there is no such claim before this one, or it is of another kind.
    """
    place = integer(claim, member_name, where)
    if not 0 <= place < len(earlier):
        raise CertificateError(
            f"{where}.{member_name}: {place}; the place of an earlier claim is needed"
        )
    other, outcome = member(data, "claims", "certificate")[place], earlier[place]
    if text(other, "kind", f"claims[{place}]") != kind:
        raise CertificateError(f"{where}.{member_name}: claims[{place}] is not of kind {kind}")
    if outcome.verdict is Verdict.PROVED:
        return other, ""
    return other, f"the claim that it rests on is not proved: {outcome.claim.name}"


def merged(spans: list[Span]) -> list[Span]:
    """Return the union of closed ranges as disjoint ones."""
    union: list[Span] = []
    for low, high in sorted(spans):
        if union and low <= union[-1][1]:
            union[-1] = union[-1][0], max(high, union[-1][1])
        else:
            union.append((low, high))
    return union


def gaps(span: Span, covered: list[Span]) -> list[Span]:
    """Return the parts of a range outside ``covered``, whose ranges are disjoint and ordered."""
    low, missing = span[0], []
    for start, stop in covered:
        if stop <= low or start >= span[1]:
            continue
        if start > low:
            missing.append((low, start))
        low = stop
    return [*missing, (low, span[1])] if low < span[1] else missing
