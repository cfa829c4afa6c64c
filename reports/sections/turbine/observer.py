"""The wind observer: its error model, premise and gains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.reports.page.text import (
    Section,
    Table,
    complex_words,
    decimal,
    significant,
    with_decimals,
)
from takagi.reports.sections.premise_table import premise_table
from takagi.reports.sections.turbine.regions import EVIDENCE

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign


def observer_section(design: TurbineDesign) -> Section:
    """Return the section about the wind observer."""
    found = design.observer
    low, high = found.observer.limits
    return Section(
        "observer",
        "Wind observer",
        {
            "l1": f"{found.gains[0]:g}",
            "l2": f"{found.gains[1]:g}",
            "decay": significant(found.decay_rate),
            "limits": f"{with_decimals(low, 1)} to {with_decimals(high, 1)}",
            "premises": premise_table(found.model, "Premises, estimation error", EVIDENCE),
            "poles": _poles(design),
            "box": [
                (name, decimal(float(a)), decimal(float(b)))
                for name, (a, b) in found.model.box.items()
            ],
        },
    )


def _poles(design: TurbineDesign) -> Table:
    """Return the poles of [-l1, d; -l2, 0] at both corners of d."""
    l1, l2 = design.observer.gains
    rows = []
    for vertex, name in zip(design.observer.model.vertices, ("lower", "upper"), strict=True):
        A = vertex.A - np.array([[l1], [l2]]) @ vertex.C
        rows.append((f"d {name}", *complex_words(np.linalg.eigvals(A), 4)))
    return Table(
        "Poles of the estimation error at the premise's corners",
        (("corner", ""), ("first", "1/s"), ("second", "1/s")),
        tuple(rows),
    )
