"""Run both checkers on one certificate and compare their verdicts.

The second checker may abstain (``NOT REPLAYED``) when it does not implement a kind of claim, or a
step such as the range of a table. Otherwise both must prove the same claims, and disprove the same
claims. If one refuses a file, the other must refuse it too, or prove nothing in it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Checked
from takagi.certificates.checker.replay.certificate import check, check_document
from takagi.certificates.cross_check.kernel.reading import Refusal
from takagi.certificates.cross_check.opinion import (
    CONTAINING,
    LOOPS,
    NOT_REPLAYED,
    Opinion,
    judge,
    judge_document,
)

REFUSED, NOT_PROVED = "REFUSED", ("UNDECIDED", "REFUSED")


@dataclass(frozen=True, slots=True)
class VerdictRow:
    """The verdicts of both checkers on one claim, or on the whole file."""

    name: str
    first: str
    second: str
    inequalities: int
    reason: str
    is_claim: bool = True

    @property
    def shown(self) -> str:
        """The name; a claim's name is free text of the file, so it is quoted."""
        return json.dumps(self.name, ensure_ascii=False) if self.is_claim else self.name

    @property
    def agrees(self) -> bool:
        """Whether both verdicts agree."""
        if self.second == NOT_REPLAYED or self.first == self.second:
            return True
        return self.first in NOT_PROVED and self.second in NOT_PROVED


@dataclass(frozen=True, slots=True)
class VerdictComparison:
    """Both verdicts on every claim; a refused file gives one row for the whole file."""

    rows: Sequence[VerdictRow]

    @property
    def agrees(self) -> bool:
        return all(row.agrees for row in self.rows)

    @property
    def replayed(self) -> int:
        """How many claims the second checker has decided."""
        return sum(row.second != NOT_REPLAYED for row in self.rows)

    @property
    def left_open(self) -> tuple[str, ...]:
        """The names of the claims that the second checker has not decided."""
        return tuple(row.name for row in self.rows if row.second == NOT_REPLAYED)

    @property
    def data(self) -> dict[str, Any]:
        """The comparison as plain data for JSON."""
        return {
            "agree": self.agrees,
            "replayed": self.replayed,
            "not_replayed": list(self.left_open),
            "claims": [
                {"name": row.name, "first": row.first, "second": row.second, "reason": row.reason}
                for row in self.rows
            ],
        }

    @property
    def text(self) -> str:
        """One line for each claim, and a summary that names the claims not replayed."""
        wide = max(len(row.first) for row in self.rows)
        other = max(len(row.second) for row in self.rows)
        lines = [
            f"  {row.first:<{wide}}  {row.second:<{other}}  {row.shown}"
            + (f" ({row.inequalities} matrices)" if row.inequalities else "")
            + (f": {row.reason}" if row.reason else "")
            for row in self.rows
        ]
        lines.insert(0, "Two checkers, the first one's verdict and the second one's:")
        count, last = len(self.rows), "they agree" if self.agrees else "THEY DIFFER"
        summed = f"{self.replayed} of {count} claims replayed twice: {last}"
        if left := [row.shown for row in self.rows if row.second == NOT_REPLAYED]:
            summed += f"; left to the first checker: {', '.join(left)}"
        return "\n".join([*lines, summed])


def cross_checked(path: Path | str) -> VerdictComparison:
    """Return what both checkers say of a certificate file; refusals are rows, not exceptions."""
    return _compared(lambda: check(path), lambda: judge(Path(path)))


def cross_checked_document(document: Mapping[str, Any]) -> VerdictComparison:
    """Return the same for a certificate in memory."""
    return _compared(lambda: check_document(document), lambda: judge_document(document))


def _compared(
    first: Callable[[], Checked], second: Callable[[], list[Opinion]]
) -> VerdictComparison:
    refusals = []
    checked: Checked | None = None
    opinions: list[Opinion] = []
    try:
        checked = first()
    except CertificateError as error:
        refusals.append(str(error))
    try:
        opinions = second()
    except Refusal as error:
        refusals.append(str(error))
    if not refusals and checked is not None and len(checked.claims) == len(opinions):
        return VerdictComparison([
            VerdictRow(
                claim.name, claim.verdict.name, found.verdict, found.inequalities, found.reason
            )
            for claim, found in zip(checked.claims, _resting(checked, opinions), strict=True)
        ])  # fmt: skip
    one = REFUSED if checked is None else checked.verdict.name
    two = _worst(opinions) if opinions else REFUSED
    count = sum(found.inequalities for found in opinions)
    if refusals and opinions:
        # A refusal by one checker must stay visible even when the other one abstains.
        told = ", ".join(f"{one.kind} {one.verdict}" for one in opinions)
        refusals.append(f"claim by claim the second checker says: {told}")
    return VerdictComparison(
        [VerdictRow("the file", one, two, count, "; ".join(refusals), is_claim=False)]
    )


def _resting(checked: Checked, opinions: Sequence[Opinion]) -> list[Opinion]:
    """Return the opinions; a claim about a plant is left open where its embedding is.

    The second checker proves it of the model, if the first has the plant in that. Where the first
    has not, nothing is proved of the plant, and the two do not differ.
    """
    left = any(
        one.kind in CONTAINING and one.verdict == NOT_REPLAYED and claim.verdict.name != "PROVED"
        for claim, one in zip(checked.claims, opinions, strict=True)
    )
    why = "the model is not known to contain its plant"
    return [
        replace(one, verdict=NOT_REPLAYED, reason=why)
        if left and one.kind in LOOPS and one.verdict == "PROVED"
        else one
        for one in opinions
    ]


def _worst(opinions: Sequence[Opinion]) -> str:
    verdicts = {found.verdict for found in opinions}
    for verdict in ("DISPROVED", "UNDECIDED", NOT_REPLAYED):
        if verdict in verdicts:
            return verdict
    return "PROVED"
