"""What a claim of kind ``equilibrium`` says, proved or not."""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.checker.turbine.equilibria.equilibrium_claim import ANSWERS
from takagi.certificates.checker.turbine.wind_intervals import Span, gaps, merged
from takagi.certificates.checker.words.law_words import law_words
from takagi.certificates.checker.words.rounded import at_least, at_most

MOST_LISTED = 12


def said(
    law: str,
    known: Span,
    proved: Sequence[tuple[Span, str]],
    failures: Sequence[tuple[Span, str, str]],
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    law, known : its name, and the winds that it knows.
    proved : winds, and what the loop does at each of them.
    failures : winds, the stated answer, and the answer found instead.
    """
    name = f"rests of the loop with the {law_words(law)}, constant winds {_shown([known])} m/s"
    parts = _parts(proved, known)
    if failures:
        reasons = [
            f"{_shown([winds])} m/s: {stated!r} is not proved ({found})"
            for winds, stated, found in failures[:MOST_LISTED]
        ]
        return name, "; ".join([*reasons, *parts])
    words = "inside the coefficient table, v_hat = v, at each constant wind"
    return name, f"{words}: {'; '.join(parts)}"


def _parts(proved: Sequence[tuple[Span, str]], known: Span) -> list[str]:
    found = []
    for answer in ANSWERS:
        spans = merged([span for span, said in proved if said == answer])
        if spans:
            found.append(f"{answer} at {_shown(spans)} m/s")
    left = gaps(known, merged([span for span, _ in proved]))
    return [*found, f"not decided: {_shown(left)} m/s"] if left else found


def _shown(spans: list[Span]) -> str:
    """Return ranges rounded inward, so that the statement holds for all named winds."""
    shown = [f"{at_most(low, 9)} to {at_least(high, 9)}" for low, high in spans[:MOST_LISTED]]
    more = f" (+{len(spans) - MOST_LISTED} more)" if len(spans) > MOST_LISTED else ""
    return ", ".join(shown) + more
