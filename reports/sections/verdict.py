"""The section on the verdict: what every report says there first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.kernel.result import Checked
from takagi.reports.page.text import Section


def verdict_box(checked: Checked, content: Mapping[str, Any]) -> Section:
    """Return the verdict box: the checker's verdict and claims, with what a report adds."""
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
