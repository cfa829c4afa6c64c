"""Why there was no answer and what would help: a value that explains it in words."""

from __future__ import annotations

from dataclasses import dataclass

from takagi.lmi.decision.diagnosis import Share, shares_in_words
from takagi.lmi.explaining.uncontrollable_blend import UncontrollableBlend

# Items that are named in words.
NAMED = 4


@dataclass(frozen=True, slots=True)
class PremiseRelief:
    """What one premise costs, the others on their whole ranges.

    Attributes
    ----------
    name, unit : of the premise.
    share : the largest share of its range, about the middle, with an answer, of those that were
        tried; 0 where it must be a constant; None where even that does not help.
    lower, upper : that range.
    """

    name: str
    unit: str
    share: float | None
    lower: float
    upper: float

    def __str__(self) -> str:
        if self.share is None:
            return f"premise {self.name}: a constant at its middle does not help"
        if self.share == 0:
            return f"premise {self.name}: a constant at {self.lower:.4g} {self.unit} is enough"
        return (
            f"premise {self.name}: {self.share:.0%} of its range is enough, "
            f"{self.lower:.4g} to {self.upper:.4g} {self.unit}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """Why a design fails, and each single change that helps; ``str()`` says it in words.

    Every change that is named was solved, and its answer passed the check; the best ones were
    bracketed by
    bisection, so a larger share or rate may have an answer too.  Nothing here is a proof.

    Attributes
    ----------
    asked : what was asked, in words.
    found : whether there is an answer as it was asked; then nothing else was tried.
    binding : the items that carry the no, largest share first.
    rules : where the rules of those items lie, e.g. ``"rule 2: speed = 7 m/s"``; empty for a
        model without premises.
    stuck : a blend that no gains stabilise, where one makes the condition infeasible; None
    otherwise.
    box : the largest share of the box, about its middle, with an answer, of those that were
        tried; None where there was none.
    premises : what each premise costs, most first; empty for a model without.
    decay_rate : the largest rate in 1/s with an answer, of those that were tried; negative where
        V may grow; None where there was none.
    lowest_rate : the lowest rate in 1/s that was tried; None when none was.
    relaxations : richer ones that were tried, with whether there were gains, or None where one
        is too large for this model or does not apply.
    asked_again : how many times it was asked.
    """

    asked: str
    found: bool
    binding: tuple[Share, ...] = ()
    rules: tuple[str, ...] = ()
    stuck: UncontrollableBlend | None = None
    box: float | None = None
    premises: tuple[PremiseRelief, ...] = ()
    decay_rate: float | None = None
    lowest_rate: float | None = None
    relaxations: tuple[tuple[str, bool | None], ...] = ()
    asked_again: int = 0

    def __str__(self) -> str:
        if self.found:
            return f"{self.asked}: found, there is nothing to explain"
        lines = [f"{self.asked}: none"]
        if self.binding:
            lines.append(f"  the no rests on {shares_in_words(self.binding[:NAMED])}")
        lines += [f"    {rule}" for rule in self.rules]
        lines += [f"  {self.stuck}"] if self.stuck is not None else []
        lines += [f"  {line}" for line in _advice(self)]
        return "\n".join(lines)


def _advice(told: Explanation) -> list[str]:
    lines = []
    if told.relaxations:
        words = {True: "has gains", False: "has none", None: "does not apply or is too large"}
        tried = ", ".join(f"{name} {words[found]}" for name, found in told.relaxations)
        lines.append(f"a richer relaxation: {tried}")
    if told.decay_rate is not None:
        grows = ": V may grow, no faster" if told.decay_rate < 0 else ""
        lines.append(f"a lower decay rate: {told.decay_rate:.4g} 1/s is enough{grows}")
    elif told.lowest_rate is not None:
        lines.append(f"a lower decay rate does not help: not even {told.lowest_rate:.4g} 1/s")
    if told.box is None:
        lines.append("a smaller box does not help: not even its middle has an answer")
    else:
        lines.append(f"a smaller box: {told.box:.0%} of it about its middle is enough")
    return lines + [str(one) for one in told.premises]
