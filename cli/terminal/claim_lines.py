"""The result of a check as lines of text, claim by claim."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.ci_formats import CheckedFile


def claim_lines(checked: CheckedFile) -> list[str]:
    """Return a line for each claim: its verdict, its name in quotes, and the checker's sentence.

    The name is a free text of the file.  Without quotes it could be taken for a sentence of the
    checker.
    """
    width = max((len(claim.verdict.name) for claim in checked.claims), default=0)
    return [
        f"  {claim.verdict.name:<{width}}  {json.dumps(claim.name, ensure_ascii=False)}: "
        f"{claim.text}"
        for claim in checked.claims
    ]
