"""One point of the published laws' map: a pair of overlaps, and the winds proved for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.certificate import check_document
from takagi.certificates.claims.turbine.published import (
    PublishedCandidate,
    claiming_what_holds,
    published_candidate,
    published_claim,
    published_law_data,
    with_overlaps,
)
from takagi.certificates.claims.turbine.published_search import FoundCell
from takagi.certificates.document.certificate_file import certificate_document, turbine_data
from takagi.certificates.sweep.grid import PARTLY, PROVED, UNDECIDED
from takagi.models.laws.published.law import PublishedLaw

# Half widths in speed of the sets to try, the largest first [rad/s].
LADDER = (0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001, 5e-5, 2e-5)

Span = tuple[float, float]


@dataclass(frozen=True, slots=True)
class WindowResult:
    """The result for the winds of one window.

    Attributes
    ----------
    wind : (low, high) [m/s].
    proved : whether the checker proved all of it.
    decay_rate : the least of its cells' [1/s]; None where it is not proved.
    half_width : in speed, of the smallest of its cells' boxes, which hold the sets [rad/s].
    rest : "intended" (at the trim), "shifted" (elsewhere), "continuum" or "none", at the lower end.
    power_ratio : power at rest over that of the trim, at the lower end; None without a rest point.
    reason : why it is not proved; None where it is.
    """

    wind: Span
    proved: bool
    decay_rate: float | None
    half_width: float | None
    rest: str
    power_ratio: float | None
    reason: str | None

    def data(self) -> dict[str, Any]:
        """Return it as in the journal, with units."""
        return {
            "wind [m/s]": list(self.wind),
            "verdict": PROVED if self.proved else UNDECIDED,
            "decay_rate [1/s]": self.decay_rate,
            "half_width [rad/s]": self.half_width,
            "rest": self.rest,
            "power_ratio [-]": self.power_ratio,
            "reason": self.reason,
        }


def overlap_point(
    law: PublishedLaw, *, speed_overlap: float, torque_overlap: float, winds: Sequence[Span]
) -> dict[str, Any]:
    """Return the result at one pair of overlaps [rad/s, N m], as in the journal.

    Raises
    ------
    ModelError : overlaps without a valid filter.
    """
    moved = with_overlaps(law, speed_overlap=speed_overlap, torque_overlap=torque_overlap)
    return point_result(certified_windows(moved, winds))


def point_result(windows: Sequence[WindowResult]) -> dict[str, Any]:
    """Return windows with their common result: verdict, least decay rate, the first that fails."""
    failing = next((window for window in windows if not window.proved), None)
    rates = [window.decay_rate for window in windows if window.decay_rate is not None]
    verdict = PROVED if failing is None else PARTLY if rates else UNDECIDED
    return {
        "verdict": verdict,
        "reason": failing and f"{failing.wind[0]:g} to {failing.wind[1]:g} m/s: {failing.reason}",
        "proved_windows": len(rates),
        "least_decay_rate [1/s]": min(rates, default=None),
        "first_failing_wind [m/s]": failing and failing.wind[0],
        "windows": [window.data() for window in windows],
    }


def certified_windows(law: PublishedLaw, winds: Sequence[Span]) -> list[WindowResult]:
    """Return, for each window of wind [m/s], whether the checker proves the law there, and why not.

    Cells are searched in floating point and written as decimals. A window is proved only if the
    checker proves it.
    """
    narrowest = min(high - low for low, high in winds)
    candidate = published_candidate(law, winds=winds, narrowest=narrowest, ladder=LADDER)
    believed = claiming_what_holds(candidate)
    proved = _proved(believed) if _covered(candidate) else set()
    return [_window(candidate, span, span in proved) for span in candidate.winds]


def _covered(candidate: PublishedCandidate) -> list[Span]:
    return [span for span in candidate.winds if _holds(candidate, span)]


def _holds(candidate: PublishedCandidate, span: Span) -> bool:
    return any(low <= span[0] and span[1] <= high for low, high in candidate.covered)


def _proved(believed: PublishedCandidate) -> set[Span]:
    """Return the windows that the checker proves."""
    if _checked(believed, [believed.winds]) == [Verdict.PROVED]:
        return set(believed.winds)
    # Each window is claimed separately, so that one that fails does not affect the others.
    verdicts = _checked(believed, [(span,) for span in believed.winds])
    return {
        span
        for span, verdict in zip(believed.winds, verdicts, strict=True)
        if verdict is Verdict.PROVED
    }


def _checked(believed: PublishedCandidate, parts: Sequence[Sequence[Span]]) -> list[Verdict]:
    """Return the checker's verdicts on claims about some of the windows each."""
    law = believed.law
    claims = [
        published_claim(
            replace(
                believed,
                winds=tuple(spans),
                cells=tuple(c for span in spans for c in _inside(believed, span)),
            )
        )
        for spans in parts
    ]
    document = certificate_document(
        model=turbine_data(law.turbine, ()),
        gains=published_law_data(law),
        claims=claims,
        provenance={"solver": {}},
    )
    return [claim.verdict for claim in check_document(document).claims]


def _inside(candidate: PublishedCandidate, span: Span) -> list[FoundCell]:
    return [
        found
        for found in candidate.cells
        if span[0] <= found.cell.wind[0] and found.cell.wind[1] <= span[1]
    ]


def _window(candidate: PublishedCandidate, span: Span, proved: bool) -> WindowResult:
    rest = candidate.rests[span[0]]
    cells = _inside(candidate, span) if proved else []
    rate = min((found.decay_rate for found in cells), default=None)
    width = min((float(found.cell.box[0]) for found in cells), default=None)
    ratio = None if rest.kind == "none" else round(rest.power_ratio, 6)
    reason = None if proved else _reason(candidate, span)
    return WindowResult(span, proved, rate, width, rest.kind, ratio, reason)


def _reason(candidate: PublishedCandidate, span: Span) -> str:
    for gap in sorted(candidate.unproved, key=lambda gap: gap.wind):
        if span[0] <= gap.wind[0] and gap.wind[1] <= span[1]:
            return gap.reason
    return "the checker did not confirm what was found"
