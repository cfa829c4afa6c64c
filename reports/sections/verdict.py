"""The verdict box, with which every report begins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.kernel.result import Checked
from takagi.reports.page.text import Section


def verdict_box(checked: Checked, content: Mapping[str, Any]) -> Section:
    """Return the verdict box: the checker's verdict and claims, and the report's own content."""
    return Section(
        "verdict",
        "Verdict",
        {
            "verdict": checked.verdict.name,
            "meaning": checked.verdict.value,
            "claims": [(c.name, c.verdict.name, c.text) for c in checked.claims],
            **content,
        },
    )
