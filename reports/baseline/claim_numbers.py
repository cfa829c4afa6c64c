"""The numbers of proved claims for continuous integration, by the standard library alone."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.reports.baseline.claim_figures import ClaimFigure, claim_figures
from takagi.reports.ci_formats import CheckedFile


def claim_numbers(document: Mapping[str, Any], checked: CheckedFile) -> list[dict[str, str]]:
    """Return for each claim its numbers, such as ``{"decay rate [1/s]": "3.38"}``.

    Bounds are rounded so that they hold.  Claims that are not proved have none.

    Parameters
    ----------
    document : as the strict reader returns it; ``checked`` may have further claims at its end.
    """
    return [
        {
            f"{figure.name} [{figure.unit}]" if figure.unit else figure.name: _rounded(figure)
            for figure in claim_figures(claim, document)
            # A bound of 0 says nothing; a profile depends on the wind.
            if isinstance(figure, ClaimFigure)
            and isinstance(figure.value, Fraction)
            and figure.value
        }
        if found.verdict.name == "PROVED"
        else {}
        for claim, found in zip(document["claims"], checked.claims, strict=False)
    ]


def _rounded(figure: ClaimFigure) -> str:
    assert isinstance(figure.value, Fraction)
    return (at_least if figure.larger else at_most)(figure.value, 3)
