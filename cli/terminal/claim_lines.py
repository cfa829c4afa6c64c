"""What a check found, claim by claim, as lines to read."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.ci_formats import CheckedFile


def claim_lines(checked: CheckedFile) -> list[str]:
    """Return a line for each claim: the verdict, the name in quotes, what was found.

    The name is free text of the file: without quotes it would look like a text of the checker.
    """
    width = max((len(claim.verdict.name) for claim in checked.claims), default=0)
    return [
        f"  {claim.verdict.name:<{width}}  {json.dumps(claim.name, ensure_ascii=False)}: "
        f"{claim.text}"
        for claim in checked.claims
    ]
