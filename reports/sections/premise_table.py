"""The table of premises with their proved bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.reports.page.text import Table, decimal

if TYPE_CHECKING:
    from takagi.models.ts.model import TSModel


def premise_table(model: TSModel, caption: str, evidence: str) -> Table:
    """Return the premises of a model with their proved ranges.

    ``evidence`` is the heading of the last column, which says how a range was bounded.
    """
    return Table(
        caption,
        (("premise", ""), ("lower", ""), ("upper", ""), ("unit", ""), (evidence, "")),
        tuple(
            (p.name, decimal(float(p.lower)), decimal(float(p.upper)), p.unit, p.evidence)
            for p in model.premises
        ),
    )
